//! The light model of one light: the usable parts of its components.

use glam::Vec3;

use super::barn_map::BarnMap;
use super::cookie::CookieError;
use super::distance::LightDistance;
use super::shadow::{ShadowOrigin, ShadowSoftness, ShadowTint};
use super::shape::LightShape;
use super::weights::{LightWeights, is_weight};
use crate::scene::LightKind;

/// The light model of one light. Parts that are missing, at their default or not usable are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightModel {
    /// Barn doors of the light.
    pub shape: Option<LightShape>,
    /// Depths between which the light shines.
    pub distance: Option<LightDistance>,
    /// Weights of ambient, diffuse and specular light.
    pub weights: LightWeights,
    /// Colour and darkness of the light's shadows.
    pub tint: ShadowTint,
    /// Place from which the light's shadows are cast.
    pub origin: Option<ShadowOrigin>,
    /// Radius of the sphere around the extent that shadows are cast with, metres.
    pub softness: Option<f32>,
    /// The texture that holds the shape; `None` if the shape is computed, because there is none or it is too sharp.
    pub barn_map: Option<BarnMap>,
}

/// The components of the light model on the entity of a light.
pub type LightModelParts<'a> = (
    Option<&'a LightShape>,
    Option<&'a LightDistance>,
    Option<&'a LightWeights>,
    Option<&'a ShadowTint>,
    Option<&'a ShadowOrigin>,
    Option<&'a ShadowSoftness>,
    Option<&'a BarnMap>,
);

/// Why a part of a light's model has no effect.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LightModelFault {
    /// A size or an edge of the shape is NaN or negative.
    #[error("{name} of LightShape is {value}, it must be at least 0")]
    Shape {
        /// Name of the field.
        name: &'static str,
        /// Value of the field.
        value: f32,
    },
    /// The roundness is NaN or outside its range.
    #[error("round of LightShape is {0}, it must be 0 to 1")]
    Round(f32),
    /// A number of the distances is NaN, or an edge is negative.
    #[error("{name} of LightDistance is {value}, it must be at least 0")]
    Distance {
        /// Name of the field.
        name: &'static str,
        /// Value of the field.
        value: f32,
    },
    /// The nearest depth lies beyond the farthest one.
    #[error("near of LightDistance is {near} m and far is {far} m, near must be at most far")]
    NearBeyondFar {
        /// Nearest depth, metres.
        near: f32,
        /// Farthest depth, metres.
        far: f32,
    },
    /// A directional light has a component that only lights with a place have.
    #[error("{0} does not fit a directional light")]
    Directional(&'static str),
    /// A weight is NaN, negative or infinite.
    #[error("{name} of LightWeights is {value}, it must be finite and at least 0")]
    Weight {
        /// Name of the field.
        name: &'static str,
        /// Value of the field.
        value: f32,
    },
    /// A component of the shadow's colour is NaN, negative or infinite.
    #[error("color of ShadowTint is {0}, its components must be finite and at least 0")]
    ShadowColor(Vec3),
    /// The darkness is NaN or outside its range.
    #[error("darkness of ShadowTint is {0}, it must be 0 to 1")]
    Darkness(f32),
    /// The place of the shadow's origin is not finite, or its direction has no length.
    #[error("ShadowOrigin is {0}, it must be finite, and a direction must have a length")]
    Origin(Vec3),
    /// The shadow's origin does not fit the light.
    #[error("ShadowOrigin has a {has}, this light needs a {needs}")]
    OriginKind {
        /// What the component has.
        has: &'static str,
        /// What the light needs.
        needs: &'static str,
    },
    /// A number of the cookie cannot be used.
    #[error("Cookie: {0}")]
    Cookie(CookieError),
    /// The shadow's origin lies behind a light that shines to one side. The origin is used.
    #[error("ShadowOrigin lies behind the light, so that objects behind the light cast shadows, too")]
    OriginBehind,
    /// The resolution of the barn map is out of its range.
    #[error("resolution of BarnMap is {0}, it must be 1 to 2048")]
    BarnMap(u32),
    /// The softness is NaN, negative or infinite.
    #[error("ShadowSoftness is {0} m, it must be finite and at least 0")]
    Softness(f32),
}

impl LightModelFault {
    /// Returns whether the part is left out. Otherwise it is used, and only looks like a mistake.
    pub fn leaves_out(&self) -> bool {
        !matches!(self, Self::OriginBehind)
    }

    /// The number of the fault among the reports of a light.
    pub fn code(&self) -> u32 {
        match self {
            Self::Shape { .. } => 1,
            Self::Round(_) => 2,
            Self::Distance { .. } => 3,
            Self::NearBeyondFar { .. } => 4,
            Self::Directional("LightShape") => 5,
            Self::Directional("LightProfile") => 14,
            Self::Directional(_) => 6,
            Self::Weight { .. } => 7,
            Self::ShadowColor(_) => 8,
            Self::Darkness(_) => 9,
            Self::Origin(_) => 10,
            Self::OriginKind { .. } => 11,
            Self::Softness(_) => 12,
            Self::Cookie(_) => 15,
            Self::OriginBehind => 13,
            Self::BarnMap(_) => 16,
        }
    }
}

impl LightModel {
    /// Gathers the usable parts of a light's components. Calls `fault` for each part that is not usable.
    pub fn of(parts: LightModelParts<'_>, kind: LightKind, mut fault: impl FnMut(LightModelFault)) -> Self {
        let (shape, distance, weights, tint, origin, softness, barn_map) = parts;
        let is_directional = kind == LightKind::Directional;
        let mut take = |error: Option<LightModelFault>| match error {
            Some(error) => {
                fault(error);
                false
            }
            None => true,
        };
        let shape = shape
            .filter(|shape| take(shape_fault(shape, is_directional)) && !shape.is_unbounded())
            .copied();
        let barn_map = barn_map
            .filter(|map| take((!map.is_valid()).then_some(LightModelFault::BarnMap(map.resolution))))
            .copied();
        Self {
            shape,
            barn_map: barn_map.filter(|map| shape.is_some_and(|shape| map.holds(&shape))),
            distance: distance
                .filter(|distance| take(distance_fault(distance, is_directional)) && !distance.is_unbounded())
                .copied(),
            weights: weights
                .filter(|weights| take(weights_fault(weights)))
                .copied()
                .unwrap_or_default(),
            tint: tint
                .filter(|tint| take(tint_fault(tint)))
                .copied()
                .unwrap_or_default(),
            origin: origin
                .filter(|origin| take(origin_fault(origin, is_directional)))
                .copied(),
            softness: softness.map(|softness| softness.0).filter(|softness| {
                take((!is_weight(*softness)).then_some(LightModelFault::Softness(*softness)))
            }),
        }
    }

    /// The share of the light that its shape and its distances let pass towards a point, 0 to 1. `point` is in light
    /// space: x and y along the doors, z the depth in front of the light.
    pub fn factor(&self, point: Vec3) -> f32 {
        let shape = self.shape.map_or(1.0, |shape| shape.factor(point));
        let depth = LightDistance::depth_of(point, self.shape.is_some());
        shape * self.distance.map_or(1.0, |distance| distance.factor(depth))
    }

    /// Returns the parts on which the light's place, its volume and its sets depend.
    pub fn bounds(&self) -> impl PartialEq + use<> {
        let origin = self.origin.map(|origin| match origin {
            ShadowOrigin::Position(point) => point.extend(1.0),
            ShadowOrigin::Direction(towards) => towards.extend(0.0),
        });
        (
            self.shape,
            self.distance,
            origin,
            self.softness,
            self.lights_shadows(),
        )
    }

    /// Returns whether the light is scaled by its shape or its distances.
    pub fn is_shaped(&self) -> bool {
        self.shape.is_some() || self.distance.is_some()
    }

    /// Returns whether the light gives something to surfaces that it does not see: ambient light, or a shadow that
    /// is not black.
    pub fn lights_shadows(&self) -> bool {
        self.weights.ambient > 0.0 || self.tint.color != Vec3::ZERO || self.tint.darkness < 1.0
    }

    /// Returns whether the light pass must tell ambient, diffuse and specular light apart.
    pub fn is_weighted(&self) -> bool {
        self.weights != LightWeights::default() || self.lights_shadows()
    }
}

fn shape_fault(shape: &LightShape, is_directional: bool) -> Option<LightModelFault> {
    let fields = [
        ("width", shape.width),
        ("height", shape.height),
        ("width_edge", shape.width_edge),
        ("height_edge", shape.height_edge),
    ];
    if let Some(&(name, value)) = fields.iter().find(|(_, value)| !(*value >= 0.0)) {
        return Some(LightModelFault::Shape { name, value });
    }
    if !(0.0..=1.0).contains(&shape.round) {
        return Some(LightModelFault::Round(shape.round));
    }
    (is_directional && !shape.is_unbounded()).then_some(LightModelFault::Directional("LightShape"))
}

fn distance_fault(distance: &LightDistance, is_directional: bool) -> Option<LightModelFault> {
    let fields = [
        ("near", distance.near),
        ("far", distance.far),
        ("near_edge", distance.near_edge),
        ("far_edge", distance.far_edge),
    ];
    if let Some(&(name, value)) = fields.iter().find(|(_, value)| !(*value >= 0.0)) {
        return Some(LightModelFault::Distance { name, value });
    }
    let (near, far) = (distance.near, distance.far);
    if near > far || near == f32::INFINITY {
        return Some(LightModelFault::NearBeyondFar { near, far });
    }
    (is_directional && !distance.is_unbounded()).then_some(LightModelFault::Directional("LightDistance"))
}

fn weights_fault(weights: &LightWeights) -> Option<LightModelFault> {
    let fields = [
        ("ambient", weights.ambient),
        ("diffuse", weights.diffuse),
        ("specular", weights.specular),
    ];
    let (name, value) = *fields.iter().find(|(_, value)| !is_weight(*value))?;
    Some(LightModelFault::Weight { name, value })
}

fn tint_fault(tint: &ShadowTint) -> Option<LightModelFault> {
    if !tint.color.to_array().into_iter().all(is_weight) {
        return Some(LightModelFault::ShadowColor(tint.color));
    }
    (!(0.0..=1.0).contains(&tint.darkness)).then_some(LightModelFault::Darkness(tint.darkness))
}

fn origin_fault(origin: &ShadowOrigin, is_directional: bool) -> Option<LightModelFault> {
    let (has, needs) = ("position", "direction");
    match *origin {
        ShadowOrigin::Position(_) if is_directional => Some(LightModelFault::OriginKind { has, needs }),
        ShadowOrigin::Direction(_) if !is_directional => Some(LightModelFault::OriginKind {
            has: needs,
            needs: has,
        }),
        ShadowOrigin::Position(point) => (!point.is_finite()).then_some(LightModelFault::Origin(point)),
        ShadowOrigin::Direction(towards) => towards
            .try_normalize()
            .is_none()
            .then_some(LightModelFault::Origin(towards)),
    }
}

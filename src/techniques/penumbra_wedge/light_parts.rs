//! The parts of a light. Wedges treat each part as a light of its own. Rectangles and spheres may be split;
//! every other light is one part.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::component::PenumbraWedge;
use crate::scene::LightKind;
use crate::sets::FrameLight;

/// The shape of a part of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartShape {
    /// A point without extent, whose shadow is hard.
    Point,
    /// A rectangle in the XY plane of light space, which shines to −Z.
    Rect {
        /// Half of the width and of the height, metres; > 0.
        half: DVec2,
    },
    /// A sphere. The disc through its centre that faces the receiver stands for it.
    Sphere {
        /// Radius, metres; > 0.
        radius: f64,
    },
}

impl PartShape {
    /// Radius of the sphere around the part, metres.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Point => 0.0,
            Self::Rect { half } => half.length(),
            Self::Sphere { radius } => radius,
        }
    }
}

/// One part of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPart {
    /// The part's centre as a homogeneous point in world space, like [`FrameLight::point_world`].
    pub point_world: DVec4,
    /// Transform from light space (the part's centre, the light's axes, world scale) to world space. It has
    /// no rotation for points and spheres, and no translation for directional lights.
    pub world_from_light: DMat4,
    /// Shape in light space.
    pub shape: PartShape,
    /// Centre and half size of the part within the light, which spans −1 to 1 along its width and height.
    pub place: [f32; 4],
    /// Centre of the whole light, in light space.
    pub whole_center: DVec3,
    /// Radius of the whole sphere before it is split, metres; 0 for other lights.
    pub whole_radius: f64,
}

/// An extent below this length counts as none, metres.
pub const LEAST_EXTENT: f64 = 1e-6;

/// A rectangle without width or height is a line. Its missing side becomes this share of the other.
const LINE_SHARE: f64 = 1e-3;

/// Appends the parts of a light, row by row.
pub fn push_parts(light: &FrameLight, settings: &PenumbraWedge, parts: &mut Vec<LightPart>) {
    let point = light.point_world;
    let centered = |shape| LightPart {
        point_world: point,
        world_from_light: DMat4::from_translation(point.truncate() * point.w),
        shape,
        place: [0.0, 0.0, 1.0, 1.0],
        whole_center: DVec3::ZERO,
        whole_radius: 0.0,
    };
    match light.light.kind {
        LightKind::Point | LightKind::Spot { .. } | LightKind::Sphere { .. }
            if light.emitter.radius > LEAST_EXTENT =>
        {
            let [columns, rows] = settings.parts();
            let count = columns * rows;
            let whole_radius = light.emitter.radius;
            let shape = PartShape::Sphere {
                radius: whole_radius / f64::from(count).sqrt(),
            };
            let centers = sphere_centers(count).map(|center| center * whole_radius);
            parts.extend(centers.map(|offset| LightPart {
                point_world: point + (offset * point.w).extend(0.0),
                world_from_light: DMat4::from_translation((point.truncate() + offset) * point.w),
                whole_center: -offset,
                whole_radius,
                ..centered(shape)
            }));
        }
        LightKind::Rect { width, height } if f64::from(width.max(height)) > LEAST_EXTENT => {
            let size = DVec2::new(f64::from(width), f64::from(height)) * light.softened();
            let size = size.max(DVec2::splat(size.max_element() * LINE_SHARE));
            let [right, up] = light.emitter.half_sides;
            let axes = axes(light, right, up);
            let [columns, rows] = settings.parts();
            let count = DVec2::new(f64::from(columns), f64::from(rows));
            for row in 0..rows {
                for column in 0..columns {
                    let cell = DVec2::new(f64::from(column), f64::from(row));
                    let place = (cell * 2.0 + 1.0) / count - 1.0;
                    let center = point.truncate() + axes * (place * size * 0.5).extend(0.0);
                    parts.push(LightPart {
                        point_world: center.extend(1.0),
                        world_from_light: DMat4::from_translation(center) * DMat4::from_mat3(axes),
                        shape: PartShape::Rect {
                            half: size * 0.5 / count,
                        },
                        place: [
                            place.x as f32,
                            place.y as f32,
                            count.x.recip() as f32,
                            count.y.recip() as f32,
                        ],
                        whole_center: (-place * size * 0.5).extend(0.0),
                        whole_radius: 0.0,
                    });
                }
            }
        }
        _ => parts.push(centered(PartShape::Point)),
    }
}

/// Returns the centres of the spheres into which a unit sphere is split. The visible disc of each has the
/// area of the whole disc divided by their count.
///
/// The discs should fill the whole disc from whichever side the light is seen. So the centres lie evenly on a
/// sphere whose radius preserves the light's extent, measured as the mean square of its places. Discs do not
/// tile a disc: the coverage of an edge errs by 0.036 of the light for four parts, 0.020 for nine and 0.012
/// for many (mean over sides and edges, computed). Distances by quantiles of `1/√(1 − R²)`, whose projection
/// is uniform, err more.
fn sphere_centers(count: u32) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    // The mean squared distance from the centre is ½ on a unit disc and 1 / (2 count) on a part's own disc.
    // Two thirds of a centre's squared distance remain in projection.
    let distance = (0.75 * (1.0 - f64::from(count).recip())).sqrt();
    (0..count).map(move |i| {
        let height = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let flat = (1.0 - height * height).sqrt();
        DVec3::new(flat * cos, height, flat * sin) * distance
    })
}

/// The light's own axes: right, up, and the reverse of the direction of shining.
fn axes(light: &FrameLight, right: DVec3, up: DVec3) -> DMat3 {
    let back = -light.direction.as_dvec3().normalize();
    // A side without length has no direction. Sides need not be exactly at right angles to the direction of
    // shining.
    let right = (right - back * right.dot(back))
        .try_normalize()
        .or_else(|| up.cross(back).try_normalize())
        .unwrap_or_else(|| back.any_orthonormal_vector());
    DMat3::from_cols(right, back.cross(right), back)
}

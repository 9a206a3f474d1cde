//! The map that a light asks for, whatever its technique. Requests that cannot be drawn are refused.

use bevy_ecs::prelude::*;
use smallvec::SmallVec;

use super::cascades::MOST_CASCADES;
use super::face::MapFace;
use super::settings::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use crate::scene::{Light, LightKind};
use crate::sets::{FrameLight, FrameLights};
use crate::techniques::registry::Refusal;

/// The stages of maps within [`BuildTechniques`](crate::schedule::AntumbraSystems::BuildTechniques), chained.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MapSystems {
    /// After this set [`MapRequests`] holds the requests of the lights of every technique with maps.
    Request,
    /// After this set the [`Maps`](super::Maps) are those of this frame.
    Build,
}

/// The faces of one map.
pub type MapFaces = SmallVec<[MapFace; 6]>;

/// The maps that the lights of this frame ask for. Each technique with maps writes its lights' requests in
/// the set [`MapSystems::Request`].
#[derive(Resource, Clone, Debug, Default)]
pub struct MapRequests {
    requests: Vec<LightRequest>,
}

/// What one light asks for.
#[derive(Clone, Debug, PartialEq)]
pub struct LightRequest {
    /// Index of the light in [`FrameLights`].
    pub light: usize,
    /// The map that the light asks for.
    pub request: MapRequest,
    /// The faces of [`MapShape::Matrices`] in this frame; empty for other shapes, whose faces are computed.
    pub faces: MapFaces,
    /// Factor on the automatic resolution of [`MapShape::Matrices`], at least 1: how much longer texels on the screen are
    /// than in a good fit. Other shapes ignore it.
    pub stretch: f64,
}

impl MapRequests {
    /// Adds the requests of the lights that are shadowed by the technique with the component `T`.
    pub fn list<T: Component>(
        &mut self,
        lights: &FrameLights,
        components: &Query<&T>,
        request: impl Fn(&T, &FrameLight) -> Result<MapRequest, Refusal>,
    ) {
        for (index, light) in lights.lights.iter().enumerate() {
            if !light.is_shadowed_by::<T>() {
                continue;
            }
            // A refused light has no technique in this frame, so it does not get here.
            let asked = components.get(light.entity).map(|map| request(map, light));
            if let Ok(Ok(request)) = asked {
                self.push(LightRequest {
                    light: index,
                    request,
                    faces: MapFaces::new(),
                    stretch: 1.0,
                });
            }
        }
    }

    /// Adds the request of one light.
    pub fn push(&mut self, request: LightRequest) {
        self.requests.push(request);
    }

    /// Removes all requests and yields them in ascending order of their light's index.
    pub fn drain(&mut self) -> impl Iterator<Item = LightRequest> + '_ {
        self.requests.sort_unstable_by_key(|request| request.light);
        self.requests.drain(..)
    }
}

/// Least distance of a near plane, metres. Depth is its share of the distance, which must stay far above the least `f32`.
const LEAST_NEAR: f32 = 1e-9;

/// Text of refusals about settings that may be any finite number from 0 on.
const FINITE: &str = "it must be finite and at least 0";

fn resolution(texels: u32) -> Refusal {
    let allowed = "it must be greater than 0, and the least at most the most";
    Refusal::setting("resolution", texels as f32, allowed)
}

/// Arrangement of the faces of a light's map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MapShape {
    /// One face along the axis of a spot light.
    Spot,
    /// Six faces of a cube.
    Cube,
    /// Boxes of a directional light, one for each of consecutive parts of the view depth.
    Cascades,
    /// Faces with a matrix each ([`FaceProjection::Matrix`](super::FaceProjection::Matrix)), which the
    /// technique hands over with its request in every frame.
    Matrices,
}

/// Half-angle, radians, beyond which a spot light's map has the faces of a cube. A single face would spend
/// most of its texels near its rim.
const WIDEST_SPOT: f64 = 1.05;

impl MapShape {
    /// Returns the arrangement that shows everything that a light can shine on, from where it shines.
    pub fn of_light(light: &Light) -> Self {
        match light.kind {
            LightKind::Directional => Self::Cascades,
            LightKind::Spot { outer_angle, .. } => Self::of_cone(f64::from(outer_angle)),
            _ => Self::Cube,
        }
    }

    fn of_cone(half_angle: f64) -> Self {
        if half_angle <= WIDEST_SPOT {
            Self::Spot
        } else {
            Self::Cube
        }
    }
}

/// A second picture of each face, two half floats a texel. The recorder of the technique draws it beside the
/// depth of the casters, and looks the map up itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beside {
    /// Distance in metres by which the picture reaches beyond the outlines of casters.
    pub metres: f32,
    /// Further distance by which the picture reaches beyond the outlines of casters, as a share of the distance
    /// from the light.
    pub share: f32,
    /// Distance in metres between caster and receiver at which the shadow of a directional light is as soft as the
    /// picture can show. Other lights ignore it.
    pub drop: f32,
}

/// The map that a light asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapRequest {
    /// Arrangement of the faces.
    pub shape: MapShape,
    /// Number of texels along a side.
    pub resolution: MapResolution,
    /// Filter that combines the comparisons of a pixel with the map.
    pub filter: MapFilter,
    /// Format of a texel.
    pub format: MapFormat,
    /// Surface of the casters that the map holds.
    pub surface: MapSurface,
    /// Bias that keeps a surface from shadowing itself.
    pub bias: MapBias,
    /// Distance from the light within which nothing casts, metres. `None` follows the clearance of the light
    /// and the nearest caster.
    pub near: Option<f32>,
    /// Whether the map is kept from frame to frame.
    pub cached: bool,
    /// Cascades of a directional light. Other shapes ignore them.
    pub cascades: Cascades,
    /// Second picture of each face; `None` if the depth of the casters is the whole map.
    pub beside: Option<Beside>,
    /// Whether the technique's own recorder draws and looks up the map, instead of the recorder of maps.
    pub apart: bool,
    /// Whether the technique keeps two more pictures of each face, of 4 bytes a texel.
    pub pictures: bool,
    /// Number of layers of the texture of [`MapShape::Matrices`], 1 to 6. Other shapes ignore it.
    pub layers: u32,
}

impl MapRequest {
    /// Returns the request with the arrangement of faces that shows all that a spot light lights from the place of its
    /// shadows ([`FrameLight::shadow_cone`]): barn doors make its cone narrower, and another place sees it from the side.
    pub fn placed(mut self, light: &FrameLight) -> Self {
        if let Some((_, half_angle)) = light.shadow_cone() {
            self.shape = MapShape::of_cone(half_angle);
        }
        self
    }

    /// Returns the request with the softness that the light's model gives its shadows, if it gives one
    /// ([`ShadowSoftness`](crate::scene::ShadowSoftness)).
    pub fn softened(mut self, light: &FrameLight) -> Self {
        if let Some(softness) = light.model.softness {
            self.filter = self.filter.softened(softness);
        }
        self
    }

    /// Returns the request if it can be drawn for the light.
    ///
    /// # Errors
    /// The refusal of the first setting with which nothing can be drawn.
    pub fn validated(self, light: &Light) -> Result<Self, Refusal> {
        let usable = |x: f32| x.is_finite() && x >= 0.0;
        match self.resolution {
            MapResolution::Fixed(0) => return Err(resolution(0)),
            MapResolution::Auto { least, most } if least == 0 || least > most => {
                return Err(resolution(least));
            }
            _ => {}
        }
        if let Some(softness) = self.filter.softness().filter(|softness| !usable(*softness)) {
            return Err(Refusal::setting("softness", softness, FINITE));
        }
        if let MapBias::Manual {
            normal_texels,
            depth_metres,
            distance_share,
        } = self.bias
        {
            for bias in [normal_texels, depth_metres, distance_share] {
                if !usable(bias) {
                    return Err(Refusal::setting("bias", bias, FINITE));
                }
            }
            if distance_share >= 1.0 {
                return Err(Refusal::setting(
                    "bias",
                    distance_share,
                    "its share of the distance must be less than 1",
                ));
            }
        }
        if self.shape == MapShape::Cascades {
            return self.validated_cascades();
        }
        let range = light.range;
        if light.kind != LightKind::Directional
            && let Some(near) = self.near
            && !(near >= LEAST_NEAR && near < range)
        {
            return Err(Refusal::Setting {
                setting: "near",
                value: near,
                unit: " m",
                allowed: "it must be at least 1e-9 m and less than the light's range; `None` chooses it",
            });
        }
        Ok(self)
    }

    fn validated_cascades(self) -> Result<Self, Refusal> {
        let Cascades {
            count,
            distance,
            log_share,
            blend,
        } = self.cascades;
        if !(1..=MOST_CASCADES).contains(&count) {
            return Err(Refusal::setting(
                "number of cascades",
                count as f32,
                "1 to 4 are possible",
            ));
        }
        if !(distance > 0.0) {
            return Err(Refusal::Setting {
                setting: "distance of the cascades",
                value: distance,
                unit: " m",
                allowed: "it must be greater than 0",
            });
        }
        if !(0.0..=1.0).contains(&log_share) {
            return Err(Refusal::setting(
                "log share of the cascades",
                log_share,
                "0 to 1 are possible",
            ));
        }
        if !(0.0..=0.5).contains(&blend) {
            return Err(Refusal::setting(
                "blend of the cascades",
                blend,
                "0 to 0.5 are possible",
            ));
        }
        Ok(self)
    }

    /// Returns the number of faces of the map.
    pub fn face_count(&self) -> u32 {
        match self.shape {
            MapShape::Spot => 1,
            MapShape::Cube => 6,
            MapShape::Cascades => self.cascades.count,
            MapShape::Matrices => self.layers,
        }
    }

    /// Whether the texture that is looked up differs from the depth into which casters are drawn.
    pub fn has_final(&self) -> bool {
        self.format != MapFormat::Depth || self.surface != MapSurface::Nearest
    }
}

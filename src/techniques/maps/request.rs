//! What a light asks for: the components of both kinds of map in one form, with everything refused that cannot be drawn.

use crate::scene::{Light, LightKind};
use crate::techniques::omni_map::OmniMap;
use crate::techniques::shadow_map::cascades::MOST_CASCADES;
use crate::techniques::shadow_map::{Cascades, ShadowMap};

use super::settings::{MapBias, MapError, MapFilter, MapFormat, MapResolution, MapSurface};

/// How the faces of a light's map stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MapShape {
    /// One face along the axis of a spot light.
    Spot,
    /// Six faces of a cube.
    Cube,
    /// Boxes behind one another.
    Cascades,
}

/// Which component a light has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MapComponent {
    /// [`ShadowMap`].
    Shadow,
    /// [`OmniMap`].
    Omni,
}

/// What a light asks for; all numbers usable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapRequest {
    /// Its component.
    pub component: MapComponent,
    /// How the faces stand.
    pub shape: MapShape,
    /// Texels along a side.
    pub resolution: MapResolution,
    /// How comparisons are put together.
    pub filter: MapFilter,
    /// What a texel holds.
    pub format: MapFormat,
    /// Which surface.
    pub surface: MapSurface,
    /// What keeps a surface from shadowing itself.
    pub bias: MapBias,
    /// Metres; `None`: a share of the range.
    pub near: Option<f32>,
    /// The map is kept.
    pub cached: bool,
    /// Of a directional light.
    pub cascades: Cascades,
}

/// Half-angle beyond which a spot light's map has the faces of a cube, radians: there a face spends most of its texels
/// near its rim.
const WIDEST_SPOT: f32 = 1.05;

fn light_name(kind: LightKind) -> &'static str {
    match kind {
        LightKind::Point => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Directional => "directional",
        LightKind::Rect { .. } => "rectangle",
        LightKind::Sphere { .. } => "sphere",
    }
}

impl MapRequest {
    /// What a [`ShadowMap`] asks for.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn of_shadow_map(map: &ShadowMap, light: &Light) -> Result<Self, MapError> {
        let shape = match light.kind {
            LightKind::Directional => MapShape::Cascades,
            LightKind::Spot { outer_angle, .. } if outer_angle > WIDEST_SPOT => MapShape::Cube,
            LightKind::Spot { .. } => MapShape::Spot,
            kind => {
                return Err(MapError::Kind {
                    component: "ShadowMap",
                    light: light_name(kind),
                    instead: "it needs a spot or directional light; use OmniMap for a light with a position",
                });
            }
        };
        let request = Self {
            component: MapComponent::Shadow,
            shape,
            resolution: map.resolution,
            filter: map.filter,
            format: MapFormat::Depth,
            surface: map.surface,
            bias: map.bias,
            near: map.near,
            cached: map.cached,
            cascades: map.cascades,
        };
        request.validated(light)
    }

    /// What an [`OmniMap`] asks for.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn of_omni_map(map: &OmniMap, light: &Light) -> Result<Self, MapError> {
        if light.kind == LightKind::Directional {
            return Err(MapError::Kind {
                component: "OmniMap",
                light: "directional",
                instead: "it needs a light with a position; use ShadowMap for a directional light",
            });
        }
        let request = Self {
            component: MapComponent::Omni,
            shape: MapShape::Cube,
            resolution: map.resolution,
            filter: map.filter,
            format: map.format,
            surface: map.surface,
            bias: map.bias,
            near: map.near,
            cached: map.cached,
            cascades: Cascades::default(),
        };
        request.validated(light)
    }

    fn validated(self, light: &Light) -> Result<Self, MapError> {
        let usable = |x: f32| x.is_finite() && x >= 0.0;
        match self.resolution {
            MapResolution::Fixed(0) => return Err(MapError::Resolution(0)),
            MapResolution::Auto { least, most } if least == 0 || least > most => {
                return Err(MapError::Resolution(least));
            }
            _ => {}
        }
        if let Some(softness) = self.filter.softness().filter(|softness| !usable(*softness)) {
            return Err(MapError::Softness(softness));
        }
        if let MapBias::Manual {
            normal_texels,
            depth_metres,
            distance_share,
        } = self.bias
        {
            for bias in [normal_texels, depth_metres, distance_share] {
                if !usable(bias) {
                    return Err(MapError::Bias(bias));
                }
            }
            if distance_share >= 1.0 {
                return Err(MapError::Bias(distance_share));
            }
        }
        if self.shape == MapShape::Cascades {
            return self.validated_cascades();
        }
        let range = light.range;
        if let Some(near) = self.near
            && !(near > 0.0 && near < range)
        {
            return Err(MapError::Near { near, range });
        }
        Ok(self)
    }

    fn validated_cascades(self) -> Result<Self, MapError> {
        let Cascades {
            count,
            distance,
            log_share,
            blend,
        } = self.cascades;
        if !(1..=MOST_CASCADES).contains(&count) {
            return Err(MapError::CascadeCount(count));
        }
        let refuse = |what, value| Err(MapError::Cascades { what, value });
        if !(distance > 0.0) {
            return refuse("distance", distance);
        }
        if !(0.0..=1.0).contains(&log_share) {
            return refuse("log share", log_share);
        }
        if !(0.0..=0.5).contains(&blend) {
            return refuse("blend", blend);
        }
        Ok(self)
    }

    /// Faces of the map.
    pub fn face_count(&self) -> u32 {
        match self.shape {
            MapShape::Spot => 1,
            MapShape::Cube => 6,
            MapShape::Cascades => self.cascades.count,
        }
    }

    /// Whether the resolved texture is not the depth that casters are drawn into.
    pub fn has_final(&self) -> bool {
        self.format != MapFormat::Depth || self.surface != MapSurface::Nearest
    }
}

//! The component that gives a light soft shadows by smoothies.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::{Light, LightKind};
use crate::techniques::maps::request::{Beside, MapRequest, MapShape};
use crate::techniques::maps::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use crate::techniques::registry::Refusal;

/// Gives any light soft shadows by a shadow map with smoothies: soft rims that are drawn along the casters'
/// silhouettes, from the light.
///
/// The umbra is that of a hard shadow map. The penumbra lies outside of it; it is sharp where a shadow begins and
/// softens with the distance between caster and receiver. It looks soft but is not exact: an area light's penumbra
/// also reaches into the umbra. Area lights cast from their centre. Alpha-tested casters cast the holes of their
/// texture, with hard edges. Casters block from both sides.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Smoothie {
    /// How wide the penumbra grows. Higher values soften shadows more and fill more texels of the picture from the
    /// light. Default: the size of the light.
    pub width: SmoothieWidth,
    /// Width of the penumbra for each metre between caster and receiver, for directional lights alone; greater than 0.
    /// It is the tangent of the light's angular radius. At a drop of `width / spread` metres the penumbra has its full
    /// width, and does not widen beyond. Higher values soften shadows sooner. Default: 0.00465, that of the sun.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub spread: f32,
    /// Texels along a side of the map, or of each cascade. Higher values sharpen what is near its caster; each
    /// doubling takes four times the memory and fill rate. Default: 128 to 1024, by the light's size on the screen;
    /// cascades take the upper limit.
    pub resolution: MapResolution,
    /// How a surface is kept from shadowing itself. The default needs no setting.
    pub bias: MapBias,
    /// Distance from the light, metres, within which nothing casts; at least 1e-9 and less than the range. Raise it to
    /// ignore casters close to the light, such as a lamp's shade. Directional lights ignore it. Default (`None`): the
    /// light's clearance where it may be on a surface, else at most a hundred-thousandth of the range, and less as far
    /// as a caster is nearer.
    #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.05))]
    pub near: Option<f32>,
    /// Keeps map and smoothies from frame to frame and draws only the faces that changed. This takes 8 bytes a texel and
    /// face, twice that while some casters move. Without it, lights share a map that is drawn every frame. Default:
    /// true.
    pub cached: bool,
    /// How a directional light's maps share the view depth. Other lights ignore it.
    pub cascades: Cascades,
}

/// The width of smoothies: that of the penumbra of a receiver far behind the caster, measured at the caster.
/// Default: [`SmoothieWidth::Light`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "WidthInFile", into = "NamedWidth")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum SmoothieWidth {
    /// The width follows from the light: 0.855 of the radius of a sphere, or of a disc as large as a rectangle. A ramp of
    /// that width is nearest to the penumbra of a disc. A point or spot light has no size; it gets [`SmoothieWidth::Share`] 0.02. A directional light gets 0.1 m.
    #[default]
    Light,
    /// The width in metres, at least 0.
    Metres(f32),
    /// The width as a share of the distance between light and caster, at least 0. The penumbra is equally wide in the
    /// picture from the light everywhere. A directional light is at no distance and is refused.
    Share(f32),
}

/// A width as a file holds it: a number of metres, `"light"`, `{"metres": 0.1}` or `{"share": 0.02}`.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(
    untagged,
    expecting = "expected a width: metres, \"light\", {\"metres\": 0.1} or {\"share\": 0.02}"
)]
enum WidthInFile {
    /// The width in metres, at least 0.
    #[cfg_attr(feature = "schema", schemars(extend("x-rust" = "SmoothieWidth::Metres(_)")))]
    Number(#[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.1))] f32),
    /// A width by its name.
    Named(NamedWidth),
}

#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum NamedWidth {
    /// The width follows from the size of the light.
    #[cfg_attr(feature = "schema", schemars(extend("x-rust" = "SmoothieWidth::Light")))]
    Light,
    /// The width in metres, at least 0.
    #[cfg_attr(feature = "schema", schemars(extend("x-rust" = "SmoothieWidth::Metres(_)")))]
    Metres(#[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.1))] f32),
    /// The width as a share of the distance between light and caster, at least 0.
    #[cfg_attr(feature = "schema", schemars(extend("x-rust" = "SmoothieWidth::Share(_)")))]
    Share(#[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.02))] f32),
}

#[cfg(feature = "serde")]
impl From<SmoothieWidth> for NamedWidth {
    fn from(width: SmoothieWidth) -> Self {
        match width {
            SmoothieWidth::Light => Self::Light,
            SmoothieWidth::Metres(metres) => Self::Metres(metres),
            SmoothieWidth::Share(share) => Self::Share(share),
        }
    }
}

#[cfg(feature = "serde")]
impl From<WidthInFile> for SmoothieWidth {
    fn from(width: WidthInFile) -> Self {
        match width {
            WidthInFile::Number(metres) | WidthInFile::Named(NamedWidth::Metres(metres)) => {
                Self::Metres(metres)
            }
            WidthInFile::Named(NamedWidth::Share(share)) => Self::Share(share),
            WidthInFile::Named(NamedWidth::Light) => Self::Light,
        }
    }
}

impl Default for Smoothie {
    fn default() -> Self {
        Self {
            width: SmoothieWidth::default(),
            spread: SUN,
            resolution: MapResolution::default(),
            bias: MapBias::default(),
            near: None,
            cached: true,
            cascades: Cascades::default(),
        }
    }
}

/// Width of the ramp nearest to the penumbra of a disc, as a share of its radius: with g(x) = 2/π (x √(1 − x²) + asin x),
/// what half of the disc leaves at x radii from the edge, it gives the least mean square of min(x / w, 1) − g(x) over the
/// radius. The rest is 0.025, where a ramp as wide as the radius leaves 0.083.
const RAMP_OF_DISC: f32 = 0.855;

/// Tangent of the sun's angular radius, 16 minutes of arc.
const SUN: f32 = 0.00465;

/// Width of the smoothies of a light without a size, as a share of the distance: a lamp of 6 cm radius 3 m away from
/// its caster. By eye.
const SHARE_OF_POINT: f32 = 0.02;

/// Width of the smoothies of a directional light, metres: the sun's penumbra of a house, 21 m behind its roof.
const METRES_OF_SUN: f32 = 0.1;

impl Smoothie {
    /// Returns the component with the width of a light of another size
    /// ([`ShadowSoftness`](crate::scene::ShadowSoftness)): that of a sphere with the radius `softness`. Of a directional
    /// light `softness` is the width, metres, and the spread grows with it, as if the sun were larger.
    pub fn softened(&self, softness: f32, light: &Light) -> Self {
        let mut soft = *self;
        if light.kind != LightKind::Directional {
            soft.width = SmoothieWidth::Metres(RAMP_OF_DISC * softness);
            return soft;
        }
        let own = match self.width {
            SmoothieWidth::Metres(metres) => metres,
            SmoothieWidth::Light => METRES_OF_SUN,
            SmoothieWidth::Share(_) => 0.0, // refused with any softness
        };
        soft.width = SmoothieWidth::Metres(softness);
        if own > 0.0 && softness > 0.0 {
            soft.spread = self.spread * softness / own;
        }
        soft
    }

    /// Width and drop of the smoothies in a light.
    fn beside(&self, light: &Light) -> Result<Beside, Refusal> {
        let is_directional = light.kind == LightKind::Directional;
        let (metres, share) = match self.width {
            SmoothieWidth::Metres(metres) => (metres, 0.0),
            SmoothieWidth::Share(_) if is_directional => {
                let instead =
                    "a width that is a share of the distance needs a light at a distance; use metres";
                return Err(Refusal::kind(light, instead));
            }
            SmoothieWidth::Share(share) => (0.0, share),
            SmoothieWidth::Light => match light.kind {
                LightKind::Sphere { radius } => (RAMP_OF_DISC * radius, 0.0),
                LightKind::Rect { width, height } => {
                    (RAMP_OF_DISC * (width * height / std::f32::consts::PI).sqrt(), 0.0)
                }
                LightKind::Point | LightKind::Spot { .. } => (0.0, SHARE_OF_POINT),
                LightKind::Directional => (METRES_OF_SUN, 0.0),
            },
        };
        for value in [metres, share] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Refusal::setting(
                    "width",
                    value,
                    "it must be finite and at least 0",
                ));
            }
        }
        if is_directional && !(self.spread > 0.0 && self.spread.is_finite()) {
            let allowed = "it must be finite and greater than 0";
            return Err(Refusal::setting("spread", self.spread, allowed));
        }
        Ok(Beside {
            metres,
            share,
            // A width of 0 darkens nothing; any drop will do.
            drop: if is_directional && metres > 0.0 {
                metres / self.spread
            } else {
                1.0
            },
        })
    }

    /// Returns the map request of the component.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn request(&self, light: &Light) -> Result<MapRequest, Refusal> {
        let request = MapRequest {
            shape: MapShape::of_light(light),
            resolution: self.resolution,
            filter: MapFilter::Bilinear,
            format: MapFormat::Depth,
            surface: MapSurface::Nearest,
            bias: self.bias,
            near: self.near,
            cached: self.cached,
            cascades: self.cascades,
            beside: Some(self.beside(light)?),
            apart: true,
            pictures: false,
            layers: 0,
        };
        request.validated(light)
    }
}

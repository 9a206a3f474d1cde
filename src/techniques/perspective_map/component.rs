//! The component that gives a light a perspective map.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;

use crate::scene::Light;
use crate::techniques::maps::request::{MapRequest, MapShape};
use crate::techniques::maps::{Cascades, MapBias, MapFilter, MapFormat, MapResolution, MapSurface};
use crate::techniques::registry::Refusal;

/// Gives any light shadows by a map whose texels are where the screen's pixels are.
///
/// The map follows the view. Its texels are finest where the viewer is near, which serves large scenes with one
/// picture; when the view moves, edges of shadows change by up to a texel. Area lights cast from their centre.
/// In an orthographic view the map is a uniform one, and a report says so.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
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
pub struct PerspectiveMap {
    /// Texels along a side of each face. Higher values sharpen edges; each doubling takes four times the memory
    /// and fill rate. Default: 128 to 1024, by the light's size on the screen.
    pub resolution: MapResolution,
    /// How comparisons with the map are combined: more taps soften or smooth edges and cost texture reads.
    /// Default: bilinear.
    pub filter: MapFilter,
    /// How a surface is kept from shadowing itself. The default needs no setting.
    pub bias: MapBias,
    /// How casters behind the viewer are handled. Default: the inverse projection.
    pub projection: PerspectiveProjection,
    /// Whether the map is one picture or several. Default: one.
    pub faces: PerspectiveFaces,
    /// What the map must show. Default: the receivers.
    pub focus: MapFocus,
    /// Distance, at least 0, by which a virtual viewer stands behind the eye, in the view's units; the near
    /// plane stays where it is. 0 gives near surfaces the most texels and far ones the fewest; higher values
    /// even them out, and an infinite slide would be a uniform map. The sum of the slide and the distance of
    /// the near plane is raised to at least the largest of three lengths: 1/255 of the visible depth; three quarters of the
    /// depth at which one of 144 lines of sight first meets a receiver; 1/8192 of the depth to the corners of flat grounds.
    /// Orthographic views have no slide. Default (`None`): measured in every frame, so that texels on the screen are
    /// shortest, by the mean of their longer sides.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub slide: Option<f32>,
    /// Distance from a light at a position, metres, within which nothing casts; at least 1e-9 and less than
    /// the range. Raise it to ignore casters close to the light, such as a lamp's shade. Default (`None`): it
    /// follows the light's clearance and the nearest caster, as in plain maps. Directional lights ignore it.
    #[cfg_attr(feature = "schema", schemars(range(min = 0), example = 0.05))]
    pub near: Option<f32>,
    /// Keeps the map while view, light and casters stand still. This takes 4 bytes a texel and face, twice that
    /// while some casters move, and draws more casters when the view moves. Without it, lights share a map that
    /// is drawn every frame. Default: false, because most views move.
    pub cached: bool,
}

/// How a perspective map handles casters behind the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum PerspectiveProjection {
    /// The picture sees past infinity, so casters may be anywhere. Source: Kozlov 2004, GPU Gems ch. 14,
    /// §14.2.1.
    #[default]
    Inverse,
    /// A virtual viewer stands behind all casters. The farther it must go, the fewer texels are near the eye, and
    /// their number jumps when a caster comes or goes. Source: Stamminger & Drettakis 2002, "Perspective Shadow
    /// Maps".
    SlideBack,
}

/// The pictures of a perspective map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum PerspectiveFaces {
    /// One picture, with the axis of the smallest cone around what it must show. A light with a position that
    /// has receivers all around gets the cube's faces while it needs them, and so does one around which they are so wide that one
    /// picture would be coarse, such as a lamp below a ceiling. A directional light that shines along the view
    /// or against it gets the cube's faces as well, with half the side, and so does one whose texels would be large in a world
    /// of kilometres.
    #[default]
    One,
    /// A cube map with a displaced centre: three to five faces for a light outside what the view shows, up to
    /// six for one inside. Each face has [`PerspectiveMap::resolution`]; the texels are spread more evenly over
    /// the screen where the light is ahead or behind.
    Cube,
}

/// The part of the view that a perspective map must show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Default, Debug, Clone, PartialEq, Hash)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MapFocus {
    /// The bounds of the visible receivers, cut by the view. Gives the finest texels.
    #[default]
    Receivers,
    /// The whole view up to the farthest receiver. The picture depends less on which receivers come and go.
    All,
}

impl PerspectiveMap {
    /// Returns the map request of the component, with one layer.
    ///
    /// # Errors
    /// The first setting that cannot be drawn with.
    pub fn request(&self, light: &Light) -> Result<MapRequest, Refusal> {
        if let Some(slide) = self.slide.filter(|slide| !(slide.is_finite() && *slide >= 0.0)) {
            return Err(Refusal::Setting {
                setting: "slide",
                value: slide,
                unit: " m",
                allowed: "it must be finite and at least 0; `None` chooses it",
            });
        }
        let request = MapRequest {
            shape: MapShape::Matrices,
            resolution: self.resolution,
            filter: self.filter,
            format: MapFormat::Depth,
            surface: MapSurface::Nearest,
            bias: self.bias,
            near: self.near,
            cached: self.cached,
            cascades: Cascades::default(),
            beside: None,
            apart: true,
            pictures: false,
            layers: 1,
        };
        request.validated(light)
    }
}

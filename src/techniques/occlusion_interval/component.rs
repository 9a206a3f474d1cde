//! The component that shadows a light from occlusion interval maps.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use bevy_transform::prelude::Transform;

use crate::scene::{Light, LightKind, LightPath};
use crate::techniques::registry::Refusal;

/// Texels per metre that can be baked. With fewer, whole rooms are smaller than the rounding of a texel.
pub(crate) const DENSITIES: std::ops::RangeInclusive<f32> = 1e-3..=1e4;

/// Gives a light that moves along a [`LightPath`] soft shadows of a static scene, from maps that were baked for it.
///
/// The light is a stretch of its path: its *width* softens shadows along the path and leaves them hard across it. Time and
/// width may change every frame and need no new maps.
///
/// The maps hold everything that stood still in the scene when they were baked. Other objects show no shadows of this
/// light and cast none, unless the light has another technique beside this one, such as a
/// [`ShadowMap`](crate::techniques::ShadowMap). It then shadows them, and by them what is in the maps.
#[derive(Component, Clone, Debug, PartialEq)]
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
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(extend("required" = ["maps"]))
)]
pub struct OcclusionInterval {
    /// Folder of the maps, relative to [`IntervalFolder`](super::IntervalFolder): the current folder, or in Bevy that of the
    /// assets. It must be given. The maps are read in the first frame that needs them
    /// ([`IntervalLibrary`](super::IntervalLibrary)).
    pub maps: String,
    /// Time, as a share of the path, 0 to 1. A clock may run on: time beyond stops at the ends of an open path, and wraps around
    /// a closed one. A file with such a time is refused. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub time: f32,
    /// Length of the light, as a share of the path, 0 to 1. Higher values soften shadows along the path, and cost nothing.
    /// With 0 shadows are hard. Default: 0.02, half an hour of a day.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub width: f32,
    /// Texels per metre of the maps that are baked for this light, 0.001 to 10000. Twice as many sharpen shadows, and take
    /// four times the memory and the time to bake. Frames ignore it. Default: 8.
    #[cfg_attr(feature = "schema", schemars(range(min = 0.001, max = 10000)))]
    pub texels_per_metre: f32,
}

impl Default for OcclusionInterval {
    fn default() -> Self {
        Self {
            maps: String::new(),
            time: 0.0,
            width: 0.02,
            texels_per_metre: 8.0,
        }
    }
}

impl OcclusionInterval {
    /// Checks the settings for a light.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub(super) fn check_settings(&self, light: &Light) -> Result<(), Refusal> {
        match light.kind {
            LightKind::Directional | LightKind::Point | LightKind::Spot { .. } => {}
            LightKind::Rect { .. } | LightKind::Sphere { .. } => {
                return Err(Refusal::kind(
                    light,
                    "its light is a line along a path; use a point or directional light, or a PenumbraWedge",
                ));
            }
        }
        if self.maps.is_empty() {
            return Err(Refusal::Missing {
                setting: "maps",
                needed: "it names the folder of the baked maps",
            });
        }
        if !self.time.is_finite() {
            return Err(Refusal::setting("time", self.time, "it must be finite"));
        }
        if !(0.0..=1.0).contains(&self.width) {
            let allowed = "it is a share of the path, 0 to 1";
            return Err(Refusal::setting("width", self.width, allowed));
        }
        if !DENSITIES.contains(&self.texels_per_metre) {
            let allowed = "it must be from 0.001 to 10000";
            return Err(Refusal::setting(
                "texels_per_metre",
                self.texels_per_metre,
                allowed,
            ));
        }
        Ok(())
    }
}

/// Puts every light with a path where its time says.
///
/// Runs before transforms are propagated. Reads [`LightPath`] and [`OcclusionInterval`]; writes `Transform`, if it
/// changes. A path that cannot be used moves nothing; the technique reports it.
pub fn follow_light_paths(
    mut lights: Query<(&LightPath, &OcclusionInterval, &mut Transform), With<Transform>>,
) {
    for (path, settings, mut transform) in &mut lights {
        if path.check().is_err() {
            continue;
        }
        let mut placed = *transform;
        path.place(settings.time, &mut placed);
        transform.set_if_neq(placed);
    }
}

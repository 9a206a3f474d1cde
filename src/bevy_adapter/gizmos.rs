//! Draws sets, silhouettes and other results of a frame as Bevy gizmos (feature `bevy-gizmos`).

use bevy::app::{App, Plugin, PostUpdate};
use bevy::color::Color;
use bevy::ecs::prelude::*;
use bevy::gizmos::config::{GizmoConfigGroup, GizmoConfigStore};
use bevy::gizmos::gizmos::Gizmos;
use bevy::gizmos::{AppGizmoBuilder, GizmoPlugin};
use bevy::reflect::Reflect;
use bevy::reflect::prelude::ReflectDefault;
use bevy::render::{ExtractSchedule, MainWorld, RenderApp};

use super::mirror::{Mirror, Mirrors};
use super::systems::AntumbraExtractSystems;
use crate::debug_lines::{DebugLines, DebugSubject, draw_debug_lines};
use crate::sets::FrameLights;
use crate::techniques::Techniques;

/// Draws what this crate computed for marked cameras as Bevy's gizmos. [`AntumbraGizmos`] says what is drawn; at first,
/// nothing is.
///
/// Add it after `DefaultPlugins`, beside [`AntumbraPlugin`](crate::plugin::AntumbraPlugin).
///
/// ```no_run
/// use antumbra::bevy_adapter::prelude::*;
/// use bevy::prelude::*;
///
/// fn show(mut gizmos: ResMut<GizmoConfigStore>) {
///     let (_, shown) = gizmos.config_mut::<AntumbraGizmos>();
///     shown.silhouettes = true;
///     shown.reach = true;
/// }
///
/// App::new()
///     .add_plugins((DefaultPlugins, AntumbraPlugin, AntumbraGizmosPlugin))
///     .add_systems(Startup, show);
/// ```
///
/// The lines are those of the frame before, so they lag behind what moves by one frame, or by two with pipelined rendering.
/// Collecting them costs time for each box and edge that is drawn, and nothing while nothing is drawn. Every camera shows
/// the lines of all marked cameras, unless [`AntumbraGizmos::camera`] chooses one.
#[derive(Clone, Copy, Debug, Default)]
pub struct AntumbraGizmosPlugin;

/// Chooses the lines that [`AntumbraGizmosPlugin`] draws. All subjects are off by default. The group's `GizmoConfig` has the width of the
/// lines, and draws them in front of everything with a `depth_bias` of −1.
#[derive(Clone, Debug, Default, Reflect, GizmoConfigGroup)]
#[reflect(Default)]
pub struct AntumbraGizmos {
    /// Whether the boxes of all objects are drawn, coloured by the smallest set that holds them: red for S, yellow for I,
    /// blue for L, white for V, dark grey for F. Over several lights, the boxes of the last one are on top.
    pub sets: bool,
    /// Whether the silhouette edges of casters are drawn, for techniques that use them.
    pub silhouettes: bool,
    /// Whether the place, the extent, the range and the cone of lights are drawn.
    pub reach: bool,
    /// Whether the convex hulls are drawn outside which no caster matters.
    pub hulls: bool,
    /// Whether the parts of the view that lights can change are drawn: scissors between depth bounds.
    pub regions: bool,
    /// Whether cells and portals are drawn.
    pub cells: bool,
    /// Whether the volumes, wedges, faces of maps and slices of the lights' techniques are drawn.
    pub techniques: bool,
    /// The light whose lines are drawn; `None` draws those of all lights. Default: `None`.
    pub light: Option<Entity>,
    /// The camera whose lines are drawn; `None` draws those of all marked cameras. Default: `None`.
    pub camera: Option<Entity>,
}

impl AntumbraGizmos {
    /// Whether a subject is drawn.
    fn shows(&self, subject: DebugSubject) -> bool {
        match subject {
            DebugSubject::Sets => self.sets,
            DebugSubject::Silhouettes => self.silhouettes,
            DebugSubject::Reach => self.reach,
            DebugSubject::Hulls => self.hulls,
            DebugSubject::Region => self.regions,
            DebugSubject::Cells => self.cells,
        }
    }

    /// Adds the lines of a camera's last frame.
    fn collect(&self, mirror: &Mirror, out: &mut DebugLines) {
        let world = &mirror.world;
        let lights = world.resource::<FrameLights>().of_scene();
        let chosen = self.light.map(|light| mirror.get(light));
        let is_shown = |entity: Entity| chosen.is_none_or(|chosen| chosen == Some(entity));
        let shown = (0..lights.len()).filter(|&light| is_shown(lights[light].entity));
        for subject in DebugSubject::ALL
            .into_iter()
            .filter(|&subject| self.shows(subject))
        {
            // Cells belong to no light, and without a light the sets of the view are left.
            if subject == DebugSubject::Cells
                || subject == DebugSubject::Sets && shown.clone().next().is_none()
            {
                draw_debug_lines(subject, world, None, out);
                continue;
            }
            for light in shown.clone() {
                draw_debug_lines(subject, world, Some(light), out);
            }
        }
        if self.techniques {
            let techniques = world.resource::<Techniques>();
            for light in shown {
                techniques.debug_lines(world, light, out);
            }
        }
    }
}

/// The lines that are drawn in this frame.
#[derive(Resource, Debug, Default)]
pub struct AntumbraGizmoLines(pub DebugLines);

impl Plugin for AntumbraGizmosPlugin {
    fn build(&self, app: &mut App) {
        app.init_gizmo_group::<AntumbraGizmos>()
            .init_resource::<AntumbraGizmoLines>()
            .add_systems(PostUpdate, draw_gizmos);
    }

    fn finish(&self, app: &mut App) {
        if !app.is_plugin_added::<GizmoPlugin>() {
            tracing::warn!(
                "AntumbraGizmosPlugin draws nothing: add Bevy's GizmoPlugin, which is one of DefaultPlugins"
            );
        }
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            let collect = collect_gizmos.before(AntumbraExtractSystems::Collect);
            render_app.add_systems(ExtractSchedule, collect);
        }
    }
}

/// Collects the lines of the last frame.
///
/// Runs in `ExtractSchedule`, before [`Collect`](AntumbraExtractSystems::Collect), while the mirrors are still
/// those that ran.
fn collect_gizmos(mut main: ResMut<MainWorld>, mirrors: Option<Res<Mirrors>>) {
    let Some(shown) = main.get_resource::<GizmoConfigStore>().map(|store| {
        let (config, shown) = store.config::<AntumbraGizmos>();
        config.enabled.then(|| shown.clone())
    }) else {
        return;
    };
    let Some(mut lines) = main.get_resource_mut::<AntumbraGizmoLines>() else {
        return;
    };
    let lines = &mut lines.bypass_change_detection().0;
    lines.clear();
    let (Some(shown), Some(mirrors)) = (shown, mirrors) else {
        return;
    };
    for (camera, mirror) in mirrors.iter() {
        if mirror.has_run && shown.camera.is_none_or(|chosen| chosen == camera) {
            shown.collect(mirror, lines);
        }
    }
}

/// Draws the lines.
///
/// Runs in `PostUpdate`.
fn draw_gizmos(lines: Res<AntumbraGizmoLines>, mut gizmos: Gizmos<AntumbraGizmos>) {
    for line in lines.0.lines() {
        let [red, green, blue] = line.color;
        gizmos.line(line.ends[0], line.ends[1], Color::srgb_u8(red, green, blue));
    }
}

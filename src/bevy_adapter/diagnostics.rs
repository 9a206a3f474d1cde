//! Counts and times of the last frame, as Bevy's diagnostics.

use std::time::Instant;

use bevy::app::{App, Plugin};
use bevy::diagnostic::{
    Diagnostic, DiagnosticMeasurement, DiagnosticPath, DiagnosticsStore, RegisterDiagnostic,
};
use bevy::ecs::prelude::*;
use bevy::render::{ExtractSchedule, MainWorld, RenderApp};

use super::mirror::{Mirror, Mirrors};
use super::systems::AntumbraExtractSystems;
use crate::schedule::SetTimes;
use crate::sets::{FrameLights, Objects, VisibleSet};
use crate::silhouettes::Silhouettes;
use crate::techniques::TextureMemory;

/// Adds counts and times of this crate to Bevy's [`DiagnosticsStore`]. They are sums over all marked cameras,
/// of the frame before.
///
/// Add it after `DefaultPlugins`, beside [`AntumbraPlugin`](crate::plugin::AntumbraPlugin). Bevy's
/// `LogDiagnosticsPlugin` logs the diagnostics, and a game reads one by its path:
///
/// ```
/// use antumbra::bevy_adapter::AntumbraDiagnosticsPlugin;
/// use bevy::diagnostic::DiagnosticsStore;
/// use bevy::prelude::*;
///
/// fn tell(diagnostics: Res<DiagnosticsStore>) {
///     let casters = diagnostics.get(&AntumbraDiagnosticsPlugin::CASTERS);
///     if let Some(count) = casters.and_then(|casters| casters.value()) {
///         println!("{count} casters over all lights");
///     }
/// }
///
/// App::new().add_plugins(AntumbraDiagnosticsPlugin).add_systems(Update, tell);
/// ```
///
/// Collecting them costs one pass over the lights and their casters in each frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct AntumbraDiagnosticsPlugin;

/// Sums over the mirrors of a frame, in the order of [`AntumbraDiagnosticsPlugin::COUNTS`].
type Sums = [f64; 8];

impl AntumbraDiagnosticsPlugin {
    /// Number of marked cameras that were drawn.
    pub const CAMERAS: DiagnosticPath = DiagnosticPath::const_new("antumbra/cameras");
    /// Number of objects of the scene: meshes that are lit or cast shadows.
    pub const OBJECTS: DiagnosticPath = DiagnosticPath::const_new("antumbra/objects");
    /// Number of objects that the cameras see.
    pub const VISIBLE: DiagnosticPath = DiagnosticPath::const_new("antumbra/visible");
    /// Number of lights that shine.
    pub const LIGHTS: DiagnosticPath = DiagnosticPath::const_new("antumbra/lights");
    /// Number of lit objects, summed over all lights.
    pub const RECEIVERS: DiagnosticPath = DiagnosticPath::const_new("antumbra/receivers");
    /// Number of casters whose shadow can reach the view, summed over all lights.
    pub const CASTERS: DiagnosticPath = DiagnosticPath::const_new("antumbra/casters");
    /// Number of silhouette edges of these casters.
    pub const SILHOUETTE_EDGES: DiagnosticPath = DiagnosticPath::const_new("antumbra/silhouette_edges");
    /// Memory of the maps and textures of all techniques, bytes.
    pub const TEXTURE_BYTES: DiagnosticPath = DiagnosticPath::const_new("antumbra/texture_bytes");
    /// CPU time of the system sets ([`AntumbraSystems`](crate::schedule::AntumbraSystems)) over all cameras,
    /// milliseconds. Copying the game's scene and recording draws are not in it.
    pub const CPU_TIME: DiagnosticPath = DiagnosticPath::const_new("antumbra/cpu_time");

    /// Paths of the counts.
    const COUNTS: [DiagnosticPath; 8] = [
        Self::CAMERAS,
        Self::OBJECTS,
        Self::VISIBLE,
        Self::LIGHTS,
        Self::RECEIVERS,
        Self::CASTERS,
        Self::SILHOUETTE_EDGES,
        Self::TEXTURE_BYTES,
    ];
}

impl Plugin for AntumbraDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in Self::COUNTS {
            app.register_diagnostic(Diagnostic::new(path));
        }
        app.register_diagnostic(Diagnostic::new(Self::CPU_TIME).with_suffix("ms"));
    }

    fn finish(&self, app: &mut App) {
        // An app without a renderer draws nothing that could be counted.
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            let publish = publish_diagnostics.before(AntumbraExtractSystems::Collect);
            render_app.add_systems(ExtractSchedule, publish);
        }
    }
}

/// Copies the counts and times of the last frame to the game's [`DiagnosticsStore`].
///
/// Runs in `ExtractSchedule`, before [`Collect`](AntumbraExtractSystems::Collect), while the mirrors are still
/// those that ran.
fn publish_diagnostics(mut main: ResMut<MainWorld>, mirrors: Option<Res<Mirrors>>) {
    let (Some(mirrors), Some(mut store)) = (mirrors, main.get_resource_mut::<DiagnosticsStore>()) else {
        return;
    };
    let (mut sums, mut milliseconds): (Sums, f64) = ([0.0; 8], 0.0);
    for (_, mirror) in mirrors.iter() {
        if !mirror.has_run {
            continue; // its camera draws nothing
        }
        for (sum, count) in sums.iter_mut().zip(counts(mirror)) {
            *sum += count;
        }
        let times = mirror.world.resource::<SetTimes>().durations;
        milliseconds += times.iter().map(|time| time.as_secs_f64() * 1e3).sum::<f64>();
    }
    let time = Instant::now();
    let values = AntumbraDiagnosticsPlugin::COUNTS.into_iter().zip(sums);
    for (path, value) in values.chain([(AntumbraDiagnosticsPlugin::CPU_TIME, milliseconds)]) {
        if let Some(diagnostic) = store.get_mut(&path).filter(|diagnostic| diagnostic.is_enabled) {
            diagnostic.add_measurement(DiagnosticMeasurement { time, value });
        }
    }
}

fn counts(mirror: &Mirror) -> Sums {
    let world = &mirror.world;
    let lights = world.resource::<FrameLights>().of_scene();
    let silhouettes = world.resource::<Silhouettes>();
    let (mut receivers, mut casters, mut edges) = (0, 0, 0);
    for light in lights {
        receivers += light.sets.i.count_ones(..);
        casters += light.sets.s.count_ones(..);
        if let Some(known) = silhouettes.of_light(light.entity) {
            let of_caster = |object| known.of_object(object);
            edges += light
                .sets
                .s
                .ones()
                .filter_map(of_caster)
                .map(|(_, silhouette)| silhouette.contour.edge_count())
                .sum::<usize>();
        }
    }
    let visible = world.resource::<VisibleSet>().set.count_ones(..);
    let objects = world.resource::<Objects>().len();
    let bytes = world.resource::<TextureMemory>().bytes() as f64;
    let [objects, visible, lights, receivers, casters, edges] =
        [objects, visible, lights.len(), receivers, casters, edges].map(|count| count as f64);
    [1.0, objects, visible, lights, receivers, casters, edges, bytes]
}

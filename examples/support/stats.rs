//! `stats.json`: the statistics of a frame.

use antumbra::prelude::*;
use antumbra::reports::{Report, Reports};
use antumbra::schedule::{AntumbraSystems, SetTimes};
use antumbra::sets::{FrustumSet, Objects, VisibleSet};
use antumbra::silhouettes::{Silhouette, Silhouettes, link_loops};
use antumbra::techniques::{Statistic, Statistics, Techniques, TextureMemory};
use bevy_ecs::prelude::{Name, World};
use serde_json::{Map, Value, json};

use super::frames::Rendered;
use super::stage::Stage;

/// Numbers of draw calls in a frame, by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Batches {
    /// Draw calls of the ambient pass.
    pub ambient: usize,
    /// Draw calls of the shadows of all lights.
    pub shadow: usize,
    /// Draw calls of the light passes of all lights.
    pub light: usize,
    /// Draw calls of blended surfaces, and of each light on each of them.
    pub blended: usize,
}

impl std::ops::AddAssign for Batches {
    fn add_assign(&mut self, other: Self) {
        self.ambient += other.ambient;
        self.shadow += other.shadow;
        self.light += other.light;
        self.blended += other.blended;
    }
}

impl Batches {
    /// Counts the draw calls of the frame that was prepared last.
    pub fn of_frame(renderer: &Renderer) -> Self {
        let frame = renderer.frame();
        let shadow = frame
            .lights
            .iter()
            .map(|light| renderer.shadow_batch_count(light));
        Self {
            ambient: frame.ambient.len(),
            shadow: shadow.sum(),
            light: frame.lights.iter().map(|light| light.batches.len()).sum(),
            blended: frame.blended.len() + frame.blended_lights.len(),
        }
    }

    /// Returns the number of all draw calls.
    pub fn total(&self) -> usize {
        self.ambient + self.shadow + self.light + self.blended
    }
}

/// Collects the statistics of the last frame.
pub fn collect(stage: &mut Stage, rendered: &Rendered) -> Value {
    let triangles: usize = stage
        .world
        .query::<&SceneMesh>()
        .iter(&stage.world)
        .map(|mesh| mesh.0.triangle_count())
        .sum();
    let world = &stage.world;
    let renderer = world.resource::<Renderer>();
    let objects = world.resource::<Objects>();
    let indices = stage.light_indices();
    let lights: Vec<Value> = (0..stage.lights.len())
        .map(|light| match indices[light] {
            Some(index) => light_stats(world, renderer, index),
            None => json!({ "skipped": skip_reason(world, stage.lights[light]) }),
        })
        .collect();
    let batches = Batches::of_frame(renderer);
    let times = world.resource::<SetTimes>();
    let cpu: Map<String, Value> = AntumbraSystems::ALL
        .iter()
        .zip(times.durations)
        .map(|(set, time)| (set.name().to_owned(), json!(time.as_secs_f64() * 1e3)))
        .collect();
    let mut gpu = Map::new();
    for pass in &rendered.pass_times {
        let total = gpu.get(&pass.label).and_then(Value::as_f64).unwrap_or(0.0);
        gpu.insert(pass.label.clone(), json!(total + pass.milliseconds));
    }
    let mut of_techniques = Statistics::default();
    let memory = world.resource::<TextureMemory>();
    let short = memory.shortages().iter();
    let shortages: Vec<String> = short.map(|short| short.shortage.to_string()).collect();
    of_techniques.set("texture_bytes", memory.bytes());
    of_techniques.set("texture_shortages", shortages);
    for row in world.resource::<Techniques>().rows() {
        row.frame_statistics(world, &mut of_techniques);
    }
    let stats = json!({
        "adapter": renderer.context().adapter,
        "size": rendered.size.to_array(),
        "objects": objects.len(),
        "objects_left_out": objects.left_out,
        "triangles": triangles,
        "F": world.resource::<FrustumSet>().set.count_ones(..),
        "V": world.resource::<VisibleSet>().set.count_ones(..),
        "lights": lights,
        "reports": world.resource::<Reports>().iter().map(|report| report_stats(stage, report)).collect::<Vec<_>>(),
        "batches": {
            "ambient": batches.ambient,
            "shadow": batches.shadow,
            "light": batches.light,
            "blended": batches.blended,
            "frame": batches.total(),
        },
        "load_ms": stage.load_time.as_secs_f64() * 1e3,
        "cpu_ms": cpu,
        "gpu_ms": gpu,
        "gpu_untimed_passes": rendered.untimed_passes,
    });
    with_statistics(stats, &of_techniques)
}

/// Adds statistics to a JSON object as further keys.
fn with_statistics(mut object: Value, statistics: &Statistics) -> Value {
    for (name, value) in statistics.iter() {
        object[name] = json_of(value);
    }
    object
}

fn json_of(value: &Statistic) -> Value {
    match value {
        Statistic::Nothing => Value::Null,
        Statistic::Flag(value) => json!(value),
        Statistic::Count(value) => json!(value),
        Statistic::Number(value) => json!(value),
        Statistic::Text(value) => json!(value),
        Statistic::List(values) => values.iter().map(json_of).collect(),
        Statistic::Group(values) => with_statistics(json!({}), values),
    }
}

fn report_stats(stage: &Stage, report: &Report) -> Value {
    json!({
        "topic": report.topic,
        "entity": subject(stage, report),
        "message": report.message,
    })
}

/// Returns the subject of a report: the name of the entity, its number among the stage's lights, or its index.
fn subject(stage: &Stage, report: &Report) -> Option<String> {
    let entity = report.entity?;
    let light = stage.lights.iter().position(|light| *light == entity);
    let name = stage.world.get::<Name>(entity);
    Some(match (light, name) {
        (_, Some(name)) => name.to_string(),
        (Some(light), None) => format!("light {light}"),
        (None, None) => format!("entity {entity}"),
    })
}

/// Prints each new report to stderr, on a line of its own that begins with `what`, the name of the thing that was
/// drawn.
pub fn print_new_reports(what: &str, stage: &mut Stage) {
    let mut reports = std::mem::take(&mut *stage.world.resource_mut::<Reports>());
    for report in reports.drain_new() {
        let subject = subject(stage, report).map_or_else(String::new, |subject| format!("{subject}: "));
        // Names may hold line breaks.
        eprintln!(
            "{}",
            format!("{what}: {subject}{}", report.message).replace(['\n', '\r'], " ")
        );
    }
    stage.world.insert_resource(reports);
}

fn skip_reason(world: &World, light: bevy_ecs::prelude::Entity) -> String {
    world
        .resource::<FrameLights>()
        .skipped
        .iter()
        .find(|skipped| skipped.entity == light)
        .map_or_else(|| "not a light".to_owned(), |skipped| skipped.error.to_string())
}

/// Returns the number of loops of a silhouette's contour; 0 if its edges do not close.
fn loop_count(silhouette: &Silhouette) -> usize {
    let edges: Vec<_> = silhouette.contour.all_edges().collect();
    link_loops(&edges).map_or(0, |loops| loops.len())
}

fn light_stats(world: &World, renderer: &Renderer, index: usize) -> Value {
    let frame = world.resource::<FrameLights>();
    let light = &frame.lights[index];
    let silhouettes = world.resource::<Silhouettes>();
    let (mut edges, mut loops) = (0, 0);
    if let Some(known) = silhouettes.of_light(light.entity) {
        for object in light.sets.s.ones() {
            if let Some((_, silhouette)) = known.of_object(object) {
                edges += silhouette.contour.edge_count();
                loops += loop_count(silhouette);
            }
        }
    }
    let drawn = renderer.frame();
    let mut companions = drawn.companions.iter().map(|companion| &companion.shadow);
    let active = drawn.lights.iter().find(|active| active.light == index);
    let active = active.or_else(|| companions.find(|active| active.light == index));
    let mut of_techniques = Statistics::default();
    for row in world.resource::<Techniques>().rows() {
        row.statistics(world, index, &mut of_techniques);
    }
    let stats = json!({
        "technique": active.map_or("none", |active| renderer.technique_name(active)),
        "L": light.sets.l.count_ones(..),
        "I": light.sets.i.count_ones(..),
        "S": light.sets.s.count_ones(..),
        "scissor": light.region.scissor.map(|s| [s.x, s.y, s.width, s.height]),
        "depth_bounds": light.region.depth_bounds.map(|bounds| json!({
            "near": bounds.near,
            // JSON cannot represent infinity.
            "far": bounds.far.is_finite().then_some(bounds.far),
        })),
        "silhouette_edges": edges,
        "silhouette_loops": loops,
        "shadow_batches": active.map_or(0, |active| renderer.shadow_batch_count(active)),
        "light_batches": active.map_or(0, |active| active.batches.len()),
    });
    let mut stats = with_statistics(stats, &of_techniques);
    // The statistics of the light's second technique, for each part of the receivers.
    for (companion, light) in frame.companions_of(light.entity) {
        if let Some(of) = light.companion_of {
            stats["moving"][of.part.name()] = light_stats(world, renderer, companion);
        }
    }
    stats
}

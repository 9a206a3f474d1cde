//! `stats.json`: what a frame was made of.

use antumbra::plugin::{AntumbraSystems, SetTimes};
use antumbra::prelude::*;
use antumbra::sets::{FrustumSet, Objects, VisibleSet};
use antumbra::silhouettes::{
    CasterEdges, FacingBits, PosedPlanes, Silhouette, Silhouettes, classify, extract_edge_vertices,
    link_loops,
};
use antumbra::techniques::maps::Maps;
use antumbra::techniques::stencil_volume::StencilVolumes;
use bevy_ecs::prelude::World;
use serde_json::{Map, Value, json};

use super::stage::{Rendered, Stage};

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
    let frame = renderer.frame();
    let shadow_batches: usize = frame
        .lights
        .iter()
        .map(|light| renderer.shadow_batch_count(light))
        .sum();
    let light_batches: usize = frame.lights.iter().map(|light| light.batches.len()).sum();
    let ambient_batches = frame.ambient.len();
    let blended_batches = frame.blended.len() + frame.blended_lights.len();
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
    json!({
        "adapter": renderer.context().adapter,
        "size": rendered.size.to_array(),
        "objects": objects.len(),
        "objects_left_out": objects.left_out,
        "triangles": triangles,
        "F": world.resource::<FrustumSet>().set.count_ones(..),
        "V": world.resource::<VisibleSet>().set.count_ones(..),
        "lights": lights,
        "map_bytes": world.resource::<Maps>().bytes,
        "map_reports": world.resource::<Maps>().reports.iter().map(|report| report.error.to_string()).collect::<Vec<_>>(),
        "batches": {
            "ambient": ambient_batches,
            "shadow": shadow_batches,
            "light": light_batches,
            "blended": blended_batches,
            "frame": ambient_batches + shadow_batches + light_batches + blended_batches,
        },
        "cpu_ms": cpu,
        "gpu_ms": gpu,
    })
}

fn skip_reason(world: &World, light: bevy_ecs::prelude::Entity) -> String {
    world
        .resource::<FrameLights>()
        .skipped
        .iter()
        .find(|skipped| skipped.entity == light)
        .map_or_else(|| "not a light".to_owned(), |skipped| skipped.error.to_string())
}

/// Loops of a silhouette's contour. Names of edges are not kept: its facing bits are found once more.
fn loop_count(world: &World, silhouette: &Silhouette) -> usize {
    let Some(edges) = world.get::<CasterEdges>(silhouette.entity) else {
        return 0;
    };
    let planes = match world.get::<PosedPlanes>(silhouette.entity) {
        Some(posed) => &posed.0,
        None => &edges.0.planes,
    };
    let (mut bits, mut edge_vertices) = (FacingBits::default(), Vec::new());
    classify(&edges.0.edges, planes, silhouette.light_local, &mut bits);
    extract_edge_vertices(&edges.0.edges, &bits, silhouette.mode, &mut edge_vertices);
    // A contour whose edges do not close has no loops to count.
    link_loops(&edge_vertices).map_or(0, |loops| loops.len())
}

fn light_stats(world: &World, renderer: &Renderer, index: usize) -> Value {
    let light = &world.resource::<FrameLights>().lights[index];
    let silhouettes = world.resource::<Silhouettes>();
    let (mut edges, mut loops) = (0, 0);
    if let Some(known) = silhouettes.of_light(light.entity) {
        for object in light.s.ones() {
            if let Some((_, silhouette)) = known.of_object(object) {
                edges += silhouette.contour.edges.len();
                loops += loop_count(world, silhouette);
            }
        }
    }
    let volumes = world.resource::<StencilVolumes>().of_light(index);
    let casters = |depth_pass: bool| {
        volumes.map_or(0, |volumes| {
            volumes
                .casters
                .iter()
                .filter(|caster| caster.depth_pass == depth_pass)
                .count()
        })
    };
    let active = renderer
        .frame()
        .lights
        .iter()
        .find(|active| active.light == index);
    json!({
        "technique": active.map_or("none", |active| renderer.technique_name(active)),
        "L": light.l.count_ones(..),
        "I": light.i.count_ones(..),
        "S": light.s.count_ones(..),
        "scissor": light.scissor.map(|s| [s.x, s.y, s.width, s.height]),
        "depth_bounds": light.depth_bounds.map(|bounds| json!({
            "near": bounds.near,
            // JSON has no infinity.
            "far": bounds.far.is_finite().then_some(bounds.far),
        })),
        "silhouette_edges": edges,
        "silhouette_loops": loops,
        "casters_depth_pass": casters(true),
        "casters_depth_fail": casters(false),
        "casters_culled": volumes.map_or(0, |volumes| volumes.culled),
        "map": world.resource::<Maps>().of_light(index).map(|map| json!({
            "resolution": map.resolution,
            "faces": map.faces.len(),
            "kept": map.cached,
            "casters": map.casters().count_ones(..),
        })),
        "shadow_batches": active.map_or(0, |active| renderer.shadow_batch_count(active)),
        "light_batches": active.map_or(0, |active| active.batches.len()),
    })
}

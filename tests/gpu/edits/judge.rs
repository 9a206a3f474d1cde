//! What two worlds show and hold, and where they differ.

use std::collections::HashMap;

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::sets::{FrustumSet, Objects, View, ViewData, VisibleSet};
use antumbra::silhouettes::Silhouettes;
use antumbra::techniques::{Statistics, Techniques};
use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use serde_json::Value;

use super::world::Live;
use crate::harness::support::frames::Rendered;
use crate::harness::support::stats;

/// Named results of a frame.
pub type Facts = Vec<(String, String)>;

/// Statistics that depend on how long ago objects moved.
const OF_MOTION: [&str; 2] = ["map_bytes", "texture_bytes"];

/// What the CPU made of the last frame.
pub fn facts(live: &Live) -> Facts {
    let world = &live.stage.world;
    let ids: HashMap<Entity, u32> = live.entities.iter().map(|(id, entity)| (*entity, *id)).collect();
    let objects = world.resource::<Objects>();
    let names = |set: &FixedBitSet| {
        let known = |object: usize| ids.get(objects.entities.get(object)?).copied();
        format!("{:?}", set.ones().map(known).collect::<Vec<_>>())
    };
    // What has no mesh is in no set, whatever its flags say.
    let present = |set: &FixedBitSet| set & &objects.present;
    let mut facts = vec![
        ("F".to_owned(), names(&world.resource::<FrustumSet>().set)),
        ("V".to_owned(), names(&world.resource::<VisibleSet>().set)),
        ("casters".to_owned(), names(&present(&objects.casters))),
        ("receivers".to_owned(), names(&present(&objects.receivers))),
    ];
    let lights = world.resource::<FrameLights>();
    let id = |entity: Entity| ids.get(&entity).copied();
    let skipped = lights.skipped.iter();
    let skipped: Vec<_> = skipped
        .map(|skipped| (id(skipped.entity), skipped.error))
        .collect();
    facts.push(("skipped".to_owned(), format!("{skipped:?}")));
    let view = world.resource::<View>().data.as_ref();
    let is_orthographic = view.is_some_and(ViewData::is_orthographic);
    let silhouettes = world.resource::<Silhouettes>();
    for (index, light) in lights.lights.iter().enumerate() {
        let mut add = |what: &str, value: String| {
            facts.push((format!("{what} of {:?}", id(light.entity)), value));
        };
        add(
            "technique",
            format!("{:?}", light.technique.map(|technique| technique.name)),
        );
        add("L", names(&light.sets.l));
        add("I", names(&light.sets.i));
        add("S", names(&light.sets.s));
        add("scissor", format!("{:?}", light.region.scissor));
        // Their slack in an orthographic view depends on the range that its depth had in the frame before.
        if !is_orthographic {
            add("depth bounds", format!("{:?}", light.region.depth_bounds));
        }
        add("receivers", format!("{:?}", light.region.receiver_bounds));
        add("lit receivers", format!("{:?}", light.region.lit_receivers));
        // A light without a technique has none that is known.
        add(
            "clearance",
            format!("{:?}", light.technique.map(|_| light.clearance)),
        );
        add(
            "place",
            format!(
                "{:?} {:?} {:?}",
                light.point_world, light.emitter, light.direction
            ),
        );
        let mut outlines = Vec::new();
        if let Some(known) = silhouettes.of_light(light.entity) {
            for object in light.sets.s.ones() {
                let silhouette = known
                    .of_object(object)
                    .map(|(_, s)| (s.contour.edge_count(), s.stacked, s.mode));
                outlines.push((id(objects.entities[object]), silhouette));
            }
        }
        add("silhouettes", format!("{outlines:?}"));
        let mut statistics = Statistics::default();
        for row in world.resource::<Techniques>().rows() {
            row.statistics(world, index, &mut statistics);
        }
        add("statistics", format!("{statistics:?}"));
    }
    let mut statistics = Statistics::default();
    for row in world.resource::<Techniques>().rows() {
        row.frame_statistics(world, &mut statistics);
    }
    let counted: Vec<_> = statistics
        .iter()
        .filter(|(name, _)| !OF_MOTION.contains(name))
        .collect();
    facts.push(("statistics".to_owned(), format!("{counted:?}")));
    let reports = world.resource::<Reports>();
    let mut said: Vec<_> = reports
        .iter()
        .map(|report| format!("{:?} {}: {}", report.entity.map(id), report.topic, report.message))
        .collect();
    said.sort();
    facts.push(("reports".to_owned(), format!("{said:#?}")));
    facts
}

/// What the renderer counted, without times.
pub fn statistics(live: &mut Live, rendered: &Rendered) -> Facts {
    let mut all = stats::collect(&mut live.stage, rendered);
    let map = all.as_object_mut().expect("an object");
    for times in [
        "cpu_ms",
        "gpu_ms",
        "load_ms",
        "adapter",
        "gpu_untimed_passes",
        "reports",
    ] {
        map.remove(times);
    }
    OF_MOTION.iter().for_each(|name| drop(map.remove(*name)));
    // A kept map is not drawn again in every frame.
    let is_map = |light: &Value| {
        !matches!(
            light["technique"].as_str(),
            Some("stencil_volume" | "penumbra_wedge")
        )
    };
    let any_map = map["lights"]
        .as_array()
        .is_some_and(|lights| lights.iter().any(is_map));
    for light in map["lights"].as_array_mut().into_iter().flatten() {
        light.as_object_mut().map(|light| light.remove("depth_bounds"));
    }
    if any_map {
        for light in map["lights"]
            .as_array_mut()
            .into_iter()
            .flatten()
            .filter(|light| is_map(light))
        {
            light.as_object_mut().map(|light| light.remove("shadow_batches"));
        }
        map["batches"]
            .as_object_mut()
            .map(|batches| (batches.remove("shadow"), batches.remove("frame")));
    }
    let mut facts = Facts::new();
    flatten("stats".to_owned(), &all, &mut facts);
    facts
}

fn flatten(name: String, value: &Value, facts: &mut Facts) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                flatten(format!("{name}.{key}"), value, facts);
            }
        }
        Value::Array(values) => {
            for (at, value) in values.iter().enumerate() {
                flatten(format!("{name}.{at}"), value, facts);
            }
        }
        value => facts.push((name, value.to_string())),
    }
}

/// A difference: its kind without numbers, and its description.
#[derive(Clone, Debug)]
pub struct Difference {
    pub kind: String,
    pub text: String,
}

/// Compares named results.
pub fn compare(edited: &Facts, fresh: &Facts, out: &mut Vec<Difference>) {
    let names: Vec<&String> = edited.iter().map(|(name, _)| name).collect();
    let others: Vec<&String> = fresh.iter().map(|(name, _)| name).collect();
    if names != others {
        let lacks = |a: &[&String], b: &[&String]| -> Vec<String> {
            a.iter()
                .filter(|name| !b.contains(name))
                .map(|name| (*name).clone())
                .collect()
        };
        out.push(Difference {
            kind: "names".to_owned(),
            text: format!(
                "edited alone: {:?}; fresh alone: {:?}",
                lacks(&names, &others),
                lacks(&others, &names)
            ),
        });
    }
    for (name, value) in edited {
        if let Some((_, other)) = fresh.iter().find(|(other, _)| other == name)
            && value != other
        {
            out.push(Difference {
                kind: name.chars().filter(|c| !c.is_ascii_digit()).collect(),
                text: format!("{name}: {value}, fresh {other}"),
            });
        }
    }
}

/// Difference by which rounding may change a pixel: kept pictures were drawn from another eye, and sums have another order.
const ROUNDING: f32 = 2e-3;

/// Compares pictures.
pub fn compare_pictures(edited: &Rendered, fresh: &Rendered, out: &mut Vec<Difference>) {
    let mut pair = |name: &str, a: &[f32], b: &[f32], channels: usize| {
        let same = |(a, b): (&f32, &f32)| (a - b).abs() <= ROUNDING;
        let differ = a.chunks(channels).zip(b.chunks(channels));
        let differ = differ.filter(|(a, b)| !a.iter().zip(*b).all(same));
        let count = differ.count();
        if count > 0 || a.len() != b.len() {
            let most = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            out.push(Difference {
                kind: name.chars().filter(|c| !c.is_ascii_digit()).collect(),
                text: format!(
                    "{name}: {count} of {} pixels, by up to {most}",
                    a.len() / channels
                ),
            });
        }
    };
    for (at, (a, b)) in edited.visibility.iter().zip(&fresh.visibility).enumerate() {
        pair(&format!("visibility {at}"), a, b, 1);
    }
    pair("radiance", &edited.radiance, &fresh.radiance, 4);
}

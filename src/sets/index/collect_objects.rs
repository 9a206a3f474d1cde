//! Collects the dense object index from components.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::GlobalTransform;

use super::objects::{Counts, Objects, Row};
use crate::scene::changes::{Since, any_changed, bits};
use crate::scene::{
    LocalBounds, ObjectChurn, PosedMesh, SceneMaterials, SelectionLayers, ShadowCaster, ShadowReceiver,
    WorldBounds,
};
use crate::sets::view::inverted_hulls::InvertedHulls;
use crate::sets::view::invisible::InvisibleObjects;
use crate::sets::work::SetWork;

/// The components that [`collect_objects`] reads of one object when it rebuilds.
type ObjectItem<'a> = (
    Entity,
    Ref<'a, WorldBounds>,
    Option<Ref<'a, GlobalTransform>>,
    Option<Ref<'a, PosedMesh>>,
    Option<&'a SelectionLayers>,
    Has<ShadowCaster>,
    Has<ShadowReceiver>,
    Has<SceneMaterials>,
);

/// Objects that also have the component `T`. The query only counts them, by archetype.
type ObjectsWith<'w, 's, T> = Query<'w, 's, (), (With<WorldBounds>, With<T>)>;

/// The queries by which [`collect_objects`] notices that objects or markers came or went.
#[derive(SystemParam)]
pub struct ObjectCounts<'w, 's> {
    churn: Res<'w, ObjectChurn>,
    casters: ObjectsWith<'w, 's, ShadowCaster>,
    receivers: ObjectsWith<'w, 's, ShadowReceiver>,
    drawn: ObjectsWith<'w, 's, SceneMaterials>,
    layered: Query<'w, 's, Ref<'static, SelectionLayers>, With<WorldBounds>>,
    culled: Res<'w, InvertedHulls>,
    invisible: Res<'w, InvisibleObjects>,
}

/// The queries by which [`collect_objects`] notices that an object moved.
#[derive(SystemParam)]
pub struct Motion<'w, 's> {
    bounds: Query<'w, 's, (Entity, Ref<'static, WorldBounds>)>,
    posed: Query<'w, 's, Entity, (With<WorldBounds>, Changed<PosedMesh>)>,
    /// Transforms of objects whose world bounds are written by the app alone. For objects with local bounds,
    /// the world bounds change together with the transform.
    transforms:
        Query<'w, 's, (Entity, Ref<'static, GlobalTransform>), (With<WorldBounds>, Without<LocalBounds>)>,
}

/// Brings [`Objects`] up to date.
///
/// Set: `CollectSets`, first. Reads [`WorldBounds`] and the marker components. If nothing changed, it only
/// reads columns of change ticks. If objects moved, only they and the clusters around them are written. If an
/// object or marker came or went, everything is rebuilt, O(n log n). Everything is also rebuilt when motion
/// has spoilt the order, which happens in at most one frame of 120.
pub fn collect_objects(
    mut objects: ResMut<Objects>,
    mut work: ResMut<SetWork>,
    all: Query<ObjectItem<'static>>,
    motion: Motion,
    members: ObjectCounts,
) {
    objects.frame += 1;
    let counts = Counts {
        churn: members.churn.0,
        objects: all.iter().len(),
        casters: members.casters.iter().len(),
        receivers: members.receivers.iter().len(),
        drawn: members.drawn.iter().len(),
        layered: members.layered.iter().len(),
    };
    let objects = &mut *objects;
    let same_members = objects.counts.replace(counts) == Some(counts) && !any_changed(&members.layered);
    if same_members && !objects.decay.is_due() {
        collect_motion(objects, &motion, &mut work);
        return;
    }
    objects.rows.clear();
    objects.rows.extend(all.iter().map(
        |(entity, bounds, transform, pose, layers, caster, receiver, drawn)| {
            let is_seen = !members.invisible.contains(entity);
            Row {
                entity,
                layers: layers.copied().unwrap_or_default().0,
                aabb: bounds.0,
                caster: caster && is_seen && !members.culled.leaves_out(entity),
                receiver,
                drawn: drawn && is_seen,
                moved: bounds.is_changed()
                    || transform.is_some_and(|transform| transform.is_changed())
                    || pose.is_some_and(|pose| pose.is_changed()),
            }
        },
    ));
    objects.rebuild(!objects.decay.is_due());
    work.layouts += 1;
}

fn collect_motion(objects: &mut Objects, motion: &Motion, work: &mut SetWork) {
    objects.begin_motion();
    let (Ok(bounds), Ok(transforms)) = (
        motion.bounds.contiguous_iter(),
        motion.transforms.contiguous_iter(),
    ) else {
        unreachable!("both are kept in tables");
    };
    for (entities, bounds) in bounds {
        let since = Since::new(bounds.last_run_tick(), bounds.this_run_tick());
        for (first, mask) in since.blocks(bounds.changed_ticks_slice()) {
            work.objects_written += u64::from(mask.count_ones());
            for row in bits(mask).map(|bit| first + bit) {
                if let Some(index) = objects.index_of(entities[row]) {
                    objects.bounds[index] = bounds[row].0;
                    objects.moved.insert(index);
                }
            }
        }
    }
    for (entities, transforms) in transforms {
        let since = Since::new(transforms.last_run_tick(), transforms.this_run_tick());
        for (first, mask) in since.blocks(transforms.changed_ticks_slice()) {
            for row in bits(mask).map(|bit| first + bit) {
                if let Some(index) = objects.index_of(entities[row]) {
                    objects.moved.insert(index);
                }
            }
        }
    }
    for entity in &motion.posed {
        if let Some(index) = objects.index_of(entity) {
            objects.moved.insert(index);
        }
    }
    objects.end_motion();
}

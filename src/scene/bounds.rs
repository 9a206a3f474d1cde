//! The systems that write the bounding boxes of objects.

use bevy_ecs::change_detection::{ContiguousMut, Tick};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;

use super::changes::{Since, bits};
use super::placement::placed;
use super::{LocalBounds, PosedMesh, SceneMesh, Skin, WorldBounds, tasks};
use crate::geometry::Aabb;

/// Recomputes [`LocalBounds`] of meshes that were added, replaced or posed.
///
/// Set: `UpdateBounds`, after [`pose_meshes`](super::pose_meshes). A mesh that is not posed yet has the
/// bounds of its rest pose. Cost: the vertices of changed meshes.
#[allow(clippy::type_complexity, reason = "a query says what the system reads")]
pub fn update_local_bounds(
    mut meshes: Query<
        (&SceneMesh, Option<&PosedMesh>, &mut LocalBounds),
        Or<(Changed<SceneMesh>, Changed<PosedMesh>)>,
    >,
    mut without_mesh: Query<&mut LocalBounds, Without<SceneMesh>>,
) {
    // The mesh component was removed; the other components remain.
    for mut bounds in &mut without_mesh {
        bounds.set_if_neq(LocalBounds::default());
    }
    for (mesh, posed, mut bounds) in &mut meshes {
        let posed = posed
            .map(|posed| &posed.positions)
            .filter(|posed| posed.len() == mesh.0.positions.len());
        let positions = posed.unwrap_or(&mesh.0.positions);
        let aabb = if mesh.0.indices.is_empty() {
            Aabb::EMPTY
        } else {
            Aabb::from_points(positions.iter().copied())
        };
        bounds.set_if_neq(LocalBounds(aabb));
    }
}

/// Number of rows that one task processes.
const CHUNK: usize = 4096;

/// Recomputes [`WorldBounds`] of objects whose transform or local bounds changed, and marks them as changed.
///
/// Set: `UpdateBounds`, after [`update_local_bounds`]. The system reads whole columns of change ticks, so
/// that objects at rest cost next to nothing. The bounds of moved objects are computed on all threads. The
/// location in code of the last change (bevy's `track_location`) is not recorded.
pub fn update_world_bounds(
    mut objects: Query<(
        Ref<LocalBounds>,
        Ref<GlobalTransform>,
        &mut WorldBounds,
        Has<Skin>,
    )>,
) {
    let Ok(tables) = objects.contiguous_iter_mut() else {
        unreachable!("all three are kept in tables");
    };
    for (local, transform, world, is_skinned) in tables {
        let since = Since::new(local.last_run_tick(), local.this_run_tick());
        let this_run = local.this_run_tick();
        let (local_ticks, transform_ticks) = (local.changed_ticks_slice(), transform.changed_ticks_slice());
        let (local, transform) = (local.into_inner(), transform.into_inner());
        let (world, mut world_ticks) = ContiguousMut::bypass_change_detection_split(world);
        let ticks = || local_ticks.chunks(CHUNK).zip(transform_ticks.chunks(CHUNK));
        let changed = |(local, transform): &(&[Tick], &[Tick])| since.any(local) || since.any(transform);
        let dirty = ticks().filter(changed).count();
        if dirty == 0 {
            continue;
        }
        let values = local.chunks(CHUNK).zip(transform.chunks(CHUNK));
        let out = world
            .chunks_mut(CHUNK)
            .zip(world_ticks.changed_mut().chunks_mut(CHUNK));
        let chunks = ticks().zip(values).zip(out);
        let chunks = chunks.filter(|((ticks, _), _)| changed(ticks));
        tasks::for_each(
            chunks,
            dirty > 1,
            |((ticks, (local, transform)), (world, stamp))| {
                for (at, (local_ticks, transform_ticks)) in
                    ticks.0.chunks(64).zip(ticks.1.chunks(64)).enumerate()
                {
                    for bit in bits(since.mask(local_ticks) | since.mask(transform_ticks)) {
                        let row = at * 64 + bit;
                        world[row] = world_bounds(&local[row], &transform[row], is_skinned);
                        stamp[row] = this_run;
                    }
                }
            },
        );
    }
}

fn world_bounds(local: &LocalBounds, transform: &GlobalTransform, is_skinned: bool) -> WorldBounds {
    let affine = placed(transform, is_skinned);
    WorldBounds(affine.map_or(Aabb::EMPTY, |affine| local.0.transformed(&affine)))
}

//! The systems that write the bounding boxes of objects.

use bevy_ecs::change_detection::{ContiguousMut, Tick};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::GlobalTransform;

use super::changes::{Since, any_changed, bits};
use super::placement::placed;
use super::{ExtraBounds, LocalBounds, PosedMesh, SceneMesh, Skin, WorldBounds, tasks};
use crate::geometry::Aabb;

/// Recomputes [`LocalBounds`] of meshes that were added, replaced or posed, or got other [`ExtraBounds`].
///
/// Set: `UpdateBounds`, after [`pose_meshes`](super::pose_meshes). A mesh that is not posed yet has the
/// bounds of its rest pose. Cost: the vertices of changed meshes; at rest columns of change ticks are read.
pub fn update_local_bounds(
    shapes: Shapes,
    mut changed: ParamSet<(
        Query<Measured, Or<(Changed<SceneMesh>, Changed<PosedMesh>, Changed<ExtraBounds>)>>,
        Query<Measured>,
    )>,
    mut without_extra: RemovedComponents<ExtraBounds>,
    mut without_mesh: Query<&mut LocalBounds, Without<SceneMesh>>,
) {
    // The mesh component was removed; the other components remain.
    for mut bounds in &mut without_mesh {
        bounds.set_if_neq(LocalBounds::default());
    }
    if shapes.any_changed() {
        changed.p0().iter_mut().for_each(measure);
    }
    let mut all = changed.p1();
    for entity in without_extra.read() {
        if let Ok(object) = all.get_mut(entity) {
            measure(object);
        }
    }
}

/// Everything by which local bounds are measured.
#[derive(SystemParam)]
pub struct Shapes<'w, 's> {
    meshes: Query<'w, 's, Ref<'static, SceneMesh>>,
    posed: Query<'w, 's, Ref<'static, PosedMesh>>,
    extra: Query<'w, 's, Ref<'static, ExtraBounds>>,
}

impl Shapes<'_, '_> {
    fn any_changed(&self) -> bool {
        any_changed(&self.meshes) || any_changed(&self.posed) || any_changed(&self.extra)
    }
}

/// An object that may be measured.
type Measured = (
    &'static SceneMesh,
    Option<&'static PosedMesh>,
    Option<&'static ExtraBounds>,
    &'static mut LocalBounds,
);

fn measure(
    (mesh, posed, extra, mut bounds): (
        &SceneMesh,
        Option<&PosedMesh>,
        Option<&ExtraBounds>,
        Mut<LocalBounds>,
    ),
) {
    let posed = posed
        .map(|posed| &posed.positions)
        .filter(|posed| posed.len() == mesh.0.positions.len());
    let positions = posed.unwrap_or(&mesh.0.positions);
    let mut aabb = Aabb::EMPTY;
    if !mesh.0.indices.is_empty() {
        aabb = Aabb::from_points(positions.iter().copied());
        if let Some(extra) = extra.filter(|extra| !extra.0.is_empty()) {
            aabb = aabb.union(extra.0);
        }
    }
    bounds.set_if_neq(LocalBounds(aabb));
}

/// Number of rows that one task processes.
const CHUNK: usize = 4096;

/// Recomputes [`WorldBounds`] of objects whose transform or local bounds changed, or that got or lost a [`Skin`], and marks
/// them as changed.
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
    bound: Query<Entity, (Added<Skin>, With<WorldBounds>)>,
    mut unbound: RemovedComponents<Skin>,
) {
    // Where a transform flattens an object, a skin changes the object's matrix.
    for entity in bound.iter().chain(unbound.read()) {
        if let Ok((local, transform, mut world, is_skinned)) = objects.get_mut(entity) {
            *world = world_bounds(&local, &transform, is_skinned);
        }
    }
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_transform::prelude::Transform;
    use glam::Vec3;

    use super::*;
    use crate::scene::MeshData;

    #[test]
    fn a_skin_that_comes_or_goes_counts_where_a_transform_is_flat() {
        let mut world = World::new();
        let mut schedule = Schedule::default();
        schedule.add_systems(update_world_bounds);
        let flat = Transform::from_scale(Vec3::new(1.0, 0.0, 1.0));
        let local = LocalBounds(Aabb::around(Vec3::ZERO, Vec3::ONE));
        let parts = (local, WorldBounds::default(), GlobalTransform::from(flat));
        let object = world.spawn(parts).id();
        let mut height = |world: &mut World| {
            schedule.run(world);
            world.get::<WorldBounds>(object).map(|bounds| bounds.0.max.y)
        };
        let is_flat = |height: Option<f32>| height.is_some_and(|height| height < 0.01);
        assert!(is_flat(height(&mut world)));
        world.entity_mut(object).insert(Skin {
            joints: Vec::new(),
            inverse_bind: [].into(),
        });
        assert_eq!(height(&mut world), Some(1.0), "the joints alone count");
        world.entity_mut(object).remove::<Skin>();
        assert!(is_flat(height(&mut world)));
    }

    #[test]
    fn extra_bounds_add_to_those_of_the_mesh_as_long_as_they_are_there() {
        let mut world = World::new();
        let mut schedule = Schedule::default();
        schedule.add_systems(update_local_bounds);
        let mesh = SceneMesh(Arc::new(MeshData::cuboid(Vec3::ONE)));
        let object = world.spawn((mesh, LocalBounds::default())).id();
        let mut bounds = |world: &mut World| {
            schedule.run(world);
            world
                .get::<LocalBounds>(object)
                .map(|bounds| (bounds.0.min, bounds.0.max))
        };
        let own = Some((Vec3::NEG_ONE, Vec3::ONE));
        assert_eq!(bounds(&mut world), own);
        let wave = Aabb::around(Vec3::ZERO, Vec3::new(0.5, 4.0, 0.5));
        world.entity_mut(object).insert(ExtraBounds(wave));
        let taller = Some((Vec3::new(-1.0, -4.0, -1.0), Vec3::new(1.0, 4.0, 1.0)));
        assert_eq!(bounds(&mut world), taller);
        world.entity_mut(object).insert(ExtraBounds(Aabb::EMPTY));
        assert_eq!(bounds(&mut world), own, "empty bounds add nothing");
        world.entity_mut(object).insert(ExtraBounds(wave));
        assert_eq!(bounds(&mut world), taller);
        world.entity_mut(object).remove::<ExtraBounds>();
        assert_eq!(bounds(&mut world), own);
    }
}

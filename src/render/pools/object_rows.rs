//! The constants of objects: which of them are old, and how they are computed.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;
use glam::{DMat4, DVec3};

use super::gpu_types;
use super::objects::{ObjectTable, object_constants};
use crate::scene::changes::bits;
use crate::scene::placement::Placement;
use crate::scene::{SurfaceWeights, tasks};
use crate::sets::Objects;

/// The view for which matrices of objects are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectView {
    /// The map from world space to clip space.
    pub clip_from_world: DMat4,
    /// The place of the eye, world space.
    pub eye_world: DVec3,
}

/// The components that an object's constants depend on.
#[derive(SystemParam)]
pub struct ObjectParts<'w, 's> {
    places: Query<'w, 's, Placement>,
    weights: Query<'w, 's, &'static SurfaceWeights>,
    weighted_anew: Query<'w, 's, Entity, Changed<SurfaceWeights>>,
    without_weights: RemovedComponents<'w, 's, SurfaceWeights>,
    without_place: RemovedComponents<'w, 's, GlobalTransform>,
}

/// Number of words of the bitsets, 64 objects each, that one task processes. This takes some 50 microseconds.
const CHUNK: usize = 4;

/// Number of objects in a word.
const WORD: usize = usize::BITS as usize;

impl ObjectParts<'_, '_> {
    /// Collects the objects that moved, or got or lost weights, since the system last ran.
    fn collect_changed(&mut self, objects: &Objects, changed: &mut FixedBitSet) {
        changed.clone_from(&objects.moved);
        let removed = self.without_weights.read().chain(self.without_place.read());
        for entity in self.weighted_anew.iter().chain(removed) {
            if let Some(object) = objects.index_of(entity) {
                changed.insert(object);
            }
        }
    }
}

/// Computes the constants and the handedness of an object. The last result tells whether it has weights.
fn constants_of(
    entity: Entity,
    places: &Query<Placement>,
    weights: &Query<&SurfaceWeights>,
    view: ObjectView,
) -> (gpu_types::Object, f32, bool) {
    let place = places.get(entity).ok();
    let world_from_local = place
        .and_then(|place| place.world_from_local())
        .unwrap_or(DMat4::ZERO);
    let handedness = world_from_local.determinant().signum() as f32;
    let is_usable = world_from_local.is_finite() && handedness != 0.0;
    let mut constants = if is_usable {
        object_constants(world_from_local, view.clip_from_world, view.eye_world)
    } else {
        gpu_types::Object::default()
    };
    let weights = weights.get(entity).ok();
    let weights = weights.filter(|weights| **weights != SurfaceWeights::default());
    if let Some(weights) = weights {
        constants.handedness[1..].copy_from_slice(&weights.to_vec3().to_array());
    }
    (
        constants,
        if is_usable { handedness } else { 0.0 },
        weights.is_some(),
    )
}

impl ObjectTable {
    /// Computes the matrices in f64: those of all objects if the view or the order of the objects is new, and otherwise those
    /// of the objects that moved or got other weights. [`ObjectTable::changed`] then names them. Many are computed on all
    /// threads.
    ///
    /// World positions are made relative to the eye before they are rounded. So a scene far from the world's
    /// origin is shaded and depth-tested as exactly as a scene near the origin.
    pub fn update_constants(
        &mut self,
        objects: &Objects,
        parts: &mut ObjectParts,
        view: ObjectView,
        is_new: bool,
    ) {
        let len = objects.len();
        parts.collect_changed(objects, &mut self.changed);
        if is_new {
            self.changed.insert_range(..);
            self.constants.clear();
            self.constants.resize(len.max(1), gpu_types::Object::default());
            self.handedness.clear();
            self.handedness.resize(len, 0.0);
            self.weighted.clear();
            self.weighted.grow(len);
        }
        let pieces = self
            .constants
            .chunks_mut(CHUNK * WORD)
            .zip(self.handedness.chunks_mut(CHUNK * WORD))
            .zip(self.weighted.as_mut_slice().chunks_mut(CHUNK))
            .zip(objects.entities.chunks(CHUNK * WORD))
            .zip(self.changed.as_slice().chunks(CHUNK));
        let pieces = pieces.filter(|(_, changed)| changed.iter().any(|bits| *bits != 0));
        let parallel = self.changed.count_ones(..) > 2 * CHUNK * WORD;
        let (places, weights) = (&parts.places, &parts.weights);
        tasks::for_each(
            pieces,
            parallel,
            |((((constants, handedness), weighted), entities), changed)| {
                for (word, (&changed, weighted)) in changed.iter().zip(weighted).enumerate() {
                    for bit in bits(changed as u64) {
                        let object = word * WORD + bit;
                        let has_weights;
                        (constants[object], handedness[object], has_weights) =
                            constants_of(entities[object], places, weights, view);
                        *weighted = *weighted & !(1 << bit) | usize::from(has_weights) << bit;
                    }
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_ecs::system::SystemState;
    use bevy_tasks::{ComputeTaskPool, TaskPool};
    use bevy_transform::prelude::Transform;
    use glam::{Quat, Vec3};

    use super::*;
    use crate::scene::{MeshData, SceneMesh, bounds};
    use crate::sets::{collect_sets, init_set_resources};

    const VIEW: ObjectView = ObjectView {
        clip_from_world: DMat4::from_cols_array(&[
            0.7, 0.1, 0.2, 0.3, 0.0, 1.2, 0.1, 0.1, 0.3, 0.2, 0.9, -1.0, 5.0, 4.0, 3.0, 2.0,
        ]),
        eye_world: DVec3::new(0.3, -4.0, 7.0),
    };

    fn place(i: usize, height: f32) -> GlobalTransform {
        let mirrored = Vec3::new(-1.0, 2.0, 1.0);
        let scale = [Vec3::ONE, mirrored, Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0)];
        Transform::from_xyz(i as f32, height, (i % 11) as f32)
            .with_rotation(Quat::from_rotation_y(i as f32))
            .with_scale(scale[usize::min(i % 9, 3)])
            .into()
    }

    fn weights(diffuse: f32) -> SurfaceWeights {
        SurfaceWeights {
            diffuse,
            ..SurfaceWeights::default()
        }
    }

    /// A world of ordinary, mirrored, flat and collapsed objects, some of them with weights, and a table of them.
    struct Fixture {
        world: World,
        entities: Vec<Entity>,
        schedule: Schedule,
        table: ObjectTable,
    }

    impl Fixture {
        fn new(count: usize) -> Self {
            let mut world = World::new();
            init_set_resources(&mut world);
            let mesh = Arc::new(MeshData::cuboid(Vec3::splat(0.4)));
            let spawn = |i: usize| {
                let mut entity = world.spawn((SceneMesh(mesh.clone()), place(i, 0.0)));
                if i.is_multiple_of(5) {
                    entity.insert(weights(i as f32));
                }
                entity.id()
            };
            let entities = (0..count).map(spawn).collect();
            let mut schedule = Schedule::default();
            let bounds = (bounds::update_local_bounds, bounds::update_world_bounds);
            schedule.add_systems((bounds.chain(), collect_sets()).chain());
            Self {
                world,
                entities,
                schedule,
                table: ObjectTable::default(),
            }
        }

        /// Runs a frame, and compares the table with one that computes everything. Returns the objects that were computed.
        fn frame(
            &mut self,
            state: &mut SystemState<(Res<Objects>, ObjectParts)>,
            is_new: bool,
        ) -> Vec<Entity> {
            self.schedule.run(&mut self.world);
            let (objects, mut parts) = state.get_mut(&mut self.world).expect("objects are collected");
            self.table.update_constants(&objects, &mut parts, VIEW, is_new);
            let mut fresh = ObjectTable::default();
            fresh.update_constants(&objects, &mut parts, VIEW, true);
            assert!(self.table.constants == fresh.constants, "constants");
            assert_eq!(self.table.handedness, fresh.handedness);
            assert_eq!(self.table.weighted, fresh.weighted);
            let changed = self.table.changed.ones();
            let mut changed: Vec<Entity> = changed.map(|object| objects.entities[object]).collect();
            changed.sort_unstable();
            self.world.clear_trackers();
            changed
        }
    }

    fn sorted(entities: &[Entity]) -> Vec<Entity> {
        let mut entities = entities.to_vec();
        entities.sort_unstable();
        entities
    }

    #[test]
    fn what_moved_or_got_weights_is_computed_and_nothing_else() {
        ComputeTaskPool::get_or_init(TaskPool::default);
        let mut fixture = Fixture::new(700);
        let state = &mut SystemState::new(&mut fixture.world);
        let entities = fixture.entities.clone();
        assert_eq!(fixture.frame(state, true), sorted(&entities));
        assert!(fixture.frame(state, false).is_empty());
        for i in [9, 500] {
            *fixture.world.get_mut(entities[i]).unwrap() = place(i, 1.0);
        }
        assert_eq!(fixture.frame(state, false), sorted(&[entities[9], entities[500]]));
        // The bounds of a box stay while it is turned over.
        let turned = Transform::from_scale(Vec3::splat(-1.0));
        *fixture.world.get_mut(entities[0]).unwrap() = GlobalTransform::from(turned);
        assert_eq!(fixture.frame(state, false), [entities[0]]);
        *fixture.world.get_mut(entities[10]).unwrap() = weights(0.25);
        assert_eq!(fixture.frame(state, false), [entities[10]]);
        fixture.world.entity_mut(entities[1]).insert(weights(0.5));
        assert_eq!(fixture.frame(state, false), [entities[1]]);
        fixture.world.entity_mut(entities[1]).remove::<SurfaceWeights>();
        assert_eq!(fixture.frame(state, false), [entities[1]]);
        fixture.world.entity_mut(entities[3]).remove::<GlobalTransform>();
        assert_eq!(fixture.frame(state, false), [entities[3]]);
        for (i, &entity) in entities.iter().enumerate().skip(4) {
            *fixture.world.get_mut(entity).unwrap() = place(i, 2.0);
        }
        assert_eq!(
            fixture.frame(state, false),
            sorted(&entities[4..]),
            "on all threads"
        );
    }
}

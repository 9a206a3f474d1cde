//! The shadow scene of one camera: a world of our own components, with our own systems, that follows the game's.

use bevy::camera::visibility::RenderLayers;
use bevy::ecs::prelude::*;
use bevy::ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy::transform::components::GlobalTransform;

use super::entity_map::EntityMap;
use super::light_convert::BevyLight;
use super::view_state::ViewState;
use crate::geometry::Aabb;
use crate::scene::{
    Light, LightSelection, LocalBounds, MorphWeights, PosedMesh, SceneMaterials, SceneMesh, SelectionLayers,
    ShadowCaster, ShadowReceiver, Skin, WorldBounds,
};
use crate::schedule;
use crate::silhouettes::casters::{CasterEdges, PosedPlanes};
use crate::techniques::{Techniques, add_row};

/// The schedule of a mirror.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct MirrorSchedule;

/// What a mirror's light stands for.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostLight {
    /// In the render world.
    pub render_entity: Entity,
    /// Whose function shades it.
    pub kind: BevyLight,
}

/// The entity of the game that an entity of a mirror stands for.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostEntity(pub Entity);

/// Bounds of a mesh that has none of our data, local space: it is lit, and casts nothing.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct HostBounds(pub Aabb);

/// All that makes an entity an object.
type ObjectComponents = (
    SceneMesh,
    SceneMaterials,
    ShadowCaster,
    ShadowReceiver,
    SelectionLayers,
    LocalBounds,
    WorldBounds,
    HostBounds,
    Skin,
    MorphWeights,
    PosedMesh,
    CasterEdges,
    PosedPlanes,
);

/// The shadow scene of one camera.
///
/// One a camera, and not one for all: what is visible, which silhouettes and maps are needed and what the GPU holds
/// depends on the view, and is kept from frame to frame.
pub struct Mirror {
    /// The scene and what follows from it.
    pub world: World,
    /// Layers that the camera sees.
    pub layers: RenderLayers,
    /// The camera's entity.
    pub camera: Entity,
    /// Everything is to be taken over, as nothing was yet.
    pub fresh: bool,
    /// What of it the GPU draws with.
    pub view: ViewState,
    schedule: Schedule,
    map: EntityMap,
}

impl Mirror {
    /// An empty scene.
    pub fn new(layers: RenderLayers, techniques: &Techniques) -> Self {
        let mut world = World::new();
        schedule::init_resources(&mut world);
        let mut schedule = Schedule::new(MirrorSchedule);
        // Systems spread their own work over all threads; one after the other they wait for nobody.
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule::add_systems(&mut schedule);
        for &row in techniques.rows() {
            add_row(row, &mut world, &mut schedule);
        }
        let camera = world.spawn(GlobalTransform::IDENTITY).id();
        Self {
            world,
            layers,
            camera,
            fresh: true,
            view: ViewState::default(),
            schedule,
            map: EntityMap::default(),
        }
    }

    /// Computes the frame.
    pub fn run(&mut self) {
        self.schedule.run(&mut self.world);
        self.world.clear_trackers();
    }

    /// What stands for an entity of the game.
    pub fn get(&self, main: Entity) -> Option<Entity> {
        self.map.get(main)
    }

    /// What stands for an entity of the game, made if need be.
    pub fn get_or_spawn(&mut self, main: Entity, transform: &GlobalTransform) -> Entity {
        if let Some(known) = self.map.get(main) {
            return known;
        }
        let mirrored = self.world.spawn((*transform, HostEntity(main))).id();
        if let Some(orphan) = self.map.insert(main, mirrored) {
            self.world.despawn(orphan);
        }
        mirrored
    }

    /// The entity is gone, or has no place any more.
    pub fn despawn(&mut self, main: Entity) {
        if let Some(mirrored) = self.map.remove(main) {
            self.world.despawn(mirrored);
        }
    }

    /// The entity is no object any more; it may still be a light or a joint.
    pub fn remove_object(&mut self, main: Entity) {
        if let Some(mirrored) = self.map.get(main)
            && self.world.get::<SelectionLayers>(mirrored).is_some()
        {
            self.world.entity_mut(mirrored).remove::<ObjectComponents>();
        }
    }

    /// The entity is no managed light any more.
    pub fn remove_light(&mut self, main: Entity, techniques: &Techniques) {
        if let Some(mirrored) = self.map.get(main)
            && self.world.get::<HostLight>(mirrored).is_some()
        {
            let mut light = self.world.entity_mut(mirrored);
            for row in techniques.rows() {
                row.remove(&mut light);
            }
            light.remove::<(Light, LightSelection, HostLight)>();
        }
    }

    /// Moves what stands for an entity of the game, if anything does.
    pub fn place(&mut self, main: Entity, transform: &GlobalTransform) {
        let Some(mirrored) = self.map.get(main) else {
            return;
        };
        let mut entity = self.world.entity_mut(mirrored);
        if let Some(mut place) = entity.get_mut::<GlobalTransform>() {
            *place = *transform;
        }
        if let Some(bounds) = entity.get::<HostBounds>().copied()
            && let Some(mut world) = entity.get_mut::<WorldBounds>()
        {
            world.0 = bounds.0.transformed(&transform.affine());
        }
    }
}

/// The mirrors, ascending by the camera's entity in the game.
#[derive(Resource, Default)]
pub struct Mirrors {
    entries: Vec<(Entity, Mirror)>,
}

impl Mirrors {
    /// All of them, each with its camera in the game.
    pub fn iter(&self) -> impl Iterator<Item = (Entity, &Mirror)> {
        self.entries.iter().map(|(camera, mirror)| (*camera, mirror))
    }

    /// All of them.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Mirror> {
        self.entries.iter_mut().map(|(_, mirror)| mirror)
    }

    /// That of a camera of the game.
    pub fn get(&self, camera: Entity) -> Option<&Mirror> {
        let at = self
            .entries
            .binary_search_by_key(&camera, |&(camera, _)| camera)
            .ok()?;
        Some(&self.entries[at].1)
    }

    /// That of a camera of the game.
    pub fn get_mut(&mut self, camera: Entity) -> Option<&mut Mirror> {
        let at = self
            .entries
            .binary_search_by_key(&camera, |&(camera, _)| camera)
            .ok()?;
        Some(&mut self.entries[at].1)
    }

    /// Keeps the mirrors of these cameras.
    pub fn retain(&mut self, keep: impl Fn(Entity) -> bool) {
        self.entries.retain(|&(camera, _)| keep(camera));
    }

    /// Adds one that is not there.
    pub fn insert(&mut self, camera: Entity, mirror: Mirror) {
        if let Err(at) = self.entries.binary_search_by_key(&camera, |&(camera, _)| camera) {
            self.entries.insert(at, (camera, mirror));
        }
    }

    /// Forgets all: they are made anew from the game in the next frame.
    pub fn clear(&mut self) {
        self.entries.clear();
    }
}

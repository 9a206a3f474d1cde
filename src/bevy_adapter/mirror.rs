//! The shadow scene of one camera: a world with this crate's components and systems that follows the game's
//! world.

use bevy::camera::visibility::RenderLayers;
use bevy::ecs::prelude::*;
use bevy::ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy::transform::components::GlobalTransform;

use super::entity_map::EntityMap;
use super::light_convert::{BevyLight, place_of_rect};
use super::ranges::Level;
use super::sync_models::remove_model;
use super::view_state::ViewState;
use crate::geometry::Aabb;
use crate::scene::{
    ExtraBounds, Light, LightPath, LightSelection, LocalBounds, MorphWeights, PosedMesh, SceneMaterials,
    SceneMesh, SelectionLayers, ShadowCaster, ShadowReceiver, Skin, WorldBounds,
};
use crate::schedule;
use crate::silhouettes::casters::{CasterEdges, PosedPlanes};
use crate::techniques::{Techniques, add_row};

/// Label of a mirror's schedule.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct MirrorSchedule;

/// The Bevy light that a mirror's light stands for.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostLight {
    /// Entity of the light in the render world.
    pub render_entity: Entity,
    /// Kind of the light, which selects Bevy's light function.
    pub kind: BevyLight,
}

/// The entity of the game that an entity of a mirror stands for.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostEntity(pub Entity);

/// Bounds, in local space, of an object whose mesh is not ready or was refused. The object is lit and casts
/// nothing.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct HostBounds(pub Aabb);

/// All components that make an entity of a mirror an object.
type ObjectComponents = (
    SceneMesh,
    SceneMaterials,
    ShadowCaster,
    ShadowReceiver,
    SelectionLayers,
    LocalBounds,
    ExtraBounds,
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
/// Each camera has its own mirror. Visible sets, silhouettes, maps and GPU buffers depend on the view and are
/// kept from frame to frame, so cameras cannot share them.
pub struct Mirror {
    /// World with the scene and everything that is computed from it.
    pub world: World,
    /// Render layers that the camera sees.
    pub layers: RenderLayers,
    /// Entity of the camera in the mirror's world.
    pub camera: Entity,
    /// True until the first synchronisation, which copies everything instead of only what changed.
    pub fresh: bool,
    /// Whether the schedule ran in the last frame.
    pub(super) has_run: bool,
    /// Number of frames since the schedule ran.
    pub(super) idle_frames: u32,
    /// State with which the GPU draws the camera's lights.
    pub view: ViewState,
    /// Objects of the game that must be synchronised again, beside those that changed in the game. Their level
    /// of detail changed, or a transform began or ceased to mirror them.
    pub(super) dirty: Vec<Entity>,
    /// Objects of the game that began or ceased to show shadows in this frame.
    pub(super) receivers_changed: Vec<Entity>,
    /// Levels of detail, by the game's entity index. Entities beyond the end are drawn wholly.
    levels: Vec<Level>,
    schedule: Schedule,
    map: EntityMap,
}

impl Mirror {
    /// Makes an empty scene for a camera that sees `layers`.
    pub fn new(layers: RenderLayers, techniques: &Techniques) -> Self {
        let mut world = World::new();
        schedule::init_resources(&mut world);
        let mut schedule = Schedule::new(MirrorSchedule);
        // Each system spreads its own work over all threads, so systems need not run side by side.
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
            has_run: false,
            idle_frames: 0,
            view: ViewState::default(),
            dirty: Vec::new(),
            receivers_changed: Vec::new(),
            levels: Vec::new(),
            schedule,
            map: EntityMap::default(),
        }
    }

    /// Runs the systems of one frame.
    pub fn run(&mut self) {
        self.schedule.run(&mut self.world);
        self.world.clear_trackers();
        self.has_run = true;
    }

    /// Returns the mirror's entity that stands for an entity of the game.
    pub fn get(&self, main: Entity) -> Option<Entity> {
        self.map.get(main)
    }

    /// Returns the mirror's entity that stands for an entity of the game. Spawns it at `transform` if there
    /// is none.
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

    /// Despawns the mirror's entity for an entity of the game that is gone or has lost its `GlobalTransform`.
    pub fn despawn(&mut self, main: Entity) {
        if let Some(mirrored) = self.map.remove(main) {
            self.world.despawn(mirrored);
        }
    }

    /// Removes the object components for an entity of the game that is no object any more. The entity may
    /// still be a light or a joint.
    pub fn remove_object(&mut self, main: Entity) {
        if let Some(mirrored) = self.map.get(main)
            && self.world.get::<SelectionLayers>(mirrored).is_some()
        {
            self.world.entity_mut(mirrored).remove::<ObjectComponents>();
        }
    }

    /// Removes the light components for an entity of the game that is no managed light any more. Returns whether
    /// it was one. It must then be placed again, because rectangles have a place of their own.
    pub fn remove_light(&mut self, main: Entity, techniques: &Techniques) -> bool {
        if let Some(mirrored) = self.map.get(main)
            && self.world.get::<HostLight>(mirrored).is_some()
        {
            let mut light = self.world.entity_mut(mirrored);
            for row in techniques.rows() {
                row.remove(&mut light);
            }
            remove_model(&mut light);
            light.remove::<(Light, LightPath, LightSelection, HostLight)>();
            return true;
        }
        false
    }

    /// Whether an object of the game shows shadows.
    pub fn shows_shadows(&self, main: Entity) -> bool {
        let object = self.map.get(main);
        object.is_some_and(|object| self.world.get::<ShadowReceiver>(object).is_some())
    }

    /// Returns the level of detail in which the camera shows an object of the game.
    pub fn level(&self, main: Entity) -> Level {
        let level = self.levels.get(main.index_u32() as usize);
        level.copied().unwrap_or_default()
    }

    /// Sets the level of detail of an object of the game. If it changed, the object is synchronised again.
    pub(super) fn set_level(&mut self, main: Entity, level: Level) {
        if self.level(main) == level {
            return;
        }
        let index = main.index_u32() as usize;
        if self.levels.len() <= index {
            self.levels.resize(index + 1, Level::Whole);
        }
        self.levels[index] = level;
        self.dirty.push(main);
    }

    /// Moves the mirror's entity that stands for an entity of the game, if there is one. A mirrored rectangle is
    /// placed so that it shines to the side that Bevy lights.
    pub fn place(&mut self, main: Entity, transform: &GlobalTransform) {
        let Some(mirrored) = self.map.get(main) else {
            return;
        };
        let mut entity = self.world.entity_mut(mirrored);
        let host = entity.get::<HostLight>();
        let is_rect = host.is_some_and(|host| host.kind == BevyLight::Rect);
        if let Some(mut place) = entity.get_mut::<GlobalTransform>() {
            // The place of a rectangle does not tell whether its transform mirrors.
            if is_rect || mirrors(&place) != mirrors(transform) {
                self.dirty.push(main);
            }
            *place = if is_rect {
                place_of_rect(transform)
            } else {
                *transform
            };
        }
        if let Some(bounds) = entity.get::<HostBounds>().copied()
            && let Some(mut world) = entity.get_mut::<WorldBounds>()
        {
            world.0 = bounds.0.transformed(&transform.affine());
        }
    }
}

/// Whether a transform turns a mesh inside out, as a scale with one or three negative factors does.
pub fn mirrors(transform: &GlobalTransform) -> bool {
    transform.affine().matrix3.determinant() < 0.0
}

/// The mirrors of all marked cameras.
#[derive(Resource, Default)]
pub struct Mirrors {
    /// The mirrors with their camera in the game, in ascending order of that entity.
    entries: Vec<(Entity, Mirror)>,
}

impl Mirrors {
    /// Yields all mirrors, each with its camera in the game, in ascending order of that entity.
    pub fn iter(&self) -> impl Iterator<Item = (Entity, &Mirror)> {
        self.entries.iter().map(|(camera, mirror)| (*camera, mirror))
    }

    /// Yields all mirrors, each with its camera in the game, in ascending order of that entity.
    pub fn iter_mut_with_camera(&mut self) -> impl Iterator<Item = (Entity, &mut Mirror)> {
        self.entries.iter_mut().map(|(camera, mirror)| (*camera, mirror))
    }

    /// Yields all mirrors, in ascending order of their camera's entity in the game.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Mirror> {
        self.entries.iter_mut().map(|(_, mirror)| mirror)
    }

    /// Returns the mirror of a camera of the game.
    pub fn get(&self, camera: Entity) -> Option<&Mirror> {
        let at = self
            .entries
            .binary_search_by_key(&camera, |&(camera, _)| camera)
            .ok()?;
        Some(&self.entries[at].1)
    }

    /// Returns the mirror of a camera of the game, to change it.
    pub fn get_mut(&mut self, camera: Entity) -> Option<&mut Mirror> {
        let at = self
            .entries
            .binary_search_by_key(&camera, |&(camera, _)| camera)
            .ok()?;
        Some(&mut self.entries[at].1)
    }

    /// Removes the mirrors of cameras for which `keep` is false.
    pub fn retain(&mut self, keep: impl Fn(Entity, &Mirror) -> bool) {
        self.entries.retain(|(camera, mirror)| keep(*camera, mirror));
    }

    /// Adds the mirror of a camera. Does nothing if the camera has a mirror.
    pub fn insert(&mut self, camera: Entity, mirror: Mirror) {
        if let Err(at) = self.entries.binary_search_by_key(&camera, |&(camera, _)| camera) {
            self.entries.insert(at, (camera, mirror));
        }
    }

    /// Removes all mirrors. The next frame makes them again from the game's world.
    pub fn clear(&mut self) {
        self.entries.clear();
    }
}

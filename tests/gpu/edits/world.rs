//! A world that follows a description.

use std::collections::HashMap;
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{LocalBounds, PosedMesh, Skin, WorldBounds};
use antumbra::techniques::maps::MapSettings;
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use bevy_transform::prelude::Transform;
use glam::{Mat4, Vec3};

use super::spec::{Lamp, PROFILES, Shape, Spec, Thing};
use crate::harness::support::stage::Stage;

/// A component of an entity that goes and comes back within one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blink {
    pub id: u32,
    pub part: u8,
}

/// A frame: what the world is to be, and how it is changed into that.
#[derive(Clone, Debug)]
pub struct Step {
    pub spec: Spec,
    /// Whether components are changed where they are; otherwise they are inserted again.
    pub in_place: bool,
    pub blinks: Vec<Blink>,
    /// Whether a frame is drawn between this step and the next.
    pub draws: bool,
}

/// A world and the description that it was brought up to last.
pub struct Live {
    pub stage: Stage,
    spec: Option<Spec>,
    pub entities: HashMap<u32, Entity>,
    pivots: [Entity; 2],
    cells: [Entity; 2],
    portal: Entity,
}

impl Live {
    /// Builds an empty world. A context gives it a renderer.
    pub fn new(context: Option<&RenderContext>) -> Self {
        let mut stage = Stage::empty(Default::default(), Camera::default(), Transform::IDENTITY);
        bevy_tasks::ComputeTaskPool::get_or_init(Default::default);
        stage.schedule.set_executor(SingleThreadedExecutor::new());
        if let Some(context) = context {
            stage
                .add_renderer(context.clone(), RenderSettings::default())
                .expect("shaders compose");
        }
        stage.world.resource_mut::<MapSettings>().face_updates = 1000;
        let world = &mut stage.world;
        let [a, b, c, d, portal] = [0; 5].map(|_| world.spawn(Transform::IDENTITY).id());
        Self {
            stage,
            spec: None,
            entities: HashMap::new(),
            pivots: [a, b],
            cells: [c, d],
            portal,
        }
    }

    /// Builds the world of a step at once. The entities have the order of those in another world.
    pub fn fresh(step: &Step, like: &Self, context: Option<&RenderContext>) -> Self {
        let mut live = Self::new(context);
        let mut order: Vec<_> = like.entities.iter().map(|(id, entity)| (*entity, *id)).collect();
        order.sort_unstable();
        let mut empty: Vec<Entity> = order
            .iter()
            .map(|_| live.stage.world.spawn_empty().id())
            .collect();
        empty.sort_unstable();
        live.entities = order.iter().map(|(_, id)| *id).zip(empty).collect();
        let step = Step {
            blinks: Vec::new(),
            ..step.clone()
        };
        live.sync(&step);
        // What this crate adds to an entity stays when the component is gone that needed it.
        for (id, entity) in &like.entities {
            let mut made = live.stage.world.entity_mut(live.entities[id]);
            let known = like.stage.world.entity(*entity);
            if known.contains::<PosedMesh>() {
                made.insert_if_new(PosedMesh::default());
            }
            if known.contains::<WorldBounds>() {
                made.insert_if_new((LocalBounds::default(), WorldBounds::default()));
            }
        }
        live
    }

    /// Changes the world into what a step says.
    pub fn sync(&mut self, step: &Step) {
        let new = &step.spec;
        let old = self.spec.take();
        self.sync_view(new);
        let ids = |spec: &Spec| {
            let things = spec.things.iter().map(|thing| thing.id);
            things
                .chain(spec.lamps.iter().map(|lamp| lamp.id))
                .collect::<Vec<_>>()
        };
        let (kept, known) = (ids(new), old.as_ref().map(&ids).unwrap_or_default());
        for gone in known.iter().filter(|id| !kept.contains(id)) {
            let entity = self.entities.remove(gone).expect("it was spawned");
            self.stage.world.despawn(entity);
        }
        for thing in &new.things {
            let before = old
                .as_ref()
                .and_then(|old| old.things.iter().find(|t| t.id == thing.id));
            self.sync_thing(thing, before, step.in_place);
        }
        for lamp in &new.lamps {
            let before = old
                .as_ref()
                .and_then(|old| old.lamps.iter().find(|l| l.id == lamp.id));
            self.sync_lamp(lamp, before, step.in_place);
        }
        for blink in &step.blinks {
            if let Some(&entity) = self.entities.get(&blink.id) {
                self.blink(entity, blink.part);
            }
        }
        self.stage.lights = new.lamps.iter().map(|lamp| self.entities[&lamp.id]).collect();
        self.spec = Some(new.clone());
    }

    fn sync_view(&mut self, new: &Spec) {
        let world = &mut self.stage.world;
        for (entity, place) in self.pivots.into_iter().zip(new.pivots) {
            put(&mut world.entity_mut(entity), Some(place), true);
        }
        let mut camera = world.entity_mut(self.stage.camera);
        put(&mut camera, new.camera, true);
        put(&mut camera, Some(new.eye), true);
        put(&mut camera, new.ignores_scale, true);
        for (entity, cell) in self.cells.into_iter().zip(new.cells) {
            let mut entity = world.entity_mut(entity);
            put(&mut entity, cell.map(|(half_size, ..)| Cell { half_size }), true);
            if let Some((_, place, layers)) = cell {
                put(&mut entity, Some(place), true);
                put(&mut entity, Some(SelectionLayers(layers)), true);
            }
        }
        let portal = new.portal.map(|(_, open)| Portal {
            open,
            ..Portal::rectangle(self.cells, 0.8, 0.8)
        });
        let mut entity = world.entity_mut(self.portal);
        put(&mut entity, portal, true);
        put(
            &mut entity,
            new.portal.map(|(place, _)| place).or(Some(Transform::IDENTITY)),
            true,
        );
        set(world, ViewportSize(new.size));
        set(world, new.culling);
        set(world, new.culled);
        set(world, new.occlusion);
        if let Some(mut renderer) = world.get_resource_mut::<Renderer>() {
            renderer.settings.ambient = new.ambient;
            renderer.settings.scissor = new.scissor;
            renderer.settings.depth_bounds = new.depth_bounds;
        }
    }

    fn entity(&mut self, id: u32) -> Entity {
        let world = &mut self.stage.world;
        *self
            .entities
            .entry(id)
            .or_insert_with(|| world.spawn_empty().id())
    }

    fn sync_thing(&mut self, new: &Thing, old: Option<&Thing>, in_place: bool) {
        let entity = self.entity(new.id);
        let pivots = self.pivots;
        let mut entity = self.stage.world.entity_mut(entity);
        if old.is_none() {
            entity.insert(Name::new(format!("thing {}", new.id)));
        }
        put_parent(&mut entity, new.parent.map(|at| pivots[at]));
        put(&mut entity, Some(new.place), in_place);
        if old.is_none_or(|old| old.shape != new.shape) {
            put_mesh(
                &mut entity,
                new.shape.as_ref(),
                old.and_then(|old| old.shape.as_ref()),
                in_place,
            );
        }
        if old.is_none_or(|old| old.materials != new.materials) {
            put_materials(&mut entity, &new.materials, in_place);
        }
        put(&mut entity, new.caster, in_place);
        put(&mut entity, new.receiver, in_place);
        put(&mut entity, new.layers, in_place);
        put(&mut entity, new.morph.clone(), in_place);
        put(&mut entity, new.blurred, in_place);
        put(&mut entity, new.extra, in_place);
        put(&mut entity, new.weights, in_place);
        if old.map(|old| old.occluder) != Some(new.occluder) {
            match new.occluder {
                None => entity.remove::<Occluder>(),
                Some(0) => entity.insert(Occluder::Own),
                Some(1) => entity.insert(Occluder::Never),
                Some(_) => entity.insert(Occluder::Proxy(Arc::new(MeshData::cuboid(Vec3::splat(0.2))))),
            };
        }
        if old.map(|old| old.skin) != Some(new.skin) {
            match new.skin {
                None => entity.remove::<Skin>(),
                Some(at) => entity.insert(Skin {
                    joints: vec![pivots[at]],
                    inverse_bind: [Mat4::IDENTITY].into(),
                }),
            };
        }
        let cells = new.cells.as_ref();
        put(
            &mut entity,
            cells.map(|at| InCells(at.iter().map(|&at| self.cells[at]).collect())),
            in_place,
        );
    }

    fn sync_lamp(&mut self, new: &Lamp, old: Option<&Lamp>, in_place: bool) {
        let entity = self.entity(new.id);
        let pivots = self.pivots;
        let mut entity = self.stage.world.entity_mut(entity);
        put_parent(&mut entity, new.parent.map(|at| pivots[at]));
        put(&mut entity, Some(new.place), in_place);
        put(&mut entity, new.light.clone(), in_place);
        put(
            &mut entity,
            new.selection.or(Some(LightSelection::default())),
            in_place,
        );
        put(&mut entity, new.stencil, in_place);
        put(&mut entity, new.wedge, in_place);
        put(&mut entity, new.map, in_place);
        put(&mut entity, new.omni, in_place);
        put(&mut entity, new.perspective, in_place);
        put(&mut entity, new.smoothie, in_place);
        put(&mut entity, new.slices, in_place);
        put(&mut entity, new.shape, in_place);
        put(&mut entity, new.distance, in_place);
        put(&mut entity, new.weights, in_place);
        put(&mut entity, new.tint, in_place);
        put(&mut entity, new.origin, in_place);
        put(&mut entity, new.softness, in_place);
        put(&mut entity, new.barn_map, in_place);
        put(&mut entity, new.cookie.clone(), in_place);
        if old.map(|old| old.profile) != Some(new.profile) {
            match new.profile {
                None => entity.remove::<LightProfile>(),
                Some(at) => entity.insert(PROFILES[at].clone()),
            };
        }
    }

    fn blink(&mut self, entity: Entity, part: u8) {
        let mut entity = self.stage.world.entity_mut(entity);
        match part {
            0 => again::<SceneMesh>(&mut entity),
            1 => again::<SceneMaterials>(&mut entity),
            2 => again::<ShadowCaster>(&mut entity),
            3 => again::<ShadowReceiver>(&mut entity),
            4 => again::<Transform>(&mut entity),
            5 => again::<Light>(&mut entity),
            6 => again::<StencilVolume>(&mut entity),
            7 => again::<OmniMap>(&mut entity),
            8 => again::<PosedMesh>(&mut entity),
            9 => again::<WorldBounds>(&mut entity),
            10 => again::<LocalBounds>(&mut entity),
            _ => again::<antumbra::scene::MorphWeights>(&mut entity),
        }
    }
}

/// Removes a component and puts it back.
fn again<C: Component>(entity: &mut EntityWorldMut) {
    if let Some(part) = entity.take::<C>() {
        entity.insert(part);
    }
}

/// Gives an entity a component, or takes it away.
fn put<C: Component<Mutability = Mutable> + PartialEq>(
    entity: &mut EntityWorldMut,
    new: Option<C>,
    in_place: bool,
) {
    match (entity.get::<C>(), new) {
        (None, None) => {}
        (Some(_), None) => {
            entity.remove::<C>();
        }
        (Some(old), Some(new)) if *old == new => {}
        (Some(_), Some(new)) => {
            if in_place {
                *entity.get_mut::<C>().expect("it is there") = new;
            } else {
                entity.insert(new);
            }
        }
        (None, Some(new)) => {
            entity.insert(new);
        }
    }
}

fn put_parent(entity: &mut EntityWorldMut, parent: Option<Entity>) {
    let old = entity.get::<ChildOf>().map(ChildOf::parent);
    match parent {
        _ if old == parent => {}
        Some(parent) => {
            entity.insert(ChildOf(parent));
        }
        None => {
            entity.remove::<ChildOf>();
        }
    }
}

fn put_mesh(entity: &mut EntityWorldMut, new: Option<&Shape>, old: Option<&Shape>, in_place: bool) {
    let Some(new) = new else {
        entity.remove::<SceneMesh>();
        return;
    };
    let same_shape = old.is_some_and(|old| old.at == new.at && old.grown != 1.0);
    let built = new.build();
    if let Some(mut mesh) = entity.get_mut::<SceneMesh>()
        && in_place
    {
        if same_shape && new.grown != 1.0 {
            Arc::make_mut(&mut mesh.0).positions = built.positions.clone();
        } else {
            mesh.0 = built;
        }
    } else {
        entity.insert(SceneMesh(built));
    }
}

fn put_materials(entity: &mut EntityWorldMut, new: &[Material], in_place: bool) {
    if let Some(mut materials) = entity.get_mut::<SceneMaterials>()
        && in_place
        && materials.0.len() == new.len()
    {
        for (old, new) in materials.0.iter_mut().zip(new) {
            if **old != *new {
                *Arc::make_mut(old) = new.clone();
            }
        }
    } else {
        entity.insert(SceneMaterials(new.iter().cloned().map(Arc::new).collect()));
    }
}

fn set<R: Resource + PartialEq>(world: &mut World, new: R) {
    if *world.resource::<R>() != new {
        world.insert_resource(new);
    }
}

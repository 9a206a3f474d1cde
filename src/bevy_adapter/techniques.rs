//! Which components make a light managed: the shadow techniques, ours and those of others.

use bevy::app::App;
use bevy::ecs::component::{ComponentId, Mutable};
use bevy::ecs::prelude::*;
use bevy::ecs::world::EntityRef;
use bevy::render::{Extract, ExtractSchedule, RenderApp};

use super::systems::AntumbraExtractSystems;
use crate::scene::ShadowedLight;
use crate::silhouettes::NeedsSilhouettes;

/// The techniques that the adapter knows; in the render world.
#[derive(Resource, Default)]
pub struct Techniques {
    entries: Vec<Technique>,
}

struct Technique {
    is_on: fn(&EntityRef) -> bool,
    copy: fn(&EntityRef, &mut EntityWorldMut),
    remove: fn(&mut EntityWorldMut),
    set_up: fn(&mut World, &mut Schedule),
}

/// Lights of the game whose technique was set, changed or taken away in this frame; in the render world.
#[derive(Resource, Default)]
pub struct TouchedLights(pub Vec<Entity>);

/// The components of all techniques; in the main world.
#[derive(Resource, Default)]
pub struct TechniqueComponents(pub Vec<ComponentId>);

/// Techniques that were registered before the app had a renderer; in the main world.
#[derive(Resource, Default)]
struct Waiting(Vec<Box<dyn FnOnce(&mut App) + Send + Sync>>);

/// Registers the techniques that waited for a renderer.
pub(super) fn add_waiting(app: &mut App) {
    if let Some(waiting) = app.world_mut().remove_resource::<Waiting>() {
        for add in waiting.0 {
            add(app);
        }
    }
}

/// Registers shadow techniques.
pub trait AddShadowTechnique {
    /// A light of Bevy's with the component `T` gets its shadows from us. `set_up` is given the world and the schedule of
    /// each camera's shadow scene: a technique that the crate does not bring adds its systems and its recorder there
    /// ([`AntumbraSystems`](crate::schedule::AntumbraSystems), [`Recorder`](crate::render::recorder::Recorder)).
    /// Does nothing in an app that never gets a renderer. Before the first frame, before or after the plugins.
    fn add_shadow_technique<T>(&mut self, set_up: fn(&mut World, &mut Schedule)) -> &mut Self
    where
        T: Component<Mutability = Mutable> + Clone + PartialEq;
}

impl AddShadowTechnique for App {
    fn add_shadow_technique<T>(&mut self, set_up: fn(&mut World, &mut Schedule)) -> &mut Self
    where
        T: Component<Mutability = Mutable> + Clone + PartialEq,
    {
        if self.get_sub_app(RenderApp).is_none() {
            let mut waiting = self.world_mut().get_resource_or_init::<Waiting>();
            waiting.0.push(Box::new(move |app| {
                app.add_shadow_technique::<T>(set_up);
            }));
            return self;
        }
        let component = self.world_mut().register_component::<T>();
        let mut components = self.world_mut().get_resource_or_init::<TechniqueComponents>();
        components.0.push(component);
        let render_app = self.sub_app_mut(RenderApp);
        render_app.init_resource::<Techniques>();
        render_app.init_resource::<TouchedLights>();
        let mut techniques = render_app.world_mut().resource_mut::<Techniques>();
        techniques.entries.push(Technique {
            is_on: |light| light.contains::<T>(),
            copy: copy::<T>,
            remove: |light| {
                light.remove::<T>();
            },
            set_up,
        });
        render_app.add_systems(
            ExtractSchedule,
            collect_touched::<T>.in_set(AntumbraExtractSystems::Collect),
        );
        self
    }
}

impl Techniques {
    /// Whether a light of the game has one.
    pub fn manage(&self, light: &EntityRef) -> bool {
        self.entries.iter().any(|technique| (technique.is_on)(light))
    }

    /// Gives a mirror's light the techniques of the game's.
    pub fn copy(&self, from: &EntityRef, to: &mut EntityWorldMut) {
        for technique in &self.entries {
            (technique.copy)(from, to);
        }
    }

    /// Takes all techniques from a mirror's light.
    pub fn remove(&self, light: &mut EntityWorldMut) {
        for technique in &self.entries {
            (technique.remove)(light);
        }
        light.remove::<(ShadowedLight, NeedsSilhouettes)>();
    }

    /// Prepares a mirror for them.
    pub fn set_up(&self, world: &mut World, schedule: &mut Schedule) {
        for technique in &self.entries {
            (technique.set_up)(world, schedule);
        }
    }
}

fn copy<T: Component<Mutability = Mutable> + Clone + PartialEq>(from: &EntityRef, to: &mut EntityWorldMut) {
    match (from.get::<T>(), to.get_mut::<T>()) {
        (Some(new), Some(mut old)) => {
            if *old != *new {
                *old = new.clone();
            }
        }
        (Some(new), None) => {
            to.insert(new.clone());
        }
        (None, Some(_)) => {
            to.remove::<T>();
        }
        (None, None) => {}
    }
}

fn collect_touched<T: Component>(
    mut touched: ResMut<TouchedLights>,
    changed: Extract<Query<Entity, Changed<T>>>,
    mut removed: Extract<RemovedComponents<T>>,
) {
    touched.0.extend(changed.iter());
    touched.0.extend(removed.read());
}

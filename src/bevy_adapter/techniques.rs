//! The components that make a light managed: the shadow techniques of this crate and of others.

use std::any::TypeId;

use bevy::app::App;
use bevy::app::PostUpdate;
use bevy::ecs::component::ComponentId;
use bevy::ecs::prelude::*;
use bevy::ecs::reflect::AppTypeRegistry;
use bevy::render::{Extract, ExtractSchedule, RenderApp};

use super::systems::AntumbraExtractSystems;
use super::systems::Installed;
use crate::schedule::AntumbraSystems;
use crate::techniques::{AddTechnique, Technique, Techniques};

/// Lights of the game whose technique or light model was inserted, changed or removed in this frame. The resource is in the
/// render world.
#[derive(Resource, Default)]
pub struct TouchedLights {
    /// Entities of the lights in the game's world. An entity may occur several times.
    pub lights: Vec<Entity>,
    /// Types of the techniques whose changes are watched.
    watched: Vec<TypeId>,
}

/// Ids of the components of all techniques. The resource is in the main world.
#[derive(Resource, Default)]
pub struct TechniqueComponents(pub Vec<ComponentId>);

/// Functions that add the techniques that were added before the app had a renderer. The resource is in the
/// main world.
#[derive(Resource, Default)]
struct Waiting(Vec<fn(&mut App) -> bool>);

/// Adds the techniques that waited for a renderer. The systems that they have added to the main world are
/// switched off.
pub(super) fn add_waiting(app: &mut App) {
    let Some(waiting) = app.world_mut().remove_resource::<Waiting>() else {
        return;
    };
    for set in AntumbraSystems::ALL {
        app.configure_sets(PostUpdate, set.run_if(not(resource_exists::<Installed>)));
    }
    for add in waiting.0 {
        add(app);
    }
}

/// Adds a technique to the render world's list in an app with Bevy's renderer. Each camera's mirror takes its
/// techniques from this list. Returns `false` if the app has no such renderer. If the app gets one before it
/// is finished, the technique is added then.
pub fn add_technique<T: Technique>(app: &mut App) -> bool {
    register_type::<T>(app);
    if app.get_sub_app(RenderApp).is_none() {
        let mut waiting = app.world_mut().get_resource_or_init::<Waiting>();
        waiting.0.push(add_technique::<T>);
        return false;
    }
    let component = app.world_mut().register_component::<T>();
    let mut components = app.world_mut().get_resource_or_init::<TechniqueComponents>();
    if !components.0.contains(&component) {
        components.0.push(component);
    }
    let render_app = app.sub_app_mut(RenderApp);
    render_app.init_resource::<TouchedLights>();
    let world = render_app.world_mut();
    world.init_resource::<Techniques>();
    world.resource_mut::<Techniques>().add_technique::<T>();
    let watched = &mut world.resource_mut::<TouchedLights>().watched;
    if !watched.contains(&TypeId::of::<T>()) {
        watched.push(TypeId::of::<T>());
        let collect = collect_touched::<T>.in_set(AntumbraExtractSystems::Collect);
        render_app.add_systems(ExtractSchedule, collect);
    }
    true
}

fn register_type<T: Technique>(app: &mut App) {
    let world = app.world_mut();
    world.init_resource::<AppTypeRegistry>();
    T::register_type(&mut world.resource::<AppTypeRegistry>().write());
}

/// Registers only the types of techniques in an app, whether or not the app has a renderer.
pub struct Reflected<'a>(pub &'a mut App);

impl AddTechnique for Reflected<'_> {
    fn add_technique<T: Technique>(&mut self) -> &mut Self {
        register_type::<T>(self.0);
        self
    }
}

pub(super) fn collect_touched<T: Component>(
    mut touched: ResMut<TouchedLights>,
    changed: Extract<Query<Entity, Changed<T>>>,
    mut removed: Extract<RemovedComponents<T>>,
) {
    touched.lights.extend(changed.iter());
    touched.lights.extend(removed.read());
}

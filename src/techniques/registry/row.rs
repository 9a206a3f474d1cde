//! A technique without its type, and settings of any technique.

use std::any::TypeId;
use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::refusal::Refusal;
use super::statistics::Statistics;
use super::technique::Technique;
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::Needs;

/// A [`Technique`] without its type: functions instead of a type parameter. Made by [`Row::of`] and nowhere else.
#[derive(Clone, Copy)]
pub struct Row {
    name: &'static str,
    needs: Needs,
    component: TypeId,
    is_on: fn(&EntityRef) -> bool,
    check: fn(&EntityRef, &Light) -> Result<(), Refusal>,
    settings_of: fn(&EntityRef) -> Option<Settings>,
    defaults: fn() -> Settings,
    #[cfg(feature = "serde")]
    parse: fn(&mut dyn erased_serde::Deserializer) -> Result<Settings, erased_serde::Error>,
    copy: fn(&EntityRef, &mut EntityWorldMut),
    remove: fn(&mut EntityWorldMut),
    init: fn(&mut World),
    add_systems: fn(&mut Schedule),
    statistics: fn(&World, usize, &mut Statistics),
    frame_statistics: fn(&World, &mut Statistics),
    report: fn(&World, &mut Round),
    #[cfg(feature = "render")]
    pub(super) gpu: super::gpu_row::GpuRow,
}

impl PartialEq for Row {
    fn eq(&self, other: &Self) -> bool {
        self.component == other.component
    }
}

impl Eq for Row {}

impl std::fmt::Debug for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Row").field(&self.name).finish()
    }
}

impl Row {
    /// The row of a technique.
    pub fn of<T: Technique>() -> Self {
        Self {
            name: T::NAME,
            needs: T::NEEDS,
            component: TypeId::of::<T>(),
            is_on: |light| light.contains::<T>(),
            check: |entity, light| entity.get::<T>().map_or(Ok(()), |settings| settings.check(light)),
            settings_of: |light| light.get::<T>().cloned().map(Settings::of),
            defaults: || Settings::of(T::default()),
            #[cfg(feature = "serde")]
            parse: |from| T::parse(from).map(Settings::of),
            copy: copy::<T>,
            remove: |light| {
                light.remove::<T>();
            },
            init: T::init,
            add_systems: T::add_systems,
            statistics: T::statistics,
            frame_statistics: T::frame_statistics,
            report: T::report,
            #[cfg(feature = "render")]
            gpu: super::gpu_row::GpuRow::of::<T>(),
        }
    }

    /// Name of the technique, in snake case.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// What the technique needs.
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// Type of the technique's component.
    pub fn component(&self) -> TypeId {
        self.component
    }

    /// Whether a light has the component.
    pub fn is_on(&self, light: &EntityRef) -> bool {
        (self.is_on)(light)
    }

    /// Whether the technique can shadow a light that has its component.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, entity: &EntityRef, light: &Light) -> Result<(), Refusal> {
        (self.check)(entity, light)
    }

    /// The settings of a light that has the component.
    pub fn settings_of(&self, light: &EntityRef) -> Option<Settings> {
        (self.settings_of)(light)
    }

    /// The settings that the technique has by default.
    pub fn defaults(&self) -> Settings {
        (self.defaults)()
    }

    /// Reads settings from a file.
    ///
    /// # Errors
    /// Names the setting that is wrong.
    #[cfg(feature = "serde")]
    pub fn parse<'de>(&self, from: impl serde::Deserializer<'de>) -> Result<Settings, erased_serde::Error> {
        (self.parse)(&mut <dyn erased_serde::Deserializer>::erase(from))
    }

    /// Makes the component of one light that of another: inserts, changes or removes it. What is equal is left alone, so
    /// that it does not count as changed.
    pub fn copy(&self, from: &EntityRef, to: &mut EntityWorldMut) {
        (self.copy)(from, to);
    }

    /// Takes the component off a light.
    pub fn remove(&self, light: &mut EntityWorldMut) {
        (self.remove)(light);
    }

    /// Inserts the technique's resources, those that are missing.
    pub fn init(&self, world: &mut World) {
        (self.init)(world);
    }

    /// Adds the technique's systems.
    pub fn add_systems(&self, schedule: &mut Schedule) {
        (self.add_systems)(schedule);
    }

    /// Sets what the technique knows of one light of the frame, of whatever technique the light is.
    pub fn statistics(&self, world: &World, light: usize, out: &mut Statistics) {
        (self.statistics)(world, light, out);
    }

    /// Sets what the technique knows of the frame.
    pub fn frame_statistics(&self, world: &World, out: &mut Statistics) {
        (self.frame_statistics)(world, out);
    }

    /// The technique's WGSL files, each after those that it imports.
    #[cfg(feature = "render")]
    pub fn shaders(&self) -> &'static [crate::render::ShaderFile] {
        self.gpu.shaders
    }

    /// Raises what the technique cannot do in this frame.
    pub(super) fn report(&self, world: &World, round: &mut Round) {
        (self.report)(world, round);
    }
}

fn copy<T: Technique>(from: &EntityRef, to: &mut EntityWorldMut) {
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

/// Settings of any technique: the component, without its type.
#[derive(Clone)]
pub struct Settings {
    row: Row,
    component: Arc<dyn AnyTechnique>,
}

trait AnyTechnique: Send + Sync {
    fn check(&self, light: &Light) -> Result<(), Refusal>;
    fn insert(&self, light: &mut EntityWorldMut);
}

impl<T: Technique> AnyTechnique for T {
    fn check(&self, light: &Light) -> Result<(), Refusal> {
        Technique::check(self, light)
    }

    fn insert(&self, light: &mut EntityWorldMut) {
        light.insert(self.clone());
    }
}

impl std::fmt::Debug for Settings {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Settings").field(&self.row.name).finish()
    }
}

impl Settings {
    /// A component as settings.
    pub fn of<T: Technique>(component: T) -> Self {
        Self {
            row: Row::of::<T>(),
            component: Arc::new(component),
        }
    }

    /// The technique whose settings these are.
    pub fn row(&self) -> Row {
        self.row
    }

    /// Whether a light can be shadowed with these settings.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.component.check(light)
    }

    /// Gives a light these settings. The world must know the technique ([`AddTechnique`](super::AddTechnique)).
    pub fn insert(&self, light: &mut EntityWorldMut) {
        self.component.insert(light);
    }
}

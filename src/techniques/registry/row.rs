//! A technique without its type, and settings of any technique.

use std::any::TypeId;
use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::refusal::{FileError, Refusal};
use super::statistics::Statistics;
use super::technique::Technique;
use super::texels::TexelLookup;
use crate::debug_lines::DebugLines;
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::{LeftObjects, Needs};

/// A [`Technique`] without its type: it holds functions instead of a type parameter. Only [`Row::of`] makes
/// rows.
#[derive(Clone, Copy)]
pub struct Row {
    constants: &'static Constants,
    needs: Needs,
    component: TypeId,
    component_name: &'static str,
    is_on: fn(&EntityRef) -> bool,
    check: fn(&EntityRef, &Light) -> Result<(), Refusal>,
    settings_of: fn(&EntityRef) -> Option<Settings>,
    defaults: fn() -> Settings,
    #[cfg(feature = "serde")]
    parse: fn(&mut dyn erased_serde::Deserializer) -> Result<Settings, erased_serde::Error>,
    #[cfg(feature = "schema")]
    schema: fn(&mut schemars::SchemaGenerator) -> Option<schemars::Schema>,
    copy: fn(&EntityRef, &mut EntityWorldMut),
    remove: fn(&mut EntityWorldMut),
    init: fn(&mut World),
    add_systems: fn(&mut Schedule),
    statistics: fn(&World, usize, &mut Statistics),
    frame_statistics: fn(&World, &mut Statistics),
    debug_lines: fn(&World, usize, &mut DebugLines),
    report: fn(&World, &mut Round),
    #[cfg(feature = "render")]
    pub(super) gpu: super::gpu_row::GpuRow,
}

/// The parts of a row that need not lie in it, because rows are copied about.
struct Constants {
    name: &'static str,
    paths: &'static [&'static str],
    load_files: fn(&mut World, Entity) -> Result<(), FileError>,
    texels: fn(&World, usize) -> Option<TexelLookup<'_>>,
    leaves_others: bool,
    left_to_others: fn(&World, usize) -> LeftObjects<'_>,
    is_same: fn(&EntityRef, &EntityRef) -> bool,
}

impl PartialEq for Row {
    fn eq(&self, other: &Self) -> bool {
        self.component == other.component
    }
}

impl Eq for Row {}

impl std::fmt::Debug for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Row").field(&self.name()).finish()
    }
}

/// Returns the name of a type without its path.
fn short_type_name<T>() -> &'static str {
    let name = std::any::type_name::<T>();
    name.rsplit("::").next().unwrap_or(name)
}

impl Row {
    /// Makes the row of a technique.
    pub fn of<T: Technique>() -> Self {
        Self {
            constants: const {
                &Constants {
                    name: T::NAME,
                    paths: T::PATHS,
                    load_files: T::load_files,
                    texels: T::texels,
                    leaves_others: T::LEAVES_OTHERS,
                    left_to_others: T::left_to_others,
                    is_same: |a, b| a.get::<T>() == b.get::<T>(),
                }
            },
            needs: T::NEEDS,
            component: TypeId::of::<T>(),
            component_name: short_type_name::<T>(),
            is_on: |light| light.contains::<T>(),
            check: |entity, light| entity.get::<T>().map_or(Ok(()), |settings| settings.check(light)),
            settings_of: |light| light.get::<T>().cloned().map(Settings::of),
            defaults: || Settings::of(T::default()),
            #[cfg(feature = "serde")]
            parse: |from| T::parse(from).map(Settings::of),
            #[cfg(feature = "schema")]
            schema: T::schema,
            copy: copy::<T>,
            remove: |light| {
                light.remove::<T>();
            },
            init: T::init,
            add_systems: T::add_systems,
            statistics: T::statistics,
            frame_statistics: T::frame_statistics,
            debug_lines: T::debug_lines,
            report: T::report,
            #[cfg(feature = "render")]
            gpu: super::gpu_row::GpuRow::of::<T>(),
        }
    }

    /// Returns the name of the technique, in snake case.
    pub fn name(&self) -> &'static str {
        self.constants.name
    }

    /// Returns the name of the component's type without its path, for messages to whoever inserted it.
    pub fn component_name(&self) -> &'static str {
        self.component_name
    }

    /// Returns what the stages before and after the technique do for its lights ([`Technique::NEEDS`]).
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// Whether a light with the technique may have another one beside it ([`Technique::LEAVES_OTHERS`]).
    pub fn leaves_others(&self) -> bool {
        self.constants.leaves_others
    }

    /// Returns the objects that the technique leaves to another one ([`Technique::left_to_others`]).
    pub(super) fn left_to_others<'w>(&self, world: &'w World, light: usize) -> LeftObjects<'w> {
        (self.constants.left_to_others)(world, light)
    }

    /// Whether two entities have equal settings of the technique, or none.
    pub(super) fn is_same(&self, a: &EntityRef, b: &EntityRef) -> bool {
        (self.constants.is_same)(a, b)
    }

    /// Returns the names of the settings that are paths ([`Technique::PATHS`]).
    pub fn paths(&self) -> &'static [&'static str] {
        self.constants.paths
    }

    /// Reads the files that the technique's settings on a light name ([`Technique::load_files`]).
    ///
    /// # Errors
    /// The setting, and what is wrong with its file.
    pub fn load_files(&self, world: &mut World, light: Entity) -> Result<(), FileError> {
        (self.constants.load_files)(world, light)
    }

    /// Returns the type of the technique's component.
    pub fn component(&self) -> TypeId {
        self.component
    }

    /// Whether a light has the technique's component.
    pub fn is_on(&self, light: &EntityRef) -> bool {
        (self.is_on)(light)
    }

    /// Checks whether the technique can shadow a light that has its component.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn check(&self, entity: &EntityRef, light: &Light) -> Result<(), Refusal> {
        (self.check)(entity, light)
    }

    /// Copies the technique's settings from a light; `None` if the light does not have the component.
    pub fn settings_of(&self, light: &EntityRef) -> Option<Settings> {
        (self.settings_of)(light)
    }

    /// Returns the technique's default settings.
    pub fn defaults(&self) -> Settings {
        (self.defaults)()
    }

    /// Reads settings of the technique from a file.
    ///
    /// # Errors
    /// The error names the setting that is wrong.
    #[cfg(feature = "serde")]
    pub fn parse<'de>(&self, from: impl serde::Deserializer<'de>) -> Result<Settings, erased_serde::Error> {
        (self.parse)(&mut <dyn erased_serde::Deserializer>::erase(from))
    }

    /// Describes the technique's settings ([`Technique::schema`]); `None` if the technique does not.
    #[cfg(feature = "schema")]
    pub fn schema(&self, of: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
        (self.schema)(of)
    }

    /// Makes the component of the light `to` equal to that of the light `from`, by inserting, changing or
    /// removing it. A component that is equal already is not touched, so it does not count as changed.
    pub fn copy(&self, from: &EntityRef, to: &mut EntityWorldMut) {
        (self.copy)(from, to);
    }

    /// Removes the technique's component from a light.
    pub fn remove(&self, light: &mut EntityWorldMut) {
        (self.remove)(light);
    }

    /// Inserts the missing ones of the technique's resources.
    pub fn init(&self, world: &mut World) {
        (self.init)(world);
    }

    /// Adds the technique's systems to a schedule.
    pub fn add_systems(&self, schedule: &mut Schedule) {
        (self.add_systems)(schedule);
    }

    /// Sets the technique's statistics of one light of the frame, whichever technique shadows that light.
    /// `light` is an index into [`FrameLights`](crate::sets::FrameLights).
    pub fn statistics(&self, world: &World, light: usize, out: &mut Statistics) {
        (self.statistics)(world, light, out);
    }

    /// Sets the technique's statistics of the whole frame.
    pub fn frame_statistics(&self, world: &World, out: &mut Statistics) {
        (self.frame_statistics)(world, out);
    }

    /// Adds lines that show how the technique shadows a light ([`Technique::debug_lines`]).
    pub(super) fn debug_lines(&self, world: &World, light: usize, out: &mut DebugLines) {
        (self.debug_lines)(world, light, out);
    }

    /// Returns what counts the texels of the technique's pictures of a light ([`Technique::texels`]).
    pub(super) fn texels<'w>(&self, world: &'w World, light: usize) -> Option<TexelLookup<'w>> {
        (self.constants.texels)(world, light)
    }

    /// Returns the technique's WGSL files. Each file comes after the files that it imports.
    #[cfg(feature = "render")]
    pub fn shaders(&self) -> &'static [crate::render::ShaderFile] {
        self.gpu.shaders
    }

    /// Raises the technique's own reports of this frame.
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

/// Settings of any technique: a component without its type.
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
        f.debug_tuple("Settings").field(&self.row.name()).finish()
    }
}

impl Settings {
    /// Makes settings from a technique's component.
    pub fn of<T: Technique>(component: T) -> Self {
        Self {
            row: Row::of::<T>(),
            component: Arc::new(component),
        }
    }

    /// Returns the row of the technique to which the settings belong.
    pub fn row(&self) -> Row {
        self.row
    }

    /// Checks whether a light can be shadowed with these settings.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.component.check(light)
    }

    /// Inserts the settings as a component of a light. The world must know the technique
    /// ([`AddTechnique`](super::AddTechnique)).
    pub fn insert(&self, light: &mut EntityWorldMut) {
        self.component.insert(light);
    }
}

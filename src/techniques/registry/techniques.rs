//! The techniques of a world.

use bevy_ecs::prelude::*;

use super::add_technique::AddTechnique;
use super::builtin::add_builtin;
use super::refusal::RefusedLight;
use super::row::{Row, Settings};
use super::technique::Technique;
use super::texels::TexelLookup;
use crate::debug_lines::DebugLines;
use crate::sets::FrameLights;

/// The techniques that a world knows. The crate's own techniques come first.
#[derive(Resource, Clone, Debug)]
pub struct Techniques {
    pub(super) rows: Vec<Row>,
    /// Lights whose technique refuses to shadow them in this frame.
    pub(super) refused: Vec<RefusedLight>,
}

impl Default for Techniques {
    /// Returns the crate's own techniques.
    fn default() -> Self {
        let mut techniques = Self {
            rows: Vec::new(),
            refused: Vec::new(),
        };
        add_builtin(&mut techniques);
        techniques
    }
}

impl AddTechnique for Techniques {
    fn add_technique<T: Technique>(&mut self) -> &mut Self {
        self.add(Row::of::<T>());
        self
    }
}

impl AddTechnique for (&mut World, &mut Schedule) {
    fn add_technique<T: Technique>(&mut self) -> &mut Self {
        let (world, schedule) = self;
        add_row(Row::of::<T>(), world, schedule);
        self
    }
}

/// Adds a technique to a world and its systems to the world's schedule, unless the world knows the technique.
pub fn add_row(row: Row, world: &mut World, schedule: &mut Schedule) {
    world.init_resource::<Techniques>();
    if world.resource_mut::<Techniques>().add(row) {
        row.init(world);
        row.add_systems(schedule);
    }
}

impl Techniques {
    /// Adds a row. Returns `false` if the technique is already in the list.
    fn add(&mut self, row: Row) -> bool {
        let is_new = !self.rows.contains(&row);
        if is_new {
            self.rows.push(row);
        }
        is_new
    }

    /// Returns the techniques in the order in which they were added.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Finds the technique of a name, in snake case.
    pub fn named(&self, name: &str) -> Option<Row> {
        self.rows.iter().copied().find(|row| row.name() == name)
    }

    /// Yields the techniques whose components are on an entity. The first of them shadows the light, unless another one leaves
    /// objects to it ([`Technique::LEAVES_OTHERS`]).
    pub fn on<'a>(&'a self, entity: EntityRef<'a>) -> impl Iterator<Item = Row> + 'a {
        self.rows.iter().copied().filter(move |row| row.is_on(&entity))
    }

    /// Adds lines that show how the techniques of a light shadow it, such as the faces of its map. `light` is an index
    /// into [`FrameLights`] of the last frame of `world`; a light without a technique has no lines.
    pub fn debug_lines(&self, world: &World, light: usize, out: &mut DebugLines) {
        let mut draw = |light: usize| {
            if let Some(row) = self.of_light(world, light) {
                row.debug_lines(world, light, out);
            }
        };
        draw(light);
        let Some(lights) = world.get_resource::<FrameLights>() else {
            return;
        };
        if let Some(light) = lights.of_scene().get(light) {
            let companions = lights.companions_of(light.entity);
            companions.for_each(|(companion, _)| draw(companion));
        }
    }

    /// Returns a function that counts the texels that a part of a surface covers in the pictures of a light's technique
    /// ([`Technique::texels`]); `None` for a light without a technique, and for one whose technique looks up no picture.
    /// `light` is an index into [`FrameLights`] of the last frame of `world`.
    pub fn texels<'w>(&self, world: &'w World, light: usize) -> Option<TexelLookup<'w>> {
        self.of_light(world, light)?.texels(world, light)
    }

    /// Returns the technique that shadows a light of the last frame.
    fn of_light(&self, world: &World, light: usize) -> Option<&Row> {
        let lights = world.get_resource::<FrameLights>()?;
        let component = lights.lights.get(light)?.technique?.component;
        self.rows.iter().find(|row| row.component() == component)
    }

    /// Removes the components of all techniques from a light. Returns their settings in the order of the
    /// list, so that [`Settings::insert`] can put them back.
    pub fn take(&self, light: &mut EntityWorldMut) -> Vec<Settings> {
        let settings: Vec<Settings> = self
            .rows
            .iter()
            .filter_map(|row| row.settings_of(&light.as_readonly()))
            .collect();
        for row in &self.rows {
            row.remove(light);
        }
        settings
    }
}

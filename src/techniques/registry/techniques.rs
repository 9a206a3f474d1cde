//! The techniques of a world.

use bevy_ecs::prelude::*;

use super::add_technique::AddTechnique;
use super::builtin::add_builtin;
use super::refusal::RefusedLight;
use super::row::{Row, Settings};
use super::technique::Technique;

/// The techniques that a world knows, those of the crate first.
#[derive(Resource, Clone, Debug)]
pub struct Techniques {
    pub(super) rows: Vec<Row>,
    /// Lights that their technique does not shadow in this frame.
    pub(super) refused: Vec<RefusedLight>,
}

impl Default for Techniques {
    /// The crate's own techniques.
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

/// Adds a technique to a world and to the schedule of its frame, unless the world knows the technique.
pub fn add_row(row: Row, world: &mut World, schedule: &mut Schedule) {
    world.init_resource::<Techniques>();
    if world.resource_mut::<Techniques>().add(row) {
        row.init(world);
        row.add_systems(schedule);
    }
}

impl Techniques {
    /// Adds a row; `false` if the technique is in the list.
    fn add(&mut self, row: Row) -> bool {
        let is_new = !self.rows.contains(&row);
        if is_new {
            self.rows.push(row);
        }
        is_new
    }

    /// The techniques in their order.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The technique of a name, in snake case.
    pub fn named(&self, name: &str) -> Option<Row> {
        self.rows.iter().copied().find(|row| row.name() == name)
    }

    /// The techniques whose components are on an entity; the first shadows the light.
    pub fn on<'a>(&'a self, entity: EntityRef<'a>) -> impl Iterator<Item = Row> + 'a {
        self.rows.iter().copied().filter(move |row| row.is_on(&entity))
    }

    /// Takes all techniques off a light. Gives them, in their order, so that they can be put back
    /// ([`Settings::insert`]).
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

//! Reports of shadow techniques that have no effect or cannot shadow a light.

use std::fmt;

use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;

use super::companions::chosen;
use super::refusal::Refusal;
use super::row::Row;
use super::techniques::Techniques;
use crate::reports::Reports;
use crate::scene::Light;
use crate::sets::CompanionOf;

/// Raises the topic `technique`, and for each technique the topic of its name.
pub fn report_techniques(world: &World, reports: &mut Reports) {
    let techniques = world.resource::<Techniques>();
    report_components(world, techniques, reports);
    for (index, row) in techniques.rows.iter().enumerate() {
        let mut round = reports.round(row.name());
        for light in techniques.refused.iter().filter(|light| light.row == index) {
            let (entity, code) = (Some(light.entity), light.refusal.code());
            let component = row.component_name();
            match light.refusal {
                Refusal::Kind { light, instead } => round.state(
                    entity,
                    code,
                    format_args!(
                        "The light has no shadow: {component} does not fit a {light} light: {instead}."
                    ),
                ),
                refusal @ (Refusal::Setting { .. } | Refusal::Missing { .. }) => round.state(
                    entity,
                    code,
                    format_args!("The light has no shadow: {refusal}. Set it in its {component}."),
                ),
            }
        }
        row.report(world, &mut round);
    }
}

/// Raises techniques on entities without a light, and several techniques on one light. It tests archetypes,
/// not single entities.
fn report_components(world: &World, techniques: &Techniques, reports: &mut Reports) {
    let mut round = reports.round("technique");
    let components = world.components();
    let light = world.component_id::<Light>();
    let companion = world.component_id::<CompanionOf>();
    for archetype in world.archetypes().iter() {
        let has = |id: Option<ComponentId>| id.is_some_and(|id| archetype.contains(id));
        let on = |row: &&Row| has(components.get_id(row.component()));
        let rows = || techniques.rows.iter().filter(on);
        let Some(chosen) = chosen(rows().enumerate()).filter(|_| !has(companion)) else {
            continue;
        };
        let first = chosen.first.1.component_name();
        let used = [Some(chosen.first.1), chosen.second.map(|(_, row)| row)];
        let used_count = used.iter().flatten().count();
        for entity in archetype.entities().iter().map(|entity| Some(entity.id())) {
            if !has(light) {
                round.state(
                    entity,
                    1,
                    format_args!(
                        "{first} has no effect: the entity is no light. Put it on the entity that has the light."
                    ),
                );
            } else if rows().count() > used_count {
                let others = fmt::from_fn(|f| {
                    rows()
                        .filter(|row| **row != *chosen.first.1)
                        .try_for_each(|row| write!(f, " and {}", row.component_name()))
                });
                let are_used = fmt::from_fn(|f| match chosen.second {
                    Some((_, second)) => write!(f, "{first} and {} are used", second.component_name()),
                    None => write!(f, "{first} is used"),
                });
                round.state(
                    entity,
                    2,
                    format_args!(
                        "The light has {} shadow techniques, {first}{others}; {are_used}. Remove the others.",
                        rows().count()
                    ),
                );
            }
        }
    }
}

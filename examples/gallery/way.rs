//! Ways to shadow the lights of a page. All of them come from a list of techniques, so that a technique of the list is in
//! the gallery without a line of its own.

use antumbra::prelude::*;
use antumbra::techniques::{Row, Settings, Techniques};
use bevy_ecs::prelude::Entity;

use super::support::stage::Stage;

/// A technique with its settings.
#[derive(Clone)]
pub struct Way {
    /// Name for file names, without spaces. No two ways of a page have the same name.
    pub name: String,
    /// Name for people.
    pub title: String,
    /// Settings of the lights.
    pub settings: Settings,
}

impl Way {
    /// Makes a way that has only the name of its technique.
    pub fn of(settings: Settings) -> Self {
        let name = settings.row().name();
        Self {
            name: name.to_owned(),
            title: name.replace('_', " "),
            settings,
        }
    }

    /// Makes a way with settings that differ from the technique's defaults. `part` ends its name, and `what` its title.
    pub fn with(settings: Settings, part: &str, what: &str) -> Self {
        let Self {
            name,
            title,
            settings,
        } = Self::of(settings);
        Self {
            name: format!("{name}-{part}"),
            title: format!("{title}, {what}"),
            settings,
        }
    }
}

/// Returns each technique of a list with its default settings.
pub fn ways_of(techniques: &Techniques) -> Vec<Way> {
    techniques
        .rows()
        .iter()
        .map(|row| Way::of(row.defaults()))
        .collect()
}

/// Shadows every light of a stage by a way. A light that the way refuses gets the first of `others` that fits it.
pub fn shadow_all(stage: &mut Stage, way: &Way, others: &[Way]) {
    for light in stage.lights.clone() {
        let Some(kind) = stage.world.get::<Light>(light).cloned() else {
            continue;
        };
        let fits = |way: &&Way| way.settings.check(&kind).is_ok();
        let settings = std::iter::once(way)
            .chain(others)
            .find(fits)
            .map(|way| &way.settings);
        shadow(stage, light, settings);
    }
}

/// Gives a light the settings of one technique and of no other; `None` leaves it without shadows.
pub fn shadow(stage: &mut Stage, light: Entity, settings: Option<&Settings>) {
    let techniques = stage.world.resource::<Techniques>().clone();
    techniques.take(&mut stage.world.entity_mut(light));
    if let Some(settings) = settings {
        stage.shadow(light, settings);
    }
}

/// A light of each kind that there is, with the kind's name for people.
pub fn light_kinds() -> [(&'static str, LightKind); 5] {
    let angles = LightKind::Spot {
        inner_angle: 0.8,
        outer_angle: 1.0,
    };
    let square = LightKind::Rect {
        width: 0.5,
        height: 0.5,
    };
    [
        ("point", LightKind::Point),
        ("spot", angles),
        ("sun", LightKind::Directional),
        ("rectangle", square),
        ("sphere", LightKind::Sphere { radius: 0.25 }),
    ]
}

/// Returns why a technique refuses a kind of light by default; `None` if it takes it.
pub fn refusal(row: Row, kind: LightKind) -> Option<String> {
    let light = Light {
        kind,
        ..Light::point(glam::Vec3::ONE, 1.0, 10.0)
    };
    let refused = row.defaults().check(&light);
    refused.err().map(|refusal| refusal.to_string())
}

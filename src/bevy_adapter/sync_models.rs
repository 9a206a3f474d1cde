//! Copying of the light model's components from the game's lights to the mirrors.

use bevy::app::App;
use bevy::ecs::component::Mutable;
use bevy::ecs::prelude::*;
use bevy::ecs::world::{EntityRef, EntityWorldMut};
use bevy::render::{ExtractSchedule, RenderApp};

use super::systems::AntumbraExtractSystems;
use super::techniques::{TouchedLights, collect_touched};
use crate::scene::{
    BarnMap, Cookie, LightDistance, LightProfile, LightShape, LightWeights, ShadowOrigin, ShadowSoftness,
    ShadowTint, SurfaceWeights,
};

/// Calls a macro with every component of the light model.
macro_rules! for_parts {
    ($call:ident) => {
        $call!(
            Cookie,
            LightShape,
            BarnMap,
            LightDistance,
            LightProfile,
            LightWeights,
            ShadowTint,
            ShadowOrigin,
            ShadowSoftness
        )
    };
}

/// Registers the components for Bevy's reflection.
pub fn register(app: &mut App) {
    macro_rules! register {
        ($($part:ty),*) => {{ $(app.register_type::<$part>();)* }};
    }
    for_parts!(register);
    app.register_type::<SurfaceWeights>();
}

/// Lists the lights on which a component of the light model was inserted, changed or removed.
pub(super) fn watch(app: &mut App) {
    let render_app = app.sub_app_mut(RenderApp);
    render_app.init_resource::<TouchedLights>();
    macro_rules! watch {
        ($($part:ty),*) => {{ $(render_app.add_systems(
            ExtractSchedule,
            collect_touched::<$part>.in_set(AntumbraExtractSystems::Collect),
        );)* }};
    }
    for_parts!(watch);
}

/// Whether a light has a component of the light model.
pub(super) fn has_model(light: &EntityRef) -> bool {
    macro_rules! has {
        ($($part:ty),*) => { $(light.contains::<$part>())||* };
    }
    for_parts!(has)
}

/// Makes the light model of a mirror's light that of the game's light.
pub(super) fn copy_model(from: &EntityRef, to: &mut EntityWorldMut) {
    macro_rules! copy {
        ($($part:ty),*) => {{ $(copy_part::<$part>(from, to);)* }};
    }
    for_parts!(copy);
}

/// Removes the light model of a mirror's light.
pub(super) fn remove_model(light: &mut EntityWorldMut) {
    macro_rules! remove {
        ($($part:ty),*) => { light.remove::<($($part),*)>() };
    }
    for_parts!(remove);
}

/// Makes a component of a mirror's entity that of the game's.
pub(super) fn copy_part<T: Component<Mutability = Mutable> + Clone + PartialEq>(
    from: &EntityRef,
    to: &mut EntityWorldMut,
) {
    match (from.get::<T>(), to.get::<T>()) {
        (Some(new), old) if old != Some(new) => {
            to.insert(new.clone());
        }
        (None, Some(_)) => {
            to.remove::<T>();
        }
        _ => {}
    }
}

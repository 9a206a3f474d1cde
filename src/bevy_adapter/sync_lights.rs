//! Synchronisation of the mirrors' lights with the game's lights that have a technique or a light model.

use bevy::camera::visibility::{InheritedVisibility, RenderLayers};
use bevy::ecs::prelude::*;
use bevy::light::{DirectionalLight, PointLight, RectLight, SpotLight};
use bevy::render::sync_world::RenderEntity;
use bevy::render::{Extract, MainWorld};
use bevy::transform::components::GlobalTransform;

use super::light_convert::{convert_light, selection};
use super::mirror::{HostLight, Mirror, Mirrors};
use super::report::LightlessTechniques;
use super::sync_models::{copy_model, copy_part, has_model};
use super::techniques::TouchedLights;
use crate::scene::{Light, LightPath, LightSelection};
use crate::techniques::Techniques;

/// Filter of lights that changed in a way that the mirrors must copy.
type LightChanged = (
    Or<(
        With<PointLight>,
        With<SpotLight>,
        With<DirectionalLight>,
        With<RectLight>,
    )>,
    Or<(
        Changed<PointLight>,
        Changed<SpotLight>,
        Changed<DirectionalLight>,
        Changed<RectLight>,
        Changed<RenderLayers>,
        Changed<InheritedVisibility>,
        Changed<LightSelection>,
        Changed<LightPath>,
        Changed<RenderEntity>,
    )>,
);

/// Filter of rectangles that moved: their size depends on their transform's scale.
type RectMoved = (With<RectLight>, Changed<GlobalTransform>);

/// Removed components that force a light to be synchronised again.
#[derive(bevy::ecs::system::SystemParam)]
pub struct RemovedFromLights<'w, 's> {
    point: Extract<'w, 's, RemovedComponents<'static, 'static, PointLight>>,
    spot: Extract<'w, 's, RemovedComponents<'static, 'static, SpotLight>>,
    directional: Extract<'w, 's, RemovedComponents<'static, 'static, DirectionalLight>>,
    rect: Extract<'w, 's, RemovedComponents<'static, 'static, RectLight>>,
    layers: Extract<'w, 's, RemovedComponents<'static, 'static, RenderLayers>>,
    selection: Extract<'w, 's, RemovedComponents<'static, 'static, LightSelection>>,
    path: Extract<'w, 's, RemovedComponents<'static, 'static, LightPath>>,
}

/// Copies lights that appeared, changed, were hidden or lost their technique and their light model to the mirrors.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync). In a steady frame it only
/// reads change ticks.
pub(super) fn sync_lights(
    main: Res<MainWorld>,
    mut mirrors: ResMut<Mirrors>,
    techniques: Res<Techniques>,
    mut touched: ResMut<TouchedLights>,
    mut lightless: ResMut<LightlessTechniques>,
    changed: Extract<Query<Entity, LightChanged>>,
    moved: Extract<Query<Entity, RectMoved>>,
    all: Extract<
        Query<
            Entity,
            Or<(
                With<PointLight>,
                With<SpotLight>,
                With<DirectionalLight>,
                With<RectLight>,
            )>,
        >,
    >,
    mut removed: RemovedFromLights,
) {
    let dirty = &mut touched.lights;
    dirty.extend(changed.iter());
    dirty.extend(moved.iter());
    dirty.extend(removed.point.read());
    dirty.extend(removed.spot.read());
    dirty.extend(removed.directional.read());
    dirty.extend(removed.rect.read());
    dirty.extend(removed.layers.read());
    dirty.extend(removed.selection.read());
    dirty.extend(removed.path.read());
    dirty.sort_unstable();
    dirty.dedup();
    for &entity in &*dirty {
        lightless.look_at(entity, main.get_entity(entity).ok().as_ref(), &techniques);
    }
    for mirror in mirrors.iter_mut() {
        if mirror.fresh {
            for light in &all {
                sync_light(mirror, &main, &techniques, light);
            }
        } else {
            for &light in &*dirty {
                sync_light(mirror, &main, &techniques, light);
            }
        }
    }
    dirty.clear();
}

fn sync_light(mirror: &mut Mirror, main: &World, techniques: &Techniques, entity: Entity) {
    let Ok(light) = main.get_entity(entity) else {
        mirror.despawn(entity);
        return;
    };
    let layers = light.get::<RenderLayers>();
    let shines = (techniques.on(light).next().is_some() || has_model(&light))
        && light
            .get::<InheritedVisibility>()
            .is_none_or(|visibility| visibility.get())
        && mirror.layers.intersects(layers.unwrap_or_default());
    let (true, Some((kind, converted)), Some(render_entity)) =
        (shines, convert_light(&light), light.get::<RenderEntity>())
    else {
        if mirror.remove_light(entity, techniques)
            && let Some(transform) = light.get::<GlobalTransform>()
        {
            mirror.place(entity, transform);
        }
        return;
    };
    let transform = light.get::<GlobalTransform>().copied().unwrap_or_default();
    let mirrored = mirror.get_or_spawn(entity, &transform);
    let mut target = mirror.world.entity_mut(mirrored);
    let selection = selection(layers, light.get::<LightSelection>());
    let host = HostLight {
        render_entity: render_entity.id(),
        kind,
    };
    if target.get::<Light>() != Some(&converted) {
        target.insert(converted);
    }
    if target.get::<LightSelection>() != Some(&selection) {
        target.insert(selection);
    }
    let is_new = target.get::<HostLight>() != Some(&host);
    if is_new {
        target.insert(host);
    }
    for row in techniques.rows() {
        row.copy(&light, &mut target);
    }
    copy_part::<LightPath>(&light, &mut target);
    copy_model(&light, &mut target);
    if is_new {
        mirror.place(entity, &transform);
    }
}

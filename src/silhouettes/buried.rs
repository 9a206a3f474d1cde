//! Shadow origins that lie inside of a caster, so that everything outside of it is in shadow.

use bevy_ecs::prelude::*;
use glam::DVec3;

use super::caster_shape::{CasterShape, CasterShapeItem};
use crate::geometry::winding_number;
use crate::scene::ShadowOrigin;
use crate::sets::{FrameLight, FrameLights, Objects};

/// Lights whose shadows are cast from inside of a caster. Written by `find_buried_origins`.
#[derive(Resource, Clone, Debug, Default)]
pub struct BuriedOrigins {
    /// Each light and a caster around the origin of its shadows, in the order of the lights.
    pub found: Vec<(Entity, Entity)>,
    checked: Vec<Checked>,
    previous: Vec<Checked>,
}

/// A caster whose bounds hold the shadow origin of a light.
#[derive(Clone, Copy, Debug)]
struct Checked {
    light: Entity,
    caster: Entity,
    is_around: bool,
}

/// Finds the lights whose moved shadows ([`ShadowOrigin`]) are cast from inside of a caster.
///
/// A caster that holds the light itself is no mistake: it is a room or a shade. Neither is one that is open there.
///
/// Set: `BuildSilhouettes`, after `update_posed_planes`. Reads [`FrameLights`], [`Objects`]; writes [`BuriedOrigins`].
/// Cost: linear in the triangles of casters whose bounds hold an origin, when the light or the caster moved.
pub fn find_buried_origins(
    mut buried: ResMut<BuriedOrigins>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    casters: Query<CasterShape>,
) {
    let buried = &mut *buried;
    std::mem::swap(&mut buried.checked, &mut buried.previous);
    buried.checked.clear();
    buried.found.clear();
    for light in &lights.lights {
        let Some(ShadowOrigin::Position(origin)) = light.model.origin.filter(|_| light.technique.is_some())
        else {
            continue;
        };
        let mut around = None;
        for object in light.sets.reach.intersection(&objects.casters) {
            if !light.casts(&objects, object) || !objects.boxes.get(object).contains(origin) {
                continue;
            }
            let caster = objects.entities[object];
            let stands = !light.moved && !objects.moved.contains(object);
            let known = buried
                .previous
                .iter()
                .find(|checked| checked.light == light.entity && checked.caster == caster);
            let is_around = match known.filter(|_| stands) {
                Some(known) => known.is_around,
                None => casters
                    .get(caster)
                    .is_ok_and(|shape| is_around_origin(&shape, light, origin.as_dvec3())),
            };
            buried.checked.push(Checked {
                light: light.entity,
                caster,
                is_around,
            });
            if is_around {
                around = around.or(Some(caster));
            }
        }
        buried.found.extend(around.map(|caster| (light.entity, caster)));
    }
}

/// Whether the caster encloses the origin of the shadows but not the light.
fn is_around_origin(shape: &CasterShapeItem, light: &FrameLight, origin: DVec3) -> bool {
    let Some(local_from_world) = shape.world_from_local().map(|matrix| matrix.inverse()) else {
        return false;
    };
    let encloses = |point_world: DVec3| {
        let point = local_from_world.transform_point3(point_world);
        winding_number(shape.positions(), shape.edges.0.edges.corners(), point).abs() > 0.5
    };
    encloses(origin) && !encloses(light.shining.emitter.point.truncate())
}

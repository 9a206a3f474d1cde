//! Lines of objects: their sets, and their silhouettes.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::DebugLines;
use crate::sets::{FrameLight, FrustumSet, Objects, VisibleSet};
use crate::silhouettes::{CasterShape, Silhouettes};

const CASTING: [u8; 3] = [240, 90, 80];
const LIT: [u8; 3] = [250, 210, 90];
const REACHED: [u8; 3] = [90, 150, 250];
const VISIBLE: [u8; 3] = [220, 220, 220];
const IN_FRUSTUM: [u8; 3] = [90, 90, 90];
const SILHOUETTE: [u8; 3] = [110, 230, 160];

/// Adds the boxes of all objects that are in a set of the light or of the view.
pub fn sets(world: &World, light: Option<&FrameLight>, out: &mut DebugLines) {
    let (Some(objects), Some(frustum), Some(visible)) = (
        world.get_resource::<Objects>(),
        world.get_resource::<FrustumSet>(),
        world.get_resource::<VisibleSet>(),
    ) else {
        return;
    };
    for index in objects.present.ones() {
        let color = match light.map(|light| &light.sets) {
            Some(sets) if sets.s.contains(index) => CASTING,
            Some(sets) if sets.i.contains(index) => LIT,
            Some(sets) if sets.l.contains(index) => REACHED,
            _ if visible.set.contains(index) => VISIBLE,
            _ if frustum.set.contains(index) => IN_FRUSTUM,
            _ => continue,
        };
        out.aabb(color, &objects.boxes.get(index));
    }
}

/// Adds the silhouette edges of the casters of a light.
pub fn silhouettes(world: &World, light: &FrameLight, out: &mut DebugLines) {
    for_each_edge(world, light, |[a, b]| out.line(SILHOUETTE, a, b));
}

/// Calls a function with both ends of each silhouette edge of a light, world space, metres. Edges of casters whose
/// transform leaves them out are skipped.
pub fn for_each_edge(world: &World, light: &FrameLight, mut edge: impl FnMut([Vec3; 2])) {
    let known = world
        .get_resource::<Silhouettes>()
        .and_then(|silhouettes| silhouettes.of_light(light.entity));
    let (Some(known), Some(mut shapes)) = (known, world.try_query::<CasterShape>()) else {
        return;
    };
    for silhouette in known.slots.iter().filter(|slot| slot.revision != 0) {
        let Ok(shape) = shapes.get(world, silhouette.entity) else {
            continue;
        };
        let Some(world_from_local) = shape.world_from_local() else {
            continue;
        };
        let positions = shape.positions();
        let place = |vertex: u32| {
            let local = positions.get(vertex as usize)?.as_dvec3();
            Some(world_from_local.transform_point3(local).as_vec3())
        };
        for [a, b] in silhouette.contour.all_edges() {
            if let (Some(a), Some(b)) = (place(a), place(b)) {
                edge([a, b]);
            }
        }
    }
}

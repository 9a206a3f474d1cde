//! Lines of cells and portals.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{BVec3, Vec3};

use super::DebugLines;
use crate::scene::{Cell, Portal};

const CELL: [u8; 3] = [150, 150, 160];
const OPEN: [u8; 3] = [90, 220, 110];
const CLOSED: [u8; 3] = [220, 80, 80];

/// Adds the boxes of cells and the outlines of portals.
pub fn cells(world: &World, out: &mut DebugLines) {
    if let Some(mut cells) = world.try_query::<(&Cell, &GlobalTransform)>() {
        for (cell, place) in cells.iter(world) {
            let corner = |bits: usize| {
                let upper = BVec3::new(bits & 1 != 0, bits & 2 != 0, bits & 4 != 0);
                place.transform_point(Vec3::select(upper, cell.half_size, -cell.half_size))
            };
            out.hexahedron(CELL, std::array::from_fn(corner));
        }
    }
    if let Some(mut portals) = world.try_query::<(&Portal, &GlobalTransform)>() {
        for (portal, place) in portals.iter(world) {
            let color = if portal.open { OPEN } else { CLOSED };
            let corners: Vec<Vec3> = portal
                .outline
                .iter()
                .map(|&corner| place.transform_point(corner))
                .collect();
            out.polygon(color, &corners);
        }
    }
}

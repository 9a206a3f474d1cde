//! Rooms and the openings between them.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;
use smallvec::SmallVec;

/// A room: a box in local space whose inside can be seen from elsewhere only through [`Portal`]s. The user
/// promises that its walls exist, are opaque and have no other openings.
///
/// An object that touches the box is in the cell; an object that touches several boxes is in all of those
/// cells. [`InCells`] overrides this. Objects in no cell are visible from everywhere, and a camera or light
/// that stands in no cell sees everything. Cells may overlap: a viewer who stands in several looks out of
/// each. While the box of a cell is empty, sheared or not finite, no cell hides anything, and the cell is
/// reported ([`Cells::issues`](crate::sets::Cells)).
///
/// The [`SelectionLayers`](super::SelectionLayers) of a cell are those of its walls. A light for which the
/// walls do not cast sees through them.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform)]
#[require(super::SelectionLayers)]
pub struct Cell {
    /// Half of the box's size along the local axes, metres; each greater than 0.
    pub half_size: Vec3,
}

/// The cells that an object is in, regardless of the cells that it touches. Entities that are no cells are
/// ignored; if none is left, the object is in no cell.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct InCells(pub SmallVec<[Entity; 2]>);

/// An opening between two cells, visible through from both sides.
///
/// An outline that is not flat or not convex counts as its convex hull. An outline without three finite
/// corners hides nothing. If a portal joins an entity that is no cell, a viewer who sees the portal sees
/// everything. All three are reported ([`Cells::issues`](crate::sets::Cells)).
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
pub struct Portal {
    /// The two cells that the portal connects.
    pub joins: [Entity; 2],
    /// Whether the portal can be seen through. A closed door is not open.
    pub open: bool,
    /// Corners of a flat convex polygon in local space, metres, in any order.
    pub outline: SmallVec<[Vec3; 4]>,
}

impl Portal {
    /// An open rectangle with the given half sizes, metres, in the local XY plane.
    pub fn rectangle(joins: [Entity; 2], half_width: f32, half_height: f32) -> Self {
        let corner = |x: f32, y: f32| Vec3::new(x * half_width, y * half_height, 0.0);
        Self {
            joins,
            open: true,
            outline: SmallVec::from_buf([
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ]),
        }
    }
}

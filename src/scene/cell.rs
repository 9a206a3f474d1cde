//! Rooms and the openings between them.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;
use smallvec::SmallVec;

/// A room: a box in its local space, of which the inside is seen from elsewhere through [`Portal`]s alone. That its
/// walls are there, opaque and whole, is a promise.
///
/// Objects that touch the box are in the cell; those in several cells, in all of them; [`InCells`] says otherwise. Objects
/// in no cell are seen from everywhere, and a camera or light that stands in no cell sees everything. Cells may overlap:
/// who stands in several looks out of each. While a cell's box is empty, sheared or not finite, no cell hides
/// anything, and it is reported ([`Cells::issues`](crate::sets::Cells)).
///
/// Its [`SelectionLayers`](super::SelectionLayers) are those of its walls: lights for which they do not cast see through.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform)]
#[require(super::SelectionLayers)]
pub struct Cell {
    /// Half of the box's size along the local axes, metres; > 0.
    pub half_size: Vec3,
}

/// The cells that an object is in, whatever it touches. Entities that are no cells count for nothing; with none left the
/// object is in no cell.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct InCells(pub SmallVec<[Entity; 2]>);

/// An opening between two cells. It is seen through both ways.
///
/// An outline that is not flat or not convex counts as its convex hull, one without three finite corners lets all through,
/// and who sees a portal that joins something which is no cell sees everything; all three are reported
/// ([`Cells::issues`](crate::sets::Cells)).
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
pub struct Portal {
    /// The two cells.
    pub joins: [Entity; 2],
    /// Seen through; a closed door is not.
    pub open: bool,
    /// Corners of a flat convex polygon in local space, in any order.
    pub outline: SmallVec<[Vec3; 4]>,
}

impl Portal {
    /// An open rectangle of these half sizes in the local XY plane.
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

//! Collects cells, portals, and the cells of each object.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use bevy_transform::prelude::GlobalTransform;
use fixedbitset::FixedBitSet;
use glam::{DVec3, Mat4};
use smallvec::SmallVec;

use crate::geometry::Aabb;
use crate::geometry::convex_polygon::CommonPlane;
use crate::scene::{Cell, InCells, Portal, SelectionLayers};
use crate::sets::index::objects::{Objects, resize};

/// Cells and portals of the world, in world space. Written by [`collect_cells`].
#[derive(Resource, Clone, Debug, Default)]
pub struct Cells {
    /// Faults of cells and portals, in ascending order of their entities.
    pub issues: Vec<(Entity, CellIssue)>,
    /// Increases when a cell, a portal or a list of cells changed.
    pub generation: u64,
    pub(super) cells: Vec<CellBox>,
    pub(super) portals: Vec<Opening>,
    /// For each cell, the objects in it.
    pub(super) members: Vec<FixedBitSet>,
    /// Objects that are in no cell.
    pub(super) loose: FixedBitSet,
    layout: u64,
    counts: [usize; 4],
}

/// What is wrong with a cell or a portal, and how it is treated instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CellIssue {
    /// The box of a cell is empty, sheared or not finite. As long as one cell has this fault, no cell hides
    /// anything.
    #[error("the cell's box is empty, sheared or not finite; no cell hides anything")]
    Volume,
    /// The outline of a portal is not flat. Its convex hull is used.
    #[error("the portal's outline is not flat; its convex hull counts")]
    NotFlat,
    /// The outline of a portal is not convex. Its convex hull is used.
    #[error("the portal's outline is not convex; its convex hull counts")]
    NotConvex,
    /// The outline of a portal has no area or is not finite. The portal hides nothing.
    #[error("the portal's outline has no area or is not finite; it lets all through")]
    Outline,
    /// A portal joins an entity that is no cell. A viewer who sees the portal sees everything.
    #[error("the portal joins something that is no cell; who sees it sees everything")]
    Dangling,
}

/// The box of a cell in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellBox {
    pub entity: Entity,
    center: DVec3,
    /// Unit axes of the box, each with the half size along it.
    axes: [(DVec3, f64); 3],
    bounds: Aabb,
    pub layers: u32,
    usable: bool,
}

/// A portal in world space.
#[derive(Clone, Debug)]
pub(super) struct Opening {
    pub joins: [Option<u32>; 2],
    pub open: bool,
    /// Points of the outline. If it is empty, the portal hides nothing.
    pub points: SmallVec<[DVec3; 8]>,
    /// Unit normal of the outline, if it is flat.
    pub normal: Option<DVec3>,
}

impl Opening {
    /// Whether the portal leads out of a cell. A portal that joins an entity which is no cell leads out of
    /// every cell that it touches, because the intended cell is among those.
    pub(super) fn leads_out_of(&self, cells: &Cells, cell: u32) -> bool {
        let dangles = self.joins.contains(&None);
        let bounds = || Aabb::from_points(self.points.iter().map(|point| point.as_vec3())).padded();
        self.joins.contains(&Some(cell))
            || dangles && (self.points.is_empty() || cells.cells[cell as usize].touches(&bounds()))
    }
}

impl CellBox {
    fn new(entity: Entity, cell: &Cell, transform: &GlobalTransform, layers: u32) -> Self {
        let affine = transform.affine();
        let axis = |axis: glam::Vec3A, half: f32| {
            let axis = glam::Vec3::from(axis).as_dvec3();
            let length = axis.length();
            (axis / length, f64::from(half) * length)
        };
        let axes = [
            axis(affine.matrix3.x_axis, cell.half_size.x),
            axis(affine.matrix3.y_axis, cell.half_size.y),
            axis(affine.matrix3.z_axis, cell.half_size.z),
        ];
        let half = Aabb {
            min: -cell.half_size,
            max: cell.half_size,
        };
        let sound = |&(axis, half): &(DVec3, f64)| axis.is_finite() && half.is_finite() && half > 0.0;
        // The axes of a sheared box are not its normals.
        let upright = |a: usize, b: usize| axes[a].0.dot(axes[b].0).abs() < 1e-4;
        Self {
            entity,
            center: affine.translation.as_dvec3(),
            axes,
            bounds: half.transformed(&affine).padded(),
            layers,
            usable: affine.is_finite()
                && axes.iter().all(sound)
                && upright(0, 1)
                && upright(1, 2)
                && upright(2, 0),
        }
    }

    /// Whether a box may touch the cell. May be true for a box that passes by an edge.
    pub(super) fn touches(&self, aabb: &Aabb) -> bool {
        if !self.usable || aabb.is_empty() || !self.bounds.intersects(aabb) {
            return false;
        }
        let (center, half) = (
            aabb.center().as_dvec3() - self.center,
            aabb.half_size().as_dvec3(),
        );
        self.axes
            .iter()
            .all(|(axis, size)| axis.dot(center).abs() <= size * (1.0 + 1e-6) + 1e-6 + axis.abs().dot(half))
    }

    /// Whether a point is in the cell.
    pub(super) fn contains(&self, point: DVec3) -> bool {
        self.usable
            && self
                .axes
                .iter()
                .all(|(axis, size)| axis.dot(point - self.center).abs() <= *size)
    }
}

impl Opening {
    fn new(portal: &Portal, transform: &GlobalTransform) -> (Self, Option<CellIssue>) {
        let world_from_local = Mat4::from(transform.affine()).as_dmat4();
        let points: SmallVec<[DVec3; 8]> = portal
            .outline
            .iter()
            .map(|point| world_from_local.transform_point3(point.as_dvec3()))
            .collect();
        let mut opening = Self {
            joins: [None; 2],
            open: portal.open,
            points,
            normal: None,
        };
        let Some(plane) = CommonPlane::of(&opening.points) else {
            opening.points.clear();
            return (opening, Some(CellIssue::Outline));
        };
        if !plane.holds(&opening.points) {
            return (opening, Some(CellIssue::NotFlat));
        }
        let is_convex = is_convex(&opening.points, plane.middle, plane.normal);
        opening.normal = Some(plane.normal);
        (opening, (!is_convex).then_some(CellIssue::NotConvex))
    }
}

/// Whether every point is a corner of the convex hull of all points, or on its border.
fn is_convex(points: &[DVec3], middle: DVec3, normal: DVec3) -> bool {
    let (right, up) = normal.any_orthonormal_pair();
    let mut around: SmallVec<[(f64, DVec3); 8]> = points
        .iter()
        .map(|point| {
            let from = *point - middle;
            (up.dot(from).atan2(right.dot(from)), from)
        })
        .collect();
    around.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = around.len();
    (0..count).all(|i| {
        let [a, b, c] = [0, 1, 2].map(|step| around[(i + step) % count].1);
        (b - a).cross(c - b).dot(normal) >= -1e-6 * (b - a).length() * (c - b).length()
    })
}

/// The components that [`collect_cells`] reads.
#[derive(SystemParam)]
pub struct CellParts<'w, 's> {
    cells: Query<
        'w,
        's,
        (
            Entity,
            &'static Cell,
            &'static GlobalTransform,
            Option<&'static SelectionLayers>,
        ),
    >,
    portals: Query<'w, 's, (Entity, &'static Portal, &'static GlobalTransform)>,
    lists: Query<'w, 's, &'static InCells>,
    layered: Query<'w, 's, (), (With<Cell>, With<SelectionLayers>)>,
    changed: Query<
        'w,
        's,
        (),
        Or<(
            Changed<Cell>,
            Changed<Portal>,
            Changed<InCells>,
            (Or<(With<Cell>, With<Portal>)>, Changed<GlobalTransform>),
            (With<Cell>, Changed<SelectionLayers>),
        )>,
    >,
}

/// Brings [`Cells`] up to date: everything if a cell, portal or list changed or objects came or went,
/// otherwise the objects that moved.
///
/// Set: `CollectSets`, after `collect_objects`. Cost: O(objects × cells) when something changed. At rest it
/// only counts.
pub fn collect_cells(mut cells: ResMut<Cells>, objects: Res<Objects>, parts: CellParts) {
    let counts = [
        parts.cells.iter().len(),
        parts.portals.iter().len(),
        parts.lists.iter().len(),
        parts.layered.iter().len(),
    ];
    if counts == [0; 4] && cells.counts == counts {
        return; // a world without cells
    }
    let cells = &mut *cells;
    if counts != cells.counts || !parts.changed.is_empty() {
        cells.counts = counts;
        cells.rebuild(&parts);
    } else if cells.layout == objects.layout_generation {
        for object in objects.moved.ones() {
            cells.place(object, &objects, &parts.lists);
        }
        return;
    }
    cells.layout = objects.layout_generation;
    cells.members.resize_with(cells.cells.len(), FixedBitSet::new);
    for members in &mut cells.members {
        resize(members, objects.len());
    }
    resize(&mut cells.loose, objects.len());
    for object in 0..objects.len() {
        cells.place(object, &objects, &parts.lists);
    }
}

impl Cells {
    /// Whether there are no cells. Cells then hide nothing.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Whether all cells have a usable box. A viewer who stands in a cell without one could not be located.
    pub fn are_sound(&self) -> bool {
        self.cells.iter().all(|cell| cell.usable)
    }

    /// Whether the walls of all cells cast for a light with this mask.
    pub fn cast_for(&self, casts_for: u32) -> bool {
        self.cells.iter().all(|cell| cell.layers & casts_for != 0)
    }

    fn rebuild(&mut self, parts: &CellParts) {
        self.generation += 1;
        self.issues.clear();
        self.cells.clear();
        self.cells
            .extend(parts.cells.iter().map(|(entity, cell, transform, layers)| {
                CellBox::new(entity, cell, transform, layers.copied().unwrap_or_default().0)
            }));
        self.cells.sort_unstable_by_key(|cell| cell.entity);
        for cell in self.cells.iter().filter(|cell| !cell.usable) {
            self.issues.push((cell.entity, CellIssue::Volume));
        }
        let mut portals: Vec<_> = parts.portals.iter().collect();
        portals.sort_unstable_by_key(|(entity, ..)| *entity);
        self.portals.clear();
        for (entity, portal, transform) in portals {
            let (mut opening, issue) = Opening::new(portal, transform);
            opening.joins = portal.joins.map(|cell| self.index_of(cell));
            self.issues.extend(issue.map(|issue| (entity, issue)));
            if opening.joins.contains(&None) {
                self.issues.push((entity, CellIssue::Dangling));
            }
            self.portals.push(opening);
        }
        self.issues.sort_by_key(|(entity, _)| *entity);
    }

    /// Index of a cell that has a usable box.
    fn index_of(&self, entity: Entity) -> Option<u32> {
        let at = self
            .cells
            .binary_search_by_key(&entity, |cell| cell.entity)
            .ok()?;
        self.cells[at].usable.then_some(at as u32)
    }

    fn place(&mut self, object: usize, objects: &Objects, lists: &Query<&InCells>) {
        let mut loose = true;
        let list = lists.get(objects.entities[object]).ok();
        let bounds = objects.boxes.get(object);
        for (cell, members) in self.cells.iter().zip(&mut self.members) {
            let inside = match list {
                Some(list) => cell.usable && list.0.contains(&cell.entity),
                None => cell.touches(&bounds),
            };
            members.set(object, inside);
            loose &= !inside;
        }
        self.loose.set(object, loose);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_that_loses_its_layers_is_collected_again() {
        let mut world = World::new();
        world.init_resource::<Cells>();
        world.init_resource::<Objects>();
        let mut schedule = Schedule::default();
        schedule.add_systems(collect_cells);
        let half_size = glam::Vec3::ONE;
        let cell = world.spawn((Cell { half_size }, SelectionLayers(2))).id();
        schedule.run(&mut world);
        assert!(!world.resource::<Cells>().cast_for(1));
        world.entity_mut(cell).remove::<SelectionLayers>();
        schedule.run(&mut world);
        assert!(world.resource::<Cells>().cast_for(1), "it is on layer 0 again");
    }
}

//! What one viewpoint, the camera or a light, knows to be hidden.

use fixedbitset::FixedBitSet;
use glam::DVec3;

use super::depth_buffer::DepthBuffer;
use super::occluders::Occluders;
use super::projection::Projection;
use super::raster::{Rasterizer, Sides};
use super::settings::OcclusionSettings;
use crate::geometry::Aabb;
use crate::sets::index::objects::Objects;

/// The depth buffers of a viewpoint, and the occluders in them.
#[derive(Clone, Debug, Default)]
pub struct Viewpoint {
    buffers: Vec<DepthBuffer>,
    /// Number of buffers in use.
    count: usize,
    /// Occluders that were drawn.
    pub drawn: FixedBitSet,
    order: Vec<(u64, u32)>,
}

/// Which sides of an occluder count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::sets) enum Blocks {
    /// The sides that are drawn.
    Sight,
    /// The sides that cast shadows.
    Light,
}

impl Viewpoint {
    /// The buffers in use.
    pub fn buffers(&self) -> &[DepthBuffer] {
        &self.buffers[..self.count]
    }

    /// Discards all buffers, so that nothing is hidden.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Draws the candidates into the buffers until the budget is used up. Candidates that cover most for each
    /// of their triangles come first.
    pub(in crate::sets) fn draw(
        &mut self,
        rasterizer: &mut Rasterizer,
        projections: &[Projection],
        candidates: impl Iterator<Item = usize>,
        objects: &Objects,
        occluders: &Occluders,
        settings: &OcclusionSettings,
        blocks: Blocks,
    ) {
        self.count = projections.len();
        for (at, projection) in projections.iter().enumerate() {
            match self.buffers.get_mut(at) {
                Some(buffer) => buffer.reset(*projection),
                None => self.buffers.push(DepthBuffer::new(*projection)),
            }
        }
        if self.drawn.len() != objects.len() {
            self.drawn = FixedBitSet::with_capacity(objects.len());
        }
        self.drawn.clear();
        self.order.clear();
        for object in candidates {
            let (center, half) = objects.boxes.center_half(object);
            let area: f64 = projections
                .iter()
                .filter_map(|projection| Some(projection.image_of_box(center, half)?.area(projection)))
                .sum();
            let worth = area / occluders.triangle_count(object).max(1) as f64;
            // The bits of numbers that are not negative sort like the numbers.
            self.order.push((!worth.max(0.0).to_bits(), object as u32));
        }
        self.order.sort_unstable();
        let mut budget = settings.triangle_budget;
        for &(_, object) in &self.order {
            let object = object as usize;
            let Some((mesh, world_from_local, drawn_sides)) = occluders.get(object) else {
                continue;
            };
            let Some(rest) = budget.checked_sub(mesh.triangles.len()) else {
                continue;
            };
            budget = rest;
            self.drawn.insert(object);
            let sides = match blocks {
                Blocks::Sight => drawn_sides,
                Blocks::Light => Sides::CAST,
            };
            for buffer in &mut self.buffers[..self.count] {
                rasterizer.draw(buffer, mesh, world_from_local, sides);
            }
        }
        for buffer in &mut self.buffers[..self.count] {
            buffer.finish();
        }
    }

    /// The box around the part of an object that the first picture may show. It is empty if no part may be
    /// visible.
    pub fn visible_part(&self, objects: &Objects, object: usize) -> Aabb {
        let (center, half) = objects.boxes.center_half(object);
        match self.buffers().first() {
            Some(buffer) => buffer.visible_part(center, half),
            None => objects.boxes.get(object),
        }
    }

    /// Whether no picture shows anything of a box.
    pub fn hides_box(&self, center: DVec3, half: DVec3) -> bool {
        self.count > 0 && self.buffers().iter().all(|buffer| buffer.hides(center, half))
    }

    /// Whether no picture shows anything of an object's bounds.
    pub fn hides(&self, objects: &Objects, object: usize) -> bool {
        let (center, half) = objects.boxes.center_half(object);
        self.hides_box(center, half)
    }
}

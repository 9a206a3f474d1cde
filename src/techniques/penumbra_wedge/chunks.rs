//! The wedges of one caster in one part of a light, kept until light or caster moves.

use std::ops::Range;

use bevy_ecs::prelude::*;
use glam::{Mat4, Vec3, Vec4};

use super::component::{WedgeBounds, WedgeSilhouette};
use super::geometry::cut::{
    ENOUGH_CUTS, MOST_CUTS, can_be_cut, cut_record, cutting_distance, find_cuts, tolerance_extent,
};
use super::geometry::cut_patches::{CutLimits, CutSurface};
use super::geometry::patches::ShadowCone;
use super::geometry::records::{Wedge, push_edge, side_plane};
use super::geometry::silhouette_layers::{Facets, LayeredContour, extract_layers};
use super::light_parts::PartShape;
use super::seen_caster::{SeenCaster, extent_local};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::silhouettes::grazed::is_grazed;
use crate::silhouettes::{CapMode, FacingBits, GrazingLight, classify, find_grazed, find_turning};

/// Everything that a chunk depends on; a chunk whose key changed is rebuilt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ChunkKey {
    pub(super) revision: u64,
    pub(super) light_from_local: Mat4,
    pub(super) shape: PartShape,
    pub(super) bounds: WedgeBounds,
    /// Whether the chunk is divided into patches.
    pub(super) by_patch: bool,
    pub(super) silhouette: WedgeSilhouette,
    /// Metres from a point of light within which surfaces do not block it; `None` if the caster is so far away that it
    /// neither touches nor cuts the part.
    pub(super) touches: Option<f64>,
}

/// Buffers that are reused for every chunk.
#[derive(Debug, Default)]
pub(super) struct ChunkScratch {
    bits: FacingBits,
    turning: Vec<u64>,
    grazed: Vec<u64>,
    cuts: CutSurface,
    level: Vec<u64>,
    contour: LayeredContour,
}

/// The unit of a chunk that is combined with other shadows: one patch or, without patches, the whole chunk.
#[derive(Clone, Debug)]
pub(super) struct ChunkPatch {
    pub(super) wedges: Range<usize>,
    /// Ranges of the caps, by layers less 1. Those that must be turned come after those that need not.
    pub(super) caps: [Range<usize>; 6],
    pub(super) cone: ShadowCone,
}

/// The wedges of one caster in one part.
#[derive(Debug)]
pub(super) struct Chunk {
    pub(super) entity: Entity,
    pub(super) part: u32,
    pub(super) key: ChunkKey,
    pub(super) light_local: [f32; 4],
    pub(super) wedges: Vec<Wedge>,
    pub(super) caps: Vec<u32>,
    pub(super) patches: Vec<ChunkPatch>,
    /// Whether the two [layers](super::geometry::silhouette_layers) differ.
    pub(super) is_layered: bool,
    /// Whether the caster [cuts](super::geometry::cut) the part.
    pub(super) is_cutting: bool,
    /// Number of polygons that cut the part but are left out.
    pub(super) cuts_left_out: u32,
    pub(super) last_used: u64,
}

#[derive(Debug)]
pub(super) struct LightChunks {
    pub(super) light: Entity,
    /// Ascending by entity and part.
    pub(super) chunks: Vec<Chunk>,
    pub(super) last_used: u64,
}

/// Returns the chunks of a light and marks them as used in this frame.
pub(super) fn chunks_of(kept: &mut Vec<LightChunks>, light: Entity, frame: u64) -> &mut Vec<Chunk> {
    let at = kept
        .binary_search_by_key(&light, |entry| entry.light)
        .unwrap_or_else(|at| {
            kept.insert(
                at,
                LightChunks {
                    light,
                    chunks: Vec::new(),
                    last_used: frame,
                },
            );
            at
        });
    kept[at].last_used = frame;
    &mut kept[at].chunks
}

impl Chunk {
    pub(super) fn empty(entity: Entity, part: u32, key: ChunkKey) -> Self {
        Self {
            entity,
            part,
            key,
            light_local: [0.0; 4],
            wedges: Vec::new(),
            caps: Vec::new(),
            patches: Vec::new(),
            is_layered: false,
            is_cutting: false,
            cuts_left_out: 0,
            last_used: 0,
        }
    }

    /// Rebuilds edges and caps for a `seen` caster; without one the chunk is left empty.
    pub(super) fn build(
        &mut self,
        seen: Option<&SeenCaster<'_, '_, '_>>,
        mode: CapMode,
        scratch: &mut ChunkScratch,
    ) {
        self.wedges.clear();
        self.caps.clear();
        self.patches.clear();
        let Some(seen) = seen else {
            return;
        };
        self.light_local = seen.light_local.to_array();
        classify(
            &seen.caster.edges.0.edges,
            seen.caster.planes(),
            seen.light_local,
            &mut scratch.bits,
        );
        self.find_turning_triangles(seen, scratch);
        self.find_cutting_triangles(seen, scratch);
        // Points of a light that is cut may be within the caster, where only fronts hide them.
        let mode = if self.is_cutting {
            CapMode::AllTriangles
        } else {
            mode
        };
        self.extract_contour(seen, mode, scratch);
        self.push_patches(seen, scratch);
        self.push_cuts(seen, scratch);
    }

    /// Marks the triangles that some points of the light see from the front and others from behind.
    fn find_turning_triangles(&self, seen: &SeenCaster<'_, '_, '_>, scratch: &mut ChunkScratch) {
        scratch.turning.clear();
        if self.key.silhouette == WedgeSilhouette::Receiver
            && !seen.is_directional()
            && let Some(extent) = extent_local(seen.part.shape, &seen.local_from_light)
        {
            let center_local = seen.light_local.truncate();
            let (edges, planes) = (&seen.caster.edges.0.edges, seen.caster.planes());
            find_turning(edges, planes, center_local, &extent, &mut scratch.turning);
        }
    }

    /// Marks the triangles that block nothing since they touch the light, and collects those that cut it.
    fn find_cutting_triangles(&mut self, seen: &SeenCaster<'_, '_, '_>, scratch: &mut ChunkScratch) {
        let ChunkScratch {
            turning,
            grazed,
            cuts,
            level,
            ..
        } = scratch;
        (self.is_cutting, self.cuts_left_out) = (false, 0);
        grazed.clear();
        level.clear();
        cuts.clear();
        let Some(clearance) = self.key.touches else {
            return;
        };
        let shape = seen.part.shape;
        let (edges, positions) = (&seen.caster.edges.0.edges, seen.caster.positions());
        let grazing = GrazingLight {
            light_world: seen.part.point_world,
            light_local: seen.light_local,
            world_from_local: seen.world_from_local,
            clearance: cutting_distance(shape, clearance),
        };
        find_grazed(edges, seen.caster.planes(), positions, &grazing, grazed);
        if can_be_cut(shape, clearance) {
            let part = (shape, clearance);
            find_cuts(
                edges,
                positions,
                &seen.light_from_local,
                part,
                grazed,
                &mut cuts.triangles,
            );
            self.is_cutting = !cuts.triangles.is_empty();
        }
        if self.is_cutting {
            // Patches that are combined by themselves have no edges that turn.
            let may_be_level = !self.key.by_patch;
            self.cuts_left_out = cuts.simplify(CutLimits {
                extent: tolerance_extent(shape),
                reach: if may_be_level {
                    grazing.clearance * 1.001 // whatever rounding did to distances
                } else {
                    f64::INFINITY
                },
                enough: ENOUGH_CUTS,
                most: MOST_CUTS,
            });
            for slot in cuts.level_slots() {
                level.resize(grazed.len(), 0);
                level[slot / CLUSTER_TRIANGLES] |= 1 << (slot % CLUSTER_TRIANGLES);
            }
        }
        // A triangle that blocks nothing, or cuts, has no edge that turns.
        for (turning, grazed) in turning.iter_mut().zip(grazed.iter()) {
            *turning &= !grazed;
        }
    }

    /// Extracts the edges and caps of both layers into the contour, by patch if the chunk is divided into patches.
    fn extract_contour(&mut self, seen: &SeenCaster<'_, '_, '_>, mode: CapMode, scratch: &mut ChunkScratch) {
        let ChunkScratch {
            bits,
            turning,
            grazed,
            level,
            contour,
            ..
        } = scratch;
        let facets = Facets {
            facing: bits,
            turning,
            grazed,
            level,
        };
        let (edges, positions) = (&seen.caster.edges.0.edges, seen.caster.positions());
        let by_patch = self.key.by_patch;
        extract_layers(edges, positions, facets, mode, by_patch, contour);
        self.is_layered = self.is_cutting || !(contour.caps[0].is_empty() && contour.caps[1].is_empty());
        if by_patch {
            // The sort is stable, so within a patch the order stays that of the mesh.
            contour.edges.sort_by_key(|edge| edge.patch);
            for caps in &mut contour.caps {
                caps.sort_by_key(|cap| cap.patch);
            }
        }
    }

    /// Appends the records of the polygons that cut the light, as a patch of their own.
    fn push_cuts(&mut self, seen: &SeenCaster<'_, '_, '_>, scratch: &ChunkScratch) {
        let ChunkScratch { bits, cuts, .. } = scratch;
        let Some(clearance) = self.key.touches.filter(|_| !cuts.polygons.is_empty()) else {
            return;
        };
        let first = self.wedges.len();
        self.wedges.extend(cuts.polygons.iter().map(|polygon| {
            let patch = &cuts.patches[polygon.patch as usize];
            let front = Vec4::from(seen.plane_light(patch.slot, bits)).truncate();
            cut_record(polygon, patch, front, clearance)
        }));
        let end = self.caps.len();
        self.patches.push(ChunkPatch {
            wedges: first..self.wedges.len(),
            caps: std::array::from_fn(|_| end..end),
            cone: ShadowCone::ALL,
        });
    }

    /// Appends wedges, caps and patches of the contour.
    fn push_patches(&mut self, seen: &SeenCaster<'_, '_, '_>, scratch: &ChunkScratch) {
        let ChunkScratch {
            bits, level, contour, ..
        } = scratch;
        let (by_patch, mirrored) = (self.key.by_patch, seen.light_from_local.determinant() < 0.0);
        let shape = if seen.is_directional() {
            PartShape::Point
        } else {
            seen.part.shape
        };
        // The plane of a level triangle contains the centre exactly, by which the shader knows it.
        let plane_light = |slot: u32| match (seen.plane_light(slot, bits), is_grazed(level, slot as usize)) {
            ([x, y, z, _], true) => [x, y, z, 0.0],
            (plane, false) => plane,
        };
        let mut edges = contour.edges.iter().peekable();
        let mut first_of = [0; 3];
        for patch in 0..if by_patch { contour.patches.count() } else { 1 } {
            let first_wedge = self.wedges.len();
            while let Some(edge) = edges.next_if(|edge| edge.patch == patch) {
                let [a, b] = edge.ends;
                push_edge(
                    edge,
                    if mirrored { [b, a] } else { [a, b] },
                    edge.sides.map(|side| side_plane(side, plane_light)),
                    &seen.light_from_local,
                    shape,
                    self.key.bounds,
                    &mut self.wedges,
                );
            }
            let caps_of = |layers: usize| {
                let rest = &contour.caps[layers][first_of[layers]..];
                &rest[..rest.partition_point(|cap| cap.patch <= patch)]
            };
            let cap_ranges = std::array::from_fn(|at| {
                let (layers, is_turned) = (at % 3, at >= 3);
                let first = self.caps.len();
                // In a caster that mirrors, triangles that are wound towards the light appear the other way round.
                let these = caps_of(layers)
                    .iter()
                    .filter(|cap| (cap.is_facing == mirrored) == is_turned);
                self.caps.extend(these.flat_map(|cap| cap.corners));
                first..self.caps.len()
            });
            first_of = [0, 1, 2].map(|layers| first_of[layers] + caps_of(layers).len());
            let points = self.wedges[first_wedge..]
                .iter()
                .flat_map(|wedge| [wedge.start_light, wedge.end_light])
                .map(Vec3::from);
            let cone = if by_patch && !seen.is_directional() {
                ShadowCone::around(points, shape.radius() as f32)
            } else {
                ShadowCone::everywhere(points)
            };
            self.patches.push(ChunkPatch {
                wedges: first_wedge..self.wedges.len(),
                caps: cap_ranges,
                cone,
            });
        }
    }
}

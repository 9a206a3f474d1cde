//! The surface that cuts a light, as few polygons instead of all its triangles.
//!
//! Shares of the light that the triangles of a connected surface hide add up by the surface's outline alone, as long as it
//! is seen from one side. So neighbours that lie in one plane, up to a tolerance, are one patch, and its outline stands for
//! them. A ceiling is one polygon, however many cells it has.
//!
//! Outlines lose the vertices that lie on straight lines ([`Outlines`]). The tolerance is a share of the light's extent, at
//! first one that no picture shows. If there are too many polygons, which is so for bulbs of many triangles, the tolerance is
//! doubled.
//!
//! Patches that lie wholly beyond the light's extent, in a plane through its centre, become no polygons. From no receiver do
//! they hide the centre, and their outlines are ordinary penumbra edges that bound no hard shadow. They are
//! [level](Patch::is_level).
//!
//! Source: the growing is the first step of Cohen-Steiner, Alliez & Desbrun 2004, "Variational Shape Approximation", without
//! its iteration.

use glam::DVec3;

use super::cut_outlines::Outlines;
use super::cut_pieces::{CutPolygon, CutTriangle, NONE, Patch, side_of};

/// Shares of the light's extent by which patches and outlines may differ from the surface, in the order in which they are
/// tried.
const TOLERANCES: [f64; 5] = [0.005, 0.01, 0.02, 0.04, 0.08];

/// Least cosine of the angle between the normals of a patch's triangles.
const LEAST_COSINE: f64 = 0.9;

/// Angle, in radians, by which rounding may turn the plane of a small triangle.
const ROUNDING_ANGLE: f64 = 2e-5;

/// The triangles of one caster that cut one part of a light, and the polygons that stand for them. Buffers are reused.
#[derive(Debug, Default)]
pub struct CutSurface {
    /// The triangles that cut the light.
    pub triangles: Vec<CutTriangle>,
    /// The nearly flat parts of the surface, nearest to the light first.
    pub patches: Vec<Patch>,
    /// The polygons that stand for the triangles, in the order of their patches.
    pub polygons: Vec<CutPolygon>,
    sides_by_edge: Vec<([u32; 2], u32)>,
    mates: Vec<u32>,
    patch_of: Vec<u32>,
    queue: Vec<u32>,
    outlines: Outlines,
}

/// The tolerances and limits to which the surface is simplified.
#[derive(Clone, Copy, Debug)]
pub struct CutLimits {
    /// Extent of the light, of which tolerances are a share; metres.
    pub extent: f64,
    /// Distance from the light's centre beyond which patches are level; infinite if none may be.
    pub reach: f64,
    /// The number of polygons above which they become coarser.
    pub enough: usize,
    /// The greatest number of polygons.
    pub most: usize,
}

impl CutSurface {
    /// Forgets all triangles.
    pub fn clear(&mut self) {
        self.triangles.clear();
        self.patches.clear();
        self.patch_of.clear();
        self.polygons.clear();
    }

    /// Makes polygons of the triangles. Returns the number of polygons that are left out because there are more than
    /// `limits.most`: those of the patches farthest from the light.
    pub fn simplify(&mut self, limits: CutLimits) -> u32 {
        self.triangles
            .sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.slot.cmp(&b.slot)));
        self.find_mates();
        for share in TOLERANCES {
            let tolerance = share * limits.extent;
            self.grow_patches(tolerance, limits.reach);
            self.outlines.find(
                &self.triangles,
                &self.mates,
                &self.patch_of,
                &self.patches,
                tolerance,
            );
            self.outlines.push_polygons(&mut self.polygons);
            if self.polygons.len() <= limits.enough {
                break;
            }
        }
        let left_out = self.polygons.len().saturating_sub(limits.most);
        self.polygons.truncate(limits.most);
        left_out as u32
    }

    /// Returns the slots of the triangles of level patches.
    pub fn level_slots(&self) -> impl Iterator<Item = usize> {
        let patches = self.triangles.iter().zip(&self.patch_of);
        patches
            .filter(|(_, patch)| self.patches[**patch as usize].is_level)
            .map(|(triangle, _)| triangle.slot as usize)
    }

    /// Pairs the two sides of each edge. Where more than two triangles meet, those whose normals agree best are paired, so
    /// the two faces of a sheet that is modelled twice stay apart.
    fn find_mates(&mut self) {
        let Self {
            triangles,
            sides_by_edge,
            mates,
            ..
        } = self;
        sides_by_edge.clear();
        mates.clear();
        mates.resize(3 * triangles.len(), NONE);
        for (index, triangle) in triangles.iter().enumerate() {
            for corner in 0..3 {
                let [a, b] = side_of(triangle.vertices, corner);
                sides_by_edge.push(([a.min(b), a.max(b)], (3 * index + corner) as u32));
            }
        }
        sides_by_edge.sort_unstable();
        let triangle_of = |side: u32| &triangles[side as usize / 3];
        let is_forward = |side: u32| {
            let [a, b] = side_of(triangle_of(side).vertices, side as usize % 3);
            a < b
        };
        let unit = |side: u32| triangle_of(side).normal().normalize_or_zero();
        for of_edge in sides_by_edge.chunk_by(|a, b| a.0 == b.0) {
            for &(_, side) in of_edge.iter().filter(|(_, side)| is_forward(*side)) {
                let free = of_edge.iter().map(|entry| entry.1);
                let free = free.filter(|&other| !is_forward(other) && mates[other as usize] == NONE);
                let agreement = |other: &u32| unit(side).dot(unit(*other));
                if let Some(mate) = free.max_by(|a, b| agreement(a).total_cmp(&agreement(b))) {
                    mates[side as usize] = mate;
                    mates[mate as usize] = side;
                }
            }
        }
    }

    /// Grows patches, each from the nearest triangle that is in none.
    fn grow_patches(&mut self, tolerance: f64, reach: f64) {
        self.patches.clear();
        self.patch_of.clear();
        self.patch_of.resize(self.triangles.len(), NONE);
        for seed in 0..self.triangles.len() {
            if self.patch_of[seed] == NONE {
                self.grow_patch(seed, tolerance, reach);
            }
        }
    }

    fn grow_patch(&mut self, seed: usize, tolerance: f64, reach: f64) {
        let (triangles, number) = (&self.triangles, self.patches.len() as u32);
        let normal = triangles[seed].normal().normalize_or_zero();
        let origin = triangles[seed].corners[0];
        let is_on = |corner: DVec3| {
            let across = corner - origin;
            normal.dot(across).abs() <= tolerance + ROUNDING_ANGLE * across.length()
        };
        let fits = |triangle: &CutTriangle| {
            let other = triangle.normal();
            // A triangle without area has no normal.
            let is_alike = normal.dot(other) >= LEAST_COSINE * other.length();
            is_alike && triangle.corners.into_iter().all(is_on)
        };
        self.patch_of[seed] = number;
        self.queue.clear();
        self.queue.push(seed as u32);
        let mut next = 0;
        let mut sum = DVec3::ZERO;
        while let Some(&triangle) = self.queue.get(next) {
            next += 1;
            sum += triangles[triangle as usize].normal();
            for &mate in &self.mates[3 * triangle as usize..][..3] {
                let other = mate as usize / 3;
                if mate != NONE && self.patch_of[other] == NONE && fits(&triangles[other]) {
                    self.patch_of[other] = number;
                    self.queue.push(other as u32);
                }
            }
        }
        let normal = sum.normalize_or_zero();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for &triangle in &self.queue {
            for corner in triangles[triangle as usize].corners {
                (low, high) = (low.min(normal.dot(corner)), high.max(normal.dot(corner)));
            }
        }
        self.patches.push(Patch {
            slot: triangles[seed].slot,
            normal,
            offset: -0.5 * (low + high),
            tolerance: 0.5 * (high - low),
            is_level: triangles[seed].distance > reach,
        });
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A surface over a grid of cells, of the height that a function gives.
    fn grid(cells: u32, size: f64, height: impl Fn(f64, f64) -> f64) -> Vec<CutTriangle> {
        let at = |vertex: u32| {
            let [x, z] = [vertex % (cells + 1), vertex / (cells + 1)];
            let [x, z] = [x, z].map(|i| (f64::from(i) / f64::from(cells) - 0.5) * size);
            DVec3::new(x, height(x, z), z)
        };
        let mut triangles = Vec::new();
        for cell in 0..cells * cells {
            let a = cell / cells * (cells + 1) + cell % cells;
            let [b, c, d] = [a + 1, a + cells + 1, a + cells + 2];
            for vertices in [[a, c, d], [a, d, b]] {
                let corners = vertices.map(at);
                triangles.push(CutTriangle {
                    slot: triangles.len() as u32,
                    vertices,
                    corners,
                    distance: crate::geometry::distance_to_triangle(DVec3::ZERO, corners),
                });
            }
        }
        triangles
    }

    fn simplified(triangles: Vec<CutTriangle>, limits: CutLimits) -> (CutSurface, u32) {
        let mut surface = CutSurface {
            triangles,
            ..CutSurface::default()
        };
        let left_out = surface.simplify(limits);
        (surface, left_out)
    }

    const LIMITS: CutLimits = CutLimits {
        extent: 0.2,
        reach: f64::INFINITY,
        enough: 64,
        most: 128,
    };

    /// The signed area of all polygons, seen along y.
    fn area(surface: &CutSurface) -> f64 {
        let double = |[a, b, c, d]: [DVec3; 4]| ((c - a).cross(d - b)).y;
        surface
            .polygons
            .iter()
            .map(|polygon| 0.5 * double(polygon.corners))
            .sum()
    }

    #[test]
    fn a_flat_grid_is_one_polygon() {
        for cells in [1, 2, 20, 100] {
            let (surface, left_out) = simplified(grid(cells, 6.0, |_, _| 0.0), LIMITS);
            assert_eq!((surface.patches.len(), left_out), (1, 0));
            assert_eq!(surface.polygons.len(), 1, "{cells}");
            assert!((area(&surface) - 36.0).abs() < 1e-9);
            assert!(surface.patches[0].tolerance < 1e-12 && !surface.patches[0].is_level);
        }
    }

    #[test]
    fn holes_are_kept() {
        // A ring: the middle four cells of six by six are missing.
        let mut triangles = grid(6, 6.0, |_, _| 0.0);
        triangles.retain(|triangle| {
            let middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3.0;
            middle.x.abs() > 1.0 || middle.z.abs() > 1.0
        });
        let (surface, _) = simplified(triangles, LIMITS);
        assert!((area(&surface).abs() - 32.0).abs() < 1e-9);
        assert_eq!(surface.polygons.len(), 2);
    }

    #[test]
    fn what_lies_in_the_plane_but_far_away_is_level() {
        let mut triangles = grid(4, 1.0, |_, _| 0.0);
        for triangle in &mut triangles {
            triangle.corners = triangle.corners.map(|corner| corner + DVec3::X * 3.0);
            triangle.distance += 2.0;
        }
        assert_eq!(simplified(triangles.clone(), LIMITS).0.polygons.len(), 1);
        let limits = CutLimits { reach: 0.2, ..LIMITS };
        let (surface, _) = simplified(triangles, limits);
        assert!(surface.polygons.is_empty());
        assert_eq!(surface.level_slots().count(), 32);
        // A patch that begins within the light's extent is a polygon up to where it ends.
        let (surface, _) = simplified(grid(20, 6.0, |_, _| 0.0), limits);
        assert_eq!((surface.polygons.len(), surface.level_slots().count()), (1, 0));
    }

    #[test]
    fn curved_surfaces_stay_within_the_tolerance_that_they_need() {
        let bump = |x: f64, z: f64| -0.5 * (x * x + z * z);
        let (surface, left_out) = simplified(grid(40, 0.8, bump), LIMITS);
        assert_eq!(left_out, 0);
        assert!(
            (10..=128).contains(&surface.polygons.len()),
            "{}",
            surface.polygons.len()
        );
        assert!(surface.patches.iter().all(|patch| patch.tolerance <= 0.08 * 0.2));
        // The outlines of neighbours agree, so nothing overlaps and nothing is missing but at the border.
        assert!((area(&surface) - 0.64).abs() < 0.64 * 0.02, "{}", area(&surface));
    }

    #[test]
    fn coarse_balls_are_as_large_as_fine_ones() {
        let ball = |rings: u32| {
            let at = |vertex: u32| {
                let [ring, step] = [vertex / (2 * rings), vertex % (2 * rings)];
                let [down, around] = [ring, step].map(|i| PI * f64::from(i) / f64::from(rings));
                DVec3::new(down.sin() * around.cos(), down.cos(), -down.sin() * around.sin()) * 0.2
            };
            let mut triangles = Vec::new();
            for quad in 0..2 * rings * rings {
                let (ring, step) = (quad / (2 * rings), quad % (2 * rings));
                let name = |ring: u32, step: u32| {
                    let is_pole = ring == 0 || ring == rings;
                    ring * 2 * rings + if is_pole { 0 } else { step % (2 * rings) }
                };
                let [a, b] = [name(ring, step), name(ring, step + 1)];
                let [c, d] = [name(ring + 1, step), name(ring + 1, step + 1)];
                for vertices in [[a, c, b], [b, c, d]] {
                    let [i, j, k] = vertices;
                    if i != j && j != k {
                        triangles.push(CutTriangle {
                            slot: triangles.len() as u32,
                            vertices,
                            corners: vertices.map(at),
                            distance: 0.2,
                        });
                    }
                }
            }
            triangles
        };
        for rings in [8, 16, 32] {
            let (surface, left_out) = simplified(ball(rings), CutLimits { most: 256, ..LIMITS });
            let faces = surface.polygons.iter().map(|polygon| {
                let [a, b, c, d] = polygon.corners;
                0.5 * (c - a).cross(d - b)
            });
            let size = faces.clone().map(|face| face.x.abs()).sum::<f64>() / 2.0;
            let whole = PI * 0.2 * 0.2;
            assert_eq!(left_out, 0);
            assert!((size / whole - 1.0).abs() < 0.04, "{rings}: {size} of {whole}");
            assert!(faces.sum::<DVec3>().length() < 1e-9 * whole, "it is closed");
        }
    }

    #[test]
    fn what_is_too_rough_is_left_out_and_counted() {
        let rough = |x: f64, z: f64| 0.3 * ((x * 97.0).sin() + (z * 83.0).cos());
        let (surface, left_out) = simplified(grid(30, 2.0, rough), LIMITS);
        assert_eq!(surface.polygons.len(), 128);
        assert!(left_out > 100);
    }

    #[test]
    fn sheets_modelled_twice_are_two_patches() {
        let mut triangles = grid(5, 1.0, |_, _| 0.0);
        let back = triangles.clone().into_iter().map(|triangle| {
            let ([a, b, c], [i, j, k]) = (triangle.corners, triangle.vertices);
            CutTriangle {
                slot: triangle.slot + 50,
                vertices: [i, k, j],
                corners: [a, c, b],
                ..triangle
            }
        });
        triangles.extend(back.collect::<Vec<_>>());
        let (surface, _) = simplified(triangles, LIMITS);
        assert_eq!((surface.patches.len(), surface.polygons.len()), (2, 2));
        assert!(area(&surface).abs() < 1e-12);
    }
}

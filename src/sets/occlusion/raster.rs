//! Rasterises occluders into a depth buffer, one object at a time. The object's triangles and boundary edges
//! go into layers, and what the layers cover goes into the buffer.

use glam::{DMat4, DVec3};
use wide::f32x8;

use super::clip::{clip_segment, clip_triangle, outside};
use super::depth_buffer::DepthBuffer;
use super::occluder_mesh::OccluderMesh;
use super::projection::{ClipPoint, Projection, SLACK};
use super::texel_layers::{Interval, Layers};

/// How far outside a triangle a texel's centre may lie and still count as covered, texels. Boundary edges
/// reach [`SLACK`] farther, which makes this harmless.
const CENTER_SLACK: f32 = 1.0 / 256.0;

/// Share of themselves by which keys are widened.
const KEY_SLACK: f32 = 1e-5;

/// Least area of a triangle for which it is decidable on which side of it a texel's centre lies, square
/// texels.
const MIN_AREA: f32 = 1e-4;

/// Least height of a triangle that has a usable slope, texels.
const MIN_HEIGHT: f32 = 0.25;

const LANES: usize = 8;

/// Which triangles of an occluder hide what lies behind them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sides {
    /// Whether triangles whose front is visible count: first those of closed pieces, then all others.
    pub front: [bool; 2],
    /// Whether triangles whose back is visible count: first those of closed pieces, then all others.
    pub back: [bool; 2],
}

impl Sides {
    /// A surface of which only fronts are drawn.
    pub const DRAWN_FRONTS: Self = Self {
        front: [true; 2],
        back: [false; 2],
    };
    /// A surface that is drawn from both sides.
    pub const DRAWN: Self = Self {
        front: [true; 2],
        back: [true; 2],
    };
    /// A caster that blocks a light. A closed piece blocks from its unlit side on, as in shadow volumes. Any
    /// other triangle blocks from where it is.
    pub const CAST: Self = Self {
        front: [false, true],
        back: [true; 2],
    };
}

/// A vertex in a picture: its place in texels, and its key.
#[derive(Clone, Copy, Debug, Default)]
struct Vertex {
    x: f32,
    y: f32,
    key: f32,
}

/// Rasterises occluders. It keeps its memory between calls.
#[derive(Clone, Debug, Default)]
pub struct Rasterizer {
    points: Vec<ClipPoint>,
    outside: Vec<u8>,
    vertices: Vec<Vertex>,
    /// For each triangle, whether it belongs to the chain that is being drawn.
    members: Vec<bool>,
    signs: Vec<i8>,
    layers: Vec<Layers>,
    /// For each row, the first column that was touched and the end of the touched columns.
    spans: Vec<(u32, u32)>,
    rows: (u32, u32),
}

impl Rasterizer {
    /// Draws the region that an occluder covers, with the triangles that `sides` selects.
    pub fn draw(
        &mut self,
        buffer: &mut DepthBuffer,
        mesh: &OccluderMesh,
        world_from_local: &DMat4,
        sides: Sides,
    ) {
        let projection = *buffer.projection();
        let flipped = world_from_local.determinant() < 0.0;
        if !self.project(&projection, mesh, world_from_local) {
            return;
        }
        let front = projection.front_sign() * if flipped { -1.0 } else { 1.0 };
        self.signs.clear();
        self.signs.extend(mesh.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| {
                let point = &self.points[corner as usize];
                DVec3::new(point.x, point.y, point.w)
            });
            let area = a.cross(b).dot(c) * front;
            i8::from(area > 0.0) - i8::from(area < 0.0)
        }));
        self.begin(buffer);
        for (sign, [closed, open]) in [(1, sides.front), (-1, sides.back)] {
            if !(closed || open) {
                continue;
            }
            let closed_count = mesh.closed_triangles;
            let taken = |triangle: usize| if triangle < closed_count { closed } else { open };
            self.members.clear();
            let signs = self.signs.iter().enumerate();
            self.members
                .extend(signs.map(|(triangle, side)| *side == sign && taken(triangle)));
            if self.members.contains(&true) {
                self.draw_chain(buffer, mesh, &projection);
                self.merge(buffer);
            }
        }
    }

    /// Projects all vertices. Returns whether any of them may be in the picture.
    fn project(&mut self, projection: &Projection, mesh: &OccluderMesh, world_from_local: &DMat4) -> bool {
        let local = projection.for_local_space(world_from_local);
        self.points.clear();
        self.outside.clear();
        self.vertices.clear();
        let mut common = u8::MAX;
        for &position in &mesh.positions {
            let point = local.point(position);
            let bits = outside(&point, projection.near());
            common &= bits;
            self.points.push(point);
            self.outside.push(bits);
            self.vertices.push(if bits == 0 {
                vertex(projection, &point)
            } else {
                Vertex::default()
            });
        }
        common == 0
    }

    fn begin(&mut self, buffer: &DepthBuffer) {
        let (width, height) = (buffer.stride(), buffer.projection().size.y as usize);
        if self.layers.len() != width * height {
            self.layers.clear();
            self.layers.resize(width * height, Layers::EMPTY);
            self.spans.clear();
            self.spans.resize(height, (u32::MAX, 0));
        }
        self.rows = (u32::MAX, 0);
    }

    fn draw_chain(&mut self, buffer: &DepthBuffer, mesh: &OccluderMesh, projection: &Projection) {
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            if !self.members[triangle] {
                continue;
            }
            let bits = corners.map(|corner| self.outside[corner as usize]);
            if bits[0] & bits[1] & bits[2] != 0 {
                continue;
            }
            if bits == [0; 3] {
                let corners = corners.map(|corner| self.vertices[corner as usize]);
                self.triangle(buffer, corners);
                continue;
            }
            let points = corners.map(|corner| self.points[corner as usize]);
            let (polygon, cut) = clip_triangle(projection, points);
            for i in 2..polygon.len() {
                let corners = [0, i - 1, i].map(|corner| vertex(projection, &polygon[corner]));
                self.triangle(buffer, corners);
            }
            if let Some(segment) = cut.and_then(|segment| clip_segment(projection, segment)) {
                self.boundary(buffer, segment.map(|point| vertex(projection, &point)));
            }
        }
        for (edge, &ends) in mesh.edges.iter().enumerate() {
            let sum: i32 = mesh
                .sides(edge)
                .filter(|(triangle, _)| self.members[*triangle])
                .map(|(_, reversed)| if reversed { -1 } else { 1 })
                .sum();
            if sum == 0 {
                continue;
            }
            let bits = ends.map(|end| self.outside[end as usize]);
            if bits[0] & bits[1] != 0 {
                continue;
            }
            if bits == [0; 2] {
                let ends = ends.map(|end| self.vertices[end as usize]);
                self.boundary(buffer, ends);
            } else if let Some(segment) = clip_segment(projection, ends.map(|end| self.points[end as usize]))
            {
                self.boundary(buffer, segment.map(|point| vertex(projection, &point)));
            }
        }
    }

    /// First and end index of the whole texels from `low` to `high` that are in the picture.
    fn texels(low: f32, high: f32, count: u32) -> (u32, u32) {
        let first = (low - SLACK).floor().clamp(0.0, count as f32) as u32;
        let last = (high + SLACK).floor().clamp(-1.0, count as f32 - 1.0) + 1.0;
        (first, last as u32)
    }

    fn touch(&mut self, row: u32, (first, end): (u32, u32)) {
        let span = &mut self.spans[row as usize];
        *span = (span.0.min(first), span.1.max(end));
        self.rows = (self.rows.0.min(row), self.rows.1.max(row + 1));
    }

    /// Adds a triangle to every texel that it may touch.
    fn triangle(&mut self, buffer: &DepthBuffer, [a, mut b, mut c]: [Vertex; 3]) {
        let size = buffer.projection().size;
        let columns = Self::texels(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x), size.x);
        let rows = Self::texels(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), size.y);
        if columns.0 >= columns.1 || rows.0 >= rows.1 {
            return;
        }
        let mut area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area < 0.0 {
            std::mem::swap(&mut b, &mut c);
            area = -area;
        }
        let (near, far) = (a.key.max(b.key).max(c.key), a.key.min(b.key).min(c.key));
        let slack = KEY_SLACK * near.abs().max(far.abs());
        let (near, far) = (near + slack, far - slack);
        let length = (columns.1 - columns.0 + rows.1 - rows.0) as f32;
        let centers = area >= MIN_AREA;
        // The triangle is too thin for a slope. Its whole range of keys is assumed over each texel.
        let is_thin = area < MIN_HEIGHT * length;
        let (slope_x, slope_y) = if is_thin {
            (0.0, 0.0)
        } else {
            let (kb, kc) = (b.key - a.key, c.key - a.key);
            (
                (kb * (c.y - a.y) - kc * (b.y - a.y)) / area,
                (kc * (b.x - a.x) - kb * (c.x - a.x)) / area,
            )
        };
        let spread = if is_thin {
            f32::INFINITY
        } else {
            let rounding = 8.0 * f32::EPSILON * length * length / area;
            (slope_x.abs() + slope_y.abs()) * (0.5 + SLACK) + slack * (1.0 + rounding / KEY_SLACK)
        };
        let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            let (ex, ey) = (to.x - from.x, to.y - from.y);
            // The normal is positive inside, which is left of the edge with y pointing down and a positive
            // area.
            let (nx, ny) = (-ey, ex);
            let reach = nx.abs() + ny.abs();
            (
                nx,
                ny,
                from,
                reach * (0.5 + SLACK),
                (nx * nx + ny * ny).sqrt() * CENTER_SLACK,
            )
        });
        for row in rows.0..rows.1 {
            let y = row as f32 + 0.5;
            self.touch(row, columns);
            let line = row as usize * buffer.stride();
            let mut column = columns.0 / LANES as u32 * LANES as u32;
            while column < columns.1 {
                let x = f32x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]) + f32x8::splat(column as f32);
                let mut touched = u32::MAX;
                let mut centered = if centers { u32::MAX } else { 0 };
                for (nx, ny, from, reach, center) in edges {
                    let along = (y - from.y) * ny;
                    let side = (x - f32x8::splat(from.x)) * f32x8::splat(nx) + f32x8::splat(along);
                    touched &= (side + f32x8::splat(reach)).simd_ge(f32x8::ZERO).to_bitmask();
                    centered &= (side + f32x8::splat(center)).simd_ge(f32x8::ZERO).to_bitmask();
                }
                touched &= 0xff;
                if column < columns.0 {
                    touched &= 0xff << (columns.0 - column);
                }
                if columns.1 - column < LANES as u32 {
                    touched &= (1 << (columns.1 - column)) - 1;
                }
                if touched != 0 {
                    let key = (x - f32x8::splat(a.x)) * f32x8::splat(slope_x)
                        + f32x8::splat(a.key + (y - a.y) * slope_y);
                    let nears = (key + f32x8::splat(spread))
                        .fast_min(f32x8::splat(near))
                        .to_array();
                    let fars = (key - f32x8::splat(spread))
                        .fast_max(f32x8::splat(far))
                        .to_array();
                    while touched != 0 {
                        let lane = touched.trailing_zeros() as usize;
                        touched &= touched - 1;
                        self.layers[line + column as usize + lane].insert(Interval {
                            near: nears[lane].max(fars[lane]),
                            far: fars[lane].min(nears[lane]),
                            open: false,
                            centered: centered >> lane & 1 != 0,
                        });
                    }
                }
                column += LANES as u32;
            }
        }
    }

    /// Adds a boundary edge to every texel that it may touch.
    fn boundary(&mut self, buffer: &DepthBuffer, [a, b]: [Vertex; 2]) {
        let size = buffer.projection().size;
        let rows = Self::texels(a.y.min(b.y), a.y.max(b.y), size.y);
        let part = |from: f32, to: f32, low: f32, high: f32| {
            // The range of parameters in which the coordinate is within low..=high.
            let length = to - from;
            if length.abs() < 1e-6 {
                return (0.0, 1.0);
            }
            let (s, t) = ((low - from) / length, (high - from) / length);
            (s.min(t).max(0.0), s.max(t).min(1.0))
        };
        for row in rows.0..rows.1 {
            let (low, high) = (row as f32 - SLACK, row as f32 + 1.0 + SLACK);
            let (s, t) = part(a.y, b.y, low, high);
            if s > t {
                continue;
            }
            let (from, to) = (a.x + (b.x - a.x) * s, a.x + (b.x - a.x) * t);
            let columns = Self::texels(from.min(to), from.max(to), size.x);
            if columns.0 >= columns.1 {
                continue;
            }
            self.touch(row, columns);
            for column in columns.0..columns.1 {
                let (low, high) = (column as f32 - SLACK, column as f32 + 1.0 + SLACK);
                let (u, v) = part(a.x, b.x, low, high);
                let (u, v) = (u.max(s), v.min(t));
                let (u, v) = if u <= v { (u, v) } else { (s, t) };
                let (ka, kb) = (a.key + (b.key - a.key) * u, a.key + (b.key - a.key) * v);
                let slack = KEY_SLACK * ka.abs().max(kb.abs());
                self.layers[row as usize * buffer.stride() + column as usize].insert(Interval {
                    near: ka.max(kb) + slack,
                    far: ka.min(kb) - slack,
                    open: true,
                    centered: false,
                });
            }
        }
    }

    /// Moves what the layers cover into the buffer, and clears them.
    fn merge(&mut self, buffer: &mut DepthBuffer) {
        for row in self.rows.0..self.rows.1 {
            let span = std::mem::replace(&mut self.spans[row as usize], (u32::MAX, 0));
            let line = row as usize * buffer.stride();
            for column in span.0..span.1 {
                let layers = &mut self.layers[line + column as usize];
                buffer.cover(column as usize, row as usize, layers.covered());
                *layers = Layers::EMPTY;
            }
        }
        self.rows = (u32::MAX, 0);
    }
}

fn vertex(projection: &Projection, point: &ClipPoint) -> Vertex {
    let (x, y) = projection.texel(point);
    Vertex {
        x: x as f32,
        y: y as f32,
        key: (point.key / point.w) as f32,
    }
}

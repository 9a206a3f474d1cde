//! The jack-o'-lantern: hollow walls with triangular eyes, a nose and a mouth, lit from inside. It is a closed caster
//! with holes whose walls surround the light.
//!
//! Source: McGuire 2004, "Efficient Shadow Volume Rendering", GPU Gems ch. 9, figure 9-2.

use antumbra::prelude::MeshData;
use glam::{Vec2, Vec3};

/// The holes of a wall; coordinates are in −1..=1 along both axes.
const HOLES: [&[Vec2]; 4] = [
    &[
        Vec2::new(-0.68, 0.15),
        Vec2::new(-0.2, 0.15),
        Vec2::new(-0.44, 0.6),
    ],
    &[Vec2::new(0.2, 0.15), Vec2::new(0.68, 0.15), Vec2::new(0.44, 0.6)],
    &[
        Vec2::new(-0.13, -0.12),
        Vec2::new(0.13, -0.12),
        Vec2::new(0.0, 0.12),
    ],
    &[
        Vec2::new(-0.75, -0.25),
        Vec2::new(-0.45, -0.62),
        Vec2::new(-0.25, -0.45),
        Vec2::new(0.0, -0.66),
        Vec2::new(0.25, -0.45),
        Vec2::new(0.45, -0.62),
        Vec2::new(0.75, -0.25),
        Vec2::new(0.4, -0.38),
        Vec2::new(0.2, -0.25),
        Vec2::new(0.0, -0.4),
        Vec2::new(-0.2, -0.25),
        Vec2::new(-0.4, -0.38),
    ],
];

/// Builds a box without a floor on the XZ plane, with a face in each wall. The outside of each wall is `half_size`
/// metres from the centre.
pub fn lantern(half_size: f32, thickness: f32) -> MeshData {
    let mut mesh = Soup::default();
    for quarter in 0..4 {
        // The walls are mitred: each is narrower and lower on its inside, so that it shares its corners exactly with
        // its neighbours and the roof.
        let place = |at: Vec2, depth: f32| {
            let inset = half_size - depth * thickness;
            let height = 2.0 * half_size - depth * thickness;
            let [x, z] = (0..quarter).fold([at.x * inset, inset], |[x, z], _| [z, -x]);
            Vec3::new(x, (at.y + 1.0) * 0.5 * height, z)
        };
        wall(&mut mesh, &place);
    }
    for depth in [0.0, 1.0] {
        let (half, height) = (half_size - depth * thickness, 2.0 * half_size - depth * thickness);
        let corner = |x: f32, z: f32| Vec3::new(x * half, height, z * half);
        let corners = [
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
            corner(-1.0, -1.0),
        ];
        mesh.quad(corners, depth > 0.0);
    }
    mesh.finish()
}

/// Builds one wall: its outside, its inside, the rims of its holes and its foot.
fn wall(mesh: &mut Soup, place: &impl Fn(Vec2, f32) -> Vec3) {
    let lines = lines();
    for band in lines.windows(2) {
        let [low, high] = [band[0], band[1]];
        let borders = borders(low, high);
        for solid in borders.chunks_exact(2) {
            let bottom = chain(low, solid[0].x_at(low), solid[1].x_at(low));
            let top = chain(high, solid[0].x_at(high), solid[1].x_at(high));
            for triangle in between(&bottom, &top) {
                mesh.triangle(triangle.map(|at| place(at, 0.0)), false);
                mesh.triangle(triangle.map(|at| place(at, 1.0)), true);
            }
        }
        // Every border except the outermost is the rim of a hole. Odd ones have their solid side on the left.
        for (index, border) in borders.iter().enumerate().skip(1).take(borders.len() - 2) {
            let [a, b] = [low, high].map(|y| Vec2::new(border.x_at(y), y));
            let rim = [place(a, 0.0), place(a, 1.0), place(b, 1.0), place(b, 0.0)];
            mesh.quad(rim, index % 2 == 0);
        }
    }
    for hole in HOLES {
        for (a, b) in edges(hole).filter(|(a, b)| a.y == b.y) {
            let (left, right) = (a.x.min(b.x), a.x.max(b.x));
            let is_sill = borders_below(a.y, (left + right) * 0.5);
            for step in chain(a.y, left, right).windows(2) {
                let rim = [
                    place(step[0], 0.0),
                    place(step[1], 0.0),
                    place(step[1], 1.0),
                    place(step[0], 1.0),
                ];
                mesh.quad(rim, !is_sill);
            }
        }
    }
    let [left, right] = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0)];
    mesh.quad(
        [
            place(left, 0.0),
            place(left, 1.0),
            place(right, 1.0),
            place(right, 0.0),
        ],
        false,
    );
}

/// A border of solid parts within a band: an edge of a hole or of the wall.
#[derive(Clone, Copy)]
struct Border(Vec2, Vec2);

impl Border {
    /// Returns the border's x at a height. The bits are the same for the bands above and below.
    fn x_at(&self, y: f32) -> f32 {
        let Self(a, b) = if self.0.y < self.1.y {
            *self
        } else {
            Self(self.1, self.0)
        };
        if y == a.y {
            a.x
        } else if y == b.y {
            b.x
        } else {
            a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y))
        }
    }

    fn spans(&self, low: f32, high: f32) -> bool {
        self.0.y.min(self.1.y) <= low && self.0.y.max(self.1.y) >= high
    }
}

fn edges(hole: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> {
    (0..hole.len()).map(|i| (hole[i], hole[(i + 1) % hole.len()]))
}

/// Returns heights, ascending, between which no border begins or ends.
fn lines() -> Vec<f32> {
    let corners = HOLES.iter().flat_map(|hole| hole.iter().map(|corner| corner.y));
    let mut lines: Vec<f32> = corners.chain([-1.0, 1.0]).collect();
    lines.sort_by(f32::total_cmp);
    lines.dedup();
    lines
}

/// Returns the borders of the solid parts of a band from left to right, two for each part.
fn borders(low: f32, high: f32) -> Vec<Border> {
    let side = |x: f32| Border(Vec2::new(x, -1.0), Vec2::new(x, 1.0));
    let rims = HOLES
        .iter()
        .flat_map(|hole| edges(hole))
        .map(|(a, b)| Border(a, b));
    let mut borders: Vec<Border> = rims
        .filter(|rim| rim.0.y != rim.1.y && rim.spans(low, high))
        .collect();
    borders.extend([side(-1.0), side(1.0)]);
    let middle = (low + high) * 0.5;
    borders.sort_by(|a, b| a.x_at(middle).total_cmp(&b.x_at(middle)));
    borders
}

/// Returns whether the wall is solid just below a point of a line.
fn borders_below(y: f32, x: f32) -> bool {
    let lines = lines();
    let Some(index) = lines
        .iter()
        .position(|line| *line == y)
        .filter(|index| *index > 0)
    else {
        return false;
    };
    let low = lines[index - 1];
    borders(low, y)
        .chunks_exact(2)
        .any(|part| part[0].x_at(y) < x && x < part[1].x_at(y))
}

/// Returns the points of the line at `y`, from `left` to `right`, where a border crosses or ends. The triangles above
/// and below share all of these vertices.
fn chain(y: f32, left: f32, right: f32) -> Vec<Vec2> {
    let lines = lines();
    let bands = lines.windows(2).filter(|band| band[0] == y || band[1] == y);
    let mut xs: Vec<f32> = bands
        .flat_map(|band| borders(band[0], band[1]))
        .map(|border| border.x_at(y))
        .chain([left, right])
        .filter(|x| (left..=right).contains(x))
        .collect();
    xs.sort_by(f32::total_cmp);
    xs.dedup();
    xs.into_iter().map(|x| Vec2::new(x, y)).collect()
}

/// Fills the area between two chains with counter-clockwise triangles.
fn between(bottom: &[Vec2], top: &[Vec2]) -> Vec<[Vec2; 3]> {
    let mut triangles: Vec<_> = bottom.windows(2).map(|step| [step[0], step[1], top[0]]).collect();
    let last = bottom[bottom.len() - 1];
    triangles.extend(top.windows(2).map(|step| [step[0], last, step[1]]));
    triangles
}

/// Builds a mesh with flat normals from triangles.
#[derive(Default)]
struct Soup {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

impl Soup {
    fn quad(&mut self, [a, b, c, d]: [Vec3; 4], flip: bool) {
        self.triangle([a, b, c], flip);
        self.triangle([a, c, d], flip);
    }

    fn triangle(&mut self, [a, b, c]: [Vec3; 3], flip: bool) {
        let triangle = if flip { [a, c, b] } else { [a, b, c] };
        let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
        self.positions.extend(triangle);
        self.normals.extend([normal.normalize_or(Vec3::Y); 3]);
    }

    fn finish(self) -> MeshData {
        let indices = (0..self.positions.len() as u32).collect();
        MeshData {
            normals: self.normals,
            ..MeshData::from_triangles("lantern", self.positions, indices)
        }
    }
}

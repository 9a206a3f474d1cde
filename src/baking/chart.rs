//! Charts: connected pieces of a surface without creases, flat on a page.

use std::collections::HashMap;

use glam::{DVec2, DVec3, UVec2, Vec2};
use smallvec::SmallVec;

/// Texels around a chart that no other chart may use. Blending reads one texel beyond the surface; the second one keeps
/// rounding apart.
pub const PADDING: u32 = 2;

/// Least cosine of the angle between two triangles that share an edge and a chart: 20 degrees. Texels are blended within a
/// chart, and at a crease the light may be in front of one side and behind the other. Flatter curves stay whole, or every
/// triangle of a ball would be a chart.
///
/// In `town_A` at 2 texels a metre, the mean error at 20 times of a day is 0.051 if charts go over creases, and 0.019 if they
/// end there (`errors_on_a_town_by_hand`); maps have 1.4 times the texels.
const LEAST_COSINE: f64 = 0.94;

/// A triangle of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartTriangle {
    /// Index of the triangle in its surface.
    pub triangle: u32,
    /// Corners, texels from the upper left corner of the chart, padding included.
    pub texels: [Vec2; 3],
}

/// A connected piece of a surface without creases.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Index of the surface.
    pub surface: u32,
    /// Width and height, texels, padding included.
    pub size: UVec2,
    /// The triangles.
    pub triangles: Vec<ChartTriangle>,
    /// Texels per metre, where they are fewer than asked for because the chart would not fit onto a page.
    pub coarser: Option<f32>,
}

/// A surface laid flat: the corners of each triangle.
#[derive(Clone, Debug, Default)]
pub struct Flat {
    /// The triangles; `None` for those that are left out.
    pub triangles: Vec<Option<FlatTriangle>>,
}

/// A triangle laid flat.
#[derive(Clone, Copy, Debug)]
pub struct FlatTriangle {
    /// Corners, in any unit of length.
    pub corners: [DVec2; 3],
    /// Numbers of the corners. Triangles that share two of them are connected.
    pub ids: [u32; 3],
    /// Unit normal of the triangle in space.
    pub normal: DVec3,
    /// Area of the triangle in space, m².
    pub area: f64,
}

/// Cuts a flat surface into connected pieces that end at creases. Each is scaled to `texels_per_metre`, or to fewer if it is
/// larger than `page_size` texels.
pub fn charts_of(surface: u32, flat: &Flat, texels_per_metre: f32, page_size: u32) -> Vec<Chart> {
    let mut pieces: Vec<Vec<u32>> = Vec::new();
    let mut piece_of: HashMap<u32, usize> = HashMap::new();
    let mut roots = Roots::default();
    for (index, triangle) in (0u32..).zip(&flat.triangles) {
        if let Some(triangle) = triangle {
            roots.join(index, triangle);
        }
    }
    for (index, triangle) in (0u32..).zip(&flat.triangles) {
        if triangle.is_some() {
            let root = roots.root(index);
            let piece = *piece_of.entry(root).or_insert_with(|| {
                pieces.push(Vec::new());
                pieces.len() - 1
            });
            pieces[piece].push(index);
        }
    }
    let chart = |piece: &Vec<u32>| lay_out(surface, flat, piece, texels_per_metre, page_size);
    pieces.iter().filter_map(chart).collect()
}

fn lay_out(surface: u32, flat: &Flat, piece: &[u32], texels_per_metre: f32, page_size: u32) -> Option<Chart> {
    let triangles = || {
        piece
            .iter()
            .filter_map(|&at| Some((at, flat.triangles[at as usize].as_ref()?)))
    };
    let (mut area, mut flat_area) = (0.0, 0.0);
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for (_, triangle) in triangles() {
        let [a, b, c] = triangle.corners;
        area += triangle.area;
        flat_area += 0.5 * (b - a).perp_dot(c - a).abs();
        min = min.min(a).min(b).min(c);
        max = max.max(a).max(b).max(c);
    }
    if !(flat_area > 0.0 && area > 0.0 && min.is_finite() && max.is_finite()) {
        return None;
    }
    let mut scale = f64::from(texels_per_metre) * (area / flat_area).sqrt();
    let room = f64::from(page_size.saturating_sub(2 * PADDING).max(1));
    let largest = (max - min).max_element() * scale;
    let mut coarser = None;
    if largest > room {
        scale *= room / largest;
        coarser = Some((f64::from(texels_per_metre) * room / largest) as f32);
    }
    // Rounding may make it a little larger than the room.
    let extent = ((max - min) * scale).min(DVec2::splat(room));
    let size = extent.ceil().as_uvec2().max(UVec2::ONE) + 2 * PADDING;
    let texel = |corner: DVec2| ((corner - min) * scale + f64::from(PADDING)).as_vec2();
    let triangles = triangles().map(|(triangle, flat)| ChartTriangle {
        triangle,
        texels: flat.corners.map(texel),
    });
    Some(Chart {
        surface,
        size,
        triangles: triangles.collect(),
        coarser,
    })
}

/// Connected triangles, as a forest with a root for each piece.
#[derive(Default)]
struct Roots {
    parents: Vec<u32>,
    /// The triangles at each edge with their normals, by the numbers of its ends.
    edges: HashMap<(u32, u32), SmallVec<[(u32, DVec3); 2]>>,
}

impl Roots {
    fn root(&mut self, mut at: u32) -> u32 {
        while self.parents[at as usize] != at {
            let up = self.parents[self.parents[at as usize] as usize];
            self.parents[at as usize] = up;
            at = up;
        }
        at
    }

    /// Adds a triangle, and joins it with its neighbours unless they meet at a crease.
    fn join(&mut self, index: u32, triangle: &FlatTriangle) {
        while self.parents.len() <= index as usize {
            self.parents.push(self.parents.len() as u32);
        }
        for side in 0..3 {
            let (a, b) = (triangle.ids[side], triangle.ids[(side + 1) % 3]);
            let edge = (a.min(b), a.max(b));
            let at_edge = self.edges.get(&edge).cloned().unwrap_or_default();
            for (other, normal) in at_edge {
                if normal.dot(triangle.normal) > LEAST_COSINE {
                    let (root, other) = (self.root(index), self.root(other));
                    self.parents[root as usize] = other;
                }
            }
            self.edges.entry(edge).or_default().push((index, triangle.normal));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(at: DVec2, first_id: u32) -> [Option<FlatTriangle>; 2] {
        let corner = |x: f64, y: f64| at + DVec2::new(x, y);
        let [a, b, c, d] = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ];
        let ids = |ids: [u32; 3]| ids.map(|id| id + first_id);
        [
            Some(FlatTriangle {
                corners: [a, b, c],
                ids: ids([0, 1, 2]),
                normal: DVec3::Y,
                area: 2.0,
            }),
            Some(FlatTriangle {
                corners: [a, c, d],
                ids: ids([0, 2, 3]),
                normal: DVec3::Y,
                area: 2.0,
            }),
        ]
    }

    #[test]
    fn connected_triangles_share_a_chart_at_the_density_asked_for() {
        let mut triangles = quad(DVec2::ZERO, 0).to_vec();
        triangles.push(None);
        triangles.extend(quad(DVec2::new(5.0, 5.0), 4));
        let charts = charts_of(3, &Flat { triangles }, 8.0, 1024);
        assert_eq!(charts.len(), 2);
        for chart in &charts {
            // The quad is 4 m² large, and so 16 texels wide.
            assert_eq!(chart.size, UVec2::splat(16 + 2 * PADDING));
            assert_eq!(
                (chart.triangles.len(), chart.surface, chart.coarser),
                (2, 3, None)
            );
        }
        assert_eq!(charts[1].triangles[0].triangle, 3);
    }

    #[test]
    fn charts_end_at_creases() {
        let charts = |degrees: f64| {
            let mut triangles = quad(DVec2::ZERO, 0).to_vec();
            let (sin, cos) = degrees.to_radians().sin_cos();
            if let Some(second) = &mut triangles[1] {
                second.normal = DVec3::new(sin, cos, 0.0);
            }
            charts_of(0, &Flat { triangles }, 8.0, 1024).len()
        };
        assert_eq!([0.0, 15.0, 25.0, 90.0, 180.0].map(charts), [1, 1, 2, 2, 2]);
    }

    #[test]
    fn no_chart_is_larger_than_a_page_however_its_size_is_rounded() {
        for i in 1..500 {
            let mut triangles = quad(DVec2::ZERO, 0).to_vec();
            for triangle in triangles.iter_mut().flatten() {
                triangle.corners = triangle.corners.map(|corner| corner * 0.1 * f64::from(i));
            }
            let charts = charts_of(0, &Flat { triangles }, 1000.0, 256);
            assert_eq!(charts[0].size, UVec2::splat(256), "{i}");
        }
    }

    #[test]
    fn charts_larger_than_a_page_are_coarser_and_say_so() {
        let triangles = quad(DVec2::ZERO, 0).to_vec();
        let charts = charts_of(0, &Flat { triangles }, 100.0, 54);
        assert_eq!(charts[0].size, UVec2::splat(54));
        assert!((charts[0].coarser.expect("it is coarser") - 25.0).abs() < 1e-3);
    }
}

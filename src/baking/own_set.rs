//! Charts by the second texture coordinates of a surface.

use std::collections::HashMap;

use glam::{DMat2, DVec2, DVec3, Vec2};

use super::chart::{Chart, Flat, FlatTriangle, charts_of};
use super::overlap::{BadCoordinates, bad_coordinates};
use super::surfaces::{SurfaceTriangle, area};

/// Least texels per metre along every axis, as a share of those asked for. Charts have as many as asked for in the mean, so this
/// is met by coordinates that are up to 4 times as long along one axis as along the other.
const LEAST_DENSITY: f64 = 0.5;

/// Largest share of a surface's area in which texels may be fewer than that. Slivers of good sets are often stretched.
const LARGEST_STRETCHED: f64 = 0.01;

/// Lays a surface flat by its second texture coordinates and cuts it into charts.
///
/// # Errors
/// [`BadCoordinates`] says why the coordinates cannot be used.
pub(super) fn by_own_set(
    surface: u32,
    triangles: &[Option<SurfaceTriangle>],
    texels_per_metre: f32,
    page_size: u32,
) -> Result<Vec<Chart>, BadCoordinates> {
    let coordinates: Vec<_> = triangles
        .iter()
        .map(|triangle| triangle.map(|triangle| triangle.coordinates))
        .collect();
    if let Some(bad) = bad_coordinates(&coordinates) {
        return Err(bad);
    }
    let charts = charts_of(surface, &by_coordinates(triangles), texels_per_metre, page_size);
    match stretched(&charts, triangles, texels_per_metre) {
        Some(triangle) => Err(BadCoordinates::Stretched(triangle)),
        None => Ok(charts),
    }
}

/// The surface by its second texture coordinates. Triangles are connected where they share both ends of an edge in space
/// and on the page.
fn by_coordinates(triangles: &[Option<SurfaceTriangle>]) -> Flat {
    let mut known: HashMap<([u64; 3], [u32; 2]), u32> = HashMap::new();
    let mut id = |position: DVec3, coordinate: Vec2| {
        let key = (
            position.to_array().map(|value| (value + 0.0).to_bits()),
            coordinate.to_array().map(|value| (value + 0.0).to_bits()),
        );
        let next = known.len() as u32;
        *known.entry(key).or_insert(next)
    };
    let flat = |triangle: &Option<SurfaceTriangle>| {
        let triangle = triangle.as_ref()?;
        Some(FlatTriangle {
            corners: triangle.coordinates.map(|corner| corner.as_dvec2()),
            ids: [0, 1, 2].map(|at| id(triangle.corners[at], triangle.coordinates[at])),
            normal: triangle.normal,
            area: area(triangle),
        })
    };
    Flat {
        triangles: triangles.iter().map(flat).collect(),
    }
}

/// Returns the triangle with the fewest texels along an axis, if too large a part of the surface has too few.
fn stretched(charts: &[Chart], triangles: &[Option<SurfaceTriangle>], texels_per_metre: f32) -> Option<u32> {
    let (mut all, mut coarse) = (0.0, 0.0);
    let (mut worst, mut least) = (None, LEAST_DENSITY);
    for chart in charts {
        // A chart that is larger than a page is made coarser, which another note says.
        let wanted = f64::from(chart.coarser.unwrap_or(texels_per_metre));
        for flat in &chart.triangles {
            let Some(triangle) = triangles.get(flat.triangle as usize).and_then(Option::as_ref) else {
                continue;
            };
            let density = least_density(triangle.corners, flat.texels) / wanted;
            all += area(triangle);
            if density < LEAST_DENSITY {
                coarse += area(triangle);
            }
            if density < least {
                (worst, least) = (Some(flat.triangle), density);
            }
        }
    }
    worst.filter(|_| coarse > LARGEST_STRETCHED * all)
}

/// Returns the texels per metre of a triangle along the axis that has fewest: the smaller singular value of the map from the
/// triangle to the page.
fn least_density([a, b, c]: [DVec3; 3], texels: [Vec2; 3]) -> f64 {
    let along = (b - a).normalize_or_zero();
    let across = (b - a).cross(c - a).cross(along).normalize_or_zero();
    let in_plane = |side: DVec3| DVec2::new(side.dot(along), side.dot(across));
    let [p, q, r] = texels.map(|texel| texel.as_dvec2());
    let page_from_plane =
        DMat2::from_cols(q - p, r - p) * DMat2::from_cols(in_plane(b - a), in_plane(c - a)).inverse();
    // Sum of the squares of both singular values, and their product.
    let squares = page_from_plane.x_axis.length_squared() + page_from_plane.y_axis.length_squared();
    let product = page_from_plane.determinant().abs();
    let root = (squares * squares - 4.0 * product * product).max(0.0).sqrt();
    product / (0.5 * (squares + root)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map that is stretched by 3 and 0.2 along two axes, and turned, has the smaller of both as its least density.
    #[test]
    fn the_least_density_is_that_of_the_worst_axis() {
        let corners = [
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(2.0, 2.5, 3.0),
            DVec3::new(1.5, 2.0, 4.0),
        ];
        let x = (corners[1] - corners[0]).normalize();
        let y = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .cross(x)
            .normalize();
        for turn in [0.0, 0.4, 1.3] {
            let place = |corner: DVec3| {
                let flat = DVec2::from_angle(turn).rotate(DVec2::new(corner.dot(x), corner.dot(y)));
                DVec2::from_angle(0.7)
                    .rotate(flat * DVec2::new(3.0, 0.2))
                    .as_vec2()
            };
            let density = least_density(corners, corners.map(place));
            assert!((density - 0.2).abs() < 1e-5, "{density}");
        }
    }
}

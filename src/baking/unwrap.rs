//! Lays a surface flat: by its second texture coordinates if every place has coordinates of its own and enough texels along
//! all axes, else by a new set.

use super::chart::{Chart, Flat, charts_of};
use super::new_set::{by_new_set, complete};
use super::overlap::BadCoordinates;
use super::own_set::by_own_set;
use super::surfaces::{Surface, SurfaceTriangle, area};

/// Something about a surface that was laid flat.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnwrapNote {
    /// The second texture coordinates are not used.
    #[error("triangles {0} and {1} overlap in the second texture coordinates, so a new set is used")]
    Overlap(u32, u32),
    /// The second texture coordinates are not used.
    #[error("triangle {0} has no area in the second texture coordinates, so a new set is used")]
    Degenerate(u32),
    /// The second texture coordinates are not used.
    #[error(
        "triangle {0} has less than half of its texels along one axis in the second texture coordinates, which are \
         stretched, so a new set is used"
    )]
    Stretched(u32),
    /// The second texture coordinates are not used.
    #[error(
        "so many triangles are close to each other in the second texture coordinates, such as those of a fan, that a search for \
         overlaps would take too long, so a new set is used"
    )]
    Crowded,
    /// Triangles are left out.
    #[error(
        "{count} triangles have no area or are not finite, the first is triangle {first}; they are left out"
    )]
    NoArea {
        /// Number of the triangles.
        count: usize,
        /// Index of the first one.
        first: usize,
    },
    /// Triangles with an area have no place in the set of texture coordinates.
    #[error("{count} triangles cannot be laid flat, the first is triangle {first}; they show no shadow")]
    NoChart {
        /// Number of the triangles.
        count: usize,
        /// Index of the first one.
        first: usize,
    },
    /// The surface cannot be laid flat as a whole.
    #[error("it cannot be laid flat ({0}), so each triangle is a chart of its own")]
    Single(String),
}

impl From<BadCoordinates> for UnwrapNote {
    fn from(bad: BadCoordinates) -> Self {
        match bad {
            BadCoordinates::Overlap(a, b) => Self::Overlap(a, b),
            BadCoordinates::Degenerate(triangle) => Self::Degenerate(triangle),
            BadCoordinates::Stretched(triangle) => Self::Stretched(triangle),
            BadCoordinates::Crowded => Self::Crowded,
        }
    }
}

/// A surface cut into charts.
#[derive(Clone, Debug, Default)]
pub struct Unwrapped {
    /// The charts.
    pub charts: Vec<Chart>,
    /// Notes for the user.
    pub notes: Vec<UnwrapNote>,
}

/// Least area of a triangle, m²: a square of a hundredth of a millimetre.
const LEAST_AREA: f64 = 1e-10;

/// Lays a surface flat and cuts it into charts.
pub fn unwrap(index: u32, surface: &Surface, texels_per_metre: f32, page_size: u32) -> Unwrapped {
    let mut notes = Vec::new();
    let usable = |triangle: &Option<SurfaceTriangle>| triangle.filter(|triangle| area(triangle) > LEAST_AREA);
    let triangles: Vec<Option<SurfaceTriangle>> = surface.triangles.iter().map(usable).collect();
    let missing = || {
        triangles
            .iter()
            .enumerate()
            .filter(|(_, triangle)| triangle.is_none())
    };
    if let Some((first, _)) = missing().next() {
        let count = missing().count();
        notes.push(UnwrapNote::NoArea { count, first });
    }
    let own = surface
        .has_coordinates
        .then(|| by_own_set(index, &triangles, texels_per_metre, page_size));
    let charts = match own {
        Some(Ok(charts)) => charts,
        other => {
            notes.extend(other.and_then(Result::err).map(UnwrapNote::from));
            let mut flat = by_new_set(&triangles).unwrap_or_else(|error| {
                notes.push(UnwrapNote::Single(error));
                Flat::default()
            });
            flat.triangles.resize(triangles.len(), None);
            complete(&mut flat, &triangles);
            charts_of(index, &flat, texels_per_metre, page_size)
        }
    };
    notes.extend(note_of_missing(&triangles, &charts));
    Unwrapped { charts, notes }
}

/// The note about triangles that should be in a chart and are in none.
fn note_of_missing(triangles: &[Option<SurfaceTriangle>], charts: &[Chart]) -> Option<UnwrapNote> {
    let mut is_missing: Vec<bool> = triangles.iter().map(Option::is_some).collect();
    for triangle in charts.iter().flat_map(|chart| &chart.triangles) {
        is_missing[triangle.triangle as usize] = false;
    }
    let count = is_missing.iter().filter(|missing| **missing).count();
    let first = is_missing.iter().position(|missing| *missing)?;
    Some(UnwrapNote::NoChart { count, first })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baking::overlap::bad_coordinates;
    use crate::baking::surfaces::world_triangles;
    use crate::scene::MeshData;
    use glam::{Affine3A, Vec2, Vec3};

    fn surface(mesh: &MeshData) -> Surface {
        Surface {
            mesh: "test".to_owned(),
            hash: 0,
            world_from_local: [0.0; 12],
            is_two_sided: false,
            receives: true,
            casts: true,
            triangles: world_triangles(mesh, &mesh.submeshes[0], &Affine3A::IDENTITY),
            has_coordinates: !mesh.uv1.is_empty(),
        }
    }

    /// Largest ratio by which the area of a triangle on the page differs from that in space.
    fn distortion(surface: &Surface, unwrapped: &Unwrapped, density: f64) -> f64 {
        let triangles = unwrapped.charts.iter().flat_map(|chart| &chart.triangles);
        triangles
            .map(|flat| {
                let [a, b, c] = flat.texels.map(|texel| texel.as_dvec2());
                let texels = 0.5 * (b - a).perp_dot(c - a).abs();
                let triangle = surface.triangles[flat.triangle as usize].expect("a triangle with area");
                let ratio = texels / (area(&triangle) * density * density);
                ratio.max(1.0 / ratio)
            })
            .fold(1.0, f64::max)
    }

    fn all_triangles(unwrapped: &Unwrapped) -> Vec<u32> {
        let triangles = unwrapped.charts.iter().flat_map(|chart| &chart.triangles);
        let mut all: Vec<u32> = triangles.map(|triangle| triangle.triangle).collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn a_mesh_without_coordinates_gets_a_set_without_overlaps() {
        for mesh in [
            MeshData::cuboid(Vec3::new(1.0, 0.5, 2.0)),
            MeshData::icosphere(1.0, 2),
        ] {
            let surface = surface(&mesh);
            let unwrapped = unwrap(0, &surface, 16.0, 512);
            assert_eq!(unwrapped.notes, []);
            assert_eq!(
                all_triangles(&unwrapped),
                (0..mesh.triangle_count() as u32).collect::<Vec<_>>()
            );
            assert!(distortion(&surface, &unwrapped, 16.0) < 2.5);
            for chart in &unwrapped.charts {
                let texels: Vec<_> = chart
                    .triangles
                    .iter()
                    .map(|triangle| Some(triangle.texels))
                    .collect();
                assert_eq!(bad_coordinates(&texels), None);
            }
        }
        let cuboid = unwrap(0, &surface(&MeshData::cuboid(Vec3::ONE)), 16.0, 512);
        assert_eq!(
            cuboid.charts.len(),
            6,
            "charts end at edges, and sides are not cut"
        );
    }

    #[test]
    fn good_coordinates_are_used_and_scaled_to_the_density() {
        let mut mesh = MeshData::plane(2.0);
        mesh.uv1 = mesh
            .positions
            .iter()
            .map(|p| Vec2::new(p.x, p.z) * 0.1 + 0.5)
            .collect();
        let surface = surface(&mesh);
        let unwrapped = unwrap(0, &surface, 8.0, 512);
        assert_eq!((unwrapped.notes.len(), unwrapped.charts.len()), (0, 1));
        assert!(distortion(&surface, &unwrapped, 8.0) < 1.001);
        // As they are: the first corner, at −X −Z, is the upper left one.
        assert_eq!(unwrapped.charts[0].triangles[0].texels[0], Vec2::splat(2.0));
    }

    #[test]
    fn bad_coordinates_are_named_and_a_new_set_is_used() {
        let mut mesh = MeshData::cuboid(Vec3::ONE);
        mesh.uv1 = (0..mesh.positions.len())
            .map(|i| [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y][i % 4])
            .collect();
        let unwrapped = unwrap(0, &surface(&mesh), 8.0, 512);
        assert_eq!(unwrapped.notes, [UnwrapNote::Overlap(0, 2)]);
        assert_eq!(all_triangles(&unwrapped).len(), 12);
        mesh.uv1 = vec![Vec2::ONE; mesh.positions.len()];
        let unwrapped = unwrap(0, &surface(&mesh), 8.0, 512);
        assert_eq!(unwrapped.notes, [UnwrapNote::Degenerate(0)]);
        assert_eq!(all_triangles(&unwrapped).len(), 12);
    }

    /// Coordinates with too few texels along one axis are not used, whether they are stretched or sheared. Up to 4 times as long
    /// along one axis as along the other, they are.
    #[test]
    fn stretched_coordinates_are_named_and_a_new_set_is_used() {
        let stretched = |along: Vec2, across: Vec2| {
            let mut mesh = MeshData::plane(2.0);
            let place = |p: &Vec3| (along * p.x + across * p.z) * 0.1 + 0.5;
            mesh.uv1 = mesh.positions.iter().map(place).collect();
            let unwrapped = unwrap(0, &surface(&mesh), 8.0, 512);
            assert!(all_triangles(&unwrapped).len() == 2 && unwrapped.charts.len() == 1);
            (unwrapped.charts[0].size, unwrapped.notes)
        };
        // Padding is 2 texels on each side.
        let size = glam::UVec2::splat(32 + 4);
        for (along, across) in [
            (Vec2::X, Vec2::Y * 4.2),
            (Vec2::X * 250.0, Vec2::Y),
            (Vec2::X, Vec2::new(3.0, 1.0)),
        ] {
            let (new, notes) = stretched(along, across);
            assert!(
                matches!(notes[..], [UnwrapNote::Stretched(_)]),
                "{along} {across}: {notes:?}"
            );
            assert!(
                new.cmpge(size).all() && new.element_product() < 2 * size.element_product(),
                "{new}"
            );
        }
        let (kept, notes) = stretched(Vec2::X, Vec2::Y * 3.8);
        assert!(notes.is_empty() && kept.y > 3 * kept.x, "{kept} {notes:?}");
    }

    #[test]
    fn large_grounds_are_laid_flat_at_any_density() {
        let surface = surface(&MeshData::plane(256.0));
        let unwrapped = unwrap(0, &surface, 64.0, 4096);
        assert_eq!((unwrapped.notes.len(), unwrapped.charts.len()), (0, 1));
        assert!(unwrapped.charts[0].coarser.is_some());
    }

    #[test]
    fn slivers_have_charts_too() {
        // A fan whose triangles become thinner and thinner.
        let mut positions = vec![Vec3::ZERO];
        positions.extend((0..14).map(|i| Vec3::new(0.5f32.powi(i), 0.0, 1.0)));
        let indices = (1..14).flat_map(|i| [0, i, i + 1]).collect();
        let mesh = MeshData::from_triangles("fan", positions, indices);
        let surface = surface(&mesh);
        let unwrapped = unwrap(0, &surface, 8.0, 512);
        assert_eq!(unwrapped.notes, []);
        assert_eq!(all_triangles(&unwrapped), (0..13).collect::<Vec<u32>>());
    }

    #[test]
    fn triangles_that_cannot_be_laid_flat_are_counted() {
        let mesh = MeshData::plane(1.0);
        let triangles = surface(&mesh).triangles;
        let mut flat = Flat {
            triangles: vec![None],
        };
        complete(&mut flat, &triangles[..1]);
        let charts = charts_of(0, &flat, 8.0, 512);
        let note = note_of_missing(&triangles, &charts);
        assert_eq!(note, Some(UnwrapNote::NoChart { count: 1, first: 1 }));
        flat.triangles.push(None);
        complete(&mut flat, &triangles);
        let charts = charts_of(0, &flat, 8.0, 512);
        assert_eq!((charts.len(), note_of_missing(&triangles, &charts)), (2, None));
    }

    #[test]
    fn triangles_without_area_are_left_out_and_counted() {
        let mut mesh = MeshData::plane(1.0);
        mesh.positions.push(Vec3::NAN);
        mesh.indices.extend([0, 1, 1, 0, 1, 4, 0, 1, 99]);
        mesh.submeshes[0].index_count = mesh.indices.len() as u32;
        let unwrapped = unwrap(0, &surface(&mesh), 8.0, 512);
        assert_eq!(unwrapped.notes, [UnwrapNote::NoArea { count: 3, first: 2 }]);
        assert_eq!(all_triangles(&unwrapped), [0, 1]);
        let nothing = MeshData::from_triangles("empty", Vec::new(), Vec::new());
        assert!(unwrap(0, &surface(&nothing), 8.0, 512).charts.is_empty());
    }

    #[test]
    fn single_triangles_keep_their_shape() {
        let surface = surface(&MeshData::icosphere(1.0, 0));
        let mut flat = Flat {
            triangles: vec![None; 20],
        };
        complete(&mut flat, &surface.triangles);
        let charts = charts_of(0, &flat, 8.0, 512);
        assert_eq!(charts.len(), 20);
        let notes = Vec::new();
        assert!(distortion(&surface, &Unwrapped { charts, notes }, 8.0) < 1.001);
    }
}

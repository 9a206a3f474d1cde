//! New sets of texture coordinates.
//!
//! They come from `uvunwrap`: charts grow within a cone of normals and are flattened by least squares conformal maps. Its
//! charts are packed by us, as the islands of existing coordinates are, because pages of maps also depend on how many
//! intervals charts need.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec2};
use uvunwrap::{Density, MeshInput, Options, Packing};

use super::chart::{Flat, FlatTriangle};
use super::surfaces::{SurfaceTriangle, area};

/// Largest ratio between areas on the page and in space within a chart of a new set. Density differs by its root.
const DISTORTION: f32 = 2.0;

/// Least area of a triangle in a new set, as a share of the area that it should have. Charts differ by less than
/// [`DISTORTION`].
const LEAST_FLAT: f64 = 1.0 / 64.0;

/// Least number of a corner of a triangle that is a chart of its own. It is larger than those of the new set.
const SINGLE: u32 = 1 << 30;

/// Texels along each side of a square as large as a surface, as `uvunwrap` lays it flat. Any number gives the same charts.
const SIDE: f64 = 1024.0;

/// The surface by a new set of texture coordinates.
pub(super) fn by_new_set(triangles: &[Option<SurfaceTriangle>]) -> Result<Flat, String> {
    let corners = || triangles.iter().flatten().flat_map(|triangle| triangle.corners);
    let Some(origin) = corners().next() else {
        return Ok(Flat {
            triangles: vec![None; triangles.len()],
        });
    };
    // Near its own origin a surface far from the world's has exact positions in `f32`, too. Corners at one place are one
    // vertex, so that triangles that share an edge may share a chart.
    let (mut positions, mut known) = (Vec::new(), HashMap::new());
    let vertex = |corner: DVec3| {
        let position = (corner - origin).as_vec3() + 0.0;
        *known
            .entry(position.to_array().map(f32::to_bits))
            .or_insert_with(|| {
                positions.push(position.to_array());
                positions.len() as u32 - 1
            })
    };
    let indices: Vec<u32> = corners().map(vertex).collect();
    // Charts are scaled to their density later. The library refuses more texels than it can count.
    let all_area: f64 = triangles.iter().flatten().map(area).sum();
    let density = SIDE / all_area.sqrt();
    let options = Options {
        density: Density::Fixed {
            texels_per_unit: density as f32,
            page_size: None,
        },
        max_area_distortion: DISTORTION,
        padding: 0,
        packing: Packing::Fast,
        ..Options::default()
    };
    let atlas = uvunwrap::generate(&[MeshInput::new(&positions, &indices)], &options)
        .map_err(|error| error.to_string())?;
    let size = DVec2::new(f64::from(atlas.width), f64::from(atlas.height));
    let mesh = atlas.meshes.first().ok_or("it gave no mesh")?;
    let mut of_triangles = mesh.indices.chunks_exact(3);
    let flat = |triangle: &Option<SurfaceTriangle>| {
        let triangle = triangle.as_ref()?;
        let ids: [u32; 3] = of_triangles.next()?.try_into().ok()?;
        let vertex = |id: u32| mesh.vertices.get(id as usize);
        let charts = ids.map(|id| vertex(id).and_then(|vertex| vertex.chart));
        let corner =
            |id: u32| vertex(id).map_or(DVec2::ZERO, |vertex| Vec2::from(vertex.uv).as_dvec2() * size);
        let corners = ids.map(corner);
        let [a, b, c] = corners;
        let area = area(triangle);
        // The library collapses triangles that it finds degenerate onto corners of others.
        let is_flat = 0.5 * (b - a).perp_dot(c - a) > LEAST_FLAT * area * density * density;
        (is_flat && charts == [charts[0]?; 3].map(Some)).then_some(FlatTriangle {
            corners,
            ids,
            normal: triangle.normal,
            area,
        })
    };
    Ok(Flat {
        triangles: triangles.iter().map(flat).collect(),
    })
}

/// Gives every triangle that is in no chart yet a chart of its own. `uvunwrap` leaves out slivers.
pub(super) fn complete(flat: &mut Flat, triangles: &[Option<SurfaceTriangle>]) {
    let single = |(index, triangle): (usize, &Option<SurfaceTriangle>)| {
        let triangle = triangle.as_ref()?;
        let [a, b, c] = triangle.corners;
        let along = (b - a).normalize_or_zero();
        let across = (b - a).cross(c - a).cross(along).normalize_or_zero();
        let first = SINGLE + 3 * index as u32;
        Some(FlatTriangle {
            corners: [a, b, c].map(|corner| DVec2::new((corner - a).dot(along), (corner - a).dot(across))),
            ids: [first, first + 1, first + 2],
            normal: triangle.normal,
            area: area(triangle),
        })
    };
    for (flat, triangle) in flat.triangles.iter_mut().zip(triangles.iter().enumerate()) {
        if flat.is_none() {
            *flat = single(triangle);
        }
    }
}

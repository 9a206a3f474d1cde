//! The shader's constants of a light's map, including the tolerances of its depth comparison.

use glam::DVec3;

use super::gpu_types::{MapFace, MapLight};
use crate::techniques::maps::face::{FaceProjection, MapFace as Face};
use crate::techniques::maps::light_map::LightMap;
use crate::techniques::maps::packing::{FOUR_BYTES_STEP, TWO_BYTES_STEP};
use crate::techniques::maps::request::MapShape;
use crate::techniques::maps::settings::{Cascades, MapBias, MapFilter, MapFormat};

/// Share of a texel by which a plane is raised; half of it is added for each texel of the filter's radius. It
/// is enough for surfaces that bend by some 8° between neighbouring texels, and too little to separate a
/// shadow from its caster. Found by `tests/gpu/maps/contacts.rs`.
const RAISED_TEXELS: f32 = 0.15;

/// Rounding of the depth that a rasterizer stores, as a share, for each texel along the side of a picture.
///
/// A driver that clips triangles at the border of the picture leaves slivers as long as the picture. The equation of their
/// plane, and with it depth, rounds as often as they are longer than wide, and one that is narrower than a texel covers
/// hardly any. Where texels are as large as those of a uniform map, the share of a texel by which planes are raised is
/// more than that; faces with a matrix have much smaller ones near the eye.
const SLIVER: f32 = 1.0 / (1 << 24) as f32;

/// Makes the shader's constants of one light's map.
pub fn map_constants(map: &LightMap, eye: DVec3, depth_bounds: (f32, f32)) -> MapLight {
    let request = &map.request;
    let mut constants = MapLight::default();
    let mut radius_texels: f32 = 0.0;
    let softness = request.filter.softness().unwrap_or(0.0);
    for (out, state) in constants.faces.iter_mut().zip(&map.faces) {
        *out = face_constants(&state.face, map.resolution, eye);
        let texel = out.projection[2];
        if texel > 0.0 {
            radius_texels = radius_texels.max(softness / texel);
        }
    }
    if matches!(request.filter, MapFilter::Brute4x4 | MapFilter::Dithered4) {
        radius_texels = 2.0;
    }
    let (raised, metres, share) = match request.bias {
        MapBias::Auto => {
            let raised = RAISED_TEXELS * (1.0 + 0.5 * radius_texels);
            (raised, map.rounding as f32, 0.0)
        }
        MapBias::Manual {
            normal_texels,
            depth_metres,
            distance_share,
        } => (normal_texels, depth_metres, distance_share),
    };
    let squared = |share: f32| 1.0 - (1.0 - share) * (1.0 - share);
    // Both sides of the comparison round a few times in `f32`. Squares double the relative error.
    let parallel = request.shape == MapShape::Cascades;
    let is_sun = map.faces.first().is_some_and(|state| {
        matches!(
            state.face.projection,
            FaceProjection::Matrix { parallel: true, .. }
        )
    });
    let sliver = match request.shape {
        MapShape::Matrices => SLIVER * map.resolution as f32,
        MapShape::Spot | MapShape::Cube | MapShape::Cascades => 0.0,
    };
    let (relative, absolute) = match request.format {
        MapFormat::Depth if is_sun => (4e-6 + sliver, 0.0),
        MapFormat::Depth if parallel => (0.0, 2e-6),
        // Depth is proportional to 1 / distance.
        MapFormat::Depth => (4e-6 + sliver + share / (1.0 - share), 0.0),
        MapFormat::R32Float => (8e-6 + squared(share), 0.0),
        MapFormat::Rgba8TwoBytes => (8e-6 + squared(share), TWO_BYTES_STEP),
        MapFormat::Rgba8FourBytes => (8e-6 + squared(share), FOUR_BYTES_STEP),
    };
    let resolution = map.resolution as f32;
    constants.size = [resolution, resolution.recip(), softness, map.faces.len() as f32];
    constants.bias = [raised, relative, absolute, metres];
    let scale = match request.beside {
        Some(beside) if parallel => beside.drop,
        _ => (map.reach * map.reach).recip() as f32,
    };
    constants.limits = [depth_bounds.0, depth_bounds.1, scale, request.cascades.blend];
    constants.ending = NO_END;
    constants
}

/// [`MapLight::ending`] of shadows that end nowhere.
const NO_END: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Shortest length, metres, over which shadows fade out before the depth at which they end.
const SHORTEST_FADE: f64 = 1e-6;

/// Returns [`MapLight::ending`] of a directional light's cascades in a view that looks along `forward`.
pub fn ending(cascades: &Cascades, forward: DVec3) -> [f32; 4] {
    let distance = f64::from(cascades.distance);
    if !distance.is_finite() {
        return NO_END;
    }
    let fade = (f64::from(cascades.blend) * distance).max(SHORTEST_FADE);
    (forward.normalize() / fade)
        .extend(distance / fade)
        .as_vec4()
        .to_array()
}

/// Makes the shader's constants of one face.
fn face_constants(face: &Face, resolution: u32, eye: DVec3) -> MapFace {
    let [x, y, z] = face.rows_from_relative(eye);
    let texel = face.texel_metres(resolution) as f32;
    let mut constants = MapFace {
        row_x: x.to_array(),
        row_y: y.to_array(),
        row_z: z.to_array(),
        ..Default::default()
    };
    match face.projection {
        FaceProjection::Perspective { tangent, near } => {
            constants.projection = [tangent as f32, near as f32, texel, 0.0];
        }
        FaceProjection::Parallel { half, length } => {
            constants.projection = [half as f32, length as f32, texel, 0.0];
        }
        FaceProjection::Matrix { parallel, .. } => {
            let clip = face.clip_from_relative(eye);
            let mut inverse = clip.inverse();
            if parallel {
                inverse.z_axis.w = 0.0; // up to rounding it is
            }
            constants.clip_from_relative = clip.as_mat4().to_cols_array_2d();
            constants.relative_from_clip = inverse.as_mat4().to_cols_array_2d();
        }
    }
    constants
}

//! The faces that a light's map should have, and the casters that each should show.

use fixedbitset::FixedBitSet;
use glam::{DVec3, Vec3};
use smallvec::SmallVec;

use super::cascades::{even_splits, fit, split_depths};
use super::cube::{GUARD_TEXELS, cube_faces, faces_of_cone};
use super::face::{FaceProjection, MapFace};
use super::frame_scene::Scene;
use super::light_map::LightMap;
use super::movers::Movers;
use super::request::{Beside, MapFaces, MapShape};
use super::settings::MapFilter;
use super::spot::spot_face;
use crate::conventions::LIGHT_CLEARANCE;
use crate::geometry::Aabb;
use crate::sets::{FrameLight, LightVolume, Objects};

/// Fills the casters of a light's map: all that the light reaches if the map is kept, else the set S. Returns
/// whether they changed.
pub fn fill_casters(casters: &mut FixedBitSet, objects: &Objects, light: &FrameLight, kept: bool) -> bool {
    let mut changed = casters.len() != objects.len();
    if changed {
        *casters = FixedBitSet::with_capacity(objects.len());
    }
    let words = casters.as_mut_slice();
    for (word, bits) in words.iter_mut().enumerate() {
        let members = if kept {
            let reached = light.sets.l.as_slice()[word] & objects.casters.as_slice()[word];
            light.casting(objects, word, reached)
        } else {
            light.sets.s.as_slice()[word]
        };
        changed |= *bits != members;
        *bits = members;
    }
    changed
}

/// Ratio between a light's range and the distance of its casters beyond which the casters count. Formats that pack distances
/// have steps in proportion to the square of what they hold.
const FAR_RANGE: f64 = 4.0;

/// Returns the distance from the light, metres, within which all casters are: the range or, without one or where it is far
/// beyond all casters, a distance rounded up to a power of two so that it does not follow every move.
pub fn farthest(light: &FrameLight, casters: impl Iterator<Item = usize>, objects: &Objects) -> f64 {
    if light.point_world.w == 0.0 {
        return 1.0;
    }
    let point = light.point_world.truncate();
    let mut farthest: f64 = 1e-3;
    for index in casters {
        let (center, half) = objects.boxes.center_half(index);
        farthest = farthest.max(((center - point).abs() + half).length());
    }
    let farthest = farthest.log2().ceil().exp2();
    let range = f64::from(light.light.range);
    if light.volume != LightVolume::Infinite && range <= FAR_RANGE * farthest {
        range
    } else {
        farthest
    }
}

/// Where the near plane of a light's map may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearPlane {
    /// Distance of the near plane, metres.
    pub metres: f64,
    /// Distance, metres, up to which no caster is but such as the light may be on; at least [`NearPlane::metres`].
    pub most: f64,
}

/// Share of the reach at which the near plane is where no caster is near. Reversed depth in floating point loses nothing by
/// a near plane close to the light.
const NEAR_SHARE: f64 = 0.25 * LIGHT_CLEARANCE as f64;

/// Least distance of the near plane, as a share of that where no caster is near.
const LEAST_NEAR: f64 = 1e-6;

/// Returns the distance of the near plane: the light's [clearance](FrameLight::clearance) where it may be on a surface, or
/// else nearer than any caster.
///
/// A light may be on a surface of each caster whose box it touches. Elsewhere the result is a share of the reach or, where
/// that is too much, as many halves of it as needed: reversed depth in floating point then changes by a power of two,
/// without any rounding, and a map shows the same.
pub fn near_plane(
    light: &FrameLight,
    casters: impl Iterator<Item = usize>,
    objects: &Objects,
    reach: f64,
) -> NearPlane {
    let whole = NEAR_SHARE * reach;
    let point = light.point_world.truncate();
    let (mut touches, mut nearest) = (false, f64::INFINITY);
    for index in casters {
        let (center, half) = objects.boxes.center_half(index);
        let offset = (center - point).abs();
        let distance = (offset - half).max(DVec3::ZERO).length();
        if distance <= light.clearance {
            touches = true;
        } else {
            nearest = nearest.min(0.5 * distance);
        }
    }
    let least = LEAST_NEAR * whole; // a perspective needs some near plane
    if touches {
        let metres = light.clearance.max(least);
        let most = nearest.max(metres);
        return NearPlane { metres, most };
    }
    let metres = whole * (nearest.max(least) / whole).log2().floor().min(0.0).exp2();
    NearPlane { metres, most: metres }
}

/// Distance, metres, within which corners of casters are placed exactly enough.
const NEAR_CORNERS: f64 = 1e3;

/// Rounding of a depth in `f32`, metres for each metre to the farthest corner of the triangle.
const CORNER_ROUNDING: f64 = 1.0 / (1 << 23) as f64;

/// Largest rounding, metres, that the comparison allows for. A sky of 300 km rounds no worse than that near its middle,
/// and a shadow would begin too far behind its caster.
const MOST_ROUNDING: f64 = 3e-3;

/// Returns the error of depths near a place, metres, that corners of casters far away from it leave there: a rasterizer
/// cuts a triangle that reaches beyond the horizon at the border of the picture, and rounds as it does. It is 0 for
/// casters within a kilometre.
pub fn corner_rounding(place: DVec3, casters: impl Iterator<Item = usize>, objects: &Objects) -> f64 {
    let corner = |index: usize| {
        let (center, half) = objects.boxes.center_half(index);
        ((center - place).abs() + half).length()
    };
    let farthest = casters.map(corner).fold(0.0, f64::max);
    ((farthest - NEAR_CORNERS).max(0.0) * CORNER_ROUNDING).min(MOST_ROUNDING)
}

/// Returns the faces that the map should have.
pub fn expected_faces(map: &LightMap, light: &FrameLight, scene: &Scene) -> MapFaces {
    let origin = light.point_world.truncate();
    let near = map.near;
    match map.request.shape {
        MapShape::Spot => spot_face(light, map.request.filter, near, map.resolution)
            .into_iter()
            .collect(),
        MapShape::Cube => cube_faces(origin, near, map.resolution).into_iter().collect(),
        MapShape::Cascades => cascade_faces(map, light, scene),
        MapShape::Matrices => {
            let taps = match map.request.filter {
                MapFilter::Brute4x4 | MapFilter::Dithered4 => 2,
                MapFilter::Bilinear | MapFilter::Jittered { .. } | MapFilter::Soft4 { .. } => 0,
            };
            let resolution = f64::from(map.resolution);
            let guard = f64::from(GUARD_TEXELS + taps).min(0.25 * resolution);
            let inside = (resolution - 2.0 * guard) / resolution;
            let faces = map.handed_over.iter().take(map.request.layers as usize);
            faces.map(|face| face.with_border(inside)).collect()
        }
    }
}

fn cascade_faces(map: &LightMap, light: &FrameLight, scene: &Scene) -> SmallVec<[MapFace; 6]> {
    let cascades = &map.request.cascades;
    let range = &map.range;
    let splits = if scene.view.is_orthographic() {
        even_splits(cascades, range)
    } else {
        split_depths(cascades, range)
    };
    let softness = f64::from(map.request.filter.softness().unwrap_or(0.0));
    let boxes = &scene.objects.boxes;
    let towards = light.point_world.truncate();
    let nearest_caster = |face: &MapFace| {
        let z: DVec3 = face.axes[2];
        let seen = map_casters(map).filter(|&index| face.may_see(&boxes.get(index)));
        let nearest = seen.map(|index| {
            let (center, half) = boxes.center_half(index);
            z.dot(center) - z.abs().dot(half)
        });
        nearest.reduce(f64::min)
    };
    (0..cascades.count as usize)
        .map(|i| {
            let depths = (splits[i], splits[i + 1]);
            fit(
                scene.view,
                towards,
                depths,
                map.resolution,
                softness,
                nearest_caster,
            )
        })
        .collect()
}

fn map_casters(map: &LightMap) -> impl Iterator<Item = usize> + '_ {
    map.casters().ones()
}

/// Returns the bounds of everything that a picture beside the depth shows of a caster.
fn reached(bounds: Aabb, beside: &Beside, face: &MapFace) -> Aabb {
    let mut margin = f64::from(beside.metres);
    if matches!(face.projection, FaceProjection::Perspective { .. }) {
        let farthest = (bounds.center().as_dvec3() - face.origin).abs() + bounds.half_size().as_dvec3();
        margin += f64::from(beside.share) * farthest.length();
    }
    let margin = Vec3::splat(margin as f32);
    Aabb {
        min: bounds.min - margin,
        max: bounds.max + margin,
    }
}

/// Divides a light's casters that a face shows into those that stand still and those that move. Without
/// `movers` all count as moving. Both sets are empty if the light does not shine into the face.
pub fn split_members(
    casters: &FixedBitSet,
    beside: Option<&Beside>,
    face: &MapFace,
    objects: &Objects,
    lit: bool,
    movers: Option<&Movers>,
    still: &mut FixedBitSet,
    moving: &mut FixedBitSet,
) {
    for set in [&mut *still, &mut *moving] {
        if set.len() == casters.len() {
            set.clear();
        } else {
            *set = FixedBitSet::with_capacity(casters.len());
        }
    }
    for index in casters.ones() {
        let bounds = objects.boxes.get(index);
        let bounds = match beside {
            Some(beside) if !bounds.is_empty() => reached(bounds, beside, face),
            _ => bounds,
        };
        if lit && face.may_see(&bounds) {
            match movers {
                Some(movers) if !movers.moving.contains(index) => still.insert(index),
                _ => moving.insert(index),
            }
        }
    }
}

/// Returns the faces of a cube into which a light can shine; all faces for a light that shines everywhere.
pub fn lit_faces(light: &FrameLight) -> [bool; 6] {
    match &light.volume {
        LightVolume::Cone(cone) | LightVolume::HalfBall(cone) => faces_of_cone(cone),
        LightVolume::Ball(_) | LightVolume::Infinite => [true; 6],
    }
}

//! Twin of the lookup of an omnidirectional map (`shaders/techniques/maps/resolve.wgsl`) on the CPU, for each filter, format
//! and surface. Its map is ray cast, so it shares nothing with the renderer but the constants of the light.
//!
//! It does not know creases: its scenes have none.

use std::cell::RefCell;
use std::collections::HashMap;

use antumbra::insides::gpu_types::MapLight;
use antumbra::insides::{pack_four_bytes, pack_two_bytes, unpack_four_bytes, unpack_two_bytes};
use antumbra::reference::{Ray, RayScene, SurfaceHit};
use antumbra::techniques::maps::{FaceProjection, LightMap, MapFilter, MapFormat, MapSurface};
use glam::{DVec2, DVec3, IVec2, UVec2};

/// Texels of depth, per texel sideways, by which a plane may recede: `STEEPEST` of the shader.
const STEEPEST: f64 = 32.0;

/// Rounding of positions: `ROUNDING` of the shader.
const ROUNDING: f64 = 2e-6;

/// What the twin believes the map to be. Each part can be made wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// The filter.
    pub filter: MapFilter,
    /// The format of a texel.
    pub format: MapFormat,
    /// The surface that a texel holds.
    pub surface: MapSurface,
    /// Whether the jittered disc differs from pixel to pixel.
    pub turns: bool,
}

/// A map that is ray cast when it is looked up.
pub struct Twin<'a> {
    /// The scene of the frame.
    pub scene: &'a RayScene,
    /// The map of the light.
    pub map: &'a LightMap,
    /// The shader's constants of the map.
    pub constants: MapLight,
    /// Position of the camera.
    pub eye: DVec3,
    /// Depths along the axis of the face by face and texel: the first and the second surface.
    seen: RefCell<HashMap<(usize, IVec2), [f64; 2]>>,
}

struct Site {
    face: usize,
    ndc: DVec2,
    along: f64,
    normal: DVec3,
    offset: f64,
}

impl<'a> Twin<'a> {
    /// Makes the twin of a map.
    pub fn new(scene: &'a RayScene, map: &'a LightMap, constants: MapLight, eye: DVec3) -> Self {
        Self {
            scene,
            map,
            constants,
            eye,
            seen: RefCell::default(),
        }
    }

    /// Visibility of a pixel's surface, and the number of taps.
    pub fn visibility(&self, hit: &SurfaceHit, pixel: UVec2, belief: &Belief) -> (f64, u32) {
        let offset_world = hit.position - self.map.faces[0].face.origin;
        let face = cube_face(offset_world);
        let position = self.in_face(face, offset_world);
        let mut offset = hit.normal.dot(offset_world);
        if offset >= 0.0 {
            return (0.0, 0);
        }
        let (tangent, near, texel) = self.projection(face);
        if position.z <= near {
            return (1.0, 0);
        }
        let [normal_texels, _, _, metres] = self.constants.bias.map(f64::from);
        let distance = position.length();
        let raise = normal_texels * texel * position.z
            + metres * (-offset / distance)
            + ROUNDING * ((hit.position - self.eye).length() + distance);
        offset += raise.min(-0.5 * offset);
        let site = Site {
            face,
            ndc: position.truncate() / (position.z * tangent),
            along: position.z,
            normal: hit.normal,
            offset,
        };
        let mut taps = 0;
        let mut tap = |texels: DVec2| {
            taps += 1;
            self.tap(&site, texels, belief)
        };
        let visibility = filtered(&mut tap, self.constants.size[2] as f64 / texel, pixel, belief);
        (visibility, taps)
    }

    fn projection(&self, face: usize) -> (f64, f64, f64) {
        let state = &self.map.faces[face].face;
        let FaceProjection::Perspective { tangent, near } = state.projection else {
            panic!("faces of a cube are perspective");
        };
        (tangent, near, state.texel_metres(self.map.resolution))
    }

    fn in_face(&self, face: usize, vector: DVec3) -> DVec3 {
        let [x, y, z] = self.map.faces[face].face.axes;
        DVec3::new(x.dot(vector), y.dot(vector), z.dot(vector))
    }

    fn tap(&self, site: &Site, texels: DVec2, belief: &Belief) -> f64 {
        let size = f64::from(self.map.resolution);
        let ndc = site.ndc + texels * DVec2::new(2.0, -2.0) / size;
        let (tangent, _, _) = self.projection(site.face);
        let [x, y, z] = self.map.faces[site.face].face.axes;
        let direction = x * (ndc.x * tangent) + y * (ndc.y * tangent) + z;
        let face = cube_face(direction);
        let in_face = self.in_face(face, direction);
        self.tap_face(site, face, in_face.truncate() / (in_face.z * tangent), belief)
    }

    fn tap_face(&self, site: &Site, face: usize, ndc: DVec2, belief: &Belief) -> f64 {
        let (tangent, near, texel) = self.projection(face);
        let place = (ndc * DVec2::new(0.5, -0.5) + 0.5) * f64::from(self.map.resolution);
        let corner = place - 0.5;
        let between = corner - corner.floor();
        let first = corner.floor().as_ivec2();
        let weight = |at: IVec2| {
            let axis = |at: i32, between: f64| if at == 1 { between } else { 1.0 - between };
            axis(at.x, between.x) * axis(at.y, between.y)
        };
        let four = [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE];
        let [_, relative, absolute, _] = self.constants.bias.map(f64::from);
        if belief.format == MapFormat::Depth {
            let normal = self.in_face(face, site.normal);
            let scale = near / site.offset;
            let plane = normal.dot((ndc * tangent).extend(1.0)) * scale;
            let slope = DVec2::new(normal.x, -normal.y) * (texel * scale);
            let lenient = (slope * (1.0 - between)).max(-slope * between);
            let deepest = near / (site.along * (1.0 + STEEPEST * texel));
            let depth = (plane + lenient.x + lenient.y).max(deepest).max(0.0);
            let depth = depth * (1.0 + relative) + absolute;
            let lit = |at: &&IVec2| depth >= near / self.stored(face, first + **at, belief.surface);
            return four.iter().filter(lit).map(|at| weight(*at)).sum();
        }
        let single = matches!(belief.filter, MapFilter::Jittered { .. });
        if single {
            return f64::from(u8::from(self.is_lit(
                site,
                face,
                place.floor().as_ivec2(),
                belief,
            )));
        }
        let lit = |at: &&IVec2| self.is_lit(site, face, first + **at, belief);
        four.iter().filter(lit).map(|at| weight(*at)).sum()
    }

    fn direction(&self, face: usize, texel: IVec2) -> DVec3 {
        let (tangent, _, _) = self.projection(face);
        let share = (texel.as_dvec2() + 0.5) / f64::from(self.map.resolution);
        ((share * DVec2::new(2.0, -2.0) + DVec2::new(-1.0, 1.0)) * tangent).extend(1.0)
    }

    /// Comparison of the plane with a squared distance, as a format holds it.
    fn is_lit(&self, site: &Site, face: usize, texel: IVec2, belief: &Belief) -> bool {
        let (_, _, texel_metres) = self.projection(face);
        let texel = texel.clamp(IVec2::ZERO, IVec2::splat(self.map.resolution as i32 - 1));
        let direction = self.direction(face, texel);
        let inverse_reach_sq = f64::from(self.constants.limits[2]);
        let share_of = |along: f64| along * along * direction.length_squared() * inverse_reach_sq;
        let towards = self.in_face(face, site.normal).dot(direction);
        let farthest = site.along * (1.0 + STEEPEST * texel_metres);
        let along = if towards < 0.0 {
            (site.offset / towards).min(farthest)
        } else {
            farthest
        };
        let stored = share_of(self.stored(face, texel, belief.surface)) as f32;
        let stored = match belief.format {
            MapFormat::Depth | MapFormat::R32Float => stored,
            MapFormat::Rgba8TwoBytes => unpack(pack_two_bytes(stored), unpack_two_bytes),
            MapFormat::Rgba8FourBytes => unpack(pack_four_bytes(stored), unpack_four_bytes),
        };
        let [_, relative, absolute, _] = self.constants.bias.map(f64::from);
        share_of(along) * (1.0 - relative) - absolute <= f64::from(stored)
    }

    /// Distance along the face's axis of the surface in a texel; infinite if there is none.
    fn stored(&self, face: usize, texel: IVec2, surface: MapSurface) -> f64 {
        let texel = texel.clamp(IVec2::ZERO, IVec2::splat(self.map.resolution as i32 - 1));
        let [first, second] = *self
            .seen
            .borrow_mut()
            .entry((face, texel))
            .or_insert_with(|| self.cast(face, texel));
        match surface {
            MapSurface::Nearest => first,
            MapSurface::Second if second.is_finite() => second,
            MapSurface::Midpoint if second.is_finite() => 0.5 * (first + second),
            MapSurface::Second | MapSurface::Midpoint => first,
        }
    }

    fn cast(&self, face: usize, texel: IVec2) -> [f64; 2] {
        let (_, near, _) = self.projection(face);
        let direction = self.direction(face, texel);
        let [x, y, z] = self.map.faces[face].face.axes;
        let ray = Ray {
            origin: self.map.faces[face].face.origin,
            direction: x * direction.x + y * direction.y + z,
        };
        let next = |from: f64| {
            let hit = self.scene.closest_hit(&ray, from, f64::INFINITY, |t| t.blocks);
            hit.map_or(f64::INFINITY, |hit| hit.t)
        };
        let first = next(near);
        [first, next(first * (1.0 + 1e-5))]
    }
}

fn unpack<const N: usize>(bytes: [u8; N], unpack: impl Fn([u8; N]) -> f32) -> f32 {
    if bytes[0] == 255 { 1e30 } else { unpack(bytes) }
}

fn cube_face(direction: DVec3) -> usize {
    let size = direction.abs();
    if size.x >= size.y && size.x >= size.z {
        usize::from(direction.x < 0.0)
    } else if size.y >= size.z {
        2 + usize::from(direction.y < 0.0)
    } else {
        4 + usize::from(direction.z < 0.0)
    }
}

fn filtered(tap: &mut impl FnMut(DVec2) -> f64, radius: f64, pixel: UVec2, belief: &Belief) -> f64 {
    match belief.filter {
        MapFilter::Bilinear => tap(DVec2::ZERO),
        MapFilter::Brute4x4 => {
            let mut sum = 0.0;
            for i in 0..16 {
                sum += tap(DVec2::new(f64::from(i % 4) - 1.5, f64::from(i / 4) - 1.5));
            }
            sum / 16.0
        }
        MapFilter::Dithered4 => {
            let odd = pixel & UVec2::ONE;
            let offset = UVec2::new(odd.x, odd.x ^ odd.y).as_dvec2();
            let corners = [(-1.5, 0.5), (0.5, 0.5), (-1.5, -1.5), (0.5, -1.5)];
            let sum: f64 = corners.iter().map(|&(x, y)| tap(offset + DVec2::new(x, y))).sum();
            0.25 * sum
        }
        MapFilter::Soft4 { .. } => {
            let a = DVec2::new(0.9239, 0.3827) * radius;
            let b = DVec2::new(-a.y, a.x);
            let sum: f64 = [a, -a, b, -b].into_iter().map(&mut *tap).sum();
            0.25 * sum
        }
        MapFilter::Jittered { adaptive, .. } => {
            let tile = if belief.turns { pixel % 16 } else { UVec2::ZERO };
            let disc = antumbra::insides::disc(tile.x, tile.y);
            let as_bytes = |x: f32| f64::from((x * 127.0).round()) / 127.0;
            let mut sum = 0.0;
            for (index, [x, y]) in disc.into_iter().enumerate() {
                if adaptive && index == 8 && (sum == 0.0 || sum == 8.0) {
                    return sum / 8.0;
                }
                sum += tap(DVec2::new(as_bytes(x), as_bytes(y)) * radius);
            }
            sum / 64.0
        }
    }
}

//! Bounds of all objects in flat arrays, and the tests that yield a word of a bitset at a time.

use glam::{DVec3, Vec3};
use wide::f32x8;

use crate::geometry::{Aabb, Cone, PlaneSet, Sphere};

/// Objects that one word of a bitset holds.
pub const WORD: usize = usize::BITS as usize;

const LANES: usize = 8;

/// Half size of a lane that holds no object: fails every test, and is far enough from overflow to stay finite there.
const ABSENT: f32 = -1e15;

/// Boxes as centres and half sizes, [padded](Aabb::padded) so that the `f32` tests here never exclude wrongly.
/// The arrays are filled up to whole words with lanes that fail every test.
#[derive(Clone, Debug, Default)]
pub struct Boxes {
    center: [Vec<f32>; 3],
    half: [Vec<f32>; 3],
    len: usize,
}

/// Eight boxes in registers.
struct Lanes {
    center: [f32x8; 3],
    half: [f32x8; 3],
}

impl Boxes {
    /// Number of boxes.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of bitset words that hold all boxes.
    pub fn words(&self) -> usize {
        self.len.div_ceil(WORD)
    }

    /// Makes all boxes absent, `len` of them; keeps the allocations.
    pub fn reset(&mut self, len: usize) {
        self.len = len;
        let lanes = len.div_ceil(WORD) * WORD;
        for (array, value) in self
            .center
            .iter_mut()
            .map(|array| (array, 0.0))
            .chain(self.half.iter_mut().map(|array| (array, ABSENT)))
        {
            array.clear();
            array.resize(lanes, value);
        }
    }

    /// Stores the padded box, or marks it absent if it is empty.
    pub fn set(&mut self, index: usize, aabb: &Aabb) {
        let (center, half) = if aabb.is_empty() {
            (Vec3::ZERO, Vec3::splat(ABSENT))
        } else {
            let padded = aabb.padded();
            (padded.center(), padded.half_size())
        };
        for axis in 0..3 {
            self.center[axis][index] = center[axis];
            self.half[axis][index] = half[axis];
        }
    }

    /// Centre and half size, in `f64`.
    pub fn center_half(&self, index: usize) -> (DVec3, DVec3) {
        let (center, half) = self.load(index);
        (center.as_dvec3(), half.as_dvec3())
    }

    /// The padded box; empty if absent.
    pub fn get(&self, index: usize) -> Aabb {
        let (center, half) = self.load(index);
        if half.x < 0.0 {
            return Aabb::EMPTY;
        }
        Aabb {
            min: center - half,
            max: center + half,
        }
    }

    #[inline]
    fn load(&self, index: usize) -> (Vec3, Vec3) {
        let [cx, cy, cz] = &self.center;
        let [hx, hy, hz] = &self.half;
        let center = Vec3::new(cx[index], cy[index], cz[index]);
        (center, Vec3::new(hx[index], hy[index], hz[index]))
    }

    /// Bits of the boxes of a word, among `candidates`, that no plane excludes.
    pub fn touching_planes(&self, word: usize, candidates: usize, volume: &PlaneSet) -> usize {
        self.test(word, candidates, |lanes| {
            let mut inside = u32::MAX;
            for plane in &volume.planes {
                let [nx, ny, nz] = plane.normal.to_array().map(f32x8::splat);
                let distance = lanes.center[0] * nx + lanes.center[1] * ny + lanes.center[2] * nz;
                let reach = lanes.half[0] * nx.abs() + lanes.half[1] * ny.abs() + lanes.half[2] * nz.abs();
                inside &= (distance + reach + f32x8::splat(plane.offset))
                    .simd_ge(f32x8::ZERO)
                    .to_bitmask();
                if inside == 0 {
                    break;
                }
            }
            inside
        })
    }

    /// Bits of the boxes of a word, among `candidates`, that share a point with the ball.
    ///
    /// Source: Arvo 1990, "A Simple Method for Box-Sphere Intersection Testing", Graphics Gems.
    pub fn touching_sphere(&self, word: usize, candidates: usize, ball: &Sphere) -> usize {
        let center = ball.center.to_array().map(f32x8::splat);
        // The boxes carry the rounding of the differences; the squares' own is relative.
        let radius_sq = f32x8::splat(ball.radius * ball.radius * (1.0 + 8.0 * f32::EPSILON));
        self.test(word, candidates, |lanes| {
            let mut distance_sq = f32x8::ZERO;
            for ((box_center, half), ball_center) in lanes.center.iter().zip(&lanes.half).zip(&center) {
                let beyond = (*box_center - *ball_center).abs() - *half;
                let beyond = beyond.fast_max(f32x8::ZERO);
                distance_sq += beyond * beyond;
            }
            distance_sq.simd_le(radius_sq).to_bitmask()
        })
    }

    /// Bits of the boxes of a word, among `candidates`, that may touch the cone: [`Cone::excludes_aabb`], eight at once.
    pub fn touching_cone(&self, word: usize, candidates: usize, cone: &Cone) -> usize {
        let ball = Sphere {
            center: cone.apex,
            radius: cone.range,
        };
        let candidates = if cone.range.is_finite() {
            self.touching_sphere(word, candidates, &ball)
        } else {
            candidates
        };
        let (x, y) = cone.axis.any_orthonormal_pair();
        let [axis, x, y] = [cone.axis, x, y].map(|v| v.to_array().map(f32x8::splat));
        let apex = cone.apex.to_array().map(f32x8::splat);
        let (sin, cos) = cone.half_angle.sin_cos();
        let (sin, cos) = (f32x8::splat(sin), f32x8::splat(cos));
        let dot = |a: &[f32x8; 3], b: &[f32x8; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        self.test(word, candidates, |lanes| {
            let to_center = [0, 1, 2].map(|i| lanes.center[i] - apex[i]);
            let size = to_center[0].abs() + to_center[1].abs() + to_center[2].abs();
            let slack = size * f32x8::splat(8.0 * f32::EPSILON);
            let along = dot(&to_center, &axis);
            let in_front = along + dot(&axis.map(f32x8::abs), &lanes.half) + slack;
            let (px, py) = (dot(&to_center, &x), dot(&to_center, &y));
            // On the axis any tangent plane will do: `px`, `py` are then far below the floor and the plane leans in.
            let length = (px * px + py * py).sqrt();
            let scale = cos / length.fast_max(f32x8::splat(1e-18));
            let normal = [0, 1, 2].map(|i| axis[i] * sin - (x[i] * px + y[i] * py) * scale);
            let beside = dot(&to_center, &normal) + dot(&normal.map(f32x8::abs), &lanes.half) + slack;
            in_front.simd_ge(f32x8::ZERO).to_bitmask() & beside.simd_ge(f32x8::ZERO).to_bitmask()
        })
    }

    fn test(&self, word: usize, candidates: usize, inside: impl Fn(&Lanes) -> u32) -> usize {
        let mut bits = 0;
        for group in 0..WORD / LANES {
            let shift = group * LANES;
            if (candidates >> shift) & 0xff == 0 {
                continue;
            }
            let first = word * WORD + shift;
            let load = |arrays: &[Vec<f32>; 3]| {
                [0, 1, 2].map(|axis| {
                    let mut lanes = [0.0; LANES];
                    lanes.copy_from_slice(&arrays[axis][first..first + LANES]);
                    f32x8::new(lanes)
                })
            };
            let lanes = Lanes {
                center: load(&self.center),
                half: load(&self.half),
            };
            bits |= ((inside(&lanes) & 0xff) as usize) << shift;
        }
        bits & candidates
    }
}

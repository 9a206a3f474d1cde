//! Visibility of a light at every pixel.

use glam::{DVec3, UVec2};
use rayon::prelude::*;

use super::error::ReferenceError;
use super::light_source::{LightShape, LightSource};
use super::primary::{HitImage, SurfaceHit};
use super::ray_scene::RayScene;
use super::sampling::{SplitMix, strata_per_side, stratified};
use super::suspects::Suspects;

/// Visibility of a light at every pixel: 1 where the surface sees the whole light, 0 where it sees none of
/// it, NaN where the pixel does not count.
#[derive(Clone, Debug)]
pub struct VisibilityImage {
    size: UVec2,
    values: Vec<f32>,
}

impl VisibilityImage {
    /// An image with the given values, for example those that a technique wrote.
    ///
    /// # Errors
    /// [`ReferenceError::ValueCount`] if the number of values does not fit the size.
    pub fn new(size: UVec2, values: Vec<f32>) -> Result<Self, ReferenceError> {
        if values.len() as u64 != u64::from(size.x) * u64::from(size.y) {
            return Err(ReferenceError::ValueCount {
                size,
                values: values.len(),
            });
        }
        Ok(Self { size, values })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// One value for each pixel, rows from the top.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Value of a pixel; `None` outside the image.
    pub fn get(&self, x: u32, y: u32) -> Option<f32> {
        (x < self.size.x && y < self.size.y)
            .then(|| self.values[y as usize * self.size.x as usize + x as usize])
    }

    /// Number of pixels that count.
    pub fn counted(&self) -> usize {
        self.values.iter().filter(|value| !value.is_nan()).count()
    }
}

/// Visibility of the light's centre, by one ray for each pixel: 0 or 1. It is NaN where the pixel does not
/// count: where it shows no surface, or a surface that the light does not select or does not reach
/// ([`LightSource::reaches`]).
pub fn hard_visibility(scene: &RayScene, hits: &HitImage, light: &LightSource) -> VisibilityImage {
    let point = match light.shape {
        LightShape::Rect { center, .. } | LightShape::Sphere { center, .. } => {
            LightShape::Point { position: center }
        }
        shape => shape,
    };
    let point = LightSource {
        shape: point,
        ..*light
    };
    let clearance = clearance_of(scene, &point);
    per_pixel(scene, hits, light, |_, hit| {
        sampled_visibility(scene, hit, &point, clearance, 1, SplitMix::new(0, 0))
    })
}

/// Visible fraction of the light, by about `samples` rays for each pixel: one at random in each stratum of a
/// square grid. Lights that are points get one ray. Pixels that do not count are NaN, as in
/// [`hard_visibility`].
///
/// Higher `samples` reduce noise and cost time in proportion. Pixels draw their samples independently; the
/// samples of a pixel depend only on `seed` and the pixel's index.
pub fn soft_visibility(
    scene: &RayScene,
    hits: &HitImage,
    light: &LightSource,
    samples: u32,
    seed: u64,
) -> VisibilityImage {
    let clearance = clearance_of(scene, light);
    let side = strata_per_side(samples);
    per_pixel(scene, hits, light, |index, hit| {
        let random = SplitMix::new(seed, index as u64);
        sampled_visibility(scene, hit, light, clearance, side, random)
    })
}

/// Visible fraction of the light from one surface point, whether or not the point counts. `stream`
/// distinguishes points that share a seed.
pub fn soft_visibility_at(
    scene: &RayScene,
    hit: &SurfaceHit,
    light: &LightSource,
    samples: u32,
    seed: u64,
    stream: u64,
) -> f32 {
    let side = strata_per_side(samples);
    let random = SplitMix::new(seed, stream);
    sampled_visibility(scene, hit, light, clearance_of(scene, light), side, random)
}

/// Distance from the light's centre within which triangles do not block it, metres; 0 for a directional light.
fn clearance_of(scene: &RayScene, light: &LightSource) -> f64 {
    let position = match light.shape {
        LightShape::Directional { .. } => return 0.0,
        LightShape::Point { position } | LightShape::Spot { position, .. } => position,
        LightShape::Rect { center, .. } | LightShape::Sphere { center, .. } => center,
    };
    scene.clearance(position, light.range, light.selection.casts_for)
}

/// Evaluates the pixels that count. Surfaces that show no shadows of the light see the whole light.
fn per_pixel(
    scene: &RayScene,
    image: &HitImage,
    light: &LightSource,
    visibility: impl Fn(usize, &SurfaceHit) -> f32 + Sync,
) -> VisibilityImage {
    let value = |(index, hit): (usize, &Option<SurfaceHit>)| {
        let Some(hit) = hit else { return f32::NAN };
        let Some(triangle) = scene.triangles().get(hit.triangle as usize) else {
            return f32::NAN;
        };
        if triangle.layers & light.selection.affects == 0 || !light.reaches(hit) {
            f32::NAN
        } else if !triangle.receives || triangle.layers & light.selection.shows_on == 0 {
            1.0
        } else {
            visibility(index, hit)
        }
    };
    VisibilityImage {
        size: image.size,
        values: image.hits.par_iter().enumerate().map(value).collect(),
    }
}

/// Share of the samples that are visible from the surface point. Samples on or below its horizon are not
/// visible.
fn sampled_visibility(
    scene: &RayScene,
    hit: &SurfaceHit,
    light: &LightSource,
    clearance: f64,
    side: u32,
    random: SplitMix,
) -> f32 {
    let receiver = Some(hit.triangle);
    let casts_for = light.selection.casts_for;
    let mut suspects = Suspects::Many;
    if let Some(ends) = light.shape.bounds().filter(|_| side > 1) {
        suspects = scene.suspects(hit.position, ends, receiver, casts_for);
        // Most pixels see all of the light, and need no samples.
        if suspects.is_empty() && is_above_horizon(hit, ends) {
            return 1.0;
        }
    }
    // The blocker of one sample is likely to block the next.
    let mut last_blocker = None;
    let mut sees = |sample: DVec3| {
        if !(hit.normal.dot(sample - hit.position) > 0.0) {
            return false;
        }
        let (from, guess) = (hit.position, last_blocker);
        let blocker = scene.blocker_among(&suspects, from, sample, clearance, receiver, casts_for, guess);
        last_blocker = blocker.or(guess);
        blocker.is_none()
    };
    match light.shape {
        LightShape::Directional { towards } => {
            let seen = hit.normal.dot(towards) > 0.0
                && !scene.blocks_direction(hit.position, towards, receiver, casts_for);
            f32::from(u8::from(seen))
        }
        LightShape::Point { position } | LightShape::Spot { position, .. } => {
            f32::from(u8::from(sees(position)))
        }
        LightShape::Rect {
            center,
            half_right,
            half_up,
            ..
        } => share_seen(side, random, |[u, v]| {
            sees(center + half_right * (2.0 * u - 1.0) + half_up * (2.0 * v - 1.0))
        }),
        LightShape::Sphere { center, radius } => {
            let towards = (center - hit.position).normalize_or(hit.normal);
            let (right, up) = towards.any_orthonormal_pair();
            share_seen(side, random, |[u, v]| {
                // The square root gives the strata equal areas.
                let (sin, cos) = (v * std::f64::consts::TAU).sin_cos();
                sees(center + (right * cos + up * sin) * (u.sqrt() * radius))
            })
        }
    }
}

/// Share of the samples of the unit square for which `sees` returns true.
fn share_seen(side: u32, random: SplitMix, mut sees: impl FnMut([f64; 2]) -> bool) -> f32 {
    let mut seen = 0;
    for sample in stratified(side, random) {
        seen += u32::from(sees(sample));
    }
    (f64::from(seen) / (f64::from(side) * f64::from(side))) as f32
}

/// Whether all of a box, given by its smallest and largest corner, is above the tangent plane of the surface, by more than
/// the rounding of a sample. The margin is some million times the rounding of `f64`, so a sample near the plane is always drawn.
fn is_above_horizon(hit: &SurfaceHit, [low, high]: [DVec3; 2]) -> bool {
    let (center, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let least = hit.normal.dot(center - hit.position) - hit.normal.abs().dot(half);
    least > 1e-9 * (center - hit.position).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::bvh::random::point;
    use crate::scene::LightSelection;
    use proptest::prelude::*;

    proptest! {
        /// The share of a rectangle that is seen is that of samples which are all drawn and searched for, whether something
        /// may block it or nothing, above the surface's horizon, below and across.
        #[test]
        fn shortcuts_change_no_share(
            triangles in prop::collection::vec([point(2.0), point(1.0), point(1.0)], 0..6),
            surface in point(1.0),
            normal in point(1.0),
            center in point(4.0),
            half in 0.01..1.5,
        ) {
            prop_assume!(normal.length() > 0.1);
            let corners = triangles.iter().map(|[a, b, c]| [*a, *a + *b, *a + *c]);
            let scene = RayScene::from_triangles(corners);
            let hit = SurfaceHit {
                position: surface,
                normal: normal.normalize(),
                triangle: u32::MAX,
                distance: 1.0,
                view_depth: 1.0,
            };
            let (half_right, half_up) = (DVec3::new(half, 0.0, 0.1), DVec3::new(0.0, 0.3 * half, 0.0));
            let light = LightSource {
                shape: LightShape::Rect { center, half_right, half_up, direction: DVec3::NEG_Z },
                range: f64::INFINITY,
                selection: LightSelection::default(),
            };
            let random = SplitMix::new(1, 2);
            let got = sampled_visibility(&scene, &hit, &light, 1e-4, 4, random.clone());
            let seen = stratified(4, random).filter(|[u, v]| {
                let sample = center + half_right * (2.0 * u - 1.0) + half_up * (2.0 * v - 1.0);
                let casts_for = light.selection.casts_for;
                hit.normal.dot(sample - surface) > 0.0
                    && scene.segment_blocker(surface, sample, 1e-4, None, casts_for, None).is_none()
            });
            prop_assert_eq!(got, seen.count() as f32 / 16.0);
        }

        /// Looking once for the triangles that may block a pixel's rays gives what a search for each ray gives, for few triangles
        /// and for many.
        #[test]
        fn one_search_sees_what_a_search_for_each_ray_sees(
            triangles in prop::collection::vec([point(2.0), point(1.0), point(1.0)], 0..80),
            surface in point(1.0),
            center in point(4.0),
            half in 0.01..1.5,
            is_sphere in any::<bool>(),
        ) {
            let corners = triangles.iter().map(|[a, b, c]| [*a, *a + *b, *a + *c]);
            let scene = RayScene::from_triangles(corners);
            let shape = if is_sphere {
                LightShape::Sphere { center, radius: half }
            } else {
                LightShape::Rect {
                    center,
                    half_right: DVec3::new(half, 0.0, 0.1),
                    half_up: DVec3::new(0.0, 0.3 * half, 0.0),
                    direction: DVec3::NEG_Z,
                }
            };
            let Some([low, high]) = shape.bounds() else { unreachable!() };
            let selection = LightSelection::default();
            let suspects = scene.suspects(surface, [low, high], None, selection.casts_for);
            for [u, v] in stratified(4, SplitMix::new(1, 2)) {
                let sample = low + (high - low) * DVec3::new(u, v, u * v);
                let searched = scene.segment_blocker(surface, sample, 1e-4, None, selection.casts_for, None);
                let known = scene.blocker_among(&suspects, surface, sample, 1e-4, None, selection.casts_for, None);
                prop_assert_eq!(searched.is_some(), known.is_some(), "{} of {:?}", sample, suspects);
            }
        }
    }
}

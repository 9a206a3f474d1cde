//! The pictures of a light: how many there are, which way they look, and how they are fitted to the scene.
//!
//! Source: Eisemann & Décoret 2008, "Occlusion Textures for Plausible Soft Shadows", §3.4 and figure 5: the centre of
//! projection lies behind the light, and the frustum holds the light and the scene. A frustum that holds a point and the
//! light holds every kernel of the point. The paper fits the frustum to the light; here the distance of the centre is
//! searched, because a scene beside the light needs another one, and the frustum need not be symmetric. Beyond the paper,
//! it is cut to the casters and the kernels that touch them: all other kernels find nothing, inside the picture or beside.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::axis::{CUBE, axis_of_one};
use super::face::{SliceFace, Slices};
use super::filter::MOST_TAPS;
use super::framing::{Framing, LightBox};
use super::scene_box::SceneBox;
use super::sliced_light::{SlicedKind, SlicedLight};
use crate::geometry::Aabb;

/// The pictures of one light.
pub type SliceFaces = SmallVec<[SliceFace; 6]>;

/// Settings that the pictures depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliceSettings {
    /// Number of slices.
    pub count: u32,
    /// How much thinner slices are away from the light, 0 to 1.
    pub weight: f64,
    /// Share of a picture's side that stays empty on each side.
    pub guard: f64,
}

/// Least depth of the scene before the light as a share of its largest depth. What is nearer does not cast.
const NEAREST: f64 = 1e-3;

/// How much larger than the casters the scene may count, for the lengths that follow from its size. A ground of many kilometres
/// would make the slices thicker than what stands on it. By eye.
const FAR: f64 = 4.0;

/// Share of the depth by which the slices reach beyond the casters, so that rounding leaves none out.
const SLACK: f64 = 1e-4;

/// Least range of all slices as a share of the size of the scene. Slices of a flat scene would otherwise be as thin as the
/// rounding of receivers, which would shadow themselves.
const LEAST_RANGE: f64 = 0.02;

/// Area of the texels, as a multiple of the smallest possible one, for which the centre of projection comes nearer to the
/// light. Measured on 121 lights in random scenes: 6 takes two fifths off the umbra that is lit under rectangles, compared with
/// 2, and a fifth off their errors; twice as much gains little more.
const LARGEST: f64 = 6.0;

/// Fits the pictures of a light to the objects that it reaches.
pub fn fit_faces(light: &SlicedLight, settings: &SliceSettings, scene: &[SceneBox]) -> SliceFaces {
    match light.kind {
        SlicedKind::Rect => std::iter::once(fit_before(light, light.axes, settings, scene)).collect(),
        SlicedKind::Directional => std::iter::once(fit_parallel(light, settings, scene)).collect(),
        SlicedKind::Sphere => match axis_of_one(light, scene) {
            Some(z) => {
                let (x, y) = z.any_orthonormal_pair();
                std::iter::once(fit_before(light, [x, y, z], settings, scene)).collect()
            }
            None => CUBE
                .iter()
                .map(|&z| fit_side(light, z, settings, scene))
                .collect(),
        },
    }
}

/// The depths of the casters, with some slack; `None` without casters. `size` is that of the scene, metres.
fn depths(boxes: &[LightBox], nearest: f64, size: f64) -> Option<[f64; 2]> {
    let (mut top, mut bottom) = (f64::INFINITY, f64::NEG_INFINITY);
    for caster in boxes.iter().filter(|light| light.casts && light.max.z > nearest) {
        top = top.min(caster.min.z.max(nearest));
        bottom = bottom.max(caster.max.z);
    }
    if !(top <= bottom) {
        return None;
    }
    let range = bottom - top;
    let slack = (SLACK * range).max(0.5 * (LEAST_RANGE * size.max(1e-6) - range));
    // Nothing behind the light may get into a slice.
    Some([(top - slack).max(0.5 * nearest), bottom + slack])
}

/// The greatest depth of the scene, metres, at most [`FAR`] times the distance of its casters.
fn scale_of_scene(boxes: &[LightBox]) -> f64 {
    let farthest = boxes.iter().map(|light| light.max.z).fold(0.0, f64::max);
    let before = boxes.iter().filter(|light| light.casts && light.max.z > 0.0);
    let distance = |light: &LightBox| light.min.abs().max(light.max.abs()).max_element();
    match before.map(distance).reduce(f64::max) {
        Some(casters) => farthest.min(FAR * casters),
        None => farthest,
    }
}

/// Scale and offset that map a range of slopes to the picture inside its guard.
fn placed([least, greatest]: [DVec2; 2], guard: f64) -> (DVec2, DVec2) {
    let size = (greatest - least).max(DVec2::splat(1e-9));
    let scale = 2.0 * (1.0 - 2.0 * guard) / size;
    (scale, -scale * 0.5 * (least + greatest))
}

/// Widens a picture along one side, so that the longer side of a kernel is a whole multiple of the shorter one in texels.
/// Lookups in N-buffers put a kernel together from that many squares.
fn evened([least, greatest]: [DVec2; 2], half: DVec2) -> [DVec2; 2] {
    let size = greatest - least;
    let kernel = half / size;
    let (long, short) = (kernel.max_element(), kernel.min_element());
    if !(short > 0.0 && long < f64::from(MOST_TAPS) * short) {
        return [least, greatest];
    }
    let change = long / short / (long / short).round();
    // A kernel that is too long gets shorter where the picture is wider.
    let widens_x = (change > 1.0) == (kernel.x > kernel.y);
    let factor = change.max(change.recip());
    let wider = if widens_x {
        DVec2::new(factor, 1.0)
    } else {
        DVec2::new(1.0, factor)
    };
    let more = 0.5 * size * (wider - 1.0);
    [least - more, greatest + more]
}

/// Fits one picture to everything before a light.
fn fit_before(
    light: &SlicedLight,
    axes: [DVec3; 3],
    settings: &SliceSettings,
    scene: &[SceneBox],
) -> SliceFace {
    let boxes: Vec<LightBox> = scene
        .iter()
        .map(|scene| LightBox::new(scene, light.origin, &axes))
        .collect();
    let farthest = boxes.iter().map(|light| light.max.z).fold(0.0, f64::max);
    let scale = scale_of_scene(&boxes);
    let nearest = NEAREST * scale;
    let slices = depths(&boxes, nearest, scale).map_or(Slices::NONE, |range| {
        Slices::new(range, settings.count, settings.weight)
    });
    let scale_of_scene = if scale > 0.0 { scale } else { 1.0 };
    let framing = Framing::new(light, &boxes, &slices, [nearest, farthest]);
    // Texels are small, in the mean over the slices, or the centre is near the light. There, rays from the light's middle
    // meet the casters of a slice where the picture shows them, and surfaces that pass through slices have fewer gaps.
    let cost = |behind: f64| {
        let [least, greatest] = framing.slopes(behind);
        let size = greatest - least;
        let area = |bottom: f64| (size.x * size.y) * (bottom + behind).powi(2);
        slices.bottoms[..slices.count]
            .iter()
            .map(|&b| area(b))
            .sum::<f64>()
    };
    let distances = || (0..=24).map(|step| scale_of_scene * (0.5 * f64::from(step) - 7.0).exp2());
    let best = distances().map(&cost).fold(f64::INFINITY, f64::min);
    let behind = distances()
        .find(|distance| cost(*distance) <= LARGEST * best)
        .unwrap_or(scale_of_scene);
    let (scale, offset) = placed(evened(framing.slopes(behind), light.half), settings.guard);
    SliceFace {
        origin: light.origin,
        axes,
        scale,
        offset,
        divisor: DVec2::new(1.0, behind),
        slices,
        farthest,
    }
}

/// Fits one of six pictures around a sphere: a pyramid of 90°, moved back so that kernels stay inside.
fn fit_side(light: &SlicedLight, z: DVec3, settings: &SliceSettings, scene: &[SceneBox]) -> SliceFace {
    let (x, y) = z.any_orthonormal_pair();
    let axes = [x, y, z];
    let radius = light.half.max_element();
    let boxes: Vec<LightBox> = scene
        .iter()
        .map(|scene| LightBox::new(scene, light.origin, &axes))
        .collect();
    let farthest = boxes.iter().map(|light| light.max.z).fold(0.0, f64::max);
    let scale = scale_of_scene(&boxes);
    // Kernels of oblique receivers are longer, by at most the square root of 2.
    let behind = (1.5 * radius).max(1e-3 * scale).max(1e-6);
    let seen: Vec<LightBox> = boxes
        .into_iter()
        .filter_map(|light| light.within_pyramid(behind))
        .collect();
    let nearest = NEAREST * scale;
    let slices = depths(&seen, nearest, scale).map_or(Slices::NONE, |range| {
        Slices::new(range, settings.count, settings.weight)
    });
    let framing = Framing::new(light, &seen, &slices, [nearest, farthest]);
    let divisor = DVec2::new(1.0, behind);
    let shown = evened(framing.cut([DVec2::NEG_ONE, DVec2::ONE], divisor), light.half);
    let (scale, offset) = placed(shown, settings.guard);
    SliceFace {
        origin: light.origin,
        axes,
        scale,
        offset,
        divisor,
        slices,
        farthest,
    }
}

/// Fits the picture of a directional light. Its rays are parallel: a centre of projection anywhere else would cut surfaces
/// into patches that are seen from the light.
fn fit_parallel(light: &SlicedLight, settings: &SliceSettings, scene: &[SceneBox]) -> SliceFace {
    let all = scene
        .iter()
        .fold(Aabb::EMPTY, |all, scene| all.union(scene.bounds));
    let casters = scene.iter().filter(|scene| scene.casts);
    let casters = casters.fold(Aabb::EMPTY, |all, scene| all.union(scene.bounds));
    let size_of = |bounds: &Aabb| f64::from(bounds.half_size().max_element()).max(0.0);
    let largest = FAR * size_of(&casters);
    // Receivers are rounded as their distance from the origin is.
    let is_wide = !casters.is_empty() && size_of(&all) > largest;
    let around = if is_wide { casters } else { all };
    let origin = if around.is_empty() {
        light.origin
    } else {
        0.5 * (around.min.as_dvec3() + around.max.as_dvec3())
    };
    let boxes: Vec<LightBox> = scene
        .iter()
        .map(|scene| LightBox::new(scene, origin, &light.axes))
        .collect();
    let size = if is_wide { largest } else { size_of(&all) };
    let farthest = boxes
        .iter()
        .map(|light| light.max.z)
        .fold(f64::NEG_INFINITY, f64::max);
    let slices = depths(&boxes, f64::NEG_INFINITY, size).map_or(Slices::NONE, |range| {
        Slices::new(range, settings.count, settings.weight)
    });
    let (mut least, mut greatest) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for light in &boxes {
        least = least.min(light.min.truncate());
        greatest = greatest.max(light.max.truncate());
    }
    if !least.cmple(greatest).all() {
        (least, greatest) = (DVec2::NEG_ONE, DVec2::ONE);
    }
    // Kernels at the first slice reach beyond the scene; a wide one finds nothing there, and may be cut.
    let size = greatest - least;
    let deep = slices.bottoms[slices.count - 1] - slices.top;
    let reach = (light.half * deep).min(0.25 * size);
    let framing = Framing::new(light, &boxes, &slices, [f64::NEG_INFINITY, farthest]);
    let shown = evened(
        framing.cut([least - reach, greatest + reach], DVec2::Y),
        light.half,
    );
    let (scale, offset) = placed(shown, settings.guard);
    SliceFace {
        origin,
        axes: light.axes,
        scale,
        offset,
        divisor: DVec2::Y,
        slices,
        farthest,
    }
}

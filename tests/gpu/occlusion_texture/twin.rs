//! The GPU draws, filters, looks up and combines as the CPU twins do.

use antumbra::insides::occlusion_textures::{
    DENSE_LEVEL, Kernel, LightSlices, Lookup, OcclusionFace, OcclusionLight, Picture, Shares, SliceFace,
    WIDER, add_overlapping, combine, measured_plane, measured_weight, mipmap_mean, mipmaps, n_buffer_mean,
    n_buffers, over_own_plane, slice_bottom, slice_kernel, slice_plane, slice_weight, summed_areas,
    summed_mean,
};
use antumbra::prelude::*;
use antumbra::reference::SurfaceHit;
use antumbra::techniques::{OcclusionTexture, OcclusionTextures, SliceCombination, SliceFilter};
use glam::{DVec3, Vec2, Vec3, Vec4};

use super::cast::{Filtered, cast_pictures};
use super::scenes::{BETWEEN, Scene, boxes, hits, lamp, rendered, square, staged};
use crate::harness::strict_context;

/// The receiver and the picture in which it is looked up.
struct Seen<'a> {
    slices: &'a LightSlices,
    face: &'a OcclusionFace,
    light: Vec4,
    filtered: &'a Filtered,
    receiver: Vec3,
    normal: Vec3,
}

impl Seen<'_> {
    /// A lookup in a slice between two depths.
    fn lookup(&self, top: f32, bottom: f32, plane: f32) -> Lookup {
        Lookup {
            top,
            bottom,
            plane,
            side: self.slices.resolution as f32,
            taps: self.slices.taps() as f32,
        }
    }

    /// The kernel of a lookup, `wider` than the light.
    fn kernel(&self, at: &Lookup, wider: f32) -> Kernel {
        let mut kernel = slice_kernel(self.face, self.light, self.receiver, at.plane);
        kernel.half *= wider;
        over_own_plane(self.face, at, self.receiver, self.normal, kernel)
    }

    fn mean(&self, set: usize, slice: usize, kernel: &Kernel) -> f32 {
        self.filtered.mean(set, slice, kernel, self.slices)
    }

    /// Adds a slice by its depths and overlaps.
    fn measured(&self, hidden: f32, slice: usize, (first, top, bottom): (f32, f32, f32)) -> f32 {
        let depth = self.receiver.z;
        let guess = self.lookup(first, bottom, 0.5 * (top + bottom.min(depth)));
        let around = self.kernel(&guess, WIDER);
        let cover = self.mean(0, slice, &around);
        if cover <= 0.0 {
            return hidden;
        }
        let plane = measured_plane(top, bottom, 2.0 - self.mean(2, slice, &around) / cover);
        if plane >= depth {
            return hidden;
        }
        // The receiver's own surface is told by its depth in the receiver's slice.
        let is_cut = first < top || depth > bottom;
        let kernel = if is_cut {
            self.kernel(&self.lookup(first, bottom, plane), 1.0)
        } else {
            slice_kernel(self.face, self.light, self.receiver, plane)
        };
        let own = self.mean(0, slice, &kernel);
        if own <= 0.0 {
            return hidden;
        }
        let inside = measured_plane(top, bottom, 2.0 - self.mean(2, slice, &kernel) / own);
        let weight = measured_weight(inside, bottom - top, depth);
        let above = slice
            .checked_sub(1)
            .map_or(0.0, |before| self.mean(1, before, &kernel));
        let shares = Shares {
            own,
            above,
            united: self.mean(1, slice, &kernel),
        };
        add_overlapping(hidden, weight, shares)
    }

    /// Adds a slice as if its casters were in the middle.
    fn combined(&self, hidden: f32, slice: usize, (first, _, bottom): (f32, f32, f32)) -> f32 {
        let settings = &self.slices.settings;
        let weight = slice_weight(self.face, slice, settings.slices as usize, self.receiver.z);
        let plane = slice_plane(self.face, slice, weight);
        let kernel = self.kernel(&self.lookup(first, bottom, plane), 1.0);
        let own = self.mean(0, slice, &kernel);
        combine(settings.combine, hidden, (weight * own).clamp(0.0, 1.0))
    }
}

/// Visibility of a receiver by the twins.
fn visibility(slices: &LightSlices, record: &OcclusionLight, filtered: &[Filtered], hit: &SurfaceHit) -> f32 {
    let depth_of = |face: &SliceFace| face.light_from_world(hit.position).z;
    let (index, face) = slices
        .faces
        .iter()
        .enumerate()
        .max_by(|(_, a), (_, b)| depth_of(a).total_cmp(&depth_of(b)))
        .expect("a face");
    let receiver = face.light_from_world(hit.position).as_vec3();
    let normal = DVec3::from(face.axes.map(|axis| axis.dot(hit.normal))).as_vec3();
    let settings = &slices.settings;
    let seen = Seen {
        slices,
        face: &record.faces[index],
        light: Vec4::from(record.kernel),
        filtered: &filtered[index],
        receiver,
        normal,
    };
    let (mut hidden, mut top) = (0.0, seen.face.depth[2]);
    let mut before = top;
    for slice in 0..settings.slices as usize {
        let bottom = slice_bottom(seen.face, slice);
        let first = if settings.close_leaks != 0 { before } else { top };
        let depths = (first, top, bottom);
        hidden = match settings.combine {
            SliceCombination::Overlap if receiver.z > top => seen.measured(hidden, slice, depths),
            SliceCombination::Overlap => hidden,
            _ if receiver.z > bottom => seen.combined(hidden, slice, depths),
            _ => hidden,
        };
        (before, top) = (top, bottom);
    }
    1.0 - hidden
}

/// Largest and mean difference between the GPU and the twins on surfaces that face up; `spoil` changes the twins' kernels.
fn difference(
    context: &RenderContext,
    scene: &Scene,
    (kind, from): (LightKind, Vec3),
    settings: OcclusionTexture,
    spoil: impl Fn(&mut OcclusionLight),
) -> (f32, f32, usize) {
    let mut stage = staged(context, scene);
    let (light, place) = lamp(kind, from);
    stage.spawn_light(light, place, Some(settings));
    let got = rendered(&mut stage);
    let (rays, hits) = hits(&mut stage);
    let world = &stage.world;
    let slices = &world.resource::<OcclusionTextures>().lights[0];
    let frame_light = &world.resource::<FrameLights>().lights[0];
    // Kernels of these lights are looked up in sparse levels.
    let is_large = kind == LONG || kind == square(2.0);
    assert!(!is_large || slices.levels() > DENSE_LEVEL + 1);
    let mut record = slices.record(frame_light, DVec3::ZERO, (1.0, 0.0));
    spoil(&mut record);
    let side = slices.resolution as usize;
    let filtered: Vec<Filtered> = slices
        .faces
        .iter()
        .map(|face| {
            let drawn = cast_pictures(face, &rays, side, &settings);
            Filtered::new(&drawn, settings.filter)
        })
        .collect();
    let (mut largest, mut sum, mut count, mut soft) = (0.0f32, 0.0, 0, 0);
    for (hit, got) in hits.hits.iter().zip(&got) {
        // Light below the horizon is cut, which the twins do not know.
        let sees_all = |y: f64| kind == LightKind::Directional || y < f64::from(from.y) - 0.2;
        let faces_up = |hit: &&SurfaceHit| hit.normal.y > 0.9 && sees_all(hit.position.y);
        let Some(hit) = hit.as_ref().filter(faces_up) else {
            continue;
        };
        let expected = visibility(slices, &record, &filtered, hit);
        largest = largest.max((expected - got).abs());
        sum += (expected - got).abs();
        count += 1;
        soft += usize::from((0.05..0.95).contains(&expected));
    }
    (largest, sum / count as f32, soft)
}

fn settings(filter: SliceFilter) -> OcclusionTexture {
    OcclusionTexture {
        filter,
        resolution: 64,
        slices: 6,
        angle_deg: 7.0,
        ..Default::default()
    }
}

const LONG: LightKind = LightKind::Rect {
    width: 1.4,
    height: 0.4,
};

#[test]
fn pictures_are_filtered_and_looked_up_as_the_twins_do() {
    let context = strict_context();
    let above = Vec3::new(0.2, 3.0, 0.1);
    let cases = [
        (LONG, above, SliceFilter::NBuffers),
        (square(2.0), above, SliceFilter::NBuffers),
        (LONG, above, SliceFilter::SummedAreas),
        (LightKind::Sphere { radius: 0.4 }, above, SliceFilter::Mipmaps),
        (LightKind::Directional, above, SliceFilter::NBuffers),
        // Casters are all around it, and far enough for their fronts alone to be drawn.
        (
            LightKind::Sphere { radius: 0.03 },
            BETWEEN,
            SliceFilter::SummedAreas,
        ),
    ];
    for (kind, from, filter) in cases {
        let (largest, mean, soft) = difference(&context, &boxes(), (kind, from), settings(filter), |_| {});
        println!("{kind:?} {filter:?}: largest {largest:.4}, mean {mean:.5}, {soft} soft");
        assert!(soft > 10, "{kind:?} {filter:?}: {soft} soft pixels");
        // A texel whose middle lies on an edge may be drawn or not.
        assert!(
            mean < 2e-3 && largest < 0.1,
            "{kind:?} {filter:?}: {mean}, {largest}"
        );
    }
}

#[test]
fn the_comparison_with_the_twins_finds_a_wrong_kernel_and_a_wrong_combination() {
    let context = strict_context();
    let above = Vec3::new(0.2, 3.0, 0.1);
    let (_, mean, _) = difference(
        &context,
        &boxes(),
        (LONG, above),
        settings(SliceFilter::SummedAreas),
        |light| light.kernel[0] *= 0.8,
    );
    assert!(mean > 4e-3, "{mean}");
    // Two texels are half of the distance between the values of level 5.
    let (_, mean, _) = difference(
        &context,
        &boxes(),
        (LONG, above),
        settings(SliceFilter::NBuffers),
        |light| light.faces[0].projection[2] += 2.0 * 2.0 / 64.0,
    );
    assert!(mean > 4e-3, "{mean}");
    for combine in [
        SliceCombination::Product,
        SliceCombination::Maximum,
        SliceCombination::Sum,
    ] {
        let settings = OcclusionTexture {
            combine,
            close_leaks: u32::MAX,
            ..settings(SliceFilter::SummedAreas)
        };
        let (largest, mean, _) = difference(&context, &boxes(), (LONG, above), settings, |_| {});
        assert!(mean < 2e-3 && largest < 0.1, "{combine:?}: {mean}, {largest}");
    }
}

/// A kernel that is wider than the picture finds the picture's share of itself, and one beyond it nothing.
#[test]
fn filters_agree_on_kernels_wider_than_the_picture() {
    let picture = Picture::from_fn(32, |_| 1.0);
    for (center, half, expected) in [(0.5, 2.0, 0.25 / 4.0), (0.7, 1.0, 0.25), (40.0, 2.0, 0.0)] {
        let kernel = antumbra::insides::occlusion_textures::Kernel {
            center: Vec2::splat(center),
            half: Vec2::splat(half),
        };
        let means = [
            n_buffer_mean(&n_buffers(picture.clone()), &kernel, 2),
            mipmap_mean(&mipmaps(picture.clone()), &kernel),
            summed_mean(&summed_areas(picture.clone()), &kernel),
        ];
        assert!(
            means.iter().all(|mean| (mean - expected).abs() < 1e-5),
            "{center} {half}: {means:?}"
        );
    }
}

/// A kernel of a size and place has the same mean under all filters where the picture is even.
#[test]
fn filters_agree_on_even_pictures() {
    let picture = Picture::from_fn(32, |_| 1.0);
    let kernel = antumbra::insides::occlusion_textures::Kernel {
        center: Vec2::new(0.5, 0.45),
        half: Vec2::new(0.2, 0.1),
    };
    let means = [
        n_buffer_mean(&n_buffers(picture.clone()), &kernel, 2),
        mipmap_mean(&mipmaps(picture.clone()), &kernel),
        summed_mean(&summed_areas(picture), &kernel),
    ];
    assert!(means.iter().all(|mean| (mean - 1.0).abs() < 1e-5), "{means:?}");
}

//! Occlusion textures on the CPU: the kernel of eq. 4, means over rectangles, slices, and pictures that hold the scene.

use antumbra::geometry::Aabb;
use antumbra::insides::occlusion_textures::{
    Kernel, OwnBox, Picture, SceneBox, SliceFace, SliceSettings, SlicedKind, SlicedLight, Slices, combine,
    fit_faces, level_count, mipmap_mean, mipmaps, n_buffer_mean, n_buffers, reached_levels, slice_kernel,
    slice_plane, slice_weight, summed_areas, summed_mean, tap_count,
};
use antumbra::techniques::SliceCombination;
use glam::{Affine3A, DVec2, DVec3, IVec2, Quat, Vec2, Vec3, Vec4};

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    fn place(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

const SETTINGS: SliceSettings = SliceSettings {
    count: 8,
    weight: 0.0,
    guard: 0.01,
};

/// A light at the origin that shines along −Y.
fn light(kind: SlicedKind, half: DVec2) -> SlicedLight {
    SlicedLight {
        origin: DVec3::ZERO,
        axes: [DVec3::X, DVec3::Z, DVec3::NEG_Y],
        half,
        kind,
    }
}

fn boxes(count: usize, seed: u64, middle: Vec3) -> Vec<SceneBox> {
    let mut random = Random(seed);
    (0..count)
        .map(|_| {
            let center = middle + random.place() * 2.0;
            SceneBox::of_bounds(Aabb::around(center, Vec3::splat(0.1 + 0.3 * random.unit())), true)
        })
        .collect()
}

fn picture(side: usize, seed: u64) -> Picture {
    let blobs: Vec<(Vec2, f32)> = {
        let mut random = Random(seed);
        (0..12)
            .map(|_| {
                (
                    Vec2::new(random.unit(), random.unit()),
                    0.05 + 0.1 * random.unit(),
                )
            })
            .collect()
    };
    Picture::from_fn(side, |texel: IVec2| {
        let at = (texel.as_vec2() + 0.5) / side as f32;
        let hit = blobs
            .iter()
            .any(|(middle, radius)| at.distance(*middle) < *radius);
        f32::from(u8::from(hit))
    })
}

/// The mean over a kernel by many points.
fn brute_mean(picture: &Picture, kernel: &Kernel) -> f32 {
    let steps = 64;
    let mut sum = 0.0;
    for index in 0..steps * steps {
        let share =
            (Vec2::new((index % steps) as f32, (index / steps) as f32) + 0.5) / steps as f32 * 2.0 - 1.0;
        let at = (kernel.center + share * kernel.half) * picture.side as f32;
        sum += picture.at(at.floor().as_ivec2());
    }
    sum / (steps * steps) as f32
}

/// Kernels inside a picture, at least a texel wide.
fn kernels(aspect: f32) -> Vec<Kernel> {
    let mut random = Random(9);
    (0..60)
        .map(|_| {
            let half = Vec2::new(aspect, 1.0) * (0.015 + 0.06 * random.unit());
            let room = Vec2::ONE - 4.0 * half.max(Vec2::splat(half.max_element()));
            let center =
                2.0 * half.max_element() + Vec2::new(random.unit(), random.unit()) * room.max(Vec2::ZERO);
            Kernel { center, half }
        })
        .collect()
}

fn root_mean_square(errors: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| {
        (sum + error * error, count + 1.0)
    });
    f32::sqrt(sum / count)
}

#[test]
fn filters_give_the_means_over_rectangles_that_points_give() {
    let picture = picture(128, 3);
    let (levels, mips, sums) = (
        n_buffers(picture.clone()),
        mipmaps(picture.clone()),
        summed_areas(picture.clone()),
    );
    println!("aspect  n-buffers  one square  mipmaps  sums: root mean square errors of 60 kernels");
    for aspect in [1.0, 3.0] {
        let kernels = kernels(aspect);
        let taps = tap_count(Vec2::new(aspect, 1.0));
        let error = |of: &dyn Fn(&Kernel) -> f32| {
            root_mean_square(
                kernels
                    .iter()
                    .map(|kernel| of(kernel) - brute_mean(&picture, kernel)),
            )
        };
        let n = error(&|kernel| n_buffer_mean(&levels, kernel, taps));
        let one = error(&|kernel| n_buffer_mean(&levels, kernel, 1));
        let mip = error(&|kernel| mipmap_mean(&mips, kernel));
        let sum = error(&|kernel| summed_mean(&sums, kernel));
        println!("{aspect:>6} {n:>10.4} {one:>11.4} {mip:>8.4} {sum:>7.4}");
        assert!(sum < 0.006, "{aspect}: {sum}");
        assert!(n < 0.04 && n < mip, "{aspect}: {n}, {mip}");
        assert!(taps == 1 || n < 0.7 * one, "{aspect}: {n}, {one}");
    }
}

/// Sums count what lies outside the picture as empty, however far a kernel reaches beyond.
#[test]
fn kernels_beyond_the_border_find_nothing_there() {
    let picture = Picture::from_fn(32, |_| 1.0);
    let (levels, sums) = (n_buffers(picture.clone()), summed_areas(picture));
    for step in 0..40 {
        let center = Vec2::new(0.5 + 0.02 * step as f32, 0.5);
        let kernel = Kernel {
            center,
            half: Vec2::splat(0.125),
        };
        let inside = ((1.0 - (center.x - 0.125)) / 0.25).clamp(0.0, 1.0);
        let sum = summed_mean(&sums, &kernel);
        assert!((sum - inside).abs() < 1e-3, "{step}: {sum}, not {inside}");
        let n = n_buffer_mean(&levels, &kernel, 1);
        assert!(
            (n - inside).abs() < 0.52 && (inside > 0.0 || n == 0.0),
            "{step}: {n}, not {inside}"
        );
    }
}

/// The rays from a receiver to the light's corners, cut by a plane, end at the corners of the kernel. Returns the kernel.
fn assert_kernel(face: &SliceFace, half: DVec2, receiver: DVec3, plane: f64) -> Kernel {
    let record = face.record(DVec3::ZERO);
    let light = half.as_vec2().extend(1.0).extend(0.0);
    let kernel = slice_kernel(&record, light, receiver.as_vec3(), plane as f32);
    for corner in [
        DVec2::new(1.0, 1.0),
        DVec2::new(-1.0, 1.0),
        DVec2::new(-1.0, -1.0),
    ] {
        let on_light = (corner * half).extend(0.0);
        let cut = receiver + (on_light - receiver) * ((receiver.z - plane) / receiver.z);
        let expected = (face.project(cut) * DVec2::new(0.5, -0.5) + 0.5).as_vec2();
        let got = kernel.center + kernel.half * (corner * DVec2::new(1.0, -1.0)).as_vec2();
        assert!(got.distance(expected) < 1e-4, "{got}, not {expected}");
    }
    kernel
}

/// Whether a kernel of a slice touches a caster in it.
fn touches(face: &SliceFace, kernel: &Kernel, slice: usize, scene: &[SceneBox]) -> bool {
    let bottom = face.slices.bottoms[slice];
    let top = slice
        .checked_sub(1)
        .map_or(face.slices.top, |before| face.slices.bottoms[before]);
    scene.iter().filter(|scene| scene.casts).any(|caster| {
        let [near, far] = caster.range(face.axes[2], face.origin);
        let (mut least, mut greatest) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in caster.bounds.corners() {
            let ndc = face.project(face.light_from_world(corner.as_dvec3()));
            let place = (ndc * DVec2::new(0.5, -0.5) + 0.5).as_vec2();
            (least, greatest) = (least.min(place), greatest.max(place));
        }
        let beside = (kernel.center + kernel.half).cmplt(least).any()
            || (kernel.center - kernel.half).cmpgt(greatest).any();
        near <= bottom && far > top && !beside
    })
}

#[test]
fn kernels_are_the_light_as_it_is_projected_through_the_receiver() {
    let half = DVec2::new(0.5, 0.2);
    let scene = boxes(20, 4, Vec3::new(0.3, -5.0, 0.0));
    let faces = fit_faces(&light(SlicedKind::Rect, half), &SETTINGS, &scene);
    let face = &faces[0];
    let sides = 256.0 * face.widest_kernel(&light(SlicedKind::Rect, half)).as_vec2();
    let mut random = Random(8);
    let (mut checked, mut touching, mut largest) = (0, 0, Vec2::ZERO);
    for index in 0..400 {
        let bounds = &scene[index % scene.len()].bounds;
        let place = bounds.center() + random.place() * bounds.half_size();
        let receiver = face.light_from_world(place.as_dvec3());
        let mut before = face.slices.top;
        for (slice, &bottom) in face.slices.bottoms[..8].iter().enumerate() {
            let planes = [bottom, 0.5 * (before + bottom)];
            before = bottom;
            for plane in planes.into_iter().filter(|_| receiver.z > bottom) {
                let kernel = assert_kernel(face, half, receiver, plane);
                let (low, high) = (kernel.center - kernel.half, kernel.center + kernel.half);
                // Figure 5: no kernel juts out of the picture that finds anything there.
                if touches(face, &kernel, slice, &scene) {
                    touching += 1;
                    assert!(
                        low.cmpge(Vec2::ZERO).all() && high.cmple(Vec2::ONE).all(),
                        "{kernel:?}"
                    );
                }
                largest = largest.max(512.0 * kernel.half);
                checked += 1;
            }
        }
    }
    assert!(checked > 1000 && touching > 300, "{touching} of {checked}");
    // The levels that are built suffice for the largest kernel, and not by much.
    assert!(
        largest.cmple(sides).all() && (largest * 1.3).cmpge(sides).all(),
        "{largest} of {sides}"
    );
}

/// A small caster far above a wide ground has the picture for itself.
#[test]
fn pictures_show_casters_and_the_kernels_that_touch_them_alone() {
    let caster = SceneBox::of_bounds(
        Aabb::around(Vec3::new(3.0, -4.0, 1.0), Vec3::new(0.2, 0.01, 0.1)),
        true,
    );
    let ground = SceneBox::of_bounds(Aabb::around(Vec3::NEG_Y * 8.0, Vec3::new(50.0, 0.0, 50.0)), false);
    for (kind, half, kernel) in [
        (SlicedKind::Rect, 0.5, 0.25),
        (SlicedKind::Sphere, 0.2, 0.1 * 1.25),
        (SlicedKind::Directional, 0.01, 0.04),
    ] {
        let faces = fit_faces(&light(kind, DVec2::splat(half)), &SETTINGS, &[caster, ground]);
        let face = &faces[0];
        let bottom = face.slices.bottoms[7];
        let across = 2.0 * (face.divisor.x * bottom + face.divisor.y) / face.scale;
        let expected = 2.0 * DVec2::new(0.2, 0.1) + 4.0 * kernel;
        let ratio = across / expected;
        assert!(
            ratio.max_element() < 1.15 && ratio.min_element() > 0.95,
            "{kind:?}: {across}"
        );
        assert_inside(face, &[caster]);
    }
}

/// A scene that is turned with its light has slices as thin as before, thanks to the objects' own boxes.
#[test]
fn turned_scenes_are_cut_as_finely_as_straight_ones() {
    let locals = [
        Aabb::around(Vec3::ZERO, Vec3::new(2.5, 0.0, 2.5)),
        Aabb::around(Vec3::ZERO, Vec3::new(0.05, 1.0, 1.0)),
    ];
    let places = [Vec3::new(0.0, -4.0, 0.0), Vec3::new(-1.5, -2.5, 0.0)];
    let fitted = |turn: Quat, with_own: bool| {
        let scene: Vec<SceneBox> = (0..2)
            .map(|index| {
                let placed = Affine3A::from_rotation_translation(turn, turn * places[index]);
                let bounds = locals[index].transformed(&placed);
                let own = OwnBox::new(&locals[index], &placed).filter(|_| with_own);
                SceneBox {
                    own,
                    ..SceneBox::of_bounds(bounds, true)
                }
            })
            .collect();
        let mut light = light(SlicedKind::Rect, DVec2::splat(0.3));
        light.axes = light.axes.map(|axis| turn.as_dquat() * axis);
        let face = &fit_faces(&light, &SETTINGS, &scene)[0];
        let bottom = face.slices.bottoms[7];
        (bottom - face.slices.top, (bottom + face.divisor.y) / face.scale.x)
    };
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 0.9, -0.3);
    let (straight, turned) = (fitted(Quat::IDENTITY, true), fitted(turn, true));
    let loose = fitted(turn, false);
    assert!((straight.0 - turned.0).abs() < 1e-3 && (straight.1 - turned.1).abs() < 1e-3);
    assert!(
        loose.0 > 1.3 * straight.0 && loose.1 > 1.2 * straight.1,
        "{loose:?} {straight:?}"
    );
}

#[test]
fn guards_fit_any_resolution_afterwards() {
    let scene = boxes(10, 2, Vec3::new(0.3, -5.0, 0.0));
    let of = |guard| {
        let settings = SliceSettings { guard, ..SETTINGS };
        fit_faces(&light(SlicedKind::Rect, DVec2::ONE), &settings, &scene)[0]
    };
    let mut face = of(2.0 / 256.0);
    face.change_guard(2.0 / 256.0, 2.0 / 32.0);
    let wide = of(2.0 / 32.0);
    assert!(face.scale.distance(wide.scale) < 1e-9 && face.offset.distance(wide.offset) < 1e-9);
}

#[test]
fn small_kernels_reach_few_levels() {
    for (size, levels) in [(0.1, 2), (1.0, 2), (1.9, 2), (2.0, 3), (60.0, 7), (255.0, 9)] {
        assert_eq!(reached_levels(Vec2::splat(size), 1), levels, "{size}");
    }
    assert_eq!(reached_levels(Vec2::new(8.0, 1.0), 8), 2);
    assert_eq!(level_count(256), 9);
}

fn assert_inside(face: &SliceFace, scene: &[SceneBox]) {
    for scene in scene {
        for corner in scene.bounds.corners() {
            let point = face.light_from_world(corner.as_dvec3());
            let ndc = face.project(point);
            assert!(ndc.abs().max_element() <= 1.0, "{corner} is at {ndc}");
            assert!(
                point.z > face.slices.top && point.z <= face.slices.bottoms[7],
                "{corner}"
            );
            let clip = face.drawn().clip_from_world() * corner.as_dvec3().extend(1.0);
            assert!((clip.truncate().truncate() / clip.w).distance(ndc) < 1e-9);
            assert!((clip.z - point.z).abs() < 1e-9);
        }
    }
}

#[test]
fn pictures_hold_the_casters_of_every_kind_of_light() {
    let below = boxes(30, 5, Vec3::new(1.0, -6.0, 0.5));
    for half in [DVec2::ZERO, DVec2::new(0.5, 0.2), DVec2::splat(8.0)] {
        let faces = fit_faces(&light(SlicedKind::Rect, half), &SETTINGS, &below);
        assert_eq!(faces.len(), 1);
        assert_inside(&faces[0], &below);
        assert!(
            faces[0].divisor.y > 0.0,
            "the centre of projection is behind the light"
        );
    }
    let sphere = fit_faces(&light(SlicedKind::Sphere, DVec2::splat(0.3)), &SETTINGS, &below);
    assert_eq!(sphere.len(), 1, "all casters are below");
    assert_inside(&sphere[0], &below);
    let around = boxes(40, 6, Vec3::ZERO);
    let cube = fit_faces(&light(SlicedKind::Sphere, DVec2::splat(0.3)), &SETTINGS, &around);
    assert_eq!(cube.len(), 6);
    let sun = fit_faces(
        &light(SlicedKind::Directional, DVec2::splat(0.01)),
        &SETTINGS,
        &below,
    );
    assert_eq!(sun[0].divisor, DVec2::Y);
    assert_inside(&sun[0], &below);
    // Behind a rectangle nothing casts.
    let above = boxes(10, 7, Vec3::Y * 5.0);
    let none = fit_faces(&light(SlicedKind::Rect, DVec2::ONE), &SETTINGS, &above);
    assert_eq!(none[0].slices, Slices::NONE);
    assert_eq!(
        fit_faces(&light(SlicedKind::Directional, DVec2::ZERO), &SETTINGS, &[])[0].slices,
        Slices::NONE
    );
}

#[test]
fn slices_fade_in_without_steps_and_end_where_they_should() {
    for weight in [0.0, 0.5, 1.0] {
        let slices = Slices::new([2.0, 6.0], 8, weight);
        assert!((slices.bottoms[7] - 6.0).abs() < 1e-12);
        let mut before = slices.top;
        for bottom in &slices.bottoms[..8] {
            assert!(*bottom > before, "{weight}: {slices:?}");
            before = *bottom;
        }
        let thickness = |slice: usize| slices.bottoms[slice] - slices.bottoms[slice - 1];
        let ratio = (slices.bottoms[0] - slices.top) / thickness(7);
        assert!(
            if weight == 0.0 {
                (ratio - 1.0).abs() < 1e-9
            } else {
                ratio > 1.5
            },
            "{weight}: {ratio}"
        );
        let face = SliceFace {
            origin: DVec3::ZERO,
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            divisor: DVec2::Y,
            slices,
            farthest: 6.0,
        };
        let record = face.record(DVec3::ZERO);
        for slice in 0..8 {
            let bottom = slices.bottoms[slice] as f32;
            let next = bottom
                + if slice == 7 {
                    thickness(7)
                } else {
                    thickness(slice + 1)
                } as f32;
            let weight = |depth| slice_weight(&record, slice, 8, depth);
            assert_eq!((weight(bottom - 1e-3), weight(next + 1e-3)), (0.0, 1.0));
            assert!((weight(0.5 * (bottom + next)) - 0.5).abs() < 1e-3);
            let top = if slice == 0 {
                slices.top
            } else {
                slices.bottoms[slice - 1]
            } as f32;
            assert_eq!(slice_plane(&record, slice, 0.0), bottom);
            assert!((slice_plane(&record, slice, 1.0) - 0.5 * (top + bottom)).abs() < 1e-5);
        }
    }
}

#[test]
fn slices_combine_as_their_names_say() {
    let all = |combination, values: &[f32]| {
        values
            .iter()
            .fold(0.0, |hidden, more| combine(combination, hidden, *more))
    };
    let values = [0.5, 0.2, 0.7];
    assert!((all(SliceCombination::Product, &values) - (1.0 - 0.5 * 0.8 * 0.3)).abs() < 1e-6);
    assert_eq!(all(SliceCombination::Maximum, &values), 0.7);
    assert_eq!(all(SliceCombination::Sum, &values), 1.0);
    for combination in [
        SliceCombination::Product,
        SliceCombination::Maximum,
        SliceCombination::Sum,
    ] {
        assert!((all(combination, &[0.0, 0.4, 0.0]) - 0.4).abs() < 1e-6);
    }
}

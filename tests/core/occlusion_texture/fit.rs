//! Kernels, and pictures that hold the casters and the kernels that touch them.

use antumbra::geometry::Aabb;
use antumbra::insides::occlusion_textures::{
    Kernel, OwnBox, SceneBox, SliceFace, SliceSettings, SlicedKind, Slices, fit_faces, slice_kernel,
};
use glam::{Affine3A, DVec2, DVec3, Quat, Vec2, Vec3};

use super::{Random, SETTINGS, boxes, light};

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
    let mut random = Random::new(8);
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

/// A small caster far above a wide ground has the picture for itself. A sphere looks towards casters that are beside it.
#[test]
fn pictures_show_casters_and_the_kernels_that_touch_them_alone() {
    let ground = SceneBox::of_bounds(Aabb::around(Vec3::NEG_Y * 8.0, Vec3::new(50.0, 0.0, 50.0)), false);
    let beside = Vec3::new(3.0, -4.0, 1.0);
    let below = Vec3::new(0.3, -4.0, 0.1);
    for (kind, place, half, kernel) in [
        (SlicedKind::Rect, beside, 0.5, 0.25),
        (SlicedKind::Sphere, below, 0.2, 0.1),
        (SlicedKind::Directional, beside, 0.01, 0.04),
    ] {
        let bounds = Aabb::around(place, Vec3::new(0.2, 0.01, 0.1));
        let caster = SceneBox::of_bounds(bounds, true);
        let faces = fit_faces(&light(kind, DVec2::splat(half)), &SETTINGS, &[caster, ground]);
        let face = &faces[0];
        let bottom = face.slices.bottoms[7];
        let across = 2.0 * (face.divisor.x * bottom + face.divisor.y) / face.scale;
        let expected = 2.0 * DVec2::new(0.2, 0.1) + 4.0 * kernel;
        let ratio = across / expected;
        assert!(
            ratio.max_element() < 1.6 && ratio.min_element() > 0.85,
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

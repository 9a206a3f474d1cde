//! Maps of spot lights whose shadows are cast from another place: they show all that the light lights, from wherever that
//! place sees it, and their texels are as fine as the picture needs.

use antumbra::prelude::*;
use antumbra::scene::{LightShape, ShadowOrigin};
use antumbra::techniques::maps::{LightMap, MapResolution, Maps};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{DVec3, UVec2, Vec3};

use super::{add, put};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(320, 180);

/// Texels that are smaller than pixels from all places.
const RESOLUTION: MapResolution = MapResolution::Fixed(1024);

/// Vertical field of view, radians.
const FOV: f32 = 0.8;

/// The eye, which looks at the origin of the world.
const EYE: Vec3 = Vec3::new(0.8, 2.2, 2.6);

/// Beside the apex of the cone, which is then narrow enough for one face.
const BESIDE: Vec3 = Vec3::new(1.5, 4.8, 0.3);

/// Inside of the cone, above the posts.
const INSIDE: Vec3 = Vec3::new(0.3, 1.3, 0.2);

/// Outside of the cone, below its apex.
const BELOW: Vec3 = Vec3::new(2.5, 2.5, 0.0);

/// A floor with nine posts.
fn posts() -> Stage {
    let camera = Camera {
        vertical_fov: FOV,
        near: 0.05,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_translation(EYE).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    let settings = RenderSettings {
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        ..RenderSettings::default()
    };
    stage
        .add_renderer(strict_context(), settings)
        .expect("shaders compose");
    add(&mut stage, MeshData::plane(6.0), Vec3::ZERO);
    for place in 0..9 {
        let at = Vec3::new((place % 3) as f32 - 1.0, 0.0, (place / 3) as f32 - 1.0) * 0.5;
        let post = MeshData::cuboid(Vec3::new(0.06, 0.3, 0.06));
        add(&mut stage, post, at + Vec3::Y * 0.3);
    }
    stage
}

/// A narrow spot light above the posts, in place of the light that the stage had.
fn light(stage: &mut Stage, range: f32, parts: impl Bundle) -> Entity {
    for old in stage.lights.drain(..) {
        stage.world.despawn(old);
    }
    let spot = Light {
        kind: LightKind::Spot {
            inner_angle: 0.2,
            outer_angle: 0.25,
        },
        ..Light::point(Vec3::ONE, 60.0, range)
    };
    let place = Transform::from_xyz(0.0, 5.0, 0.0).looking_to(Vec3::NEG_Y, Vec3::Z);
    stage.spawn_light(spot, place, Some(parts))
}

fn visibility(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("the frame renders").visibility.remove(0)
}

fn map(stage: &Stage) -> &LightMap {
    let maps = stage.world.resource::<Maps>();
    maps.of_light(0).expect("a shadow is visible")
}

/// Shares of the lit pixels' shadows that are lost, and of the pixels without a shadow that are dark.
fn faults(lit: &[bool], truth: &[f32], got: &[f32]) -> (f64, f64) {
    let share = |is_dark: bool| {
        let all = (0..truth.len()).filter(|&pixel| lit[pixel] && (truth[pixel] < 0.5) == is_dark);
        let wrong = all.clone().filter(|&pixel| (got[pixel] < 0.5) != is_dark).count();
        let count = all.count();
        assert!(count > 200, "{count} pixels");
        wrong as f64 / count as f64
    };
    (share(true), share(false))
}

/// A place of the shadows, the range of the light, and the number of faces that its plain map then has.
const PLACES: [(Vec3, f32, usize); 5] = [
    (BESIDE, 7.0, 1),
    (INSIDE, 7.0, 6),
    (BELOW, 7.0, 6),
    (BESIDE, f32::INFINITY, 1),
    (INSIDE, f32::INFINITY, 6),
];

/// The pixels that the light lights, and the visibility under volumes from each of [`PLACES`].
fn truths(stage: &mut Stage) -> (Vec<bool>, [Vec<f32>; 5]) {
    light(stage, 7.0, ());
    let whole = stage.render().expect("the frame renders");
    let lit = whole
        .radiance
        .chunks_exact(4)
        .map(|pixel| pixel[0] > 0.0)
        .collect();
    let truths = PLACES.map(|(origin, range, _)| {
        let origin = ShadowOrigin::Position(origin);
        light(stage, range, (StencilVolume::default(), origin));
        visibility(stage)
    });
    (lit, truths)
}

/// Moves the place of a light's shadows from one of [`PLACES`] to the next, and compares each picture with the volumes.
/// Edges may be wrong by a texel, and those of smoothies are soft.
fn follows(technique: impl Bundle + Clone, has_plain_map: bool) {
    let mut stage = posts();
    let (lit, truths) = truths(&mut stage);
    let entity = light(&mut stage, 7.0, technique);
    let own = visibility(&mut stage);
    let (lost, _) = faults(&lit, &truths[1], &own);
    assert!(lost > 0.4, "shadows of the light's own place: {lost} lost");
    for ((origin, range, faces), truth) in PLACES.into_iter().zip(&truths) {
        put(&mut stage, entity, Some(ShadowOrigin::Position(origin)));
        stage.world.get_mut::<Light>(entity).expect("it is a light").range = range;
        let got = visibility(&mut stage);
        let (lost, dark) = faults(&lit, truth, &got);
        assert!(
            lost < 0.08 && dark < 0.15,
            "{origin} {range}: {lost} lost, {dark} dark"
        );
        if has_plain_map {
            assert_eq!(map(&stage).faces.len(), faces, "{origin} {range}");
        }
    }
}

#[test]
fn shadow_maps_follow_the_place_of_a_spots_shadows() {
    let resolution = RESOLUTION;
    follows(
        ShadowMap {
            resolution,
            ..ShadowMap::default()
        },
        true,
    );
}

#[test]
fn smoothies_follow_the_place_of_a_spots_shadows() {
    let resolution = RESOLUTION;
    follows(
        Smoothie {
            resolution,
            ..Smoothie::default()
        },
        true,
    );
}

#[test]
fn perspective_maps_follow_the_place_of_a_spots_shadows() {
    let resolution = RESOLUTION;
    follows(
        PerspectiveMap {
            resolution,
            ..PerspectiveMap::default()
        },
        false,
    );
}

/// A shadow map without limits of its resolution that matter.
fn unlimited() -> ShadowMap {
    ShadowMap {
        resolution: MapResolution::Auto { least: 8, most: 4096 },
        ..ShadowMap::default()
    }
}

#[test]
fn texels_of_a_moved_spot_are_as_small_as_pixels() {
    let mut stage = posts();
    light(&mut stage, 7.0, (unlimited(), ShadowOrigin::Position(BESIDE)));
    visibility(&mut stage);
    let map = map(&stage);
    let face = &map.faces[0].face;
    let along = face.axes[2].dot(DVec3::ZERO - face.origin);
    let texel = face.texel_metres(map.resolution) * along;
    let pixel = f64::from(2.0 * (0.5 * FOV).tan() * EYE.length() / SIZE.y as f32);
    assert!(texel < 1.5 * pixel, "{texel} m, where a pixel has {pixel} m");
    assert!(texel > 0.25 * pixel, "{texel} m, where a pixel has {pixel} m");
}

#[test]
fn maps_behind_doors_have_no_texels_to_spare() {
    let resolution = |width: f32| {
        let mut stage = posts();
        let entity = light(&mut stage, 7.0, unlimited());
        let shape = LightShape {
            width,
            height: width,
            ..LightShape::default()
        };
        put(&mut stage, entity, Some(shape));
        visibility(&mut stage);
        map(&stage).resolution
    };
    let (narrow, wide) = (resolution(0.05), resolution(f32::INFINITY));
    assert!(4 * narrow <= wide, "{narrow} and {wide} texels");
}

//! How maps are fitted: slide, faces and layers, and when they are fitted again. Frames run without a renderer.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::PerspectiveMaps;
use antumbra::techniques::maps::{LightMap, MapResolution, Maps};
use antumbra::techniques::perspective_map::Fit;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use super::variants;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(96, 54);

fn stage(eye: Vec3, target: Vec3) -> Stage {
    let camera = Camera {
        vertical_fov: 0.9,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    Stage::empty(
        SIZE,
        camera,
        Transform::from_translation(eye).looking_at(target, Vec3::Y),
    )
}

fn add(stage: &mut Stage, mesh: MeshData, at: Transform) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        at,
    );
    stage.world.spawn(parts).id()
}

fn add_box(stage: &mut Stage, min: [f32; 3], max: [f32; 3]) -> Entity {
    let (min, max) = (Vec3::from(min), Vec3::from(max));
    let mesh = MeshData::cuboid((max - min) * 0.5);
    add(stage, mesh, Transform::from_translation((min + max) * 0.5))
}

fn sun(stage: &mut Stage, direction: Vec3, map: PerspectiveMap) -> Entity {
    let place = Transform::default().looking_to(direction, Vec3::Y);
    stage.spawn_light(Light::directional(Vec3::ONE, 3.0), place, Some(map))
}

fn run(stage: &mut Stage) -> Fit {
    stage.schedule.run(&mut stage.world);
    let maps = stage.world.resource::<PerspectiveMaps>();
    *maps.of_light(0).expect("it is fitted")
}

fn map(stage: &Stage) -> &LightMap {
    stage.world.resource::<Maps>().of_light(0).expect("it has a map")
}

/// Three houses on a ground that reaches farther than any shadow.
fn houses() -> Stage {
    let mut stage = stage(Vec3::new(4.953, 1.7, 8.0), Vec3::new(0.0, 1.0, -2.0));
    add(&mut stage, MeshData::plane(60.0), Transform::default());
    add_box(&mut stage, [-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]);
    add_box(&mut stage, [2.0, 0.0, -20.0], [4.0, 3.0, -18.0]);
    add_box(&mut stage, [-6.0, 0.0, -40.0], [-3.0, 4.0, -36.0]);
    stage
}

#[test]
fn ground_beyond_all_shadows_does_not_decide_the_slide() {
    let directions = [(0.658, -0.313, -0.685), (0.3, -0.4, -0.9), (-0.7, -0.5, 0.2)];
    for (x, y, z) in directions {
        let direction = Vec3::new(x, y, z);
        let fit_with = |slide| {
            let mut stage = houses();
            let map = PerspectiveMap {
                slide,
                ..variants(1024)[0]
            };
            sun(&mut stage, direction, map);
            run(&mut stage)
        };
        let chosen = fit_with(None);
        println!("{direction}: {chosen:?}");
        assert!(chosen.slide.is_finite() && chosen.faces == 1, "{chosen:?}");
        for slide in [0.0, 3.0, 30.0, 300.0, 1e9] {
            let other = fit_with(Some(slide));
            println!("    slide {slide}: {:.3}", other.texel_side);
            // Slides are tried in steps of 4.
            assert!(
                chosen.texel_side <= 1.25 * other.texel_side,
                "{direction}: {chosen:?} {other:?}"
            );
        }
    }
}

/// Two boxes close by and a wall far behind them, with the light along the view: no single picture has more texels on the
/// boxes than a uniform map.
#[test]
fn lights_along_the_view_get_the_faces_of_a_cube_with_half_the_side() {
    let frame = |stage: &mut Stage, direction: Vec3, slide| {
        let settings = PerspectiveMap {
            slide,
            ..variants(1024)[0]
        };
        sun(stage, direction, settings);
        let fit = run(stage);
        let map = map(stage);
        assert_eq!(map.faces.len(), fit.faces);
        (fit, map.resolution, map.request.layers)
    };
    let boxes = || {
        let mut stage = stage(Vec3::new(0.0, 1.7, 0.0), Vec3::new(0.0, 1.7, -10.0));
        add_box(&mut stage, [-40.0, -30.0, -51.0], [40.0, 30.0, -50.0]);
        add_box(&mut stage, [-1.8, 0.2, -3.2], [-0.3, 3.0, -3.0]);
        add_box(&mut stage, [0.4, 0.2, -4.2], [1.9, 3.0, -4.0]);
        stage
    };
    let (along, resolution, layers) = frame(&mut boxes(), Vec3::NEG_Z, None);
    assert!(along.replaces_one && along.faces > 1, "{along:?}");
    assert_eq!((resolution, layers), (512, 5));
    let (uniform, ..) = frame(&mut boxes(), Vec3::NEG_Z, Some(1e9));
    assert!(
        2.0 * along.texel_side < uniform.texel_side,
        "{along:?} {uniform:?}"
    );
    let (beside, resolution, layers) = frame(&mut houses(), Vec3::new(0.5, -1.0, -0.4), None);
    assert!(!beside.replaces_one && beside.faces == 1, "{beside:?}");
    assert_eq!((resolution, layers), (1024, 1));
}

#[test]
fn faces_are_fitted_again_only_when_something_changed() {
    let mut stage = houses();
    let moving = add_box(&mut stage, [-0.5, 3.0, -6.0], [0.5, 4.0, -5.0]);
    let light = sun(&mut stage, Vec3::new(0.5, -1.0, -0.4), variants(512)[0]);
    let frame = |stage: &mut Stage| {
        run(stage);
        let faces: Vec<_> = map(stage).faces.iter().map(|state| state.face).collect();
        (stage.world.resource::<PerspectiveMaps>().fitted_anew, faces)
    };
    let (first, faces) = frame(&mut stage);
    assert_eq!(first, 1);
    for _ in 0..3 {
        assert_eq!(frame(&mut stage), (0, faces.clone()), "at rest");
    }
    let mut last = faces;
    let camera = stage.camera;
    let mut change = |what: &str, change: &dyn Fn(&mut World)| {
        change(&mut stage.world);
        let (anew, faces) = frame(&mut stage);
        assert_eq!(anew, 1, "{what}");
        assert_ne!(faces, last, "{what}");
        last = faces;
        assert_eq!(frame(&mut stage).0, 0, "after {what}");
    };
    change("the view", &|world| {
        let mut view = world.get_mut::<Transform>(camera).expect("it stands somewhere");
        view.rotation *= Quat::from_rotation_y(0.1);
    });
    change("a caster", &|world| {
        let mut place = world.get_mut::<Transform>(moving).expect("it stands somewhere");
        place.translation.y += 30.0;
    });
    change("the light", &|world| {
        let mut place = world.get_mut::<Transform>(light).expect("it stands somewhere");
        place.rotation *= Quat::from_rotation_y(0.1);
    });
    change("a setting", &|world| {
        let mut map = world.get_mut::<PerspectiveMap>(light).expect("it has a map");
        map.slide = Some(50.0);
    });
    change("a mesh", &|world| {
        let mesh = MeshData::cuboid(Vec3::new(9.0, 0.5, 0.5));
        world.get_mut::<SceneMesh>(moving).expect("it has a mesh").0 = Arc::new(mesh);
    });
}

/// A lamp over a street whose receivers come to be all around it when the view turns.
#[test]
fn layers_come_at_once_and_go_late() {
    let mut stage = stage(Vec3::new(0.0, 1.7, 0.0), Vec3::new(0.0, 1.0, -5.0));
    for (at, half) in [
        (Vec3::NEG_Y, Vec3::new(6.0, 1.0, 20.0)),
        (Vec3::new(0.0, 5.0, 12.0), Vec3::new(6.0, 1.0, 8.0)),
    ] {
        add(
            &mut stage,
            MeshData::cuboid(half),
            Transform::from_translation(at),
        );
    }
    let light = Light::point(Vec3::ONE, 50.0, 60.0);
    let place = Transform::from_xyz(0.0, 2.0, 8.0);
    let settings = PerspectiveMap {
        resolution: MapResolution::Fixed(64),
        ..Default::default()
    };
    stage.spawn_light(light, place, Some(settings));
    let frame = |stage: &mut Stage, turn: f32| {
        let camera = stage.camera;
        let mut view = stage
            .world
            .get_mut::<Transform>(camera)
            .expect("it stands somewhere");
        view.rotation = Quat::from_rotation_y(turn);
        let fit = run(stage);
        (fit.faces > 1, map(stage).request.layers)
    };
    let back = std::f32::consts::PI;
    assert_eq!(frame(&mut stage, 0.0), (false, 1));
    assert_eq!(frame(&mut stage, back), (true, 6));
    let mut kept = 0;
    while frame(&mut stage, 0.0) == (false, 6) {
        kept += 1;
        assert!(kept < 1000, "the layers stay for ever");
    }
    assert_eq!(kept, 119);
    assert_eq!(frame(&mut stage, 0.0), (false, 1));
}

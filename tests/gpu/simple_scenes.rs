//! Scenes of boxes and spheres, where not one pixel off the edge band may be wrong; and the jack-o'-lantern.

use std::sync::Arc;

use crate::harness::radiance::judge_radiance;
use crate::harness::support::stage::Stage;
use crate::harness::{judge, own_context, strict_context};
use antumbra::prelude::*;
use antumbra::reference::{HardError, RayScene};
use antumbra::scene::Submesh;
use bevy_transform::prelude::Transform;
use glam::{EulerRot, Quat, UVec2, Vec3};

const SIZE: UVec2 = UVec2::new(192, 108);

fn camera(eye: Vec3, target: Vec3) -> (Camera, Transform) {
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.02,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    (
        camera,
        Transform::from_translation(eye).looking_at(target, Vec3::Y),
    )
}

fn stage(context: &RenderContext) -> Stage {
    let (camera, view) = camera(Vec3::new(3.0, 3.0, 6.0), Vec3::ZERO);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    let settings = RenderSettings {
        ambient: Vec3::ZERO, // what is not lit is black
        ..RenderSettings::default()
    };
    stage
        .add_renderer(context.clone(), settings)
        .expect("shaders compose");
    stage
}

fn add(stage: &mut Stage, mesh: MeshData, transform: Transform) {
    stage.world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
        (ShadowCaster, ShadowReceiver),
        transform,
    ));
}

/// Boxes and spheres on a ground: some touch, overlap, are mirrored, squashed or turned.
fn boxes_and_spheres(context: &RenderContext) -> Stage {
    let mut stage = stage(context);
    let at = Transform::from_xyz;
    let turned = Quat::from_euler(EulerRot::XYZ, 0.4, 0.7, 0.2);
    let cube = || MeshData::cuboid(Vec3::splat(0.5));
    add(&mut stage, MeshData::plane(12.0), at(0.0, 0.0, 0.0));
    add(&mut stage, cube(), at(0.0, 0.5, 0.0));
    add(&mut stage, cube(), at(1.6, 0.9, -0.4).with_rotation(turned));
    add(
        &mut stage,
        cube(),
        at(-1.5, 0.8, 0.6)
            .with_scale(Vec3::new(-0.5, 1.6, 0.8))
            .with_rotation(turned),
    );
    add(&mut stage, MeshData::icosphere(0.6, 3), at(-0.2, 1.6, 0.1));
    add(
        &mut stage,
        MeshData::icosphere(0.5, 2),
        at(0.9, 0.4, 1.5).with_scale(Vec3::new(1.0, -0.6, 1.4)),
    );
    add(&mut stage, MeshData::icosphere(0.7, 4), at(-2.0, 0.7, -1.8));
    stage
}

fn judged(stage: &mut Stage) -> HardError {
    let rendered = stage.render().expect("the frame renders");
    let scene = RayScene::from_world(&mut stage.world);
    let shown = judge_radiance(stage, &scene, &rendered.radiance);
    assert_eq!(shown.wrong_inner, 0, "radiance: {shown:?}");
    judge(stage, &scene, 0, &rendered.visibility[0])
}

fn look_from(stage: &mut Stage, eye: Vec3, target: Vec3) {
    let entity = stage.camera;
    stage.world.entity_mut(entity).insert(camera(eye, target));
}

fn relight(stage: &mut Stage, light: Light, place: Transform) {
    for light in stage.lights.drain(..) {
        stage.world.despawn(light);
    }
    stage.spawn_light(light, place, Some(StencilVolume::default()));
}

#[test]
fn boxes_and_spheres_have_no_wrong_pixel() {
    let context = strict_context();
    let mut stage = boxes_and_spheres(&context);
    let eyes = [
        (Vec3::new(3.0, 3.0, 6.0), Vec3::ZERO),
        (Vec3::new(-2.6, 0.4, -2.6), Vec3::new(2.0, 0.5, 2.0)), // in the shadow of a sphere
        (Vec3::new(0.0, 0.5, 0.0), Vec3::new(3.0, 0.0, 2.0)),   // inside a box
        (Vec3::new(0.0, 0.5, 0.51), Vec3::new(1.0, 0.3, 3.0)),  // its near plane touches one
        (Vec3::new(0.1, 9.0, 0.1), Vec3::ZERO),
    ];
    let lights = [
        Vec3::new(2.0, 4.0, 1.0),
        Vec3::new(-4.0, 1.2, -4.0),
        Vec3::new(0.3, 2.6, 0.4),
        Vec3::new(-0.2, 1.6, 0.1), // inside a sphere
        Vec3::new(0.5, 3.0, 0.5),  // in the planes of a box's faces
    ];
    let kinds = [
        LightKind::Point,
        LightKind::Spot {
            inner_angle: 0.4,
            outer_angle: 0.7,
        },
        LightKind::Directional,
    ];
    let mut inner = 0;
    for (eye, target) in eyes {
        look_from(&mut stage, eye, target);
        for position in lights {
            for kind in kinds {
                let place = Transform::from_translation(position).looking_at(Vec3::ZERO, Vec3::Z);
                let range = if kind == LightKind::Point {
                    14.0
                } else {
                    f32::INFINITY
                };
                let light = Light {
                    kind,
                    ..Light::point(Vec3::ONE, 20.0, range)
                };
                relight(&mut stage, light, place);
                let error = judged(&mut stage);
                inner += error.inner;
                assert_eq!(
                    error.wrong_inner, 0,
                    "eye {eye}, light {position} {kind:?}: {error:?}"
                );
            }
        }
    }
    println!("{inner} pixels judged, none wrong");
    assert!(inner > 400_000, "too little was judged: {inner}");
}

/// A hollow ball with a wall of some thickness and holes: those of its triangles whose direction from the centre is
/// in a hole are left out of both shells, and the rims are walled.
fn jack_o_lantern() -> MeshData {
    let outer = MeshData::icosphere(1.0, 4);
    let is_hole = |direction: Vec3| {
        let d = direction.normalize();
        let eye = |x: f32| (d - Vec3::new(x, 0.35, 0.85).normalize()).length() < 0.22;
        let mouth = d.z > 0.3 && d.x.abs() < 0.5 && (d.y + 0.3).abs() < 0.13;
        let bottom = d.y < -0.93;
        eye(-0.4) || eye(0.4) || mouth || bottom
    };
    let count = outer.positions.len() as u32;
    let mut positions = outer.positions.clone();
    positions.extend(outer.positions.iter().map(|p| *p * 0.9));
    let mut indices = Vec::new();
    let mut rims = std::collections::BTreeMap::new();
    for corner in outer.indices.chunks_exact(3) {
        let [a, b, c] = [corner[0], corner[1], corner[2]];
        let middle: Vec3 = [a, b, c].iter().map(|&i| outer.positions[i as usize]).sum();
        if is_hole(middle) {
            continue;
        }
        indices.extend([a, b, c, c + count, b + count, a + count]);
        for edge in [(a, b), (b, c), (c, a)] {
            if rims.remove(&(edge.1, edge.0)).is_none() {
                rims.insert(edge, ());
            }
        }
    }
    for &(a, b) in rims.keys() {
        indices.extend([b, a, a + count, b, a + count, b + count]);
    }
    let mut mesh = MeshData::from_triangles("jack-o'-lantern", positions, indices);
    mesh.submeshes = vec![Submesh {
        first_index: 0,
        index_count: mesh.indices.len() as u32,
    }];
    mesh
}

#[test]
fn light_inside_a_jack_o_lantern_is_exact() {
    let context = strict_context();
    let mut stage = stage(&context);
    let mesh = jack_o_lantern();
    let edges = antumbra::silhouettes::CasterMeshes::default()
        .get_or_build(&Arc::new(mesh.clone()))
        .expect("it welds");
    assert!(edges.edges.is_closed(), "a wall with thickness is closed");
    add(&mut stage, mesh, Transform::from_xyz(0.0, 1.0, 0.0));
    add(&mut stage, MeshData::plane(12.0), Transform::default());
    add(
        &mut stage,
        MeshData::cuboid(Vec3::new(0.2, 0.6, 0.2)),
        Transform::from_xyz(1.0, 0.6, 3.0),
    );
    relight(
        &mut stage,
        Light::point(Vec3::ONE, 20.0, 30.0),
        Transform::from_xyz(0.05, 1.1, 0.02),
    );
    let eyes = [
        (Vec3::new(3.0, 3.0, 6.0), Vec3::new(0.0, 0.5, 1.0)),
        (Vec3::new(0.0, 0.5, 7.0), Vec3::new(0.0, 1.0, 0.0)), // in a beam
        (Vec3::new(0.0, 0.9, -0.5), Vec3::new(0.0, 1.0, 3.0)), // inside
        (Vec3::new(-6.0, 2.0, -3.0), Vec3::ZERO),             // behind: all in shadow
    ];
    for (eye, target) in eyes {
        look_from(&mut stage, eye, target);
        let error = judged(&mut stage);
        println!("{eye}: {error:?}");
        assert_eq!(error.wrong_inner, 0, "eye {eye}: {error:?}");
        assert!(error.inner > 1000, "eye {eye}: {error:?}");
    }
}

#[test]
fn the_judge_finds_a_missing_caster() {
    let context = strict_context();
    let mut stage = boxes_and_spheres(&context);
    relight(
        &mut stage,
        Light::point(Vec3::ONE, 20.0, 30.0),
        Transform::from_xyz(2.0, 4.0, 1.0),
    );
    assert_eq!(judged(&mut stage).wrong_inner, 0);
    let scene = RayScene::from_world(&mut stage.world);
    let caster = stage
        .world
        .query_filtered::<bevy_ecs::prelude::Entity, bevy_ecs::prelude::With<ShadowCaster>>()
        .iter(&stage.world)
        .nth(2)
        .expect("there are seven");
    stage.world.entity_mut(caster).remove::<ShadowCaster>();
    let rendered = stage.render().expect("the frame renders");
    let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
    assert!(error.wrong_inner > 50, "{error:?}");
}

#[test]
fn mirrored_views_and_baseline_devices_are_as_exact() {
    for (requested, mirrored) in [
        (RequestedFeatures::default(), true),
        (RequestedFeatures::BASELINE, false),
        (RequestedFeatures::BASELINE, true),
    ] {
        let context = own_context(requested);
        if requested == RequestedFeatures::BASELINE {
            assert!(context.device.features().is_empty(), "nothing is asked for");
            assert_eq!(context.device.limits(), wgpu::Limits::default());
        }
        let mut stage = boxes_and_spheres(&context);
        for eye in [Vec3::new(3.0, 3.0, 6.0), Vec3::new(-2.6, 0.4, -2.6)] {
            let (camera, mut view) = camera(eye, Vec3::ZERO);
            if mirrored {
                view.scale = Vec3::new(-1.0, 1.0, 1.0);
            }
            let entity = stage.camera;
            stage.world.entity_mut(entity).insert((camera, view));
            relight(
                &mut stage,
                Light::point(Vec3::ONE, 20.0, 14.0),
                Transform::from_xyz(2.0, 4.0, 1.0),
            );
            let error = judged(&mut stage);
            assert_eq!(
                error.wrong_inner, 0,
                "{requested:?} mirrored {mirrored} eye {eye}: {error:?}"
            );
            assert!(error.inner > 5000, "{error:?}");
        }
    }
}

//! Worlds that look alike: the one that a renderer comes from, and the one whose vertices are far from their meshes' origins.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// A floor below some balls, and for each technique a lamp or a sun that it fits.
fn stage(balls: usize) -> Stage {
    let view = Transform::from_xyz(2.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(64, 36), camera, view);
    let matte = Arc::new(Material::matte(Vec3::splat(0.7)));
    let floor = (MeshData::plane(4.0), Vec3::ZERO);
    let balls = (0..balls).map(|at| {
        let along = at as f32 - 0.5 * balls as f32;
        (MeshData::icosphere(0.4, 3), Vec3::new(along, 1.3, 0.3 * along))
    });
    for (mesh, at) in balls.chain([floor]) {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([matte.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at),
        ));
    }
    let place = Transform::from_xyz(0.5, 4.0, 0.4).looking_at(Vec3::ZERO, Vec3::Z);
    let lamp = Light::point(Vec3::ONE, 6.0, 30.0);
    let kinds = [
        LightKind::Point,
        LightKind::Sphere { radius: 0.2 },
        LightKind::Directional,
    ];
    for row in Techniques::default().rows() {
        let settings = row.defaults();
        let mut lights = kinds.iter().map(|&kind| Light { kind, ..lamp.clone() });
        if let Some(light) = lights.find(|light| settings.check(light).is_ok()) {
            stage.spawn_shadowed(light, place, Some(&settings));
        }
    }
    stage
}

fn add_renderer(stage: &mut Stage) {
    let settings = RenderSettings::default();
    stage
        .add_renderer(strict_context(), settings)
        .expect("shaders compose");
}

/// The visibility of each light, as a new renderer draws it.
fn fresh(balls: usize) -> Vec<Vec<f32>> {
    let mut stage = stage(balls);
    add_renderer(&mut stage);
    stage.render().expect("the frame renders").visibility
}

#[test]
fn a_renderer_that_changes_worlds_draws_what_a_new_one_draws() {
    let expected = [1, 3].map(fresh);
    assert!(expected[0].len() >= 5, "most techniques have a light");
    for (one, three) in expected[0].iter().zip(&expected[1]) {
        assert_ne!(one, three, "the comparison can fail");
    }
    // The other world is new, or has run as many frames.
    for [frames, others] in [[1, 0], [2, 2]] {
        for [from, to] in [[0, 1], [1, 0]] {
            let mut stages = [stage(1), stage(3)];
            add_renderer(&mut stages[from]);
            for _ in 0..frames {
                stages[from].render().expect("the frame renders");
            }
            for _ in 0..others {
                stages[to].run();
            }
            let renderer = stages[from].world.remove_resource::<Renderer>();
            stages[to].world.insert_resource(renderer.expect("it was there"));
            let shown = stages[to].render().expect("the frame renders").visibility;
            for (light, (shown, expected)) in shown.iter().zip(&expected[to]).enumerate() {
                assert_eq!(
                    shown, expected,
                    "light {light} from {from}, {frames} and {others} frames"
                );
            }
        }
    }
}

/// Moves the vertices of all meshes, and the meshes back.
fn move_vertices(stage: &mut Stage, by: Vec3) {
    let mut meshes = stage.world.query::<(&mut SceneMesh, &mut Transform)>();
    for (mut mesh, mut transform) in meshes.iter_mut(&mut stage.world) {
        let mut data = (*mesh.0).clone();
        for position in &mut data.positions {
            *position += by;
        }
        mesh.0 = Arc::new(data);
        transform.translation -= by;
    }
}

/// The same triangles to the last bit: what is rounded far away is moved back.
#[test]
fn meshes_far_from_their_own_origin_look_like_near_ones() {
    let far = Vec3::new(0.0, 50_000.0, 0.0);
    let visibility = |moves: &[Vec3]| {
        let mut stage = stage(3);
        for by in moves {
            move_vertices(&mut stage, *by);
        }
        add_renderer(&mut stage);
        stage.render().expect("the frame renders").visibility
    };
    let [near, moved] = [visibility(&[far, -far]), visibility(&[far])];
    for (light, (near, moved)) in near.iter().zip(&moved).enumerate() {
        let wrong = near
            .iter()
            .zip(moved)
            .filter(|(a, b)| (*a - *b).abs() > 0.1)
            .count();
        let dark = near.iter().filter(|&&v| v < 0.5).count();
        println!("light {light}: {wrong} pixels differ, {dark} are dark");
        assert!(
            dark > 20 && wrong <= near.len() / 200,
            "light {light}: {wrong} of {dark}"
        );
    }
}

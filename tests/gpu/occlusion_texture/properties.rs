//! Holes, slices that fade, lights of any orientation.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{Texture, TextureSlot, TextureWrap};
use antumbra::techniques::OcclusionTexture;
use bevy_transform::prelude::Transform;
use glam::{Affine2, Quat, Vec2, Vec3};

use super::scenes::{empty, hits, lamp, rendered, spawn, square, truth};
use crate::harness::strict_context;

/// A plane that rises through all slices shadows itself nowhere, and under a plate its shadow has no steps.
#[test]
fn slices_fade_where_a_plane_passes_through_them() {
    let context = strict_context();
    let slope = Transform::from_rotation(Quat::from_rotation_z(0.5));
    let picture = |with_plate: bool| {
        let mut stage = empty(&context, Vec3::new(0.0, 5.0, 0.1));
        spawn(&mut stage, MeshData::plane(1.5), slope);
        if with_plate {
            let over = Transform::from_xyz(0.0, 1.6, 1.2);
            spawn(&mut stage, MeshData::cuboid(Vec3::new(2.0, 0.01, 0.7)), over);
        }
        let (light, place) = lamp(square(1.2), Vec3::new(0.0, 4.0, 0.0));
        stage.spawn_light(light, place, Some(OcclusionTexture::default()));
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 900);
        (truth, got)
    };
    let (truth, alone) = picture(false);
    let dark = truth
        .values()
        .iter()
        .zip(&alone)
        .filter(|(truth, got)| **truth == 1.0 && **got < 0.98);
    assert_eq!(dark.count(), 0, "a plane shadows itself");
    let (truth, got) = picture(true);
    let width = truth.size().x as usize;
    let (mut worst, mut soft) = (0.0f32, 0);
    for index in 0..got.len() - 1 {
        let (a, b) = (truth.values()[index], truth.values()[index + 1]);
        if (index + 1) % width == 0 || !(a > 0.02 && a < 0.98 && b > 0.02 && b < 0.98) {
            continue;
        }
        worst = worst.max((got[index] - got[index + 1]).abs() - (a - b).abs());
        soft += 1;
    }
    println!("neighbours differ by at most {worst:.4} more than in truth, over {soft} pairs");
    assert!(soft > 80 && worst < 1.0 / 64.0, "{worst}, {soft}");
}

/// A plate nearly along the light's rays passes through slices whose texels are wider than the way of a ray from the plate.
#[test]
fn a_plate_along_the_rays_shadows_itself_nowhere() {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::ZERO);
    let view = Transform::from_xyz(-1.5, 1.7, -1.05).looking_at(Vec3::new(0.24, 0.69, -0.02), Vec3::Y);
    stage.world.entity_mut(stage.camera).insert(view);
    spawn(&mut stage, MeshData::plane(4.25), Transform::IDENTITY);
    let ball = Transform::from_xyz(-0.2, 0.75, -1.0);
    spawn(&mut stage, MeshData::icosphere(0.7, 1), ball);
    let corners = [
        [-0.2, 2.05, 0.13],
        [0.65, 1.97, -0.91],
        [-0.48, 1.22, -1.77],
        [-1.32, 1.3, -0.73],
    ];
    let plate = MeshData::from_triangles("plate", corners.map(Vec3::from).to_vec(), vec![0, 1, 2, 0, 2, 3]);
    spawn(&mut stage, plate, Transform::IDENTITY);
    let light = Light {
        kind: square(0.1),
        ..Light::point(Vec3::ONE, 30.0, f32::INFINITY)
    };
    let toward = Vec3::new(2.35, -0.97, 1.96);
    let place = Transform::from_xyz(-1.95, 0.82, -2.56).looking_to(toward, Vec3::new(0.1, 0.3, 0.9));
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    for slices in [8, 10, 12, 16] {
        let entity = stage.lights[0];
        stage.world.entity_mut(entity).insert(OcclusionTexture {
            slices,
            ..Default::default()
        });
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 16);
        let lit = truth
            .values()
            .iter()
            .zip(&got)
            .filter(|(truth, _)| **truth == 1.0);
        let dark = lit.clone().filter(|(_, got)| **got < 0.9).count();
        println!("{slices} slices: {dark} of {} lit pixels are dark", lit.count());
        assert!(dark < 20, "{slices} slices: {dark}");
    }
}

/// Slices move a ceiling into the room that a tilted lamp below it shines into, because the centre of projection is above it.
#[test]
fn a_ceiling_over_a_tilted_lamp_shadows_itself_nowhere() {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::ZERO);
    let view = Transform::from_xyz(2.3, 1.6, 2.6).looking_at(Vec3::new(-0.7, 2.3, -1.0), Vec3::Y);
    stage.world.entity_mut(stage.camera).insert(view);
    spawn(&mut stage, MeshData::plane(3.0), Transform::IDENTITY);
    let down = Quat::from_rotation_x(std::f32::consts::PI);
    let ceiling = Transform::from_xyz(0.0, 2.7, 0.0).with_rotation(down);
    spawn(&mut stage, MeshData::plane(3.0), ceiling);
    // Something lies beyond the ceiling, so that slices are spent on it.
    spawn(
        &mut stage,
        MeshData::cuboid(Vec3::splat(0.3)),
        Transform::from_xyz(0.0, 3.0, 1.0),
    );
    spawn(
        &mut stage,
        MeshData::cuboid(Vec3::splat(0.4)),
        Transform::from_xyz(0.0, 0.4, 0.0),
    );
    let light = Light {
        kind: square(0.6),
        ..Light::point(Vec3::ONE, 30.0, f32::INFINITY)
    };
    let place =
        Transform::from_xyz(1.0, 2.2, -2.6).looking_to(Vec3::new(-0.3, -1.0, 0.8), Vec3::new(0.0, 0.0, 1.0));
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    for close_leaks in [0, u32::MAX] {
        let light = stage.lights[0];
        stage.world.entity_mut(light).insert(OcclusionTexture {
            close_leaks,
            ..Default::default()
        });
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 16);
        let (_, hits) = hits(&mut stage);
        let lit = hits
            .hits
            .iter()
            .zip(truth.values().iter().zip(&got))
            .filter(|(hit, (truth, _))| hit.is_some_and(|hit| hit.normal.y < -0.9) && **truth == 1.0);
        let dark = lit.clone().filter(|(_, (_, got))| **got < 0.9).count();
        println!("{dark} of {} lit pixels are dark", lit.clone().count());
        assert!(lit.count() > 1000, "the ceiling is seen");
        assert!(dark < 10, "{close_leaks}: {dark}");
    }
}

/// The whole scene is turned about the light; the shadow stays near the truth.
#[test]
fn lights_of_any_orientation_and_receivers_beside_and_behind_them_are_right() {
    let context = strict_context();
    let kind = LightKind::Rect {
        width: 0.8,
        height: 0.3,
    };
    let picture = |turn: Quat| {
        let place = |at: Vec3| Transform::from_translation(turn * at).with_rotation(turn);
        let mut stage = empty(&context, Vec3::ZERO);
        let camera = stage.camera;
        let view = Transform::from_translation(turn * Vec3::new(1.5, 1.0, 3.0))
            .looking_at(turn * Vec3::new(0.0, -1.5, 0.0), turn * Vec3::Y);
        stage.world.entity_mut(camera).insert(view);
        spawn(&mut stage, MeshData::plane(2.5), place(Vec3::new(0.0, -2.0, 0.0)));
        spawn(&mut stage, MeshData::plane(0.4), place(Vec3::new(0.1, -1.0, 0.0)));
        // A wall that begins behind the light, and a ball behind it.
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(0.05, 2.0, 1.0)),
            place(Vec3::new(-1.5, -0.5, 0.0)),
        );
        spawn(
            &mut stage,
            MeshData::icosphere(0.3, 2),
            place(Vec3::new(0.3, 0.6, 0.0)),
        );
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 40.0, 30.0)
        };
        let down = Transform::IDENTITY.looking_at(Vec3::NEG_Y, Vec3::Z);
        let settings = OcclusionTexture {
            slices: 16,
            ..Default::default()
        };
        stage.spawn_light(light, Transform::from_rotation(turn) * down, Some(settings));
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 64);
        (
            got,
            super::scenes::rmse(&truth, &vec![1.0; truth.values().len()]),
            truth,
        )
    };
    let (straight, lit, truth) = picture(Quat::IDENTITY);
    let error = super::scenes::rmse(&truth, &straight);
    println!("error {error:.4}, without a shadow {lit:.4}");
    assert!(error < 0.05 && lit > 3.0 * error, "{error}, {lit}");
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 0.9, -0.3);
    let (turned, _, truth) = picture(turn);
    let error = super::scenes::rmse(&truth, &turned);
    println!("error {error:.4} of the turned scene");
    assert!(error < 0.05 && lit > 3.0 * error, "{error}, {lit}");
}

/// A plate whose texture is opaque on one half casts half a shadow.
#[test]
fn alpha_tested_casters_cast_their_holes() {
    let context = strict_context();
    let shadow = |texels: Option<[u8; 2]>| {
        let mut stage = empty(&context, Vec3::new(1.0, 3.0, 2.5));
        spawn(&mut stage, MeshData::plane(2.5), Transform::IDENTITY);
        let plate = spawn(&mut stage, card(), Transform::from_xyz(0.0, 1.0, 0.0));
        if let Some(alphas) = texels {
            stage
                .world
                .entity_mut(plate)
                .insert(SceneMaterials([masked(alphas)].into()));
        }
        let (light, place) = lamp(square(0.4), Vec3::new(0.0, 3.0, 0.0));
        stage.spawn_light(light, place, Some(OcclusionTexture::default()));
        let got = rendered(&mut stage);
        let (_, hits) = hits(&mut stage);
        let ground = hits
            .hits
            .iter()
            .zip(&got)
            .filter(|(hit, _)| hit.as_ref().is_some_and(|hit| hit.position.y.abs() < 1e-3));
        ground.map(|(_, got)| 1.0 - got).sum::<f32>()
    };
    let (whole, half, none) = (shadow(None), shadow(Some([255, 0])), shadow(Some([0, 0])));
    println!("shadow {whole:.1} of a plate, {half:.1} of half a plate, {none:.2} of a hole");
    assert!(whole > 50.0 && none < 0.5, "{whole}, {none}");
    assert!((0.35..0.65).contains(&(half / whole)), "{half} of {whole}");
}

/// A material that cuts holes where its texture of two texels is transparent.
fn masked(alphas: [u8; 2]) -> Arc<Material> {
    let texture = Texture {
        name: "halves".to_owned(),
        width: 2,
        height: 1,
        rgba8: alphas.iter().flat_map(|alpha| [200, 200, 200, *alpha]).collect(),
        wrap: [TextureWrap::Clamp; 2],
        linear_magnify: false,
        linear_minify: false,
    };
    Arc::new(Material {
        base_color_texture: Some(TextureSlot {
            texture: Arc::new(texture),
            uv_set: 0,
            uv_transform: Affine2::IDENTITY,
        }),
        alpha_mode: AlphaMode::Mask(0.5),
        double_sided: true,
        ..Material::matte(Vec3::ONE)
    })
}

/// A square of side 1 with the texture spread over it.
fn card() -> MeshData {
    let positions = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let mut mesh = MeshData::from_triangles("card", positions.to_vec(), vec![0, 2, 1, 0, 3, 2]);
    mesh.uv0 = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    mesh
}

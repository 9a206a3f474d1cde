//! A spot light of Bevy with a light model lets pass what the same light lets pass in our own renderer.

use antumbra::bevy_adapter::prelude::*;
use bevy::prelude::*;

use crate::harness;
use crate::light_model::{LIGHT, lit, texels};

/// The spot light of both renderers: below it a floor and a box.
const SPOT: [f32; 2] = [0.55, 0.8];

/// A picture of four colours, the shape, the weights and the tint of the spot's model.
fn spot_model() -> (LightShape, Cookie, LightWeights, ShadowTint) {
    let texels = [
        Vec3::new(1.0, 0.4, 0.3),
        Vec3::new(0.3, 1.0, 0.5),
        Vec3::new(0.4, 0.5, 1.0),
        Vec3::ONE,
    ];
    let image = CookieImage::from_linear("four", 2, 2, texels.to_vec()).expect("a picture");
    let shape = LightShape {
        width: 0.3,
        height: 0.2,
        width_edge: 0.3,
        height_edge: 0.3,
        round: 0.6,
    };
    let cookie = Cookie {
        size: 0.7,
        turn: 0.3,
        density: 0.8,
        ..Cookie::new(image)
    };
    // Without highlights, whose formula is Bevy's there and ours here, light is scaled by colour alone.
    let diffuse = LightWeights {
        specular: 0.0,
        ..default()
    };
    let tint = ShadowTint {
        color: Vec3::new(0.1, 0.1, 0.4),
        darkness: 0.8,
    };
    (shape, cookie, diffuse, tint)
}

/// Bevy's spot light without and with its model.
fn bevy_spot() -> [Vec<[f32; 3]>; 2] {
    let mut lit = lit(false);
    let (camera, light) = (lit.camera, lit.light);
    let spot = SpotLight {
        intensity: 300_000.0,
        color: Color::linear_rgb(1.0, 0.5, 0.25),
        inner_angle: SPOT[0],
        outer_angle: SPOT[1],
        range: 1000.0,
        ..default()
    };
    let (shape, cookie, weights, tint) = spot_model();
    let mut entity = lit.game.world().entity_mut(light);
    entity.remove::<(PointLight, StencilVolume)>();
    entity.insert((spot, weights));
    let open = lit.game.run(5).settled(camera);
    let modelled = lit.with((StencilVolume::default(), shape, cookie, weights, tint));
    modelled.save("bevy_spot");
    [open, modelled].map(|picture| texels(&picture).collect())
}

/// The same scene in our own renderer.
fn own_spot() -> [Vec<[f32; 3]>; 2] {
    use crate::core_harness::{strict_context, support::stage::Stage};
    use antumbra::prelude as ours;
    use std::sync::Arc;

    let camera = ours::Camera {
        vertical_fov: std::f32::consts::FRAC_PI_4,
        near: 0.1,
        aspect: harness::SIZE.x as f32 / harness::SIZE.y as f32,
        ..Default::default()
    };
    let view = Transform::from_xyz(0.0, 3.5, 4.5).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(harness::SIZE, camera, view);
    let settings = ours::RenderSettings {
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        ..Default::default()
    };
    stage
        .add_renderer(strict_context(), settings)
        .expect("shaders compose");
    for (mesh, at) in [
        (ours::MeshData::plane(4.0), Vec3::ZERO),
        (ours::MeshData::cuboid(Vec3::splat(0.4)), Vec3::new(0.0, 0.8, 0.0)),
    ] {
        stage.world.spawn((
            ours::SceneMesh(Arc::new(mesh)),
            ours::SceneMaterials([Arc::new(ours::Material::matte(Vec3::splat(0.8)))].into()),
            (ours::ShadowCaster, ours::ShadowReceiver),
            Transform::from_translation(at),
        ));
    }
    let spot = ours::Light {
        kind: ours::LightKind::Spot {
            inner_angle: SPOT[0],
            outer_angle: SPOT[1],
        },
        ..ours::Light::point(Vec3::new(1.0, 0.5, 0.25), 100.0, f32::INFINITY)
    };
    let place = Transform::from_translation(LIGHT).looking_at(Vec3::new(0.0, 0.0, 0.2), Vec3::Z);
    let (shape, cookie, weights, tint) = spot_model();
    let light = stage.spawn_light(spot, place, Some(weights));
    let draw = |stage: &mut Stage| {
        let rendered = stage.render().expect("the frame renders");
        let texels = rendered.radiance.chunks_exact(4);
        texels
            .map(|texel| [texel[0], texel[1], texel[2]])
            .collect::<Vec<_>>()
    };
    let open = draw(&mut stage);
    stage
        .world
        .entity_mut(light)
        .insert((StencilVolume::default(), shape, cookie, tint));
    [open, draw(&mut stage)]
}

#[test]
fn a_bevy_spot_with_a_model_is_the_standalone_one() {
    let ([bevy_open, bevy], [own_open, own]) = (bevy_spot(), own_spot());
    let (mut compared, mut wrong, mut in_shadow, mut largest) = (0, 0, 0, 0.0f32);
    for pixel in 0..own.len() {
        for i in 0..3 {
            let (open, own_open) = (bevy_open[pixel][i], own_open[pixel][i]);
            if open < 0.02 || own_open < 0.02 {
                continue;
            }
            // The share of the light that the model lets pass, by each renderer.
            let (share, own_share) = (bevy[pixel][i] / open, own[pixel][i] / own_open);
            let error = (share - own_share).abs();
            compared += 1;
            // A pixel at the edge of a shadow may be on the other side of it.
            wrong += usize::from(error > (1.0 + own_share) / 300.0);
            if error <= 0.05 {
                largest = largest.max(error);
            }
            in_shadow += usize::from(i == 2 && own_share > 0.02 && own[pixel][2] > own[pixel][0]);
        }
    }
    println!("{compared} channels, {wrong} apart by more than rounding, others by at most {largest:.5}");
    assert!(
        compared > 5000 && in_shadow > 50,
        "{compared} compared, {in_shadow} blueish"
    );
    assert!(wrong * 300 < compared, "{wrong} of {compared} are apart");
}

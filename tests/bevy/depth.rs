//! Our depth is Bevy's.

use antumbra::bevy_adapter::HostEntity;
use antumbra::bevy_adapter::Mirrors;
use antumbra::prelude::{RenderContext, Renderer};
use antumbra::render::readback::read_texture;
use antumbra::scene::SceneMaterials;
use antumbra::sets::View;
use bevy::camera::ScalingMode;
use bevy::prelude::*;
use bevy::render::sync_world::RenderEntity;
use bevy::render::view::ViewDepthTexture;

use crate::harness::{self, Game};

/// Of the orthographic view, metres.
const FAR: f32 = 100.0;

fn game(orthographic: bool) -> (Game, Entity) {
    let mut game = harness::game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(1.0, 3.0, 6.0));
    if orthographic {
        world
            .entity_mut(camera)
            .insert(Projection::Orthographic(OrthographicProjection {
                scaling_mode: ScalingMode::FixedVertical { viewport_height: 5.0 },
                far: FAR,
                ..OrthographicProjection::default_3d()
            }));
    }
    let meshes: [Mesh; 3] = [
        Plane3d::default().mesh().size(8.0, 8.0).into(),
        Cuboid::new(1.0, 1.0, 1.0).into(),
        Sphere::new(0.7).into(),
    ];
    for (i, mesh) in meshes.into_iter().enumerate() {
        let place = Transform::from_xyz(i as f32 - 1.0, 0.3 * i as f32, 0.2)
            .with_rotation(Quat::from_rotation_y(0.4 * i as f32));
        harness::add_mesh(world, mesh, place);
    }
    harness::add_light(world);
    game.run(4).settled(camera);
    (game, camera)
}

fn floats(context: &RenderContext, texture: &wgpu::Texture) -> Vec<f32> {
    let rows = read_texture(context, texture, wgpu::TextureAspect::DepthOnly, "depth").unwrap();
    let texels = rows.bytes.chunks_exact(4);
    texels
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
        .collect()
}

/// Bevy's depth, ours, and how ours is stored.
fn depths(game: &mut Game, camera: Entity) -> (Vec<f32>, Vec<f32>, antumbra::sets::ViewDepth) {
    let view = game.world().get::<RenderEntity>(camera).expect("a camera").id();
    let world = game.render_world();
    let bevys = world
        .get::<ViewDepthTexture>(view)
        .expect("a view")
        .texture
        .clone();
    let mirror = world.resource::<Mirrors>().get(camera).expect("a mirror");
    let renderer = mirror.world.resource::<Renderer>();
    let context = renderer.context();
    let ours = &renderer.targets().expect("targets").depth_stencil;
    let depth = mirror.world.resource::<View>().data.as_ref().unwrap().depth;
    (floats(context, &bevys), floats(context, ours), depth)
}

/// Forgets what we draw over the copy.
fn draw_nothing(game: &mut Game, camera: Entity) {
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    let world = &mut mirrors.get_mut(camera).unwrap().world;
    let drawn: Vec<Entity> = world
        .query_filtered::<Entity, (With<HostEntity>, With<SceneMaterials>)>()
        .iter(world)
        .collect();
    assert_eq!(drawn.len(), 3);
    for object in drawn {
        world.entity_mut(object).remove::<SceneMaterials>();
    }
    game.run(2);
}

#[test]
fn the_copy_is_exact_to_the_bit() {
    let (mut game, camera) = game(false);
    let (bevys, ours, _) = depths(&mut game, camera);
    let shown = bevys.iter().filter(|depth| **depth > 0.0).count();
    assert!(shown > 3000, "{shown}");
    // With our own surfaces over it, it differs by roundings, which is what they are drawn for.
    let ratio = |(a, b): (&f32, &f32)| if a == b { 0.0 } else { (a - b).abs() / a.max(*b) };
    let largest = bevys.iter().zip(&ours).map(ratio).fold(0.0, f32::max);
    let replaced = bevys.iter().zip(&ours).filter(|(a, b)| a != b).count();
    println!("{replaced} of {shown} depths are our own roundings, by at most {largest}");
    assert!(largest < 1e-3, "{largest}");
    draw_nothing(&mut game, camera);
    let (bevys, ours, _) = depths(&mut game, camera);
    let differing = bevys
        .iter()
        .zip(&ours)
        .filter(|(a, b)| a.to_bits() != b.to_bits());
    let differing = differing.count();
    println!("{differing} of {} depths of the copy differ", bevys.len());
    assert_eq!(differing, 0);
}

#[test]
fn the_copy_of_an_orthographic_view_has_its_own_scale() {
    let (mut game, camera) = game(true);
    draw_nothing(&mut game, camera);
    let (bevys, ours, depth) = depths(&mut game, camera);
    let antumbra::sets::ViewDepth::Finite { near, far } = depth else {
        panic!("it is linear");
    };
    let mut worst: f64 = 0.0;
    let mut shown = 0;
    for (bevys, ours) in bevys.iter().zip(&ours) {
        assert_eq!(*bevys == 0.0, *ours == 0.0);
        if *bevys > 0.0 {
            shown += 1;
            let theirs = f64::from(FAR) * (1.0 - f64::from(*bevys));
            worst = worst.max((far - f64::from(*ours) * (far - near) - theirs).abs());
        }
    }
    println!("{shown} depths of an orthographic view, off by at most {worst} m");
    assert!(shown > 3000 && worst < 2e-5, "{worst}");
}

//! Cameras that draw into a part of their target, or share it with cameras of other samples.

use antumbra::bevy_adapter::prelude::*;
use bevy::camera::{Hdr, MainPassResolutionOverride, RenderTarget, Viewport};
use bevy::core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::sync_world::RenderEntity;

use crate::harness::{self, Game, Picture};

const HALF: UVec2 = UVec2::new(64, 36);

fn scene(world: &mut World) {
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    harness::add_mesh(
        world,
        Cuboid::from_length(1.0),
        Transform::from_xyz(0.0, 0.5, 0.0),
    );
    harness::add_light(world);
}

/// The left or right half of a target, for a camera with 4× MSAA.
fn half(world: &mut World, target: &RenderTarget, right: bool) -> Entity {
    let size = UVec2::new(harness::SIZE.x / 2, harness::SIZE.y);
    let viewport = Viewport {
        physical_position: UVec2::new(if right { size.x } else { 0 }, 0),
        physical_size: size,
        ..default()
    };
    let camera = Camera {
        order: isize::from(right),
        viewport: Some(viewport),
        ..default()
    };
    let place = Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let parts = (
        Camera3d::default(),
        Hdr,
        Msaa::Sample4,
        Tonemapping::None,
        target.clone(),
    );
    world.spawn((parts, camera, place)).id()
}

/// A camera with prepasses of its own, at the right of a target.
fn with_prepasses(world: &mut World, target: &RenderTarget) -> Entity {
    let camera = half(world, target, true);
    let prepasses = (DepthPrepass, NormalPrepass, MotionVectorPrepass);
    world.entity_mut(camera).insert(prepasses);
    camera
}

#[test]
fn a_camera_with_prepasses_and_msaa_shares_the_target_of_a_marked_one() {
    let right_halves = |mut app: App, marked: bool| {
        let world = app.world_mut();
        scene(world);
        let mark = |world: &mut World, camera: Entity| {
            if marked {
                world.entity_mut(camera).insert(AntumbraCamera);
            }
        };
        // Bevy makes shared textures for the camera that it meets first.
        let targets = [(); 2].map(|()| harness::target(world, harness::SIZE));
        let left = half(world, &targets[0], false);
        mark(world, left);
        let rights = [
            with_prepasses(world, &targets[0]),
            with_prepasses(world, &targets[1]),
        ];
        let late = half(world, &targets[1], false);
        mark(world, late);
        let mut game = Game::start(app);
        game.run(3);
        let [first, second] = rights;
        let [first, second, of_left, of_late] = game.all_settled([first, second, left, late]);
        let pictures = [first, second].map(|picture| {
            let rows = picture.texels.chunks(harness::SIZE.x as usize);
            let right = rows.flat_map(|row| row[harness::SIZE.x as usize / 2..].to_vec());
            right.collect::<Vec<_>>()
        });
        (pictures, [of_left, of_late])
    };
    let (ours, marked) = right_halves(harness::antumbra(), true);
    let (bevys, _) = right_halves(harness::headless(), false);
    assert!(ours == bevys, "cameras that are not marked are Bevy's to the bit");
    assert_eq!(marked[0].difference(&marked[1]).channels, 0);
    assert!(marked[0].mean() > 0.0);
}

#[test]
fn an_upscalers_part_of_the_target_has_light_and_shadows() {
    let mut game = harness::game();
    let world = game.world();
    scene(world);
    let whole = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let small = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let target = harness::target(world, HALF);
    world.entity_mut(small).insert(target);
    game.run(2);
    // Upscalers insert it in the render world.
    let view = game.world().get::<RenderEntity>(whole).expect("a view").id();
    game.render_world()
        .entity_mut(view)
        .insert(MainPassResolutionOverride(HALF));
    let [whole, small] = game.run(2).all_settled([whole, small]);
    whole.save("upscaled");
    small.save("upscaled_small");
    let rows = whole.texels.chunks(whole.size.x as usize).take(HALF.y as usize);
    let part = Picture {
        size: HALF,
        texels: rows.flat_map(|row| row[..HALF.x as usize].to_vec()).collect(),
    };
    let difference = part.difference(&small);
    assert!(difference.absolute < 0.01, "{difference:?}");
    assert!(small.mean() > 0.01);
}

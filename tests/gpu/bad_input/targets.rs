//! Pictures of no size, of one pixel, and beyond the device; views that see nothing.

use antumbra::render::RenderError;

use super::*;

fn resize(stage: &mut Stage, size: UVec2) {
    stage.world.insert_resource(ViewportSize(size));
}

#[test]
fn a_picture_without_pixels_draws_nothing() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let usual = render(&mut stage);
    for size in [UVec2::ZERO, UVec2::new(96, 0), UVec2::new(0, 64)] {
        resize(&mut stage, size);
        stage.schedule.run(&mut stage.world);
        let mut renderer = stage.world.resource_mut::<Renderer>();
        assert!(renderer.take_failure().is_none());
        assert!(renderer.targets().is_none());
        assert!(renderer.frame().batches.is_empty() && renderer.frame().lights.is_empty());
        let mut encoder = context.device.create_command_encoder(&Default::default());
        renderer.record(&mut encoder, &Default::default());
        context.queue.submit([encoder.finish()]);
    }
    resize(&mut stage, SIZE);
    assert!(same(&usual, &render(&mut stage)), "the picture comes back");
}

#[test]
fn a_picture_of_one_pixel_is_drawn() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    for size in [UVec2::ONE, UVec2::new(1, 64), UVec2::new(96, 1)] {
        resize(&mut stage, size);
        let rendered = render(&mut stage);
        assert_eq!(rendered.radiance.len(), 4 * size.element_product() as usize);
        let seen = rendered.radiance.chunks(4).any(|texel| texel[0] > 0.0);
        assert!(seen, "{size}: something is seen");
    }
}

#[test]
fn a_picture_beyond_the_device_is_an_error_for_its_frame_only() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let usual = render(&mut stage);
    resize(&mut stage, UVec2::new(1 << 20, 4));
    // Objects come in the same frame: what failed must not leave a table that is too short for them.
    let more: Vec<Entity> = (0..100)
        .map(|index| {
            let at = Transform::from_xyz(index as f32 * 0.1 - 5.0, 0.5, -2.0);
            stage
                .world
                .spawn(object(MeshData::cuboid(Vec3::splat(0.04)), at))
                .id()
        })
        .collect();
    let error = stage
        .render()
        .expect_err("no device has a million texels in a row");
    assert!(matches!(error, RenderError::Limit { .. }), "{error}");
    for entity in more {
        stage.world.despawn(entity);
    }
    resize(&mut stage, SIZE);
    assert!(same(&usual, &render(&mut stage)), "the picture comes back");
}

#[test]
fn without_a_usable_camera_nothing_is_drawn() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let usual = render(&mut stage);
    let nan = f32::NAN;
    let mut unusable: Vec<(Camera, Transform)> = [
        Transform::from_xyz(nan, 0.0, 0.0),
        view().with_rotation(glam::Quat::from_xyzw(nan, 0.0, 0.0, 1.0)),
        view().with_scale(Vec3::ZERO),
        Transform::from_xyz(f32::INFINITY, 0.0, 0.0),
    ]
    .map(|at| (camera(), at))
    .into();
    for camera in [
        Camera {
            near: 0.0,
            ..camera()
        },
        Camera {
            near: nan,
            ..camera()
        },
        Camera {
            vertical_fov: 0.0,
            ..camera()
        },
        Camera {
            vertical_fov: 4.0,
            ..camera()
        },
        Camera {
            aspect: f32::INFINITY,
            ..camera()
        },
    ] {
        unusable.push((camera, view()));
    }
    let entity = stage.camera;
    for (bad, at) in unusable {
        stage.world.entity_mut(entity).insert((bad, at));
        let nothing = render(&mut stage);
        assert!(
            nothing.radiance.iter().all(|value| *value == 0.0),
            "{bad:?} {at:?} draws"
        );
    }
    stage.world.entity_mut(entity).remove::<Camera>();
    assert!(render(&mut stage).radiance.iter().all(|value| *value == 0.0));
    stage.world.entity_mut(entity).insert((camera(), view()));
    assert!(same(&usual, &render(&mut stage)), "the picture comes back");
}

#[test]
fn settings_that_are_not_finite_do_not_reach_the_gpu() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let bad = RenderSettings {
        ambient: Vec3::new(f32::NAN, 0.1, f32::INFINITY),
        background: Vec3::new(f32::NAN, 0.1, -f32::INFINITY),
        exposure: f32::NAN,
        ..RenderSettings::default()
    };
    stage.world.resource_mut::<Renderer>().settings = bad;
    let spoilt = render(&mut stage);
    let mut renderer = stage.world.resource_mut::<Renderer>();
    renderer.settings = RenderSettings {
        ambient: Vec3::new(0.0, 0.1, 0.0),
        background: Vec3::new(0.0, 0.1, 0.0),
        exposure: 1.0,
        ..RenderSettings::default()
    };
    assert!(
        same(&spoilt, &render(&mut stage)),
        "numbers that are not finite count as 0, such an exposure as 1"
    );
}

/// The scene changes while nothing is drawn: the target has no size, or is larger than the device allows.
#[test]
fn changes_while_nothing_is_drawn_are_seen_afterwards() {
    let context = strict_context();
    let too_large = context.device.limits().max_texture_dimension_2d + 1;
    for hidden in [UVec2::ZERO, UVec2::new(too_large, 1)] {
        let mut stage = box_on_plane(&context);
        let before = render(&mut stage);
        let change = |stage: &mut Stage| {
            let mut casters = stage.world.query_filtered::<Entity, With<ShadowCaster>>();
            let cube = casters.iter(&stage.world).nth(1).expect("two objects");
            let moved = Transform::from_xyz(0.6, 0.75, 0.4);
            let painted = SceneMaterials([Arc::new(Material::matte(Vec3::X))].into());
            stage.world.entity_mut(cube).insert((moved, painted));
            let more = object(MeshData::icosphere(0.4, 2), Transform::from_xyz(-1.2, 0.6, 0.0));
            stage.world.spawn(more);
        };
        stage.world.insert_resource(ViewportSize(hidden));
        change(&mut stage);
        for _ in 0..2 {
            stage.schedule.run(&mut stage.world);
            stage.world.resource_mut::<Renderer>().take_failure();
        }
        stage.world.insert_resource(ViewportSize(SIZE));
        let after = render(&mut stage);
        let mut fresh = box_on_plane(&context);
        change(&mut fresh);
        assert!(same(&after, &render(&mut fresh)), "hidden by {hidden}");
        assert!(!same(&after, &before), "the change is seen");
    }
}

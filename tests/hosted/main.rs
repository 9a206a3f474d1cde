//! A frame that a host draws and lights: its depth is not ours to the last bit, its targets are larger than the view, its
//! projection is its own. What lights see must be what they see in a frame of our own.

#[path = "../harness/mod.rs"]
mod harness;
mod host;

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{RayScene, primary_hits};
use antumbra::render::hosted::HostView;
use antumbra::sets::FrameLights;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{EulerRot, Quat, UVec2, Vec2, Vec3};
use harness::support::stage::Stage;
use harness::{judge, strict_context};
use host::{Host, far_parallel_projection, finite_projection, oblique_projection};

const SIZE: UVec2 = UVec2::new(160, 90);

fn camera() -> Camera {
    Camera {
        vertical_fov: 0.9,
        near: 0.05,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    }
}

/// An orthographic camera, its near plane behind it.
fn parallel() -> Camera {
    Camera::orthographic(4.9, -1.0, 60.0, SIZE.x as f32 / SIZE.y as f32)
}

/// Boxes and spheres on a ground, at a place of the world where f32 has steps of 8 µm.
fn stage(context: &RenderContext, camera: Camera) -> Stage {
    let middle = Vec3::new(70.0, 3.0, -110.0);
    let view = Transform::from_translation(middle + Vec3::new(2.5, 3.0, 5.0)).looking_at(middle, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    let turned = Quat::from_euler(EulerRot::XYZ, 0.4, 0.7, 0.2);
    let at = |x, y, z| Transform::from_translation(middle + Vec3::new(x, y, z));
    let mut add = |mesh: MeshData, transform: Transform| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            transform,
        ));
    };
    add(
        MeshData::plane(20.0),
        at(0.0, 0.0, 0.0).with_rotation(Quat::from_rotation_x(0.05)),
    );
    add(
        MeshData::cuboid(Vec3::splat(0.5)),
        at(0.0, 0.6, 0.0).with_rotation(turned),
    );
    add(
        MeshData::cuboid(Vec3::splat(0.5)),
        at(-1.5, 0.8, 0.6)
            .with_scale(Vec3::new(-0.5, 1.6, 0.8))
            .with_rotation(turned),
    );
    add(MeshData::icosphere(0.6, 4), at(1.3, 0.7, -0.4));
    add(MeshData::icosphere(0.4, 3), at(-0.2, 1.7, 0.1));
    stage.world.insert_resource(FaceCulling::None);
    stage
}

fn light_at(stage: &mut Stage, kind: LightKind, shadow: impl Bundle) {
    let eye = Vec3::new(72.0, 8.0, -108.0);
    let place = Transform::from_translation(eye).looking_at(Vec3::new(70.0, 3.0, -110.0), Vec3::Z);
    let range = f32::INFINITY;
    stage.spawn_light(
        Light {
            kind,
            range,
            ..Light::point(Vec3::ONE, 20.0, range)
        },
        place,
        Some(shadow),
    );
}

fn alone(camera: &Camera) -> HostView {
    HostView {
        target_size: SIZE,
        viewport_origin: UVec2::ZERO,
        clip_from_view: camera.clip_from_view(),
    }
}

/// Pictures of the first light's visibility: of a frame of our own, and of one in a host.
fn both(context: &RenderContext, stage: &mut Stage, view: HostView) -> [Vec<f32>; 2] {
    let set_host = |stage: &mut Stage, view| {
        let mut renderer = stage.world.resource_mut::<Renderer>();
        renderer.set_host(view).expect("shaders compose");
    };
    set_host(stage, None);
    let own = stage.render().expect("the frame renders").visibility.remove(0);
    set_host(stage, Some(view));
    let host = Host::new(context, view);
    stage.schedule.run(&mut stage.world);
    host.draw_depth(&mut stage.world, SIZE);
    let mut renderer = stage.world.resource_mut::<Renderer>();
    assert!(renderer.take_failure().is_none());
    assert!(renderer.radiance().is_none(), "the host has the radiance");
    let (added, values) = host.add_lights(&renderer);
    assert_eq!(added, stage.lights, "each light is added once");
    let outside = values.len() - SIZE.element_product() as usize;
    let hosted = host.crop(&values, SIZE);
    let nothing = values.iter().filter(|value| **value == 0.0).count();
    let inside = hosted.iter().filter(|value| **value == 0.0).count();
    assert_eq!(nothing - inside, outside, "nothing outside of the view is lit");
    [own, hosted]
}

/// Whether each pixel shows something: where nothing is, a host adds nothing, and visibility is 1.
fn shows(stage: &mut Stage) -> Vec<bool> {
    let scene = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).unwrap();
    let transform = stage.world.get::<GlobalTransform>(stage.camera).unwrap();
    let hits = primary_hits(&scene, camera, transform, SIZE).unwrap().hits;
    hits.iter().map(Option::is_some).collect()
}

/// Of pixels that show something, off the edges of shadows, where two rasterizers may differ: how many differ, how many
/// there are.
fn differing(stage: &mut Stage, own: &[f32], hosted: &[f32], tolerance: f32) -> (usize, usize) {
    let shows = shows(stage);
    let (width, height) = (SIZE.x as usize, SIZE.y as usize);
    let flat = |picture: &[f32], p: usize| {
        [p, p - 1, p + 1, p - width, p + width]
            .iter()
            .all(|&q| shows[q] && (picture[q] - picture[p]).abs() <= tolerance)
    };
    let inner = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| y * width + x));
    let judged: Vec<usize> = inner.filter(|&p| flat(own, p)).collect();
    let wrong = judged.iter().filter(|&&p| (own[p] - hosted[p]).abs() > tolerance);
    (wrong.count(), judged.len())
}

/// In perspective, and in an orthographic view.
fn compare(name: &str, kind: LightKind, shadow: impl Bundle + Clone, tolerance: f32) {
    let context = strict_context(RequestedFeatures::default());
    for camera in [camera(), parallel()] {
        let mut stage = stage(&context, camera);
        light_at(&mut stage, kind, shadow.clone());
        let [own, hosted] = both(&context, &mut stage, alone(&camera));
        let (wrong, judged) = differing(&mut stage, &own, &hosted, tolerance);
        println!("{name}, {camera:?}: {wrong} of {judged} pixels differ off the edges");
        assert_eq!(wrong, 0, "{name}");
        let dark = hosted.iter().filter(|value| **value < 0.5).count();
        assert!((500..judged).contains(&dark), "{name}: {dark} pixels are dark");
    }
}

#[test]
fn another_light_differs() {
    let context = strict_context(RequestedFeatures::default());
    let mut pictures = [LightKind::Point, LightKind::Directional].map(|kind| {
        let mut stage = stage(&context, camera());
        light_at(&mut stage, kind, StencilVolume::default());
        let [own, hosted] = both(&context, &mut stage, alone(&camera()));
        (stage, own, hosted)
    });
    let other = pictures[1].2.clone();
    let (stage, own, _) = &mut pictures[0];
    let (wrong, _) = differing(stage, own, &other, 0.0);
    assert!(wrong > 100, "{wrong} pixels differ");
}

#[test]
fn stencil_volumes_are_as_in_a_frame_of_our_own() {
    compare("stencil", LightKind::Point, StencilVolume::default(), 0.0);
}

#[test]
fn wedges_are_as_in_a_frame_of_our_own() {
    let kind = LightKind::Rect {
        width: 0.6,
        height: 0.4,
    };
    compare("wedges", kind, PenumbraWedge::default(), 0.04);
}

#[test]
fn maps_are_as_in_a_frame_of_our_own() {
    compare("omni map", LightKind::Point, OmniMap::default(), 0.1);
    let spot = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    compare("spot map", spot, ShadowMap::default(), 0.1);
}

#[test]
fn hosted_shadows_are_the_ray_casters() {
    let context = strict_context(RequestedFeatures::default());
    for (name, camera, project) in [
        ("as ours", camera(), None),
        (
            "far plane",
            camera(),
            Some(finite_projection as fn(&Camera, f64) -> _),
        ),
        (
            "jittered",
            Camera {
                shift: Vec2::new(0.31, -0.22) / SIZE.as_vec2(),
                ..camera()
            },
            None,
        ),
        (
            "off-centre",
            Camera {
                shift: Vec2::new(0.4, -0.3),
                ..camera()
            },
            None,
        ),
        ("orthographic", parallel(), None),
        (
            "orthographic and off-centre, with a far plane at a kilometre",
            Camera {
                shift: Vec2::new(0.4, -0.3),
                ..parallel()
            },
            Some(far_parallel_projection),
        ),
    ] {
        let mut stage = stage(&context, camera);
        light_at(&mut stage, LightKind::Point, StencilVolume::default());
        let mut view = alone(&camera);
        if let Some(project) = project {
            view.clip_from_view = project(&camera, 60.0);
        }
        let [own, hosted] = both(&context, &mut stage, view);
        let shows = shows(&mut stage);
        let scene = RayScene::from_world(&mut stage.world);
        let pairs = hosted.iter().zip(&shows);
        let shown = pairs
            .map(|(value, shows)| if *shows { *value } else { 1.0 })
            .collect();
        for (who, picture) in [("own", &own), ("hosted", &shown)] {
            let error = judge(&stage, &scene, 0, picture);
            println!("{name}, {who}: {error:?}");
            assert_eq!(error.wrong_inner, 0, "{name}, {who}: {error:?}");
        }
    }
}

#[test]
fn a_view_in_a_part_of_larger_targets() {
    let context = strict_context(RequestedFeatures::default());
    let camera = camera();
    let rect = LightKind::Rect {
        width: 0.6,
        height: 0.4,
    };
    for technique in 0..3 {
        let mut stage = stage(&context, camera);
        match technique {
            0 => light_at(&mut stage, LightKind::Point, StencilVolume::default()),
            1 => light_at(&mut stage, rect, PenumbraWedge::default()),
            _ => light_at(&mut stage, LightKind::Point, OmniMap::default()),
        }
        let [_, whole] = both(&context, &mut stage, alone(&camera));
        let part = HostView {
            target_size: SIZE + UVec2::new(45, 33),
            viewport_origin: UVec2::new(17, 29),
            ..alone(&camera)
        };
        let [_, placed] = both(&context, &mut stage, part);
        let differing = whole
            .iter()
            .zip(&placed)
            .filter(|(a, b)| (**a - **b).abs() > 0.02)
            .count();
        println!("technique {technique}: {differing} pixels differ");
        assert!(
            differing <= 12,
            "technique {technique}: {differing} pixels differ"
        );
    }
}

#[test]
fn an_oblique_near_plane_cuts_the_picture_alone() {
    let context = strict_context(RequestedFeatures::default());
    let camera = camera();
    let mut stage = stage(&context, camera);
    light_at(&mut stage, LightKind::Point, StencilVolume::default());
    let view = HostView {
        clip_from_view: oblique_projection(&camera),
        ..alone(&camera)
    };
    let [own, hosted] = both(&context, &mut stage, view);
    let (wrong, judged) = differing(&mut stage, &own, &hosted, 0.0);
    println!("{wrong} of {judged} differ");
    assert_eq!(wrong, 0);
}

/// The host does not show an object that casts, as when its material is all hole: what lies behind it receives, and shows
/// its shadow.
#[test]
fn what_the_host_does_not_show_still_casts() {
    let context = strict_context(RequestedFeatures::default());
    let view = alone(&camera());
    let mut stage = stage(&context, camera());
    light_at(&mut stage, LightKind::Point, StencilVolume::default());
    let ball = stage
        .world
        .query_filtered::<(Entity, &SceneMesh), With<ShadowCaster>>()
        .iter(&stage.world)
        .max_by_key(|(_, mesh)| mesh.0.indices.len())
        .map(|(entity, _)| entity)
        .expect("there is a ball");
    // Told so, since its surface would otherwise be taken to hide its near cap.
    stage.world.entity_mut(ball).remove::<SceneMaterials>();
    let mut renderer = stage.world.resource_mut::<Renderer>();
    renderer.set_host(Some(view)).unwrap();
    stage.schedule.run(&mut stage.world);
    let mut host = Host::new(&context, view);
    host.hidden = Some(ball);
    host.draw_depth(&mut stage.world, SIZE);
    let (_, hosted) = host.add_lights(stage.world.resource::<Renderer>());
    let shows = shows(&mut stage);
    let scene = RayScene::from_world(&mut stage.world);
    let pairs = hosted.iter().zip(&shows);
    let shown: Vec<f32> = pairs
        .map(|(value, shows)| if *shows { *value } else { 1.0 })
        .collect();
    let error = judge(&stage, &scene, 0, &shown);
    println!("{error:?}");
    assert_eq!(error.wrong_inner, 0, "{error:?}");
    assert!(error.inner > 10_000);
}

#[test]
fn a_view_outside_of_its_targets_is_refused() {
    let context = strict_context(RequestedFeatures::default());
    let mut stage = stage(&context, camera());
    let view = HostView {
        viewport_origin: UVec2::new(1, 0),
        ..alone(&camera())
    };
    let mut renderer = stage.world.resource_mut::<Renderer>();
    renderer.set_host(Some(view)).unwrap();
    stage.schedule.run(&mut stage.world);
    let mut renderer = stage.world.resource_mut::<Renderer>();
    let failure = renderer.take_failure().expect("it is refused").to_string();
    assert!(failure.contains("160") && failure.contains("host"), "{failure}");
    let host = Host::new(&context, view);
    let (added, values) = host.add_lights(&renderer);
    assert!(added.is_empty() && values.iter().all(|v| *v == 0.0));
}

/// Tiles behind a wall, all dark, and a pole among them that the light sees over the wall: the light pass of a frame of our
/// own need not draw the tiles, and nothing need shadow them; a host lights whatever is there.
fn dark_tiles(context: &RenderContext) -> Stage {
    let view = Transform::from_xyz(13.0, 5.0, 3.0).looking_at(Vec3::new(3.0, 1.0, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera(), view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    let mut add = |half: Vec3, at: Vec3| {
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::cuboid(half))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at),
        ));
    };
    add(Vec3::new(0.1, 1.5, 9.0), Vec3::new(0.0, 1.5, 0.0));
    add(Vec3::new(0.1, 4.0, 0.1), Vec3::new(3.0, 4.0, 0.5));
    for tile in 0..24 {
        let (row, column) = ((tile / 6) as f32, (tile % 6) as f32);
        let at = Vec3::new(1.5 + 2.0 * row, 0.0, 2.0 * column - 5.0);
        add(Vec3::new(0.95, 0.05, 0.95), at);
    }
    let place = Transform::from_xyz(-2.0, 2.0, 0.0);
    let light = Light::point(Vec3::ONE, 20.0, 14.0);
    stage.spawn_light(light, place, Some(StencilVolume::default()));
    stage
}

#[test]
fn what_the_light_does_not_see_stays_dark() {
    let context = strict_context(RequestedFeatures::default());
    let mut stage = dark_tiles(&context);
    let [own, hosted] = both(&context, &mut stage, alone(&camera()));
    let lights = stage.world.resource::<FrameLights>();
    assert!(lights.lights[0].dark.count_ones(..) > 6, "tiles are left out");
    let (wrong, judged) = differing(&mut stage, &own, &hosted, 0.0);
    println!("{wrong} of {judged} pixels differ off the edges");
    assert_eq!(wrong, 0);
}

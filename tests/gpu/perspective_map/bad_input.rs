//! Bad settings are refused, orthographic views get a uniform map and a report, and views of nothing draw nothing.

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::reports::Reports;
use antumbra::techniques::maps::{MapFilter, MapResolution};
use antumbra::techniques::{MapFocus, PerspectiveMaps};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::{KINDS, SPOT, variants};
use crate::harness::{judge, strict_context};
use crate::maps::scenes;

#[test]
fn settings_that_cannot_be_drawn_are_refused() {
    let (mut stage, _) = scenes::all()[0].stage(&strict_context());
    let bad = [
        PerspectiveMap {
            slide: Some(-1.0),
            ..Default::default()
        },
        PerspectiveMap {
            slide: Some(f32::NAN),
            ..Default::default()
        },
        PerspectiveMap {
            resolution: MapResolution::Fixed(0),
            ..Default::default()
        },
        PerspectiveMap {
            near: Some(0.0),
            ..Default::default()
        },
        PerspectiveMap {
            filter: MapFilter::Soft4 { softness: -1.0 },
            ..Default::default()
        },
    ];
    for map in bad {
        let (light, place) = scenes::all()[0].light(SPOT);
        let entity = stage.spawn_light(light, place, Some(map));
        let rendered = stage.render().expect("the frame renders");
        assert!(rendered.visibility[0].iter().all(|v| *v == 1.0), "{map:?}");
        let reports = stage.world.resource::<Reports>();
        assert!(
            reports
                .of_entity(entity)
                .any(|report| report.message.contains("no shadow")),
            "{map:?}"
        );
        stage.lights.clear();
        stage.world.despawn(entity);
    }
}

#[test]
fn an_orthographic_view_has_a_uniform_map_and_a_report() {
    let scene = &scenes::all()[0];
    let (mut stage, _) = scene.stage(&strict_context());
    let slid = PerspectiveMap {
        slide: Some(1.0),
        focus: MapFocus::All,
        ..variants(512)[0]
    };
    for kind in KINDS {
        // The view begins before or behind the virtual viewer.
        for (map, near) in [(variants(512)[0], 0.1), (variants(512)[2], 0.1), (slid, -20.0)] {
            let aspect = scenes::SIZE.x as f32 / scenes::SIZE.y as f32;
            let entity = stage.camera;
            let camera = Camera::orthographic(4.0, near, 50.0, aspect);
            stage.world.entity_mut(entity).insert(camera);
            for light in stage.lights.drain(..) {
                stage.world.despawn(light);
            }
            let (light, place) = scene.light(kind);
            stage.spawn_light(light, place, Some(map));
            let rendered = stage.render().expect("the frame renders");
            let rays = RayScene::from_world(&mut stage.world);
            let error = judge(&stage, &rays, 0, &rendered.visibility[0]);
            assert!(
                error.share().is_none_or(|share| share <= 0.005),
                "{kind:?} {map:?}: {error:?}"
            );
            let dark = rendered.visibility[0].iter().filter(|v| **v == 0.0).count();
            assert!(dark > 100, "{kind:?} {map:?}: {dark} pixels are dark");
            let fit = stage
                .world
                .resource::<PerspectiveMaps>()
                .of_light(0)
                .expect("it is fitted");
            assert_eq!(fit.slide, f64::INFINITY);
            let told = stage
                .world
                .resource::<Reports>()
                .iter()
                .any(|report| report.message.contains("uniform"));
            assert!(told, "{kind:?}");
        }
    }
}

/// The virtual viewer would stand at the near plane, where w grows by more than the rounding of casters allows.
#[test]
fn without_a_slide_before_a_tiny_near_plane_shadows_are_right() {
    let scene = &scenes::all()[0];
    let (mut stage, rays) = scene.stage(&strict_context());
    let entity = stage.camera;
    let camera = stage.world.entity(entity).get::<Camera>();
    let camera = Camera {
        near: 1e-4,
        ..*camera.expect("a camera")
    };
    stage.world.entity_mut(entity).insert(camera);
    for kind in KINDS {
        for light in stage.lights.drain(..) {
            stage.world.despawn(light);
        }
        let (light, place) = scene.light(kind);
        stage.spawn_light(light, place, Some(variants(512)[4]));
        let rendered = stage.render().expect("the frame renders");
        let error = judge(&stage, &rays, 0, &rendered.visibility[0]);
        let dark = rendered.visibility[0].iter().filter(|v| **v == 0.0).count();
        println!("{kind:?}: {dark} dark, {error:?}");
        assert!(dark > 100, "{kind:?}: {dark} pixels are dark");
        let share = error.share().expect("pixels count");
        assert!(share <= 0.005, "{kind:?}: {error:?}");
    }
}

#[test]
fn views_of_nothing_and_lights_in_corners_draw_without_a_fault() {
    let scene = &scenes::all()[0];
    let (mut stage, _) = scene.stage(&strict_context());
    let eye = Vec3::new(1.6, 1.5, 2.6);
    let targets = [
        Vec3::new(0.0, 0.35, 0.0),
        eye + Vec3::Y,
        eye + Vec3::new(1.0, 0.6, 1.0),
        eye + Vec3::X,
    ];
    for target in targets {
        let up = if target == eye + Vec3::Y { Vec3::X } else { Vec3::Y };
        let view = Transform::from_translation(eye).looking_at(target, up);
        let camera = stage.camera;
        stage.world.entity_mut(camera).insert(view);
        // At the eye, on a corner of the near plane, far away, on the floor.
        let corner = eye + view.forward() * 0.02 + view.right() * 0.0172 + view.up() * 0.00966;
        for at in [
            eye,
            corner,
            Vec3::splat(1e6),
            Vec3::new(0.3, 0.0, 1.2),
            Vec3::new(0.0, 0.5, 0.0),
        ] {
            for kind in KINDS {
                for map in variants(64) {
                    for light in stage.lights.drain(..) {
                        stage.world.despawn(light);
                    }
                    let light = Light {
                        kind,
                        ..Light::point(Vec3::ONE, 20.0, f32::INFINITY)
                    };
                    let place = Transform::from_translation(at).looking_at(Vec3::new(0.1, 0.2, 0.3), Vec3::Z);
                    stage.spawn_light(light, place, Some(map));
                    let rendered = stage.render().expect("the frame renders");
                    assert!(rendered.visibility[0].iter().all(|v| (0.0..=1.0).contains(v)));
                }
            }
        }
    }
}

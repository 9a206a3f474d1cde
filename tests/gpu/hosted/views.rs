//! Cameras and projections of a host that are not ours, and views in a part of its targets.

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::render::HostView;
use glam::{UVec2, Vec2};

use super::comparison::{both, differing, visibility_of_shown};
use super::host::{Host, far_parallel_projection, finite_projection, oblique_projection};
use super::scenes::{SIZE, alone, camera, light_at, parallel, stage};
use crate::harness::{judge, strict_context};

#[test]
fn hosted_shadows_are_the_ray_casters() {
    let context = strict_context();
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
        let shown = visibility_of_shown(&mut stage, &hosted);
        let scene = RayScene::from_world(&mut stage.world);
        for (who, picture) in [("own", &own), ("hosted", &shown)] {
            let error = judge(&stage, &scene, 0, picture);
            println!("{name}, {who}: {error:?}");
            assert_eq!(error.wrong_inner, 0, "{name}, {who}: {error:?}");
        }
    }
}

#[test]
fn a_view_in_a_part_of_larger_targets() {
    let context = strict_context();
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
    let context = strict_context();
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

#[test]
fn a_view_outside_of_its_targets_is_refused() {
    let context = strict_context();
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

//! What holds of wedges whatever they are compared with.

use antumbra::prelude::*;
use antumbra::techniques::penumbra_wedge::WedgeCulling;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::scenes::{
    EYE, Lit, SAMPLES, crowd, ground, judge, light, lit, rect, rendered, spawn, sphere, truth,
};
use crate::harness::strict_context;

#[test]
fn without_extent_the_shadow_is_that_of_stencil_volumes() {
    let context = strict_context();
    for kind in [
        rect(0.0, 0.0),
        sphere(0.0),
        LightKind::Point,
        LightKind::Directional,
    ] {
        let mut stage = crowd(&context, false);
        let entity = light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let wedges = rendered(&mut stage, 0);
        assert!(wedges.values().contains(&0.0));
        stage
            .world
            .entity_mut(entity)
            .remove::<PenumbraWedge>()
            .insert(StencilVolume::default());
        let volumes = rendered(&mut stage, 0);
        // The faces of volumes lie 1/512 of a pixel farther than those of wedges: pixels that near an edge may differ.
        let pairs = || wedges.values().iter().zip(volumes.values());
        let differing = pairs().filter(|(a, b)| a != b).count();
        assert!(
            differing * 1000 <= wedges.values().len(),
            "{kind:?}: {differing} pixels differ"
        );
    }
}

#[test]
fn the_camera_may_stand_in_shadow_and_wedge() {
    let context = strict_context();
    for (name, eye) in [
        ("umbra", Vec3::new(0.0, 0.25, 0.1)),
        ("wedge", Vec3::new(0.95, 0.5, 0.2)),
    ] {
        let mut stage = ground(&context, eye, Vec3::new(-2.0, 0.0, -2.5));
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(0.9, 0.1, 0.9)),
            Transform::from_xyz(0.0, 1.2, 0.0),
        );
        let above = Lit {
            from: Vec3::new(0.0, 4.5, 0.0),
            ..lit(rect(0.6, 0.6), PenumbraWedge::default())
        };
        light(&mut stage, &above);
        let truth = truth(&mut stage, 0, SAMPLES);
        for culling in [WedgeCulling::Depth, WedgeCulling::Stencil] {
            let light = stage.lights[0];
            stage.world.entity_mut(light).insert(PenumbraWedge {
                culling,
                ..Default::default()
            });
            let error = judge(&mut stage, &truth, &format!("inside_{name}_{culling:?}"));
            assert!(
                error.penumbra > 100 && error.rmse_penumbra <= 0.01,
                "{name} {culling:?}: {error:?}"
            );
        }
    }
}

#[test]
fn contact_leaks_nothing() {
    let context = strict_context();
    for kind in [rect(0.5, 0.5), sphere(0.25)] {
        let mut stage = ground(&context, EYE, Vec3::new(0.0, 0.2, 0.0));
        // A sliver into the ground.
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(0.5, 0.6, 0.5)),
            Transform::from_xyz(0.0, 0.55, 0.0).with_rotation(Quat::from_rotation_y(0.5)),
        );
        light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let truth = truth(&mut stage, 0, SAMPLES);
        let error = judge(&mut stage, &truth, "contact");
        let got = rendered(&mut stage, 0);
        let (width, height) = (truth.size().x as i32, truth.size().y as i32);
        // Off a band of one pixel: where all neighbours agree.
        let (mut lit, mut dark) = (0, 0);
        for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
            let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let values: Vec<f32> = near
                .filter_map(|(dx, dy)| truth.get((x + dx) as u32, (y + dy) as u32))
                .collect();
            let value = got.get(x as u32, y as u32).unwrap();
            lit += usize::from(values.iter().all(|v| *v == 0.0) && value > 0.1);
            dark += usize::from(values.iter().all(|v| *v == 1.0) && value < 0.9);
        }
        assert_eq!((lit, dark), (0, 0), "{kind:?} {error:?}");
    }
}

#[test]
fn the_debug_view_shows_wedges() {
    let context = strict_context();
    for kind in [rect(0.8, 0.5), sphere(0.4), LightKind::Point] {
        let mut stage = crowd(&context, false);
        light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let without = stage.render().expect("a frame");
        stage.world.resource_mut::<Renderer>().settings.debug_volumes = true;
        let with = stage.render().expect("a frame");
        let brighter = with.radiance.iter().zip(&without.radiance).filter(|(a, b)| a > b);
        assert!(brighter.count() > 1000, "{kind:?}");
        assert_eq!(with.visibility, without.visibility, "{kind:?}");
    }
}

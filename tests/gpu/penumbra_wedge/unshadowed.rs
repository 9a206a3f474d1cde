//! Lights that nothing shadows record no wedges, and have their shadows as soon as something casts.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::PenumbraWedges;
use antumbra::techniques::penumbra_wedge::{EmitterTexture, LightTexture};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{EYE, Lit, ground, light, rect, spawn, sphere};
use crate::harness::strict_context;
use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;

/// A floor that does not cast, and two lamps: the first is a ball in two parts, the second a rectangle.
fn stage(with_wedges: bool) -> Stage {
    let mut stage = ground(&strict_context(), EYE, Vec3::ZERO);
    let mut floors = stage.world.query_filtered::<Entity, With<ShadowCaster>>();
    let floors: Vec<_> = floors.iter(&stage.world).collect();
    for floor in floors {
        stage.world.entity_mut(floor).remove::<ShadowCaster>();
    }
    for (kind, x, split) in [(sphere(0.3), -1.0, [2, 1]), (rect(0.8, 0.6), 1.0, [1, 1])] {
        let lamp = Lit {
            kind,
            from: Vec3::new(x, 4.0, 0.2),
            to: Vec3::new(x, 0.0, 0.2),
            wedge: PenumbraWedge {
                split,
                ..PenumbraWedge::default()
            },
        };
        let entity = light(&mut stage, &lamp);
        if !with_wedges {
            stage.world.entity_mut(entity).remove::<PenumbraWedge>();
        }
    }
    stage
}

fn render(stage: &mut Stage) -> Rendered {
    stage.render().expect("the frame renders")
}

fn same(a: &Rendered, b: &Rendered) -> bool {
    a.visibility == b.visibility && a.radiance == b.radiance
}

fn plate(stage: &mut Stage) -> Entity {
    spawn(
        stage,
        MeshData::cuboid(Vec3::new(0.5, 0.1, 0.4)),
        Transform::from_xyz(0.2, 1.4, 0.0),
    )
}

/// Number of lights and of parts for which something is recorded.
fn recorded(stage: &Stage) -> [usize; 2] {
    let wedges = stage.world.resource::<PenumbraWedges>();
    [wedges.lights.len(), wedges.parts.len()]
}

#[test]
fn lights_that_nothing_shadows_record_nothing() {
    let plain = render(&mut stage(false));
    let mut fresh = stage(true);
    plate(&mut fresh);
    let shadowed = render(&mut fresh);
    assert_eq!(recorded(&fresh), [2, 3]);
    for visibility in &shadowed.visibility {
        assert!(visibility.iter().filter(|v| **v < 0.5).count() > 50);
    }

    let mut stage = stage(true);
    for _ in 0..2 {
        let lit = render(&mut stage);
        assert_eq!(recorded(&stage), [0, 0]);
        assert!(lit.visibility.iter().flatten().all(|v| *v == 1.0));
        assert!(same(&lit, &plain), "it is lit as without a technique");
        let caster = plate(&mut stage);
        assert!(same(&render(&mut stage), &shadowed), "the caster comes");
        assert_eq!(recorded(&stage), [2, 3]);
        assert!(same(&render(&mut stage), &shadowed), "at rest");
        stage.world.despawn(caster);
    }
}

/// One light loses its only caster while the other one keeps its own.
#[test]
fn the_wedges_of_other_lights_stay() {
    for goes in 0..2 {
        let mut stage = stage(true);
        for (at, entity) in stage.lights.clone().into_iter().enumerate() {
            let selection = LightSelection {
                casts_for: 1 << at,
                ..LightSelection::default()
            };
            stage.world.entity_mut(entity).insert(selection);
        }
        let casters = [0, 1].map(|at| {
            let caster = plate(&mut stage);
            stage.world.entity_mut(caster).insert(SelectionLayers(1 << at));
            caster
        });
        let both = render(&mut stage);
        let layers = SelectionLayers(0);
        let kept = SelectionLayers(1 << goes);
        stage.world.entity_mut(casters[goes]).insert(layers);
        let one = render(&mut stage);
        assert_eq!(recorded(&stage)[0], 1);
        assert!(one.visibility[goes].iter().all(|v| *v == 1.0));
        assert!(one.visibility[1 - goes] == both.visibility[1 - goes]);
        stage.world.entity_mut(casters[goes]).insert(kept);
        assert!(render(&mut stage).visibility == both.visibility);
    }
}

#[test]
fn casters_without_area_shadow_nothing() {
    let mut stage = stage(true);
    let line = vec![Vec3::ZERO, Vec3::X * 0.5, Vec3::X];
    let line = MeshData::from_triangles("line", line, vec![0, 1, 2]);
    spawn(&mut stage, line, Transform::from_xyz(0.0, 1.4, 0.0));
    let lit = render(&mut stage);
    let lights = &stage.world.resource::<FrameLights>().lights;
    assert!(lights.iter().all(|light| !light.sets.s.is_clear()));
    let darkest = lit.visibility.iter().flatten().fold(1.0f32, |a, b| a.min(*b));
    assert!(darkest > 0.99, "{darkest}");
}

/// The colours of a texture come with the mask, whether or not there are shadows.
#[test]
fn a_textured_light_keeps_its_colours() {
    let mut stage = stage(true);
    let plain = render(&mut stage);
    let red = vec![vec![Vec3::X]];
    let texture = Arc::new(LightTexture::new(1, 1, red).expect("a texel"));
    let rectangle = stage.lights[1];
    stage
        .world
        .entity_mut(rectangle)
        .insert(EmitterTexture { texture, frame: 0 });
    let red = render(&mut stage);
    assert_eq!(recorded(&stage), [1, 1]);
    let sum = |rendered: &Rendered, channel: usize| -> f32 {
        rendered.radiance.iter().skip(channel).step_by(4).sum()
    };
    assert!((sum(&red, 0) / sum(&plain, 0) - 1.0).abs() < 1e-2);
    assert!(sum(&red, 1) < 0.8 * sum(&plain, 1));
}

//! Counting in front of surfaces and counting behind them give the same picture.

use antumbra::prelude::*;
use antumbra::techniques::PenumbraWedges;
use antumbra::techniques::penumbra_wedge::WedgeCulling;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{Lit, ground, light, spawn, sphere};
use crate::harness::strict_context;

/// A table under a lamp, and a box above, whose shadow passes beside the eye: no surface receives it, so its wedges end below
/// the eye, and rays of view would enter it where it has no cap.
#[test]
fn casters_counted_towards_the_viewer_leave_the_others_alone() {
    let context = strict_context();
    let toward = Vec3::new(-0.09, 0.65, -0.14);
    let mut counted = 0;
    for eye in [
        Vec3::new(-3.93, 3.3, 0.09),
        Vec3::new(-3.93, 3.3, -0.21),
        Vec3::new(-3.93, 3.0, 0.09),
    ] {
        let mut stage = ground(&context, eye, toward);
        let above = Transform::from_xyz(-0.9421, 1.7381, 0.1089);
        spawn(&mut stage, MeshData::cuboid(Vec3::splat(0.5)), above);
        let table = Transform::from_xyz(0.02, 0.45, -0.93);
        spawn(&mut stage, MeshData::plane(1.5), table);
        let from = Vec3::new(0.0193, 0.6653, -0.9311);
        let lamp = Lit {
            kind: sphere(0.05),
            from,
            to: from + Vec3::NEG_Y,
            wedge: PenumbraWedge::default(),
        };
        let lamp = light(&mut stage, &lamp);
        let [towards, away] = [WedgeCulling::Depth, WedgeCulling::None].map(|culling| {
            let wedge = PenumbraWedge {
                culling,
                ..Default::default()
            };
            stage.world.entity_mut(lamp).insert(wedge);
            let rendered = stage.render().expect("the frame renders");
            let casters = &stage.world.resource::<PenumbraWedges>().casters;
            counted += casters.iter().filter(|caster| caster.towards).count();
            rendered.visibility[0].clone()
        });
        let different = towards
            .iter()
            .zip(&away)
            .filter(|(a, b)| (*a - *b).abs() > 0.01)
            .count();
        let dark = away.iter().filter(|v| **v < 0.5).count();
        println!("{eye}: {different} pixels differ, {dark} are dark");
        assert!(dark > 1000 && different <= 10, "{eye}: {different} of {dark}");
    }
    assert!(counted > 0, "no caster is counted towards the viewer");
}

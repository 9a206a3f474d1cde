//! Nothing is kept of objects that are gone.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::silhouettes::CasterEdges;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{ground, lamp, object};
use crate::harness::support::stage::Stage;

#[test]
fn silhouettes_of_despawned_casters_let_go_of_their_mesh() {
    let mut stage = ground();
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.3, 5.0, 0.2), 30.0);
    stage.world.entity_mut(light).insert(StencilVolume::default());
    let spawn = |stage: &mut Stage, height: f32| {
        let mesh = MeshData::cuboid(Vec3::splat(0.5));
        let place = Transform::from_xyz(0.0, height, 0.0);
        let id = stage.world.spawn(object(mesh, place)).id();
        stage.schedule.run(&mut stage.world);
        id
    };
    let first = spawn(&mut stage, 1.0);
    let edges = stage.world.get::<CasterEdges>(first).expect("it casts");
    let edges = Arc::downgrade(&edges.0);
    assert!(edges.upgrade().is_some());
    stage.world.despawn(first);
    stage.schedule.run(&mut stage.world);
    // Edge meshes that are not in use are given up when a new mesh comes. This one is out of the light's range, so it takes
    // over nothing of the light.
    spawn(&mut stage, -500.0);
    assert!(edges.upgrade().is_none());
}

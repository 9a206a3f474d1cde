//! Meshes that are modelled or placed twice in one place cast as once.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::silhouettes::CoincidentCasters;
use antumbra::techniques::PenumbraWedges;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{Lit, ground, light, rect, spawn};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const POSTS: usize = 6;

fn post(number: usize) -> (MeshData, Transform) {
    let at = Transform::from_xyz(-0.6 + 0.24 * number as f32, 0.7, 0.0);
    (MeshData::cuboid(Vec3::new(0.02, 0.7, 0.02)), at)
}

/// All posts as one mesh, each so many times.
fn as_one_mesh(times: usize) -> MeshData {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for number in (0..times).flat_map(|_| 0..POSTS) {
        let (mesh, place) = post(number);
        let first = positions.len() as u32;
        indices.extend(mesh.indices.iter().map(|index| first + index));
        positions.extend(mesh.positions.iter().map(|p| place.transform_point(*p)));
    }
    MeshData::from_triangles("posts", positions, indices)
}

fn lamp_over_ground() -> Stage {
    let mut stage = ground(&strict_context(), Vec3::new(0.5, 2.0, 2.5), Vec3::ZERO);
    let lamp = Lit {
        kind: rect(0.5, 0.5),
        from: Vec3::new(1.7, 3.9, 1.3),
        to: Vec3::new(0.0, 0.9, 0.0),
        wedge: PenumbraWedge::default(),
    };
    light(&mut stage, &lamp);
    stage
}

fn visibility(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("a frame").visibility[0].clone()
}

#[test]
fn what_is_placed_twice_casts_as_once() {
    let mut stage = lamp_over_ground();
    for number in 0..POSTS {
        let (mesh, place) = post(number);
        spawn(&mut stage, mesh, place);
    }
    let once = visibility(&mut stage);
    let shadowed = once.iter().filter(|value| **value < 0.9).count();
    assert!(shadowed > 300, "{shadowed}");
    let wedges = stage.world.resource::<PenumbraWedges>().casters.len();
    // The meshes are equal, not the same.
    let twins: Vec<_> = (0..POSTS)
        .map(|number| {
            let (mesh, place) = post(number);
            spawn(&mut stage, mesh, place)
        })
        .collect();
    assert_eq!(visibility(&mut stage), once);
    assert_eq!(stage.world.resource::<PenumbraWedges>().casters.len(), wedges);
    // Each casts its own shadow as soon as it is elsewhere, and where it casts for other lights.
    let mut moved = stage.world.get_mut::<Transform>(twins[0]).expect("a post");
    moved.translation.z += 0.3;
    let apart = visibility(&mut stage);
    let more = apart.iter().filter(|value| **value < 0.9).count();
    assert!(more > shadowed + 20, "{more} of {shadowed}");
    assert_eq!(stage.world.resource::<PenumbraWedges>().casters.len(), wedges + 1);
    stage.world.entity_mut(twins[1]).insert(SelectionLayers(2));
    visibility(&mut stage);
    assert_eq!(stage.world.resource::<CoincidentCasters>().count(), POSTS - 2);
    // Another mesh in the same box is no twin.
    let mut other = post(2).0;
    other.positions[0] *= 0.5;
    stage
        .world
        .entity_mut(twins[2])
        .insert(SceneMesh(Arc::new(other)));
    visibility(&mut stage);
    assert_eq!(stage.world.resource::<CoincidentCasters>().count(), POSTS - 3);
}

#[test]
fn what_is_modelled_twice_casts_as_once() {
    let alone = |mesh| {
        let mut stage = lamp_over_ground();
        spawn(&mut stage, mesh, Transform::IDENTITY);
        visibility(&mut stage)
    };
    let [once, twice, four_times] = [1, 2, 4].map(|times| alone(as_one_mesh(times)));
    assert!(once.iter().filter(|value| **value < 0.9).count() > 300);
    assert_eq!(twice, once);
    assert_eq!(four_times, once);
    // A face and a half of the first post.
    let mut with_part = as_one_mesh(1);
    with_part.indices.extend_from_within(..9);
    let with_part = MeshData::from_triangles("part twice", with_part.positions, with_part.indices);
    assert_eq!(alone(with_part), once);
}

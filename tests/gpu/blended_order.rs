//! Blended surfaces are drawn from the farthest to the nearest, wherever the origins of their meshes are, and all that they send
//! is weighted by their alpha.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{Orthographic, Submesh};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3, Vec4};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(32, 32);

const ALPHA: f32 = 0.75;

/// The near pane and the far one: distance before the eye, metres, and colour.
const PANES: [(f32, Vec3); 2] = [(2.0, Vec3::X), (4.0, Vec3::Z)];

/// A square across the view, whose vertices hold its place.
fn square(distance: f32) -> MeshData {
    let corner = |x: f32, y: f32| Vec3::new(x, y, -distance);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let corners = corners.map(|(x, y)| corner(x, y)).to_vec();
    MeshData::from_triangles("pane", corners, vec![0, 1, 2, 0, 2, 3])
}

fn pane(color: Vec3) -> Arc<Material> {
    Arc::new(Material {
        base_color: color.extend(ALPHA),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..Material::matte(Vec3::ONE)
    })
}

/// Linear radiance in the middle of the picture.
fn middle(objects: Vec<(MeshData, Vec<Arc<Material>>)>, orthographic: bool) -> Vec3 {
    let camera = Camera {
        aspect: 1.0,
        orthographic: orthographic.then_some(Orthographic {
            height: 1.0,
            far: 20.0,
        }),
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, Transform::IDENTITY);
    let settings = RenderSettings {
        ambient: Vec3::ZERO,
        ..Default::default()
    };
    stage
        .add_renderer(strict_context(), settings)
        .expect("shaders compose");
    for (mesh, materials) in objects {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials(materials.into()),
            Transform::IDENTITY,
        ));
    }
    let rendered = stage.render().expect("the frame renders");
    let at = 4 * (SIZE.y / 2 * SIZE.x + SIZE.x / 2) as usize;
    Vec3::from_slice(&rendered.radiance[at..at + 3])
}

/// Both panes as submeshes of one mesh, in an order.
fn as_one(order: [usize; 2]) -> (MeshData, Vec<Arc<Material>>) {
    let parts = order.map(|index| square(PANES[index].0));
    let positions = parts.iter().flat_map(|part| part.positions.clone()).collect();
    let second = parts[1].indices.iter().map(|index| index + 4);
    let indices = parts[0].indices.iter().copied().chain(second).collect();
    let mut mesh = MeshData::from_triangles("panes", positions, indices);
    let submesh = |first_index| Submesh {
        first_index,
        index_count: 6,
    };
    mesh.submeshes = vec![submesh(0), submesh(6)];
    (mesh, order.map(|index| pane(PANES[index].1)).to_vec())
}

#[test]
fn the_nearest_pane_is_drawn_last_whatever_the_order_of_objects_and_submeshes() {
    let [near, far] = PANES.map(|(_, color)| color);
    let expected = ALPHA * near + (1.0 - ALPHA) * ALPHA * far;
    let wrong = ALPHA * far + (1.0 - ALPHA) * ALPHA * near;
    assert!((expected - wrong).length() > 0.5, "the orders can be told apart");
    for orthographic in [false, true] {
        for order in [[0, 1], [1, 0]] {
            let apart = order.map(|index| (square(PANES[index].0), vec![pane(PANES[index].1)]));
            for objects in [apart.to_vec(), vec![as_one(order)]] {
                let count = objects.len();
                let got = middle(objects, orthographic);
                assert!(
                    (got - expected).length() < 0.01,
                    "{count} objects, {order:?}: {got}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn the_emission_of_a_pane_is_weighted_by_its_alpha() {
    let glow = |alpha: f32| {
        let material = Material {
            base_color: Vec4::new(0.0, 0.0, 0.0, alpha),
            emissive: Vec3::ONE,
            alpha_mode: AlphaMode::Blend,
            ..Material::matte(Vec3::ONE)
        };
        middle(vec![(square(2.0), vec![Arc::new(material)])], false).x
    };
    for alpha in [1.0, 0.5, 0.1, 0.01] {
        let got = glow(alpha);
        assert!((got - alpha).abs() < 0.005, "{got} at {alpha}");
    }
}

//! Meshes that are empty, degenerate, broken or incomplete, as casters and receivers.

use antumbra::reports::Reports;
use antumbra::scene::Submesh;
use glam::{Vec2, Vec4};

use super::*;

const PLACE: Vec3 = Vec3::new(-1.5, 1.0, 0.5);

fn cuboid() -> MeshData {
    MeshData::cuboid(Vec3::splat(0.4))
}

/// A mesh with one submesh over all of its indices.
fn mesh(positions: &[Vec3], indices: &[u32]) -> MeshData {
    MeshData {
        name: "bad".to_owned(),
        positions: positions.to_vec(),
        normals: vec![Vec3::Y; positions.len()],
        indices: indices.to_vec(),
        submeshes: vec![Submesh {
            first_index: 0,
            index_count: indices.len() as u32,
        }],
        ..MeshData::default()
    }
}

/// The usual scene with one more object.
fn with(context: &RenderContext, extra: MeshData) -> Stage {
    let mut stage = box_on_plane(context);
    stage
        .world
        .spawn(object(extra, Transform::from_translation(PLACE)));
    stage
}

#[test]
fn meshes_without_area_change_nothing() {
    let context = strict_context();
    let without = render(&mut box_on_plane(&context));
    let (o, x, nan) = (Vec3::ZERO, Vec3::X, Vec3::NAN);
    for (what, bad) in [
        ("empty", mesh(&[], &[])),
        ("without triangles", mesh(&[o, x, Vec3::Y], &[])),
        ("a point", mesh(&[o, o, o], &[0, 1, 2])),
        ("one vertex thrice", mesh(&[o, x, Vec3::Y], &[1, 1, 1])),
        ("a line", mesh(&[o, x, 2.0 * x], &[0, 1, 2])),
        ("NaN throughout", mesh(&[nan; 3], &[0, 1, 2])),
        ("infinite throughout", mesh(&[Vec3::INFINITY; 3], &[0, 1, 2])),
        ("one NaN corner", mesh(&[o, x, nan], &[0, 1, 2])),
    ] {
        let mut stage = with(&context, bad);
        assert!(same(&without, &render(&mut stage)), "{what} changes the picture");
    }
}

#[test]
fn one_triangle_casts_and_receives() {
    let context = strict_context();
    let without = render(&mut box_on_plane(&context));
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(0.2, 0.3, 1.0)];
    for indices in [[0, 1, 2], [0, 2, 1]] {
        let mut stage = with(&context, mesh(&corners, &indices));
        let rendered = render(&mut stage);
        assert_true(&mut stage, &rendered);
        assert!(!same(&without, &rendered), "it is seen");
    }
}

/// Appends a triangle to the cuboid.
fn spoilt_cuboid(vertex: Vec3, indices: [u32; 3]) -> MeshData {
    let mut mesh = cuboid();
    mesh.positions.push(vertex);
    mesh.normals.push(Vec3::Y);
    mesh.indices.extend(indices);
    mesh.submeshes[0].index_count += 3;
    mesh
}

#[test]
fn a_broken_triangle_is_left_out_and_the_rest_is_drawn_and_casts() {
    let context = strict_context();
    let whole = render(&mut with(&context, cuboid()));
    let last = cuboid().positions.len() as u32;
    for (what, vertex) in [
        ("NaN", Vec3::NAN),
        ("one NaN component", Vec3::new(0.1, f32::NAN, 0.0)),
        ("infinite", Vec3::new(0.0, f32::INFINITY, 0.0)),
    ] {
        let mut stage = with(&context, spoilt_cuboid(vertex, [0, last, 1]));
        assert!(same(&whole, &render(&mut stage)), "{what}");
    }
    // The control: a finite vertex there is seen.
    let mut stage = with(&context, spoilt_cuboid(Vec3::new(1.0, 1.0, 1.0), [0, last, 1]));
    assert!(!same(&whole, &render(&mut stage)));
}

#[test]
fn a_vertex_that_is_not_there_is_counted_and_draws_no_garbage() {
    let context = strict_context();
    let whole = render(&mut with(&context, cuboid()));
    let last = cuboid().positions.len() as u32;
    for index in [last + 1, 1 << 20, u32::MAX] {
        let mut stage = with(&context, spoilt_cuboid(Vec3::ZERO, [0, index, 1]));
        let rendered = render(&mut stage);
        // It casts nothing, as its edges are unknown, but it is drawn: only shadows may differ.
        let mut unshadowed = with(&context, cuboid());
        unshadowed
            .world
            .entity_mut(unshadowed.lights[0])
            .remove::<StencilVolume>();
        stage.world.entity_mut(stage.lights[0]).remove::<StencilVolume>();
        assert!(
            same(&render(&mut unshadowed), &render(&mut stage)),
            "index {index}"
        );
        let mut reports = stage.world.resource_mut::<Reports>();
        let said: Vec<_> = reports.drain_new().map(|report| &report.message).collect();
        assert_eq!(said.len(), 1, "{said:?}: it is reported once");
        assert!(said[0].contains("triangle 12"), "{said:?}");
        assert!(!same(&whole, &rendered), "the comparison sees shadows");
    }
}

#[test]
fn indices_and_submeshes_that_do_not_fit_are_cut() {
    let context = strict_context();
    let whole = render(&mut with(&context, cuboid()));
    let spoilt = |spoil: fn(&mut MeshData)| {
        let mut mesh = cuboid();
        spoil(&mut mesh);
        render(&mut with(&context, mesh))
    };
    let long = spoilt(|mesh| mesh.submeshes[0].index_count += 30);
    assert!(same(&whole, &long), "a submesh beyond the indices is cut to them");
    let overflowing = spoilt(|mesh| mesh.submeshes[0].index_count = u32::MAX);
    assert!(same(&whole, &overflowing));
    let beyond = spoilt(|mesh| {
        mesh.submeshes.push(Submesh {
            first_index: u32::MAX - 1,
            index_count: u32::MAX,
        });
    });
    assert!(same(&whole, &beyond), "one that begins beyond them is left out");
    spoilt(|mesh| {
        mesh.indices.push(0); // casts nothing, see above
        mesh.submeshes[0].index_count += 1;
    });
}

#[test]
fn streams_that_are_missing_or_too_short_or_not_finite_have_defaults() {
    let context = strict_context();
    let lit_as = |spoil: &dyn Fn(&mut MeshData)| {
        let mut mesh = cuboid();
        spoil(&mut mesh);
        render(&mut with(&context, mesh))
    };
    let count = cuboid().positions.len();
    let up = lit_as(&|mesh| mesh.normals = vec![Vec3::Y; count]);
    for (what, normals) in [
        ("no normals", vec![]),
        ("NaN normals", vec![Vec3::NAN; count]),
        ("zero normals", vec![Vec3::ZERO; count]),
        ("half of the normals", vec![Vec3::Y; count / 2]),
        ("too many normals", vec![Vec3::Y; count * 2]),
    ] {
        assert!(
            same(&up, &lit_as(&|mesh| mesh.normals.clone_from(&normals))),
            "{what}"
        );
    }
    let plain = lit_as(&|_| {});
    assert!(!same(&up, &plain), "normals show");
    for uv0 in [
        vec![Vec2::NAN; count],
        vec![Vec2::ONE; 3],
        vec![Vec2::ONE; 3 * count],
    ] {
        assert!(same(&plain, &lit_as(&|mesh| mesh.uv0.clone_from(&uv0))));
        assert!(same(&plain, &lit_as(&|mesh| mesh.uv1.clone_from(&uv0))));
    }
    for colors in [
        vec![Vec4::NAN; count],
        vec![Vec4::ONE; 3],
        vec![Vec4::ONE; 3 * count],
    ] {
        assert!(same(&plain, &lit_as(&|mesh| mesh.colors.clone_from(&colors))));
    }
    for tangents in [vec![Vec4::NAN; count], vec![Vec4::ZERO; 1]] {
        assert!(same(&plain, &lit_as(&|mesh| mesh.tangents.clone_from(&tangents))));
    }
}

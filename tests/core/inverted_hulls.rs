//! What the view culls as a whole casts no shadow, and everything else does.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::Submesh;
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::sets::Objects;
use antumbra::silhouettes::CasterEdges;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

struct Frame {
    world: World,
    schedule: Schedule,
    camera: Entity,
}

impl Frame {
    fn new() -> Self {
        let mut world = World::new();
        init_resources(&mut world);
        world.insert_resource(ViewportSize(UVec2::new(64, 48)));
        world.spawn((
            Light::point(Vec3::ONE, 10.0, f32::INFINITY),
            Transform::from_xyz(0.0, 6.0, 1.0),
        ));
        let camera = world
            .spawn((Camera::default(), Transform::from_xyz(0.0, 1.0, 8.0)))
            .id();
        Self {
            world,
            schedule: standalone_schedule(),
            camera,
        }
    }

    fn spawn(&mut self, mesh: MeshData, double_sided: bool) -> Entity {
        let material = Material {
            double_sided,
            ..Material::default()
        };
        let drawn = (
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(material)].into()),
        );
        let casts = (ShadowCaster, ShadowReceiver);
        self.world.spawn((drawn, casts, Transform::IDENTITY)).id()
    }

    /// Whether an object casts in the next frame.
    fn casts(&mut self, entity: Entity) -> bool {
        self.schedule.run(&mut self.world);
        let objects = self.world.resource::<Objects>();
        let index = objects
            .entities
            .iter()
            .position(|&other| other == entity)
            .unwrap();
        objects.casters.contains(index)
    }
}

fn inverted(mut mesh: MeshData) -> MeshData {
    mesh.indices
        .as_chunks_mut::<3>()
        .0
        .iter_mut()
        .for_each(|corners| corners.swap(1, 2));
    mesh
}

#[test]
fn an_inverted_hull_casts_only_where_its_surface_is_seen() {
    let mut frame = Frame::new();
    let hull = frame.spawn(inverted(MeshData::cuboid(Vec3::splat(0.6))), false);
    let within = frame.spawn(MeshData::cuboid(Vec3::splat(0.5)), false);
    assert!(!frame.casts(hull) && frame.casts(within));
    // By the setting, and where every surface is drawn from both sides.
    frame.world.insert_resource(CulledCasters::Cast);
    assert!(frame.casts(hull));
    frame.world.insert_resource(CulledCasters::LeaveOut);
    frame.world.insert_resource(FaceCulling::None);
    assert!(frame.casts(hull));
    frame.world.insert_resource(FaceCulling::SingleSided);
    assert!(
        !frame.casts(hull) && !frame.casts(hull),
        "and in every frame after"
    );
    // To a camera within it its walls are there.
    let camera = frame.camera;
    frame.world.get_mut::<Transform>(camera).unwrap().translation = Vec3::new(0.1, 0.2, 0.3);
    assert!(frame.casts(hull) && frame.casts(within));
    frame.world.get_mut::<Transform>(camera).unwrap().translation = Vec3::new(0.0, 1.0, 8.0);
    assert!(!frame.casts(hull));
    // A hull that moves around the camera.
    frame.world.get_mut::<Transform>(hull).unwrap().translation = Vec3::new(0.0, 1.0, 8.0);
    assert!(frame.casts(hull));
    // Another mesh, and another material.
    frame.world.get_mut::<Transform>(hull).unwrap().translation = Vec3::ZERO;
    assert!(!frame.casts(hull));
    frame.world.get_mut::<SceneMesh>(hull).unwrap().0 = Arc::new(MeshData::cuboid(Vec3::splat(0.6)));
    assert!(frame.casts(hull));
}

/// The number of triangles with which an object casts in the next frame.
fn casting_triangles(frame: &mut Frame, entity: Entity) -> usize {
    assert!(frame.casts(entity));
    let edges = frame.world.get::<CasterEdges>(entity).unwrap();
    edges.0.edges.triangle_count()
}

#[test]
fn a_hull_that_is_a_submesh_casts_only_where_its_surface_is_seen() {
    let mut frame = Frame::new();
    let hull = inverted(MeshData::cuboid(Vec3::splat(0.6)));
    let mut mesh = MeshData::cuboid(Vec3::splat(0.5));
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(&hull.positions);
    mesh.normals.extend(&hull.normals);
    mesh.indices.extend(hull.indices.iter().map(|index| base + index));
    mesh.submeshes.push(Submesh {
        first_index: 36,
        index_count: 36,
    });
    let object = frame.spawn(mesh, false);
    let material = |double_sided| {
        Arc::new(Material {
            double_sided,
            ..Material::default()
        })
    };
    let dress = |frame: &mut Frame, body: bool, hull: bool| {
        let materials = SceneMaterials(vec![material(body), material(hull)].into());
        frame.world.entity_mut(object).insert(materials);
    };
    // A submesh without a material is not drawn, and casts all the same.
    assert_eq!(casting_triangles(&mut frame, object), 24);
    dress(&mut frame, false, false);
    assert_eq!(casting_triangles(&mut frame, object), 12);
    let ticks = |frame: &Frame| {
        frame
            .world
            .entity(object)
            .get_ref::<CasterEdges>()
            .unwrap()
            .last_changed()
    };
    let before = ticks(&frame);
    assert_eq!(
        casting_triangles(&mut frame, object),
        12,
        "and in every frame after"
    );
    assert_eq!(before, ticks(&frame), "nothing is written where nothing changes");
    dress(&mut frame, true, true);
    assert_eq!(casting_triangles(&mut frame, object), 24, "both sides are seen");
    dress(&mut frame, true, false);
    assert_eq!(
        casting_triangles(&mut frame, object),
        12,
        "the body has both sides"
    );
    let camera = frame.camera;
    frame.world.get_mut::<Transform>(camera).unwrap().translation = Vec3::new(0.1, 0.2, 0.3);
    assert_eq!(casting_triangles(&mut frame, object), 24, "to a camera within it");
    frame.world.get_mut::<Transform>(camera).unwrap().translation = Vec3::new(0.0, 1.0, 8.0);
    assert_eq!(casting_triangles(&mut frame, object), 12);
    for (setting, culling, count) in [
        (CulledCasters::Cast, FaceCulling::SingleSided, 24),
        (CulledCasters::LeaveOut, FaceCulling::None, 24),
        (CulledCasters::LeaveOut, FaceCulling::SingleSided, 12),
    ] {
        frame.world.insert_resource(setting);
        frame.world.insert_resource(culling);
        assert_eq!(
            casting_triangles(&mut frame, object),
            count,
            "{setting:?} {culling:?}"
        );
    }
    // An ordinary mesh in its place.
    let plain = MeshData::cuboid(Vec3::splat(0.5));
    frame.world.entity_mut(object).insert(SceneMesh(Arc::new(plain)));
    assert_eq!(casting_triangles(&mut frame, object), 12);
}

#[test]
fn what_is_seen_casts() {
    let mut frame = Frame::new();
    let two_sided = frame.spawn(inverted(MeshData::cuboid(Vec3::ONE)), true);
    let plane = frame.spawn(inverted(MeshData::plane(1.0)), false);
    let mut open = inverted(MeshData::cuboid(Vec3::ONE));
    open.indices.truncate(30);
    open.submeshes[0].index_count = 30;
    let open = frame.spawn(open, false);
    // A box with another one inside out beside it: in part only.
    let mut mixed = inverted(MeshData::cuboid(Vec3::ONE));
    let other = MeshData::cuboid(Vec3::splat(0.5));
    let base = mixed.positions.len() as u32;
    mixed
        .positions
        .extend(other.positions.iter().map(|&position| position + 3.0 * Vec3::X));
    mixed.normals.extend(&other.normals);
    mixed
        .indices
        .extend(other.indices.iter().map(|index| base + index));
    mixed.submeshes[0].index_count = mixed.indices.len() as u32;
    let mixed = frame.spawn(mixed, false);
    for (entity, what) in [
        (two_sided, "both sides"),
        (plane, "plane"),
        (open, "open"),
        (mixed, "in part"),
    ] {
        assert!(frame.casts(entity), "{what}");
    }
}

#[test]
fn each_of_many_parts_is_judged_by_itself() {
    const PARTS: u32 = 40;
    let mut mesh = MeshData {
        submeshes: Vec::new(),
        ..MeshData::default()
    };
    for part in 0..PARTS {
        // Every second box is inside out. Its vertices stand in the reverse order.
        let mut one = MeshData::cuboid(Vec3::splat(0.2));
        if part % 2 == 1 {
            one = inverted(one);
            let last = one.positions.len() as u32 - 1;
            one.positions.reverse();
            one.normals.reverse();
            one.indices.iter_mut().for_each(|index| *index = last - *index);
        }
        let base = mesh.positions.len() as u32;
        mesh.submeshes.push(Submesh {
            first_index: mesh.indices.len() as u32,
            index_count: one.indices.len() as u32,
        });
        mesh.indices.extend(one.indices.iter().map(|index| base + index));
        mesh.normals.extend(&one.normals);
        let shift = 0.5 * part as f32 * Vec3::X;
        mesh.positions.extend(one.positions.iter().map(|at| at + shift));
    }
    let mut frame = Frame::new();
    let object = frame.spawn(mesh, false);
    let material = Arc::new(Material::default());
    let materials = vec![material; PARTS as usize];
    frame
        .world
        .entity_mut(object)
        .insert(SceneMaterials(materials.into()));
    assert_eq!(casting_triangles(&mut frame, object), 12 * PARTS as usize / 2);
}

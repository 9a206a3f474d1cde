//! Gathers the objects of a world that stand still: the surfaces for which maps are baked, and the triangles that block rays.

use std::collections::{HashMap, HashSet};

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec2, Vec3};

use crate::reference::RayScene;
use crate::scene::placement::Placement;
use crate::scene::{
    FaceCulling, MeshData, MorphWeights, PosedMesh, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster,
    ShadowReceiver, Skin, Submesh,
};
use crate::techniques::occlusion_interval::surface::{local_triangles, surface_hash};

/// A surface that stands still: one submesh of one object.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Name of the mesh.
    pub mesh: String,
    /// Hash of the corners in the space of the object.
    pub hash: u64,
    /// Columns of the object's transform.
    pub world_from_local: [f32; 12],
    /// Whether the camera sees the backs of the triangles.
    pub is_two_sided: bool,
    /// Whether the surface is drawn and shows shadows.
    pub receives: bool,
    /// Whether the surface blocks the light.
    pub casts: bool,
    /// The triangles in their order; `None` for one that is not finite or names a missing vertex.
    pub triangles: Vec<Option<SurfaceTriangle>>,
    /// Whether the mesh has a second set of texture coordinates.
    pub has_coordinates: bool,
}

/// A triangle in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceTriangle {
    /// Corners, metres, in the order of the mesh.
    pub corners: [DVec3; 3],
    /// Second texture coordinates of the corners.
    pub coordinates: [Vec2; 3],
    /// Unit normal of the front; zero for a triangle without area.
    pub normal: DVec3,
    /// Index of the triangle in the rays' scene; `None` if it is not there.
    pub slot: Option<u32>,
}

/// Area of a triangle in space, m².
pub(super) fn area(triangle: &SurfaceTriangle) -> f64 {
    let [a, b, c] = triangle.corners;
    0.5 * (b - a).cross(c - a).length()
}

/// What stands still in a world.
#[derive(Debug)]
pub struct StillScene {
    /// The surfaces, in the order of entities and submeshes.
    pub surfaces: Vec<Surface>,
    /// Everything that blocks rays.
    pub rays: RayScene,
}

#[derive(QueryData)]
struct Object {
    entity: Entity,
    mesh: &'static SceneMesh,
    place: Placement,
    materials: Option<&'static SceneMaterials>,
    casts: Has<ShadowCaster>,
    layers: Option<&'static SelectionLayers>,
    receives: Has<ShadowReceiver>,
    is_posed: Has<PosedMesh>,
    is_skinned: Has<Skin>,
    is_morphed: Has<MorphWeights>,
}

/// Gathers what stands still: every mesh without joints and morph weights, except those of `moving` entities. `casts_for` is
/// the mask of the layers that block the light.
/// `GlobalTransform`s are read as they are, so propagate transforms first.
pub fn gather(world: &mut World, moving: &[Entity], casts_for: u32) -> StillScene {
    let sees_backs = world.get_resource::<FaceCulling>() == Some(&FaceCulling::None);
    let mut query = world.query::<Object>();
    let mut objects: Vec<_> = query.iter(world).collect();
    objects.sort_unstable_by_key(|object| object.entity);
    let mut surfaces = Vec::new();
    let mut owners = Vec::new();
    let mut left_out: HashSet<Entity> = HashSet::new();
    for object in &objects {
        let moves = object.is_posed || object.is_skinned || object.is_morphed;
        if moves || moving.contains(&object.entity) {
            left_out.insert(object.entity);
            continue;
        }
        let Some(place) = object.place.exact_affine() else {
            continue;
        };
        let is_invisible = |materials: &SceneMaterials| {
            materials.are_invisible(&object.mesh.0, |texture| texture.greatest_alpha())
        };
        if object.materials.is_some_and(is_invisible) {
            continue;
        }
        push_surfaces(
            object,
            &place,
            (sees_backs, casts_for),
            &mut surfaces,
            &mut owners,
        );
    }
    let rays = RayScene::from_world_if(world, |entity| !left_out.contains(&entity));
    find_slots(&rays, &mut surfaces, &owners);
    StillScene { surfaces, rays }
}

/// The entity of a surface, and the index of its first triangle in its mesh.
type Owner = (Entity, u32);

fn push_surfaces(
    object: &ObjectItem,
    place: &Affine3A,
    (sees_backs, casts_for): (bool, u32),
    surfaces: &mut Vec<Surface>,
    owners: &mut Vec<Owner>,
) {
    let mesh = &*object.mesh.0;
    let layers = object.layers.copied().unwrap_or_default().0;
    let casts = object.casts && layers & casts_for != 0;
    for (index, submesh) in mesh.submeshes.iter().enumerate() {
        let material = object.materials.and_then(|materials| materials.0.get(index));
        let receives = object.receives && material.is_some_and(|material| !material.unlit);
        if !(receives || object.casts) {
            continue;
        }
        surfaces.push(Surface {
            mesh: mesh.name.clone(),
            hash: surface_hash(mesh, submesh),
            world_from_local: place.to_cols_array(),
            is_two_sided: sees_backs || material.is_some_and(|material| material.double_sided),
            receives,
            casts,
            triangles: world_triangles(mesh, submesh, place),
            has_coordinates: mesh.uv1.len() == mesh.positions.len() && !mesh.uv1.is_empty(),
        });
        owners.push((object.entity, mesh.submesh_range(submesh).start as u32 / 3));
    }
}

pub(super) fn world_triangles(
    mesh: &MeshData,
    submesh: &Submesh,
    place: &Affine3A,
) -> Vec<Option<SurfaceTriangle>> {
    // As in the rays' scene: products of two `f32` are exact in `f64`.
    let world_from_local = DAffine3::from_mat3_translation(
        DMat3::from_cols_array(&place.matrix3.to_cols_array().map(f64::from)),
        Vec3::from(place.translation).as_dvec3(),
    );
    let side = if world_from_local.matrix3.determinant() < 0.0 {
        -1.0
    } else {
        1.0
    };
    let indices = mesh.indices[mesh.submesh_range(submesh)].chunks_exact(3);
    local_triangles(mesh, submesh)
        .zip(indices)
        .map(|(local, indices)| {
            let corners = local?.map(|corner| world_from_local.transform_point3(corner.as_dvec3()));
            let [a, b, c] = corners;
            let coordinate = |at: usize| mesh.uv1.get(indices[at] as usize).copied().unwrap_or(Vec2::NAN);
            corners
                .iter()
                .all(|corner| corner.is_finite())
                .then(|| SurfaceTriangle {
                    corners,
                    coordinates: [coordinate(0), coordinate(1), coordinate(2)],
                    normal: (b - a).cross(c - a).normalize_or_zero() * side,
                    slot: None,
                })
        })
        .collect()
}

fn find_slots(rays: &RayScene, surfaces: &mut [Surface], owners: &[Owner]) {
    let triangles = rays.triangles().iter().zip(0u32..);
    let slots: HashMap<(Entity, u32), u32> = triangles
        .filter_map(|(triangle, slot)| Some(((triangle.entity?, triangle.source_index), slot)))
        .collect();
    for (surface, (entity, first)) in surfaces.iter_mut().zip(owners) {
        for (triangle, source) in surface.triangles.iter_mut().zip(*first..) {
            if let Some(triangle) = triangle {
                triangle.slot = slots.get(&(*entity, source)).copied();
            }
        }
    }
}

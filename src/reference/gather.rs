//! Gathers the triangles of a world's entities.

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::ray_scene::{RayScene, SceneTriangle};
use crate::scene::material::Hidden;
use crate::scene::placement::Placement;
use crate::scene::{
    MeshData, PosedMesh, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster, ShadowReceiver,
};

/// The components of an entity that the judge reads.
#[derive(QueryData)]
struct Object {
    entity: Entity,
    mesh: &'static SceneMesh,
    posed: Option<&'static PosedMesh>,
    place: Placement,
    materials: Option<&'static SceneMaterials>,
    layers: Option<&'static SelectionLayers>,
    blocks: Has<ShadowCaster>,
    receives: Has<ShadowReceiver>,
}

impl RayScene {
    /// Gathers the triangles of every [`SceneMesh`] entity, in the pose of its [`PosedMesh`] if it has one
    /// that is not empty.
    ///
    /// The camera sees triangles of entities with [`SceneMaterials`], and blended ones as solidly as others.
    /// Objects and submeshes that are invisible by their alpha are left out. Triangles of [`ShadowCaster`]s block light, and those of [`ShadowReceiver`]s show shadows. Objects
    /// whose transform is not finite or leaves no area are left out, as in the renderer. Triangles that are not
    /// finite or name a missing vertex are dropped and counted. `GlobalTransform`s are read as they are, so
    /// propagate transforms first.
    pub fn from_world(world: &mut World) -> Self {
        Self::from_world_if(world, |_| true)
    }

    /// Gathers like [`RayScene::from_world`] the triangles of those entities for which `takes` returns true.
    pub(crate) fn from_world_if(world: &mut World, takes: impl Fn(Entity) -> bool) -> Self {
        let mut query = world.query::<Object>();
        let mut objects: Vec<_> = query.iter(world).collect();
        objects.sort_unstable_by_key(|object| object.entity);
        let mut triangles = Vec::new();
        let mut missing_count = 0;
        for object in objects.into_iter().filter(|object| takes(object.entity)) {
            missing_count += push_triangles(&object, &mut triangles);
        }
        let mut scene = Self::from_scene_triangles(triangles);
        scene.add_dropped(missing_count);
        scene
    }
}

/// Appends an object's triangles. Returns how many triangles name a missing vertex.
fn push_triangles(object: &ObjectItem, triangles: &mut Vec<SceneTriangle>) -> usize {
    let is_drawn = object.materials.is_some();
    let Some(affine) = object.place.exact_affine().filter(|_| object.blocks || is_drawn) else {
        return 0;
    };
    let mesh = &*object.mesh.0;
    let hidden = object.materials.map_or(Hidden::Nothing, |materials| {
        materials.hidden(mesh, |texture| texture.greatest_alpha())
    });
    if hidden == Hidden::Everything {
        return 0;
    }
    let positions = object
        .posed
        .map(|posed| &posed.positions)
        .filter(|positions| !positions.is_empty())
        .unwrap_or(&mesh.positions);
    // Everything is `f64` from here: products of two `f32` are exact, and a far translation costs no
    // precision.
    let world_from_local = DAffine3::from_mat3_translation(
        DMat3::from_cols_array(&affine.matrix3.to_cols_array().map(f64::from)),
        Vec3::from(affine.translation).as_dvec3(),
    );
    let is_mirrored = world_from_local.matrix3.determinant() < 0.0;
    let looks = triangle_looks(mesh, object.materials, &hidden);
    let mut missing_count = 0;
    for (index, triangle) in mesh.indices.chunks_exact(3).enumerate() {
        let corner =
            |i: usize| -> Option<DVec3> { positions.get(triangle[i] as usize).map(|p: &Vec3| p.as_dvec3()) };
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            missing_count += 1;
            continue;
        };
        let [a, b, c] = [a, b, c].map(|p| world_from_local.transform_point3(p));
        if looks[index].is_hidden {
            continue;
        }
        triangles.push(SceneTriangle {
            corners: if is_mirrored { [a, c, b] } else { [a, b, c] },
            entity: Some(object.entity),
            source_index: index as u32,
            layers: object.layers.copied().unwrap_or_default().0,
            is_primary: looks[index].is_drawn,
            blocks: object.blocks,
            receives: object.receives,
            is_double_sided: looks[index].is_double_sided,
        });
    }
    missing_count
}

/// How the camera sees a triangle.
#[derive(Clone, Copy, Default)]
struct Look {
    is_drawn: bool,
    is_double_sided: bool,
    /// Alpha hides it, so it is not there.
    is_hidden: bool,
}

/// The look of every triangle. Triangles outside all submeshes, triangles of meshes without materials, and
/// triangles of submeshes beyond the last material are not drawn.
fn triangle_looks(mesh: &MeshData, materials: Option<&SceneMaterials>, hidden: &Hidden) -> Vec<Look> {
    let mut looks = vec![Look::default(); mesh.triangle_count()];
    let Some(materials) = materials else { return looks };
    for (index, submesh) in mesh.submeshes.iter().enumerate() {
        let material = materials.0.get(index);
        let look = Look {
            is_drawn: material.is_some(),
            is_double_sided: material.is_some_and(|material| material.double_sided),
            is_hidden: matches!(hidden, Hidden::Submeshes(hidden) if hidden.contains(&(index as u32))),
        };
        let first = submesh.first_index as usize / 3;
        let end = first + submesh.index_count as usize / 3;
        looks[first.min(mesh.triangle_count())..end.min(mesh.triangle_count())].fill(look);
    }
    looks
}

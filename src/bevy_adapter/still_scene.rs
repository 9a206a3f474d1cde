//! Copies the static meshes of a game into a world of our own components, from which maps are baked.

use std::sync::Arc;

use bevy::asset::Assets;
use bevy::camera::visibility::{InheritedVisibility, RenderLayers};
use bevy::ecs::prelude::*;
use bevy::ecs::query::QueryData;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::mesh::morph::MeshMorphWeights;
use bevy::mesh::skinning::SkinnedMesh;
use bevy::mesh::{Mesh, Mesh3d};
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::render::render_resource::Face;
use bevy::transform::components::GlobalTransform;
use glam::Vec3;

use super::light_convert::layer_bits;
use super::mesh_convert::convert_mesh;
use crate::scene::{Material, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster, ShadowReceiver};

#[derive(QueryData)]
struct Object {
    entity: Entity,
    mesh: &'static Mesh3d,
    transform: &'static GlobalTransform,
    material: Option<&'static MeshMaterial3d<StandardMaterial>>,
    layers: Option<&'static RenderLayers>,
    visibility: Option<&'static InheritedVisibility>,
    casts_not: Has<NotShadowCaster>,
    receives_not: Has<NotShadowReceiver>,
    is_skinned: Has<SkinnedMesh>,
    is_morphed: Has<MeshMorphWeights>,
}

/// Copies the visible meshes of a game into a world of our own, for `antumbra::baking`. Skinned and morphed meshes are left
/// out, and those for which `moves` returns true. Meshes that cannot cast (the topic `mesh` of the reports names them) are
/// left out, too.
///
/// Call it after a frame, when all assets are loaded and transforms are propagated. Meshes must still be in the main world.
///
/// ```no_run
/// use antumbra::baking::{BakeSettings, bake_into};
/// use antumbra::bevy_adapter::still_scene;
/// use antumbra::scene::LightPath;
/// use bevy::prelude::*;
///
/// fn bake(world: &mut World) -> Result<(), antumbra::baking::BakeError> {
///     let mut still = still_scene(world, |_| false);
///     let path = LightPath::Sun { latitude_degrees: 50.0, day: 172.0, hours: [4.0, 20.0] };
///     // A light uses them with `OcclusionInterval { maps: "maps".into(), .. }`: names are relative to the assets.
///     bake_into("assets/maps".as_ref(), &mut still, &path, &BakeSettings::default(), |_| ())?;
///     Ok(())
/// }
/// ```
pub fn still_scene(world: &mut World, moves: impl Fn(Entity) -> bool) -> World {
    let mut query = world.query::<Object>();
    let mut still = World::new();
    let (Some(meshes), Some(materials)) = (
        world.get_resource::<Assets<Mesh>>(),
        world.get_resource::<Assets<StandardMaterial>>(),
    ) else {
        return still;
    };
    let mut objects: Vec<_> = query.iter(world).collect();
    objects.sort_unstable_by_key(|object| object.entity);
    for object in objects {
        let is_hidden = object.visibility.is_some_and(|visibility| !visibility.get());
        if is_hidden || object.is_skinned || object.is_morphed || moves(object.entity) {
            continue;
        }
        let Some(mesh) = meshes.get(&object.mesh.0) else {
            continue;
        };
        let Ok(mesh) = convert_mesh(mesh, &object.entity.to_string()) else {
            continue;
        };
        let material = object.material.and_then(|material| materials.get(&material.0));
        // Bevy culls by the winding on the screen, so a transform that mirrors shows the other side.
        let is_one_sided = material.is_some_and(|material| material.cull_mode == Some(Face::Back));
        let mirrors = object.transform.affine().matrix3.determinant() < 0.0;
        let material = Material {
            double_sided: mirrors || !is_one_sided,
            ..Material::matte(Vec3::ONE)
        };
        let mut copy = still.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(material)].into()),
            SelectionLayers(layer_bits(object.layers)),
            *object.transform,
        ));
        if !object.casts_not {
            copy.insert(ShadowCaster);
        }
        if !object.receives_not {
            copy.insert(ShadowReceiver);
        }
    }
    still
}

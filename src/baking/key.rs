//! The key of a bake: a hash of everything that its result depends on. A bake goes on from a file, and maps are kept, if they
//! have the same key.

use super::chart::Chart;
use super::partial::BATCH;
use super::settings::BakeSettings;
use super::surfaces::{StillScene, Surface};
use crate::reference::RayScene;
use crate::scene::LightPath;
use crate::techniques::occlusion_interval::intervals::STEPS;
use crate::techniques::occlusion_interval::surface::StableHash;

/// Version of the baker. It increases whenever the same input gives other maps, so that old ones are baked again.
const BAKER_VERSION: u64 = 3;

/// The key of a bake.
pub(super) fn key_of(scene: &StillScene, charts: &[Chart], path: &LightPath, settings: &BakeSettings) -> u64 {
    let mut hash = StableHash::default();
    for number in [BAKER_VERSION, BATCH as u64, STEPS as u64] {
        hash.add(number);
    }
    add_surfaces(&mut hash, &scene.surfaces);
    add_blockers(&mut hash, &scene.rays, settings.casts_for);
    for chart in charts {
        hash.add(u64::from(chart.surface) << 32 | chart.triangles.len() as u64);
        hash.add(u64::from(chart.size.x) << 32 | u64::from(chart.size.y));
        for triangle in &chart.triangles {
            hash.add(u64::from(triangle.triangle));
            for texel in triangle.texels {
                hash.add_float(texel.x);
                hash.add_float(texel.y);
            }
        }
    }
    hash.add_bytes(format!("{path:?}").as_bytes());
    hash.add_float(settings.texels_per_metre);
    hash.add(u64::from(settings.page_size));
    hash.value()
}

fn add_surfaces(hash: &mut StableHash, surfaces: &[Surface]) {
    hash.add(surfaces.len() as u64);
    for surface in surfaces {
        hash.add(surface.hash);
        hash.add_bytes(surface.mesh.as_bytes());
        for value in surface.world_from_local {
            hash.add_float(value);
        }
        let flags = [surface.is_two_sided, surface.receives, surface.casts];
        for flag in flags {
            hash.add(u64::from(flag));
        }
    }
}

/// Adds the triangles that block the light's rays.
fn add_blockers(hash: &mut StableHash, rays: &RayScene, casts_for: u32) {
    let blockers = || {
        let triangles = rays.triangles().iter();
        triangles.filter(|triangle| triangle.blocks && triangle.layers & casts_for != 0)
    };
    hash.add(blockers().count() as u64);
    for value in blockers()
        .flat_map(|triangle| triangle.corners)
        .flat_map(|corner| corner.to_array())
    {
        hash.add((value + 0.0).to_bits());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_ecs::prelude::*;
    use bevy_transform::prelude::GlobalTransform;
    use glam::Vec3;

    use crate::baking::BakeSettings;
    use crate::baking::job::Job;
    use crate::scene::{
        LightPath, Material, MeshData, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster,
        ShadowReceiver,
    };

    /// A ground, and a board that casts and shows no shadows.
    fn world() -> (World, Entity) {
        let mut world = World::new();
        let plane = |size: f32| SceneMesh(Arc::new(MeshData::plane(size)));
        let materials = SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into());
        let place = |height: f32| GlobalTransform::from_xyz(0.0, height, 0.0);
        world.spawn((plane(2.0), materials.clone(), ShadowReceiver, place(0.0)));
        let board = world
            .spawn((plane(0.5), materials, ShadowCaster, place(1.0)))
            .id();
        (world, board)
    }

    fn key(world: &mut World, settings: &BakeSettings) -> u64 {
        let path = LightPath::Arc {
            direction: Vec3::NEG_X,
            axis: Vec3::Z,
            degrees: 180.0,
        };
        Job::new(world, &path, settings).expect("it can be baked").key
    }

    #[test]
    fn the_key_depends_on_what_casts() {
        let settings = BakeSettings::default();
        let (mut world, board) = world();
        let first = key(&mut world, &settings);
        assert_eq!(key(&mut world, &settings), first);
        let mut keys = vec![first];
        let mut differs = |key: u64, what: &str| {
            assert!(!keys.contains(&key), "{what}");
            keys.push(key);
        };
        world.entity_mut(board).remove::<ShadowCaster>();
        differs(key(&mut world, &settings), "it casts no longer");
        world
            .entity_mut(board)
            .insert((ShadowCaster, GlobalTransform::from_xyz(0.0, 1.5, 0.0)));
        differs(key(&mut world, &settings), "it stands elsewhere");
        world
            .entity_mut(board)
            .insert(SceneMesh(Arc::new(MeshData::plane(0.4))));
        differs(key(&mut world, &settings), "it has another shape");
        let layer = |casts_for: u32| BakeSettings {
            casts_for,
            ..BakeSettings::default()
        };
        differs(
            key(&mut world, &layer(2)),
            "the light's casters are on another layer",
        );
        world.entity_mut(board).insert(SelectionLayers(2));
        assert_eq!(key(&mut world, &layer(2)), keys[3], "only what blocks counts");
    }
}

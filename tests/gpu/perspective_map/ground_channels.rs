//! Up to four grounds are blurred at once, each in a channel of its own; what is no ground keeps the map.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::scene::BlurredGround;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{DVec3, Quat, Vec3};

use super::grounds::{add, expected, lights, stage};
use super::variants;
use crate::harness::maps::Judge;
use crate::harness::support::stage::Stage;

/// Pixels of which one is judged.
const EVERY: usize = 2;

/// Half the side of each of four grounds, metres, and the radii of their blurs.
const TILE: f32 = 0.8;
const RADII: [f32; 4] = [0.05, 0.08, 0.13, 0.2];

/// Four tiles, tilted in different ways, with a plate over each.
fn tiles() -> (Stage, Vec<Transform>) {
    let (mut stage, ground) = stage(0.1);
    let others: Vec<Entity> = stage
        .world
        .query_filtered::<Entity, With<SceneMesh>>()
        .iter(&stage.world)
        .collect();
    assert!(others.contains(&ground));
    for entity in others {
        stage.world.despawn(entity);
    }
    let places: Vec<Transform> = [
        (-0.85, -0.85, Quat::from_rotation_x(0.12)),
        (0.85, -0.85, Quat::from_rotation_z(0.15)),
        (-0.85, 0.85, Quat::from_rotation_z(-0.12)),
        (0.85, 0.85, Quat::from_rotation_x(-0.08)),
    ]
    .map(|(x, z, turn)| Transform::from_xyz(x, 0.0, z).with_rotation(turn))
    .into();
    for (index, place) in places.iter().enumerate() {
        let tile = add(&mut stage, MeshData::plane(TILE), *place);
        let radius = RADII[index];
        stage.world.entity_mut(tile).insert(BlurredGround { radius });
        let plate = Transform::from_translation(place.translation + Vec3::new(0.0, 0.45, 0.0))
            .with_rotation(Quat::from_rotation_y(index as f32));
        add(&mut stage, MeshData::cuboid(Vec3::new(0.3, 0.01, 0.2)), plate);
    }
    (stage, places)
}

/// RMSE of each tile where the Gaussian of its radius is neither lit nor dark, and the number of such pixels. `radius_of`
/// names the tile whose radius counts.
fn judge_tiles(
    judge: &Judge,
    rendered: &[f32],
    places: &[Transform],
    radius_of: impl Fn(usize) -> usize,
) -> Vec<(f64, usize)> {
    let of_tile = |(index, place): (usize, &Transform)| {
        let radius = f64::from(RADII[radius_of(index)]);
        let (normal, middle) = (
            (place.rotation * Vec3::Y).as_dvec3(),
            place.translation.as_dvec3(),
        );
        let sides = [Vec3::X, Vec3::Z].map(|axis| (place.rotation * axis).as_dvec3());
        let is_of_tile = |point: DVec3| {
            let mut along = sides.iter().map(|side| side.dot(point - middle).abs());
            along.all(|along| along <= f64::from(TILE))
        };
        let (mut sum, mut count) = (0.0, 0);
        let pixels = judge.hits.hits.iter().enumerate();
        for (pixel, hit) in pixels.filter(|(pixel, _)| pixel % EVERY == 0) {
            let Some(hit) = hit
                .as_ref()
                .filter(|hit| is_of_tile(hit.position) && normal.dot(hit.position - middle).abs() < 1e-4)
            else {
                continue;
            };
            let expected = expected(judge, hit, radius, is_of_tile);
            if (0.01..0.99).contains(&expected) {
                sum += (f64::from(rendered[pixel]) - expected).powi(2);
                count += 1;
            }
        }
        ((sum / f64::from(count as u32)).sqrt(), count)
    };
    places.iter().enumerate().map(of_tile).collect()
}

#[test]
fn each_of_four_grounds_has_a_gaussian_of_its_own_radius() {
    for (light, place) in lights() {
        let (mut stage, places) = tiles();
        stage.spawn_light(light.clone(), place, Some(variants(512)[0]));
        let rendered = stage.render().expect("the frame renders").visibility.remove(0);
        let rays = RayScene::from_world(&mut stage.world);
        let judge = Judge::new(&stage, &rays, 0).expect("something casts");
        let errors = judge_tiles(&judge, &rendered, &places, |tile| tile);
        println!("{:?}: RMSE and pixels {errors:.4?}", light.kind);
        for (tile, (rmse, count)) in errors.iter().enumerate() {
            assert!(
                *rmse <= 0.03 && *count >= 8,
                "{:?}, tile {tile}: {rmse} of {count}",
                light.kind
            );
        }
        // The blur of another channel is none of theirs.
        let errors = judge_tiles(&judge, &rendered, &places, |tile| (tile + 2) % 4);
        println!("{:?}: RMSE to other radii {errors:.4?}", light.kind);
        assert!(errors.iter().all(|(rmse, _)| *rmse > 0.04), "{errors:?}");
    }
}

/// Two tiles of one mesh, which are one batch: the one is blurred, the other keeps the map, and so do boxes.
#[test]
fn receivers_without_a_ground_keep_the_map_though_they_share_mesh_and_batch_with_one() {
    for (light, place) in lights() {
        let (mut stage, ground) = stage(0.2);
        stage.world.despawn(ground);
        let mesh = Arc::new(MeshData::plane(0.9));
        let looks: SceneMaterials = SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into());
        for x in [-0.95, 0.95] {
            let at = Transform::from_xyz(x, 0.0, 0.0);
            let parts = (
                SceneMesh(mesh.clone()),
                looks.clone(),
                ShadowCaster,
                ShadowReceiver,
                at,
            );
            let tile = stage.world.spawn(parts).id();
            if x < 0.0 {
                stage.world.entity_mut(tile).insert(BlurredGround { radius: 0.2 });
            }
            // One shadow on each tile, and one on the side of a box.
            let plate = Transform::from_xyz(x, 0.5, 0.1);
            add(&mut stage, MeshData::cuboid(Vec3::new(0.3, 0.01, 0.3)), plate);
        }
        stage.spawn_light(light.clone(), place, Some(variants(512)[0]));
        let rendered = stage.render().expect("the frame renders").visibility.remove(0);
        let rays = RayScene::from_world(&mut stage.world);
        let judge = Judge::new(&stage, &rays, 0).expect("something casts");
        let (mut soft, mut dark) = ([0; 2], 0);
        let mut others = rendered.clone();
        for (pixel, hit) in judge.hits.hits.iter().enumerate() {
            let Some(hit) = hit else { continue };
            let is_tile = hit.position.y.abs() < 1e-4;
            let side = usize::from(hit.position.x > 0.0);
            if is_tile {
                soft[side] += usize::from((0.1..0.9).contains(&rendered[pixel]));
            }
            if is_tile && side == 0 {
                others[pixel] = judge.truth.values()[pixel];
            } else {
                dark += usize::from(judge.truth.values()[pixel] == 0.0);
            }
        }
        let error = judge.compare(&others);
        println!("{:?}: {soft:?} soft, {dark} dark, {error:?}", light.kind);
        assert!(
            error.wrong == 0 && dark > 30,
            "{:?}: {dark} dark, {error:?}",
            light.kind
        );
        assert!(
            soft[0] > 60 && 3 * soft[1] < soft[0],
            "{:?}: {soft:?} soft",
            light.kind
        );
    }
}

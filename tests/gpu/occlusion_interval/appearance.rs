//! Surfaces that show shadows, or backs, only since the maps were baked.

use std::sync::Arc;

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::techniques::IntervalMaps;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::faults::{dark, said};
use super::scenes::{ladder, lit_ladder, path};
use crate::harness::support::stage::Stage;

/// The ground of the ladder, whose place no other object has.
fn ground(stage: &mut Stage) -> Entity {
    let mut query = stage
        .world
        .query_filtered::<(Entity, &Transform), With<SceneMesh>>();
    let mut places = query.iter(&stage.world);
    let found = places.find(|(_, place)| **place == Transform::IDENTITY);
    found.expect("the ground").0
}

fn paint_ground(stage: &mut Stage, material: Material) {
    let ground = ground(stage);
    let materials = SceneMaterials([Arc::new(material)].into());
    stage.world.entity_mut(ground).insert(materials);
}

fn white() -> Material {
    Material::matte(Vec3::ONE)
}

fn unlit() -> Material {
    Material {
        unlit: true,
        ..white()
    }
}

fn baked(mut stage: Stage) -> Arc<IntervalMaps> {
    let settings = BakeSettings {
        texels_per_metre: 2.0,
        ..Default::default()
    };
    let bake = bake_intervals(&mut stage.world, &path(), &settings, |_| ()).expect("it is baked");
    Arc::new(bake.maps)
}

fn reports(stage: &mut Stage) -> Vec<String> {
    let _shown = dark(stage);
    said(stage)
}

#[test]
fn what_was_unlit_when_it_was_baked_shows_no_shadow_and_is_counted() {
    let mut scene = ladder();
    paint_ground(&mut scene, unlit());
    let maps = baked(scene);
    let mut stage = lit_ladder(maps, 0.3, 0.02);
    let expected = "1 receivers are not in the light's maps";
    for _ in 0..2 {
        paint_ground(&mut stage, white());
        let said = reports(&mut stage);
        assert!(said.len() == 1 && said[0].starts_with(expected), "{said:?}");
        paint_ground(&mut stage, unlit());
        assert_eq!(reports(&mut stage), [] as [String; 0], "as it was baked");
    }
}

#[test]
fn backs_that_are_seen_since_the_bake_are_counted() {
    let maps = baked(ladder());
    let mut stage = lit_ladder(maps, 0.3, 0.02);
    let nothing = [] as [String; 0];
    assert_eq!(reports(&mut stage), nothing, "as they were baked");
    let expect = |stage: &mut Stage, count: usize| {
        let said = reports(stage);
        let expected = format!("{count} receivers are seen from both sides");
        assert!(said.len() == 1 && said[0].starts_with(&expected), "{said:?}");
    };
    let double_sided = Material {
        double_sided: true,
        ..white()
    };
    paint_ground(&mut stage, double_sided);
    expect(&mut stage, 1);
    stage.world.insert_resource(FaceCulling::None);
    expect(&mut stage, 9);
    paint_ground(&mut stage, white());
    expect(&mut stage, 9);
    stage.world.insert_resource(FaceCulling::SingleSided);
    assert_eq!(reports(&mut stage), nothing, "as they were baked");
    let mut scene = ladder();
    scene.world.insert_resource(FaceCulling::None);
    let mut stage = lit_ladder(baked(scene), 0.3, 0.02);
    assert_eq!(reports(&mut stage), nothing, "the maps hold more than is seen");
    stage.world.insert_resource(FaceCulling::None);
    assert_eq!(reports(&mut stage), nothing, "they hold the backs");
}

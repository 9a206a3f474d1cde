//! A second technique on the light: what is not in the maps casts on what is, and shows shadows itself.

mod lifetimes;
mod rest;
mod truth;

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::SurfaceHit;
use antumbra::sets::CompanionOf;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::scenes::{lit_ladder, maps};
use crate::harness::support::stage::Stage;

pub const SIZE: UVec2 = UVec2::new(128, 72);

/// One box hangs in the open, the other half below the roof.
pub const BOXES: [Vec3; 2] = [Vec3::new(0.95, 0.9, 0.9), Vec3::new(-0.8, 0.9, -0.25)];

pub const HALF: f32 = 0.3;

pub fn spawn_box(stage: &mut Stage, place: Vec3) -> Entity {
    let parts = (
        SceneMesh(Arc::new(MeshData::cuboid(Vec3::splat(HALF)))),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_translation(place),
    );
    stage.world.spawn(parts).id()
}

/// The ladder in the light of maps, with two boxes that are not in them.
pub fn with_boxes(time: f32, width: f32) -> Stage {
    let mut stage = lit_ladder(maps(), time, width);
    stage.world.insert_resource(ViewportSize(SIZE));
    for place in BOXES {
        spawn_box(&mut stage, place);
    }
    stage
}

/// Gives the only light of a stage a second technique.
pub fn add(stage: &mut Stage, second: impl Bundle) {
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(second);
}

pub fn visibility(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("the frame renders").visibility.remove(0)
}

/// Adds the second technique of a light.
pub type Add = fn(&mut Stage);

pub const SECONDS: [(&str, Add); 5] = [
    ("shadow_map", |stage| add(stage, ShadowMap::default())),
    ("stencil_volume", |stage| add(stage, StencilVolume::default())),
    ("perspective_map", |stage| {
        add(stage, PerspectiveMap::default());
    }),
    ("penumbra_wedge", |stage| add(stage, PenumbraWedge::default())),
    ("occlusion_texture", |stage| {
        let hard = OcclusionTexture {
            angle_deg: 0.1,
            resolution: 256,
            ..Default::default()
        };
        add(stage, hard);
    }),
];

/// Whether a point of the scene is on one of the boxes.
pub fn is_on_box(hit: &SurfaceHit) -> bool {
    BOXES.iter().any(|place| {
        let offset = (hit.position - place.as_dvec3()).abs();
        offset.max_element() < f64::from(HALF) + 1e-4
    })
}

pub fn companions(stage: &mut Stage) -> usize {
    stage.world.query::<&CompanionOf>().iter(&stage.world).count()
}

//! A ground, objects over it and a lamp, drawn under every technique and judged by rays.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{HardError, RayScene};
use antumbra::techniques::stencil_volume::{Counting, Extent};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;
use crate::harness::{judge, strict_context};

/// Pixels of the test pictures.
pub const SIZE: UVec2 = UVec2::new(160, 90);

/// Components of an object that casts and receives.
pub fn object(mesh: MeshData, place: Transform) -> impl Bundle {
    (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
        ShadowCaster,
        ShadowReceiver,
        place,
    )
}

/// A stage without objects, seen from a place.
pub fn stage(eye: Vec3, target: Vec3, camera: Camera) -> Stage {
    let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..camera
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    // As the judge sees it.
    stage.world.insert_resource(FaceCulling::None);
    stage
}

/// A ground of 20 metres, seen aslant from above.
pub fn ground() -> Stage {
    let mut stage = stage(
        Vec3::new(2.5, 3.5, 4.5),
        Vec3::new(0.0, 0.4, 0.0),
        Camera::default(),
    );
    stage
        .world
        .spawn(object(MeshData::plane(20.0), Transform::IDENTITY));
    stage
}

/// A lamp without a technique.
pub fn lamp(stage: &mut Stage, kind: LightKind, at: Vec3, range: f32) -> Entity {
    let light = Light {
        kind,
        color: Vec3::ONE,
        intensity: 40.0,
        range,
    };
    let place = Transform::from_translation(at).looking_at(Vec3::ZERO, Vec3::X);
    stage.spawn_light(light, place, None::<StencilVolume>)
}

/// The techniques that draw hard shadows of a lamp, by name.
pub const HARD: [&str; 3] = ["stencil", "stencil to infinity", "wedges"];

/// Gives the light a technique of [`HARD`] or a map, and takes others away.
pub fn set_technique(stage: &mut Stage, light: Entity, name: &str) {
    let mut entity = stage.world.entity_mut(light);
    entity.remove::<(StencilVolume, PenumbraWedge, OmniMap, PerspectiveMap, Smoothie)>();
    match name {
        "stencil" => entity.insert(StencilVolume::default()),
        "stencil to infinity" => entity.insert(StencilVolume {
            counting: Counting::DepthFail,
            extent: Extent::Infinite,
        }),
        "wedges" => entity.insert(PenumbraWedge::default()),
        "perspective" => entity.insert(PerspectiveMap::default()),
        "smoothie" => entity.insert(Smoothie::default()),
        _ => entity.insert(OmniMap::default()),
    };
}

/// Draws a frame.
pub fn draw(stage: &mut Stage) -> Rendered {
    stage.render().expect("it is drawn")
}

/// The error of the first light's visibility, against the world as it is.
pub fn error_of(stage: &mut Stage, rendered: &Rendered) -> HardError {
    let scene = RayScene::from_world(&mut stage.world);
    judge(stage, &scene, 0, &rendered.visibility[0])
}

/// Pixels that the first light does not reach.
pub fn dark(rendered: &Rendered) -> usize {
    rendered.visibility[0]
        .iter()
        .filter(|value| **value == 0.0)
        .count()
}

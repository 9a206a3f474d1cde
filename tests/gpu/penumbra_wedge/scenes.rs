//! Scenes that the wedges are judged in, and the judge.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, RayScene, SoftError, VisibilityImage, compare_soft, difference_image, primary_hits,
    soft_visibility,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, UVec2, Vec3};

use crate::harness::support::stage::Stage;

/// Pixels of the test pictures.
pub const SIZE: UVec2 = UVec2::new(160, 90);

/// Samples of the truth.
pub const SAMPLES: u32 = 1024;

/// A light of a shape at a place, shining towards a target.
#[derive(Clone, Debug)]
pub struct Lit {
    /// Shape.
    pub kind: LightKind,
    /// Place.
    pub from: Vec3,
    /// What it shines to.
    pub to: Vec3,
    /// Technique.
    pub wedge: PenumbraWedge,
}

/// A rectangle.
pub fn rect(width: f32, height: f32) -> LightKind {
    LightKind::Rect { width, height }
}

/// A sphere.
pub fn sphere(radius: f32) -> LightKind {
    LightKind::Sphere { radius }
}

/// A stage with a ground plane and a camera.
pub fn ground(context: &RenderContext, eye: Vec3, target: Vec3) -> Stage {
    let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    spawn(&mut stage, MeshData::plane(20.0), Transform::IDENTITY);
    stage
}

/// Adds a caster that receives.
pub fn spawn(stage: &mut Stage, mesh: MeshData, place: Transform) -> Entity {
    stage
        .world
        .spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            place,
        ))
        .id()
}

/// Adds a light.
pub fn light(stage: &mut Stage, lit: &Lit) -> Entity {
    let up = if (lit.to - lit.from).normalize().y.abs() > 0.95 {
        Vec3::Z
    } else {
        Vec3::Y
    };
    let place = Transform::from_translation(lit.from).looking_at(lit.to, up);
    let light = Light {
        kind: lit.kind,
        color: Vec3::ONE,
        intensity: 60.0,
        range: f32::INFINITY,
    };
    stage.spawn_light(light, place, Some(lit.wedge))
}

/// Truth of a light in the frame that ran last.
pub fn truth(stage: &mut Stage, light: usize, samples: u32) -> VisibilityImage {
    stage.schedule.run(&mut stage.world);
    let scene = RayScene::from_world(&mut stage.world);
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("a camera");
    let transform = world.get::<GlobalTransform>(stage.camera).expect("its place");
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(&scene, camera, transform, size).expect("a usable camera");
    let source = LightSource::of_entity(world, stage.lights[light]).expect("a usable light");
    soft_visibility(&scene, &hits, &source, samples, 7)
}

/// Visibility of a light as rendered.
pub fn rendered(stage: &mut Stage, light: usize) -> VisibilityImage {
    let rendered = stage.render().expect("the frame renders");
    VisibilityImage::new(rendered.size, rendered.visibility[light].clone()).expect("a whole picture")
}

/// The error of the first light; leaves pictures if `ANTUMBRA_TEST_PICTURES` names a folder.
pub fn judge(stage: &mut Stage, truth: &VisibilityImage, name: &str) -> SoftError {
    let got = rendered(stage, 0);
    let error = compare_soft(truth, &got)
        .expect("pictures of one size")
        .expect("pixels that count");
    println!(
        "{name}: rmse {:.4}, penumbra {:.4} ({} px), p99 {:.3}, umbra lit {:.4}, lit dark {:.4}",
        error.rmse, error.rmse_penumbra, error.penumbra, error.p99, error.umbra_lit, error.lit_dark
    );
    if let Some(folder) = std::env::var_os("ANTUMBRA_TEST_PICTURES") {
        let folder = std::path::PathBuf::from(folder);
        let size = got.size();
        for (kind, image) in [("got", &got), ("truth", truth)] {
            let bytes: Vec<u8> = image
                .values()
                .iter()
                .map(|v| {
                    if v.is_nan() {
                        90
                    } else {
                        (v.clamp(0.0, 1.0) * 255.0).round() as u8
                    }
                })
                .collect();
            image::GrayImage::from_raw(size.x, size.y, bytes)
                .expect("whole")
                .save(folder.join(format!("{name}_{kind}.png")))
                .expect("a writable folder");
        }
        let difference = difference_image(truth, &got).expect("one size");
        image::RgbaImage::from_raw(size.x, size.y, difference.rgba8)
            .expect("whole")
            .save(folder.join(format!("{name}_difference.png")))
            .expect("a writable folder");
    }
    error
}

/// Where the camera stands.
pub const EYE: Vec3 = Vec3::new(2.5, 3.0, 4.5);

/// A light above the scene.
pub fn lit(kind: LightKind, wedge: PenumbraWedge) -> Lit {
    Lit {
        kind,
        from: Vec3::new(0.6, 4.5, 0.8),
        to: Vec3::ZERO,
        wedge,
    }
}

/// Spheres and boxes that overlap as seen from the light, in an order.
pub fn crowd(context: &RenderContext, reversed: bool) -> Stage {
    let mut stage = ground(context, EYE, Vec3::ZERO);
    let mut casters: Vec<(MeshData, Transform)> = (0..6)
        .map(|i| {
            let angle = i as f32 * 1.1;
            let place = Transform::from_xyz(0.5 * angle.cos(), 0.5 + 0.25 * i as f32, 0.5 * angle.sin());
            let mesh = if i % 2 == 0 {
                MeshData::cuboid(Vec3::splat(0.25))
            } else {
                MeshData::icosphere(0.3, 2)
            };
            (mesh, place.with_rotation(Quat::from_rotation_x(angle)))
        })
        .collect();
    if reversed {
        casters.reverse();
    }
    for (mesh, place) in casters {
        spawn(&mut stage, mesh, place);
    }
    stage
}

/// Of any pixel.
pub fn largest_difference(a: &VisibilityImage, b: &VisibilityImage) -> f32 {
    let pairs = a.values().iter().zip(b.values());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// Visibility of the first light with other settings.
pub fn with(stage: &mut Stage, wedge: PenumbraWedge) -> VisibilityImage {
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(wedge);
    rendered(stage, 0)
}

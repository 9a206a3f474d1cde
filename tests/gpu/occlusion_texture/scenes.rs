//! Scenes like those of the paper, small: a tree over a ground, thin wings, boxes over each other, an uneven ground.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    HitImage, LightShape, LightSource, RayScene, VisibilityImage, primary_hits, soft_visibility,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, UVec2, Vec3};

use crate::harness::support::stage::Stage;

/// Pixels of the pictures.
pub const SIZE: UVec2 = UVec2::new(96, 54);

/// Half of the angle with which directional lights are judged, as a tangent.
pub const SUN_TANGENT: f64 = 0.06;

/// A scene without light and camera.
pub struct Scene {
    /// Name for messages.
    pub name: &'static str,
    /// Meshes with their places.
    pub parts: Vec<(MeshData, Transform)>,
    /// Place of the eye; it looks at the middle of the scene.
    pub eye: Vec3,
}

fn at(x: f32, y: f32, z: f32) -> Transform {
    Transform::from_xyz(x, y, z)
}

fn ground() -> (MeshData, Transform) {
    (MeshData::plane(2.5), at(0.0, 0.0, 0.0))
}

/// Random numbers from a seed.
pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    /// The next number.
    pub fn unit(&mut self) -> f32 {
        self.0.f32()
    }

    /// A place in a box around the origin.
    pub fn place(&mut self, half: Vec3) -> Vec3 {
        (Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0) * half
    }
}

/// A plate over a ground.
pub fn plate() -> Scene {
    Scene {
        name: "a plate",
        parts: vec![ground(), (MeshData::plane(0.5), at(0.1, 1.0, 0.0))],
        eye: Vec3::new(1.5, 3.5, 3.0),
    }
}

/// A place between the boxes of [`boxes`], with some above and some below.
pub const BETWEEN: Vec3 = Vec3::new(0.1, 1.1, -0.1);

/// Boxes over each other, whose shadows overlap in part.
pub fn boxes() -> Scene {
    let mut parts = vec![ground()];
    for (index, height) in [0.5f32, 0.9, 1.3, 1.7].into_iter().enumerate() {
        let turned = Quat::from_rotation_y(0.5 * index as f32);
        let shift = Quat::from_rotation_y(1.7 * index as f32) * Vec3::X * 0.35;
        parts.push((
            MeshData::cuboid(Vec3::new(0.35, 0.06, 0.25)),
            Transform::from_translation(shift + Vec3::Y * height).with_rotation(turned),
        ));
    }
    Scene {
        name: "boxes",
        parts,
        eye: Vec3::new(1.5, 3.0, 3.0),
    }
}

/// Low boxes and a plate.
pub fn low() -> Scene {
    let cuboid = |half: Vec3, x, y, z| (MeshData::cuboid(half), at(x, y, z));
    Scene {
        name: "low boxes",
        parts: vec![
            ground(),
            cuboid(Vec3::new(0.5, 0.05, 0.4), 0.0, 0.6, 0.0),
            cuboid(Vec3::new(0.15, 0.3, 0.15), -0.6, 0.3, 0.5),
            cuboid(Vec3::new(0.2, 0.25, 0.1), 0.3, 0.25, -0.7),
        ],
        eye: Vec3::new(1.5, 3.5, 3.0),
    }
}

/// A trunk with many leaves.
pub fn tree() -> Scene {
    let mut random = Random::new(5);
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for leaf in 0..160u32 {
        let middle = Vec3::new(0.0, 1.3, 0.0) + random.place(Vec3::new(0.6, 0.5, 0.6));
        let turn =
            Quat::from_rotation_y(random.unit() * 6.0) * Quat::from_rotation_x(random.unit() * 2.0 - 1.0);
        for corner in [
            Vec3::new(-1.0, 0.0, -0.6),
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(-0.6, 0.0, 1.0),
        ] {
            positions.push(middle + turn * corner * 0.11);
        }
        indices.extend([3 * leaf, 3 * leaf + 1, 3 * leaf + 2]);
    }
    let leaves = MeshData::from_triangles("leaves", positions, indices);
    let trunk = (MeshData::cuboid(Vec3::new(0.06, 0.6, 0.06)), at(0.0, 0.6, 0.0));
    Scene {
        name: "a tree",
        parts: vec![ground(), trunk, (leaves, at(0.0, 0.0, 0.0))],
        eye: Vec3::new(1.5, 2.6, 3.2),
    }
}

/// Two thin wings that pass through several slices.
pub fn wings() -> Scene {
    let wing = |side: f32| {
        Transform::from_xyz(side * 0.4, 0.9, 0.0).with_rotation(Quat::from_rotation_z(side * 0.7))
    };
    let parts = vec![
        ground(),
        (MeshData::plane(0.5), wing(-1.0)),
        (MeshData::plane(0.5), wing(1.0)),
    ];
    Scene {
        name: "wings",
        parts,
        eye: Vec3::new(0.8, 3.2, 3.2),
    }
}

/// Balls over a ground of hills.
pub fn hills() -> Scene {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    let count = 24u32;
    for z in 0..=count {
        for x in 0..=count {
            let place = Vec3::new(x as f32, 0.0, z as f32) / count as f32 * 5.0 - Vec3::new(2.5, 0.0, 2.5);
            let height = 0.25 * (place.x * 2.1).sin() * (place.z * 1.7).cos();
            positions.push(place + Vec3::Y * height);
        }
    }
    for z in 0..count {
        for x in 0..count {
            let a = z * (count + 1) + x;
            let (b, c, d) = (a + 1, a + count + 1, a + count + 2);
            indices.extend([a, c, b, b, c, d]);
        }
    }
    let parts = vec![
        (
            MeshData::from_triangles("hills", positions, indices),
            at(0.0, 0.0, 0.0),
        ),
        (MeshData::icosphere(0.3, 2), at(-0.3, 1.0, 0.1)),
        (MeshData::icosphere(0.2, 2), at(0.5, 0.8, -0.3)),
    ];
    Scene {
        name: "hills",
        parts,
        eye: Vec3::new(1.2, 2.6, 3.2),
    }
}

/// A stage with a renderer and a view.
pub fn empty(context: &RenderContext, eye: Vec3) -> Stage {
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let view = Transform::from_translation(eye).looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    stage
}

/// Adds a caster that receives.
pub fn spawn(stage: &mut Stage, mesh: MeshData, place: Transform) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
        (ShadowCaster, ShadowReceiver),
        place,
    );
    stage.world.spawn(parts).id()
}

/// A stage with a scene.
pub fn staged(context: &RenderContext, scene: &Scene) -> Stage {
    let mut stage = empty(context, scene.eye);
    for (mesh, place) in &scene.parts {
        spawn(&mut stage, mesh.clone(), *place);
    }
    stage
}

/// A light at a place that shines straight down.
pub fn lamp(kind: LightKind, from: Vec3) -> (Light, Transform) {
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 40.0, 30.0)
    };
    (
        light,
        Transform::from_translation(from).looking_at(from - Vec3::Y, Vec3::Z),
    )
}

/// A square light.
pub const fn square(side: f32) -> LightKind {
    LightKind::Rect {
        width: side,
        height: side,
    }
}

/// Visibility of the first light.
pub fn rendered(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("the frame renders").visibility.remove(0)
}

/// The surface of every pixel in the frame that ran last.
pub fn hits(stage: &mut Stage) -> (RayScene, HitImage) {
    let scene = RayScene::from_world(&mut stage.world);
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("a camera");
    let transform = world.get::<GlobalTransform>(stage.camera).expect("its place");
    let hits = primary_hits(&scene, camera, transform, world.resource::<ViewportSize>().0);
    (scene, hits.expect("a usable camera"))
}

/// The true visibility of the first light in the frame that ran last. A directional light covers [`SUN_TANGENT`].
pub fn truth(stage: &mut Stage, samples: u32) -> VisibilityImage {
    let (scene, hits) = hits(stage);
    let mut source = LightSource::of_entity(&stage.world, stage.lights[0]).expect("a usable light");
    if let LightShape::Directional { towards } = source.shape {
        source.shape = LightShape::Sphere {
            center: towards * 1e3,
            radius: 1e3 * SUN_TANGENT,
        };
    }
    soft_visibility(&scene, &hits, &source, samples, 7)
}

/// Root of the mean square difference over the pixels that count.
pub fn rmse(truth: &VisibilityImage, got: &[f32]) -> f64 {
    let pairs = truth
        .values()
        .iter()
        .zip(got)
        .filter(|(truth, _)| !truth.is_nan());
    let (mut sum, mut count) = (0.0, 0.0);
    for (truth, got) in pairs {
        sum += f64::from(truth - got).powi(2);
        count += 1.0;
    }
    f64::sqrt(sum / f64::max(count, 1.0))
}

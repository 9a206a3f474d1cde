//! Scenes made to show what maps do wrong: acne, shadows parted from their casters, light through walls.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use bevy_ecs::prelude::{Entity, With};
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use crate::harness::support::stage::Stage;

/// Pixels of the pictures.
pub const SIZE: UVec2 = UVec2::new(112, 63);

/// A scene: what stands in it, the eye and what it looks at, the light.
pub struct TestScene {
    /// Its name.
    pub name: &'static str,
    /// Casters and receivers.
    pub objects: Vec<(MeshData, Transform)>,
    /// From where, and to where, the camera looks.
    pub view: (Vec3, Vec3),
    /// The light's place, and what it shines at.
    pub light: (Vec3, Vec3),
    /// Factor on all sizes, and an offset of everything.
    pub scale: f32,
    /// Metres.
    pub offset: Vec3,
}

fn floor() -> (MeshData, Transform) {
    (MeshData::plane(6.0), Transform::default())
}

fn cube(x: f32, y: f32, z: f32, half: f32) -> (MeshData, Transform) {
    (MeshData::cuboid(Vec3::splat(half)), Transform::from_xyz(x, y, z))
}

fn block(at: [f32; 3], half: [f32; 3]) -> (MeshData, Transform) {
    (
        MeshData::cuboid(half.into()),
        Transform::from_translation(at.into()),
    )
}

fn ball(x: f32, y: f32, z: f32, radius: f32) -> (MeshData, Transform) {
    (MeshData::icosphere(radius, 4), Transform::from_xyz(x, y, z))
}

/// The lower half of a sphere's shell, seen from inside: concave everywhere.
fn bowl() -> (MeshData, Transform) {
    let whole = MeshData::icosphere(1.0, 5);
    let low = |corner: &u32| whole.positions[*corner as usize].y < 0.2;
    let indices = whole
        .indices
        .chunks_exact(3)
        .filter(|corners| corners.iter().all(low))
        .flatten()
        .copied()
        .collect();
    let mesh = MeshData::from_triangles("bowl", whole.positions.clone(), indices);
    (mesh, Transform::from_xyz(0.0, 1.05, 0.0))
}

/// All of them.
pub fn all() -> Vec<TestScene> {
    let view = (Vec3::new(1.6, 1.5, 2.6), Vec3::new(0.0, 0.35, 0.0));
    let light = (Vec3::new(-1.6, 2.3, 0.3), Vec3::ZERO);
    let scene = |name, objects| TestScene {
        name,
        objects,
        view,
        light,
        scale: 1.0,
        offset: Vec3::ZERO,
    };
    let lit = |name, objects, light: [f32; 3]| TestScene {
        light: (light.into(), Vec3::ZERO),
        ..scene(name, objects)
    };
    let tilt = |mesh: (MeshData, Transform), rotation| (mesh.0, mesh.1.with_rotation(rotation));
    let cube_on_floor = || vec![floor(), cube(0.0, 0.5, 0.0, 0.5)];
    let sheet = |rotation| {
        (
            MeshData::plane(0.7),
            Transform::from_xyz(0.0, 0.7, 0.0).with_rotation(rotation),
        )
    };
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let room = |thick: f32| {
        vec![
            block([0.0, -thick, 0.0], [2.0, thick, 2.0]),
            block([0.0, 2.0 + thick, 0.0], [2.0, thick, 2.0]),
            block([-2.0 - thick, 1.0, 0.0], [thick, 1.0, 2.0]),
            block([2.0 + thick, 1.0, 0.0], [thick, 1.0, 2.0]),
            block([0.0, 1.0, -2.0 - thick], [2.0, 1.0, thick]),
        ]
    };
    let with = |mut objects: Vec<(MeshData, Transform)>, more: (MeshData, Transform)| {
        objects.push(more);
        objects
    };
    let pillars = (0..7).map(|i| block([i as f32 * 0.4 - 1.2, 0.5, 0.0], [0.03, 0.5, 0.03]));
    let steps = (0..6).map(|i| block([0.0, 0.1 * i as f32, -0.25 * i as f32], [0.9, 0.1, 0.15]));
    vec![
        scene("cube on floor", cube_on_floor()),
        lit("cube, light at 8°", cube_on_floor(), [4.0, 0.57, 0.9]),
        lit("cube, light along a face", cube_on_floor(), [0.502, 3.0, 0.2]),
        lit("cube, near light", cube_on_floor(), [0.9, 0.8, 0.7]),
        lit("cube, far light", cube_on_floor(), [60.0, 80.0, 50.0]),
        scene("sphere contact", vec![floor(), ball(0.0, 0.5, 0.0, 0.5)]),
        lit(
            "sphere from above",
            vec![floor(), ball(0.0, 0.5, 0.0, 0.5)],
            [0.1, 3.0, 0.1],
        ),
        lit(
            "sphere, grazing",
            vec![floor(), ball(0.0, 0.5, 0.0, 0.5)],
            [-4.0, 0.8, 0.5],
        ),
        scene(
            "wall of 4 cm",
            vec![floor(), block([0.0, 0.6, 0.0], [0.9, 0.6, 0.02])],
        ),
        scene(
            "wall of 2 mm",
            vec![floor(), block([0.0, 0.6, 0.0], [0.9, 0.6, 0.001])],
        ),
        lit(
            "sheet, light before",
            vec![floor(), sheet(upright)],
            [0.4, 2.0, 2.4],
        ),
        lit(
            "sheet, light behind",
            vec![floor(), sheet(upright)],
            [0.4, 2.0, -2.4],
        ),
        lit("sheet edge-on", vec![floor(), sheet(upright)], [2.4, 2.0, 0.02]),
        TestScene {
            view: (Vec3::new(0.3, 1.2, 1.9), Vec3::new(0.0, 0.9, -1.0)),
            ..lit(
                "inside a room",
                with(room(0.1), cube(0.4, 0.3, -0.7, 0.3)),
                [-0.4, 1.6, 0.3],
            )
        },
        TestScene {
            view: (Vec3::new(0.3, 1.2, 1.9), Vec3::new(0.0, 0.9, -1.0)),
            ..lit(
                "next room's light",
                with(room(0.05), cube(0.4, 0.3, -0.7, 0.3)),
                [-3.0, 1.2, -0.5],
            )
        },
        TestScene {
            view: (Vec3::new(0.3, 1.2, 1.9), Vec3::new(0.0, 0.9, -1.0)),
            ..lit("light under the ceiling", room(0.1), [0.2, 1.95, -0.4])
        },
        scene(
            "row of pillars",
            std::iter::once(floor()).chain(pillars).collect(),
        ),
        TestScene {
            view: (Vec3::new(1.6, 2.2, 2.6), Vec3::new(0.0, 0.3, -0.4)),
            ..scene("stairs", std::iter::once(floor()).chain(steps).collect())
        },
        lit(
            "plane along the light",
            vec![
                floor(),
                tilt(
                    block([0.0, 0.8, 0.0], [1.0, 0.01, 1.0]),
                    Quat::from_rotation_z(0.72),
                ),
            ],
            [2.0, 2.65, 0.0],
        ),
        TestScene {
            view: (Vec3::new(0.8, 2.4, 1.6), Vec3::new(0.0, 0.4, 0.0)),
            ..lit("bowl", vec![bowl()], [0.3, 3.0, 0.4])
        },
        TestScene {
            view: (Vec3::new(0.5, 0.6, 1.6), Vec3::new(0.0, 0.5, 0.0)),
            ..lit(
                "sphere's terminator",
                vec![floor(), ball(0.0, 0.5, 0.0, 0.5)],
                [2.5, 0.5, 0.6],
            )
        },
        scene(
            "stacked cubes",
            vec![floor(), cube(0.0, 0.3, 0.0, 0.3), cube(0.1, 0.85, 0.05, 0.25)],
        ),
        scene(
            "cube 2 cm over the floor",
            vec![floor(), cube(0.0, 0.52, 0.0, 0.5)],
        ),
        scene(
            "cube on its corner",
            vec![
                floor(),
                tilt(
                    cube(0.0, 0.6, 0.0, 0.4),
                    Quat::from_euler(glam::EulerRot::XYZ, 0.6, 0.3, 0.8),
                ),
            ],
        ),
        scene(
            "overlapping cubes",
            vec![floor(), cube(0.0, 0.4, 0.0, 0.4), cube(0.35, 0.3, 0.3, 0.35)],
        ),
        lit(
            "light 5 cm over the floor",
            vec![floor(), cube(0.0, 0.1, 0.0, 0.1)],
            [0.9, 0.05, 0.8],
        ),
        TestScene {
            scale: 0.01,
            ..scene("a centimetre", cube_on_floor())
        },
        TestScene {
            scale: 200.0,
            ..scene("two hundred metres", cube_on_floor())
        },
        TestScene {
            offset: Vec3::new(4096.0, 0.0, -8192.0),
            ..scene("far from the origin", cube_on_floor())
        },
    ]
}

impl TestScene {
    /// Sets up a stage without its light.
    pub fn stage(&self, context: &RenderContext) -> (Stage, RayScene) {
        let mut stage = Stage::empty(SIZE, Camera::default(), Transform::IDENTITY);
        stage.world.insert_resource(FaceCulling::None);
        stage
            .add_renderer(context.clone(), RenderSettings::default())
            .expect("shaders compose");
        let rays = self.fill(&mut stage);
        (stage, rays)
    }

    /// Puts the scene in place of what a stage has.
    pub fn fill(&self, stage: &mut Stage) -> RayScene {
        let mut old = stage.world.query_filtered::<Entity, With<SceneMesh>>();
        for entity in old.iter(&stage.world).collect::<Vec<_>>() {
            stage.world.despawn(entity);
        }
        for light in stage.lights.drain(..) {
            stage.world.despawn(light);
        }
        let at = |point: Vec3| point * self.scale + self.offset;
        let camera = Camera {
            vertical_fov: 0.9,
            near: 0.02 * self.scale,
            aspect: SIZE.x as f32 / SIZE.y as f32,
            ..Camera::default()
        };
        let view = Transform::from_translation(at(self.view.0)).looking_at(at(self.view.1), Vec3::Y);
        stage.world.entity_mut(stage.camera).insert((camera, view));
        for (mesh, transform) in &self.objects {
            stage.world.spawn((
                SceneMesh(Arc::new(mesh.clone())),
                SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
                (ShadowCaster, ShadowReceiver),
                Transform {
                    translation: at(transform.translation),
                    scale: transform.scale * self.scale,
                    ..*transform
                },
            ));
        }
        stage.schedule.run(&mut stage.world);
        RayScene::from_world(&mut stage.world)
    }

    /// The light of one kind, and where it stands.
    pub fn light(&self, kind: LightKind) -> (Light, Transform) {
        let at = |point: Vec3| point * self.scale + self.offset;
        let (place, target) = (at(self.light.0), at(self.light.1));
        let up = if (target - place).normalize().y.abs() > 0.95 {
            Vec3::X
        } else {
            Vec3::Y
        };
        let range = 20.0 * self.scale.max(self.light.0.length() / 10.0 * self.scale);
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 20.0, range)
        };
        (light, Transform::from_translation(place).looking_at(target, up))
    }
}

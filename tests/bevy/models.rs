//! A scene of our own components as a game of Bevy's.

use antumbra::bevy_adapter::prelude::*;
use antumbra::scene::{self, LightKind, MeshData, MorphTarget, MorphWeights, SceneMesh, Skin};
use bevy::asset::RenderAssetUsages;
use bevy::camera::{Hdr, ScalingMode};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::ecs::entity::EntityHashMap;
use bevy::light::NotShadowCaster;
use bevy::mesh::morph::{MeshMorphWeights, MorphAttributes};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::mesh::{Indices, PrimitiveTopology, VertexAttributeValues};
use bevy::prelude::*;

use crate::core_harness::support::stage::Stage;
use crate::harness::{self, Game};

/// Our mesh as one of Bevy's.
pub fn mesh(data: &MeshData) -> Mesh {
    let usages = RenderAssetUsages::default();
    let positions: Vec<[f32; 3]> = data.positions.iter().map(|p| p.to_array()).collect();
    let normals: Vec<[f32; 3]> = data.normals.iter().map(|n| n.to_array()).collect();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, usages)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(data.indices.clone()));
    if !data.joints.is_empty() {
        mesh.insert_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(data.joints.clone()),
        );
        let weights: Vec<[f32; 4]> = data.joint_weights.iter().map(|w| w.to_array()).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    }
    if !data.morph_targets.is_empty() {
        let of_target = |target: &MorphTarget| -> Vec<MorphAttributes> {
            let pairs = target.positions.iter().zip(&target.normals);
            pairs
                .map(|(&position, &normal)| MorphAttributes {
                    position,
                    normal,
                    ..default()
                })
                .collect()
        };
        mesh.set_morph_targets(data.morph_targets.iter().flat_map(of_target).collect());
    }
    mesh
}

/// A game without ambient light that shows what a stage shows, one stage after the other.
pub struct ModelGame {
    game: Game,
    camera: Entity,
}

impl ModelGame {
    pub fn new() -> Self {
        Self {
            game: harness::dark_game(),
            camera: Entity::PLACEHOLDER,
        }
    }

    /// Puts the scene of a stage in the place of the last one, with the camera and the first light where the stage has
    /// them.
    pub fn show(&mut self, stage: &mut Stage, technique: impl Bundle) -> &mut Self {
        let size = stage.world.resource::<antumbra::sets::ViewportSize>().0;
        let world = self.game.clear().world();
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial {
                base_color: Color::WHITE,
                perceptual_roughness: 1.0,
                reflectance: 0.0,
                double_sided: true,
                cull_mode: None,
                ..default()
            });
        let mut joints = EntityHashMap::<Entity>::default();
        let mut objects = stage
            .world
            .query::<(&SceneMesh, &GlobalTransform, Option<&Skin>, Option<&MorphWeights>)>();
        for (scene_mesh, transform, skin, weights) in objects.iter(&stage.world) {
            let handle = world.resource_mut::<Assets<Mesh>>().add(mesh(&scene_mesh.0));
            let mut object = world.spawn((Mesh3d(handle), MeshMaterial3d(material.clone())));
            object.insert(Transform::from(*transform));
            if let Some(MorphWeights(weights)) = weights {
                let weights = weights.clone();
                object.insert(MeshMorphWeights::Value { weights });
            }
            let object = object.id();
            let Some(skin) = skin else { continue };
            let skin_joints = skin.joints.iter().map(|&joint| {
                let transform = stage
                    .world
                    .get::<GlobalTransform>(joint)
                    .copied()
                    .unwrap_or_default();
                *joints
                    .entry(joint)
                    .or_insert_with(|| world.spawn(Transform::from(transform)).id())
            });
            let skin_joints: Vec<Entity> = skin_joints.collect();
            let mut binds = world.resource_mut::<Assets<SkinnedMeshInverseBindposes>>();
            let inverse_bindposes = binds.add(SkinnedMeshInverseBindposes::from(skin.inverse_bind.to_vec()));
            world.entity_mut(object).insert(SkinnedMesh {
                inverse_bindposes,
                joints: skin_joints,
            });
        }
        let (view, at) = {
            let camera = stage.world.entity(stage.camera);
            (
                *camera.get::<scene::Camera>().unwrap(),
                *camera.get::<GlobalTransform>().unwrap(),
            )
        };
        let target = harness::target(world, size);
        let camera = world.spawn((
            Camera3d::default(),
            AntumbraCamera,
            (Hdr, Msaa::Off, Tonemapping::None),
            target,
            match view.orthographic {
                None => Projection::Perspective(PerspectiveProjection {
                    fov: view.vertical_fov,
                    near: view.near,
                    near_clip_plane: Vec4::new(0.0, 0.0, -1.0, -view.near),
                    ..default()
                }),
                Some(orthographic) => Projection::Orthographic(OrthographicProjection {
                    near: view.near,
                    far: orthographic.far,
                    scaling_mode: ScalingMode::FixedVertical {
                        viewport_height: orthographic.height,
                    },
                    ..OrthographicProjection::default_3d()
                }),
            },
            Transform::from(at),
        ));
        self.camera = camera.id();
        let (light, at) = {
            let light = stage.world.entity(stage.lights[0]);
            (
                light.get::<scene::Light>().unwrap().clone(),
                *light.get::<GlobalTransform>().unwrap(),
            )
        };
        let bounds = stage.scene_bounds();
        let distance = (at.translation() - bounds.center()).length().max(1e-3);
        world
            .spawn((Transform::from(at), technique))
            .insert_light(&light, distance);
        self.game.run(5);
        self
    }

    /// Whether anything blocks light.
    pub fn set_casting(&mut self, casts: bool) -> &mut Self {
        let world = self.game.world();
        let meshes: Vec<Entity> = world
            .query_filtered::<Entity, With<Mesh3d>>()
            .iter(world)
            .collect();
        for mesh in meshes {
            if casts {
                world.entity_mut(mesh).remove::<NotShadowCaster>();
            } else {
                world.entity_mut(mesh).insert(NotShadowCaster);
            }
        }
        self.game.run(2);
        self
    }

    pub fn picture(&mut self) -> harness::Picture {
        self.game.settled(self.camera)
    }
}

trait InsertLight {
    fn insert_light(&mut self, light: &scene::Light, distance: f32) -> Entity;
}

impl InsertLight for EntityWorldMut<'_> {
    /// Bright enough at a distance that whatever is lit is seen in 16 bits.
    fn insert_light(&mut self, light: &scene::Light, distance: f32) -> Entity {
        let intensity = 1e5 * distance * distance;
        let light = &scene::Light {
            range: light.range.min(1e4),
            ..light.clone()
        };
        match light.kind {
            LightKind::Point => self.insert(PointLight {
                intensity,
                range: light.range,
                ..default()
            }),
            LightKind::Sphere { radius } => self.insert(PointLight {
                intensity,
                range: light.range,
                radius,
                ..default()
            }),
            LightKind::Spot {
                inner_angle,
                outer_angle,
            } => self.insert(SpotLight {
                intensity,
                range: light.range,
                inner_angle,
                outer_angle,
                ..default()
            }),
            LightKind::Directional => self.insert(DirectionalLight {
                illuminance: 1e4,
                ..default()
            }),
            LightKind::Rect { width, height } => self.insert(RectLight {
                intensity,
                range: light.range,
                width,
                height,
                ..default()
            }),
        };
        self.id()
    }
}

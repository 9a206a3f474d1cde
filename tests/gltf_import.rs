//! glTF files load to what they say: held against values worked out by hand, and against the models.

mod gltf_builder;

use antumbra::scene::gltf_import::{SkipKind, load_gltf, load_gltf_slice, spawn_scene};
use antumbra::scene::{
    AlphaMode, Camera, Light, LightKind, LocalBounds, MorphWeights, PosedMesh, SceneMaterials, SceneMesh,
    TextureWrap, WorldBounds, apply_animation,
};
use base64::Engine;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, Vec2, Vec3, Vec4};
use gltf_builder::*;
use serde_json::{Value, json};

fn assert_near(actual: Vec3, expected: Vec3) {
    assert!(actual.distance(expected) < 1e-5, "{actual} is not {expected}");
}

#[test]
#[should_panic(expected = "is not")]
fn assert_near_fails_when_one_component_moves() {
    assert_near(Vec3::ZERO, Vec3::new(0.0, 1e-3, 0.0));
}

fn indices_of_mode(mode: u32, indices: &[u16]) -> Vec<u32> {
    let mut builder = quad();
    let accessor = builder.indices_u16(indices);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
    builder.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
    builder.load().meshes[0].data.indices.clone()
}

#[test]
fn triangles_strips_and_fans_become_triangle_lists() {
    assert_eq!(indices_of_mode(4, &[0, 1, 2, 2, 1, 3]), [0, 1, 2, 2, 1, 3]);
    assert_eq!(indices_of_mode(5, &[0, 1, 2, 3]), [0, 1, 2, 1, 3, 2]);
    assert_eq!(indices_of_mode(6, &[0, 1, 3, 2]), [1, 3, 0, 3, 2, 0]);
}

#[test]
fn points_and_lines_are_counted_and_not_drawn() {
    for mode in 0..=3 {
        let mut builder = quad();
        builder.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let gltf = builder.load();
        assert_eq!(gltf.triangle_count(), 0);
        assert_eq!(gltf.report.count(SkipKind::DrawMode), 1);
        assert!(
            gltf.report
                .to_string()
                .starts_with("mesh 0 primitive 0: skipped 1 points or lines")
        );
        assert_eq!(gltf.report.to_string().lines().count(), 1);
    }
}

#[test]
fn indices_of_every_width_and_none() {
    let wide: Vec<u8> = [2u32, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect();
    let middle: Vec<u8> = [2u16, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect();
    for (bytes, component) in [(vec![2u8, 1, 0], U8), (middle, U16), (wide, U32)] {
        let mut builder = quad();
        let accessor = builder.accessor(&bytes, component, "SCALAR", 3);
        builder.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
        assert_eq!(builder.load().meshes[0].data.indices, [2, 1, 0]);
    }
    assert_eq!(triangle().load().meshes[0].data.indices, [0, 1, 2]);
}

#[test]
fn absent_normals_are_flat_and_split_vertices() {
    let mut builder = quad();
    builder.binary[3 * 12 + 8..3 * 12 + 12].copy_from_slice(&1.0f32.to_le_bytes()); // bends the fourth corner up
    let attributes = builder.json["meshes"][0]["primitives"][0]["attributes"]
        .as_object_mut()
        .unwrap();
    attributes.remove("NORMAL");
    let gltf = builder.load();
    let mesh = &gltf.meshes[0].data;
    assert_eq!((mesh.positions.len(), mesh.indices.len()), (6, 6));
    assert_eq!(mesh.normals[..3], [Vec3::Z; 3]);
    let bent = Vec3::new(-1.0, -1.0, 1.0).normalize();
    for &normal in &mesh.normals[3..] {
        assert_near(normal, bent);
    }
}

#[test]
fn sparse_values_replace_dense_ones_and_zeros() {
    let mut builder = triangle();
    let places = builder.view(&[1, 2]);
    let values: Vec<u8> = [5.0f32, 6.0, 7.0, 8.0, 9.0, 10.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let values = builder.view(&values);
    let sparse = json!({
        "count": 2, "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": values}
    });
    builder.json["accessors"][0]["sparse"] = sparse.clone();
    let expected = [Vec3::ZERO, Vec3::new(5.0, 6.0, 7.0), Vec3::new(8.0, 9.0, 10.0)];
    assert_eq!(builder.load().meshes[0].data.positions, expected);

    builder.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(builder.load().meshes[0].data.positions, expected);
}

#[test]
fn normalized_integers_and_strides() {
    let mut builder = quad();
    // 16-bit positions in a stride of 8, normalised: −32768 is clamped to −1
    let shorts: [i16; 16] = [0, 0, 0, 9, 32767, 0, 0, 9, 0, -32768, 0, 9, 0, 0, -32767, 9];
    let bytes: Vec<u8> = shorts.iter().flat_map(|x| x.to_le_bytes()).collect();
    let positions = builder.accessor(&bytes[..30], 5122, "VEC3", 4);
    let view = builder.json["accessors"][positions]["bufferView"]
        .as_u64()
        .unwrap() as usize;
    builder.json["bufferViews"][view]["byteStride"] = json!(8);
    builder.json["accessors"][positions]["normalized"] = json!(true);
    let uv = builder.accessor(&[0, 255, 51, 0, 0, 0, 0, 0], U8, "VEC2", 4);
    builder.json["accessors"][uv]["normalized"] = json!(true);
    let colors = builder.accessor(&[255, 0, 51, 0, 0, 0, 0, 0, 0, 255, 255, 255], U8, "VEC3", 4);
    builder.json["accessors"][colors]["normalized"] = json!(true);
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] = json!(positions);
    attributes["TEXCOORD_1"] = json!(uv);
    attributes["COLOR_0"] = json!(colors);
    builder.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let gltf = builder.load();
    let mesh = &gltf.meshes[0].data;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, -Vec3::Y, -Vec3::Z]);
    assert_eq!(mesh.uv1[..2], [Vec2::new(0.0, 1.0), Vec2::new(0.2, 0.0)]);
    assert!(mesh.uv0.is_empty());
    assert_eq!(mesh.colors[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
}

#[test]
fn primitives_become_submeshes_and_missing_streams_are_filled() {
    let mut builder = quad();
    let (positions, uv) = (builder.floats(&TRIANGLE), builder.floats(&[[0.5, 0.25]; 3]));
    let shared = builder.indices_u16(&[1, 3, 2]);
    builder.push(
        "materials",
        json!({"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}),
    );
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    let mut third = primitives[0].clone();
    third["indices"] = json!(shared);
    primitives.push(json!({"attributes": {"POSITION": positions, "TEXCOORD_0": uv}, "material": 0}));
    primitives.push(third);
    let gltf = builder.load();
    let mesh = &gltf.meshes[0];
    let ranges: Vec<_> = mesh
        .data
        .submeshes
        .iter()
        .map(|s| (s.first_index, s.index_count))
        .collect();
    assert_eq!(ranges, [(0, 6), (6, 3), (9, 3)]);
    assert_eq!(
        mesh.data.positions.len(),
        7,
        "the third primitive shares the vertices of the first"
    );
    assert_eq!(mesh.data.indices[6..], [4, 5, 6, 1, 3, 2]);
    assert_eq!(
        mesh.data.uv0,
        [[Vec2::ZERO; 4].as_slice(), &[Vec2::new(0.5, 0.25); 3]].concat()
    );
    let names: Vec<_> = mesh
        .materials
        .iter()
        .map(|material| material.name.as_str())
        .collect();
    assert_eq!(names, ["default", "red", "default"]);
}

fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbaImage::from_pixel(width, height, image::Rgba([10, 20, 30, 40]));
    pixels.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn data_uri(bytes: &[u8]) -> String {
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

#[test]
fn materials_with_every_texture() {
    let mut builder = quad();
    let view = builder.view(&png(2, 3));
    builder.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    builder.push("images", json!({"uri": data_uri(&png(1, 1))}));
    builder.push(
        "samplers",
        json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9984}),
    );
    builder.push("textures", json!({"source": 0, "sampler": 0}));
    builder.push("textures", json!({"source": 1}));
    let turned = json!({"KHR_texture_transform": {
        "offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0], "texCoord": 1}});
    builder.json["materials"] = json!([{
        "name": "all", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.75,
            "baseColorTexture": {"index": 0, "extensions": turned},
            "metallicRoughnessTexture": {"index": 1, "texCoord": 1}},
        "normalTexture": {"index": 1, "scale": 2.0, "extensions": turned},
        "occlusionTexture": {"index": 0, "strength": 0.5, "extensions": turned},
        "emissiveTexture": {"index": 1}, "emissiveFactor": [1.0, 0.5, 0.0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
    }, {"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}}]);
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let material = &gltf.materials[0];
    assert_eq!(material.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!(
        (material.metallic, material.roughness, material.normal_scale),
        (0.5, 0.75, 2.0)
    );
    assert_eq!(
        (material.alpha_mode, material.double_sided, material.unlit),
        (AlphaMode::Mask(0.25), true, false)
    );
    assert_eq!(
        (material.emissive, material.occlusion_strength),
        (Vec3::new(4.0, 2.0, 0.0), 0.5)
    );
    let base = material.base_color_texture.as_ref().unwrap();
    assert_eq!((base.texture.width, base.texture.height, base.uv_set), (2, 3, 1));
    assert_eq!(base.texture.rgba8[..4], [10, 20, 30, 40]);
    assert_eq!(base.texture.wrap, [TextureWrap::Clamp, TextureWrap::Mirror]);
    assert!(!base.texture.linear_magnify && !base.texture.linear_minify);
    // scale gives (2, 0), a quarter turn counter-clockwise with v pointing down (0, −2), the offset (0.5, −1.75)
    for slot in [
        &material.base_color_texture,
        &material.normal_texture,
        &material.occlusion_texture,
    ] {
        let moved = slot.as_ref().unwrap().uv_transform.transform_point2(Vec2::X);
        assert!(moved.distance(Vec2::new(0.5, -1.75)) < 1e-6, "{moved}");
    }
    assert_eq!(material.metallic_roughness_texture.as_ref().unwrap().uv_set, 1);
    let normal = &material.normal_texture.as_ref().unwrap().texture;
    assert!(normal.linear_magnify && normal.linear_minify && normal.wrap == [TextureWrap::Repeat; 2]);
    assert_eq!(
        (gltf.materials[1].alpha_mode, gltf.materials[1].unlit),
        (AlphaMode::Blend, true)
    );
}

#[test]
fn buffers_come_from_data_uris_and_encoded_file_names() {
    let builder = quad();
    let expected = builder.load().meshes[0].data.clone();
    let text = |uri: String| serde_json::to_vec(&builder.document(Some(uri))).unwrap();

    let inline = load_gltf_slice(&text(data_uri(&builder.binary)), None, "inline.gltf").unwrap();
    assert_eq!(inline.meshes[0].data, expected);

    let folder = std::env::temp_dir().join(format!("antumbra gltf {}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("two words.bin"), &builder.binary).unwrap();
    std::fs::write(folder.join("scene.gltf"), text("two%20words.bin".to_owned())).unwrap();
    let external = load_gltf(folder.join("scene.gltf")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(external.meshes[0].data, expected);
}

#[test]
fn scenes_lights_and_cameras_are_spawned_in_node_order() {
    let mut builder = animated();
    builder.push("scenes", json!({"name": "second", "nodes": [4]}));
    builder.push("scenes", json!({}));
    builder.push("nodes", json!({"scale": [-1, 1, 1], "name": "mirror"}));
    builder.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {
        "xmag": 2.0, "ymag": 1.0, "zfar": 10.0, "znear": 0.0}}),
    );
    builder.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {
        "xmag": 1.0, "ymag": 1.0, "zfar": 0.1, "znear": 10.0}}),
    );
    let lights = builder.json["extensions"]["KHR_lights_punctual"]["lights"]
        .as_array_mut()
        .unwrap();
    lights
        .push(json!({"type": "spot", "range": 7.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}}));
    lights.push(json!({"type": "directional", "color": [1.0, 0.5, 0.25]}));
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::Camera), 1);
    assert_eq!(gltf.cameras[1], Some(Camera::orthographic(2.0, 0.0, 10.0, 2.0)));
    assert_eq!(gltf.cameras[2], None);
    assert_eq!(gltf.lights[0], Light::point(Vec3::ONE, 12.5, f32::INFINITY));
    let spot = LightKind::Spot {
        inner_angle: 0.1,
        outer_angle: 0.2,
    };
    assert_eq!((gltf.lights[1].kind, gltf.lights[1].range), (spot, 7.0));
    assert_eq!(gltf.lights[2], Light::directional(Vec3::new(1.0, 0.5, 0.25), 1.0));

    let (mut world, mut schedule) = frame();
    let first = spawn_scene(&mut world, &gltf, None).unwrap();
    let second = spawn_scene(&mut world, &gltf, Some(1)).unwrap();
    assert!(
        spawn_scene(&mut world, &gltf, Some(2))
            .unwrap()
            .nodes
            .nodes
            .iter()
            .all(Option::is_none)
    );
    let node = first.nodes.nodes[3].unwrap();
    assert_eq!(
        (&first.lights[..], &first.cameras[..]),
        (&[node][..], &[node][..])
    );
    assert_eq!(world.get::<Camera>(node).unwrap().vertical_fov, 0.8);
    assert_eq!(first.nodes.nodes[4], None);
    assert_eq!(
        world.get::<Name>(first.nodes.nodes[1].unwrap()).unwrap().as_str(),
        "hip"
    );
    assert_eq!(
        world
            .get::<ChildOf>(first.nodes.nodes[2].unwrap())
            .unwrap()
            .parent(),
        first.nodes.nodes[1].unwrap()
    );
    let mirror = second.nodes.nodes[4].unwrap();
    schedule.run(&mut world);
    assert!(
        world
            .get::<GlobalTransform>(mirror)
            .unwrap()
            .affine()
            .matrix3
            .determinant()
            < 0.0
    );
    let message = spawn_scene(&mut world, &gltf, Some(3)).unwrap_err().to_string();
    assert!(
        message.contains("test.glb: file: scene 3 does not exist, the file has 3"),
        "{message}"
    );
}

#[test]
fn skin_and_morph_pose_to_hand_computed_vertices() {
    let gltf = animated().load();
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let mesh = spawned.meshes[0];
    assert_ne!(
        Some(mesh),
        spawned.nodes.nodes[0],
        "a skinned mesh leaves its node"
    );
    schedule.run(&mut world);
    assert_eq!(
        world.get::<PosedMesh>(mesh).unwrap().positions,
        world.get::<SceneMesh>(mesh).unwrap().0.positions
    );

    // halfway: the second joint has moved by (2, 0, 0), the target is at one half
    apply_animation(&mut world, &spawned, &gltf.clips[0], 1.0);
    schedule.run(&mut world);
    let posed = world.get::<PosedMesh>(mesh).unwrap();
    let lift = 0.5 * Vec3::Z;
    for (vertex, expected) in [
        Vec3::ZERO,
        Vec3::X * 3.0,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(2.5, 1.0, 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        assert_near(posed.positions[vertex], expected + lift);
        assert_near(posed.normals[vertex], Vec3::Z);
    }
    let bounds = world.get::<WorldBounds>(mesh).unwrap().0;
    assert_near(bounds.max, Vec3::new(3.0, 1.0, 0.5));

    // times are clamped
    apply_animation(&mut world, &spawned, &gltf.clips[0], 99.0);
    assert_eq!(world.get::<MorphWeights>(mesh).unwrap().0, [1.0]);
    assert_eq!(gltf.clips[0].duration(), 2.0);

    // a turned joint turns normals
    let hip = spawned.nodes.nodes[1].unwrap();
    world.get_mut::<Transform>(hip).unwrap().rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    apply_animation(&mut world, &spawned, &gltf.clips[0], 0.0);
    schedule.run(&mut world);
    let posed = world.get::<PosedMesh>(mesh).unwrap();
    assert_near(posed.positions[2], Vec3::Z);
    assert_near(posed.normals[2], -Vec3::Y);
}

#[derive(Resource, Default)]
struct PoseCount(usize);

#[test]
fn meshes_pose_only_when_something_moved_and_survive_singular_transforms() {
    let gltf = animated().load();
    let (mut world, mut schedule) = frame();
    world.init_resource::<PoseCount>();
    schedule.add_systems(
        (|posed: Query<(), Changed<PosedMesh>>, mut count: ResMut<PoseCount>| {
            count.0 += posed.iter().count()
        })
        .after(antumbra::scene::pose::pose_meshes),
    );
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let mesh = spawned.meshes[0];
    let joint = spawned.nodes.nodes[2].unwrap();
    let poses = |world: &mut World, schedule: &mut Schedule| {
        world.resource_mut::<PoseCount>().0 = 0;
        schedule.run(world);
        world.resource::<PoseCount>().0
    };
    assert_eq!(poses(&mut world, &mut schedule), 1);
    assert_eq!(poses(&mut world, &mut schedule), 0);
    world.get_mut::<Transform>(joint).unwrap().translation.x = 1.0;
    assert_eq!(poses(&mut world, &mut schedule), 1);
    world.get_mut::<MorphWeights>(mesh).unwrap().0[0] = 0.5;
    assert_eq!(poses(&mut world, &mut schedule), 1);
    let before = world.get::<PosedMesh>(mesh).unwrap().clone();

    // the root's move carries joints and mesh alike: posed anew, to the same place
    world.get_mut::<Transform>(spawned.root).unwrap().translation = Vec3::new(1e4, 0.0, 0.0);
    assert_eq!(poses(&mut world, &mut schedule), 1);
    for (after, before) in world
        .get::<PosedMesh>(mesh)
        .unwrap()
        .positions
        .iter()
        .zip(&before.positions)
    {
        assert!(after.distance(*before) < 2e-3, "{after} {before}");
    }
    let before = world.get::<PosedMesh>(mesh).unwrap().clone();
    world.get_mut::<Transform>(spawned.root).unwrap().scale = Vec3::ZERO;
    assert_eq!(poses(&mut world, &mut schedule), 0);
    assert_eq!(*world.get::<PosedMesh>(mesh).unwrap(), before);
    world.get_mut::<Transform>(spawned.root).unwrap().scale = Vec3::ONE;
    assert_eq!(poses(&mut world, &mut schedule), 1);
    world.despawn(joint);
    world.get_mut::<MorphWeights>(mesh).unwrap().0[0] = 0.0;
    assert_eq!(poses(&mut world, &mut schedule), 0);
    world.entity_mut(mesh).remove::<antumbra::scene::Skin>();
    assert_eq!(poses(&mut world, &mut schedule), 1);
    assert_eq!(
        world.get::<PosedMesh>(mesh).unwrap().positions,
        gltf.meshes[0].data.positions
    );
}

#[test]
fn equal_vertices_pose_to_equal_bits_whatever_the_order_of_their_joints() {
    let mut builder = animated();
    // the same three influences in three orders
    let joints = builder.accessor(&[0, 1, 1, 0, 1, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0], U8, "VEC4", 4);
    let weights = [
        [0.1, 0.3, 0.6, 0.0],
        [0.6, 0.1, 0.3, 0.0],
        [0.3, 0.6, 0.1, 0.0],
        [0.1, 0.3, 0.6, 0.0],
    ];
    let weights = builder.floats(&weights);
    let positions = builder.floats(&[[0.3, 0.7, 0.9]; 4]);
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["POSITION"] = json!(positions);
    let gltf = builder.load();
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let hip = spawned.nodes.nodes[1].unwrap();
    world.get_mut::<Transform>(hip).unwrap().rotation = Quat::from_rotation_z(0.7);
    apply_animation(&mut world, &spawned, &gltf.clips[0], 0.37);
    schedule.run(&mut world);
    let posed = &world.get::<PosedMesh>(spawned.meshes[0]).unwrap().positions;
    assert!(
        posed
            .iter()
            .all(|p| p.to_array().map(f32::to_bits) == posed[0].to_array().map(f32::to_bits))
    );
    assert_ne!(posed[0], Vec3::new(0.3, 0.7, 0.9));
}

#[test]
fn more_than_four_joints_keep_the_strongest() {
    let mut builder = animated();
    let weights = builder.floats(&[[0.5, 0.5, 0.0, 0.0]; 4]);
    let joints = builder.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"].clone();
    let strong = builder.floats(&[[0.75, 0.75, 0.75, 0.75]; 4]);
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["JOINTS_1"] = joints;
    attributes["WEIGHTS_1"] = json!(strong);
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::VertexData), 4);
    assert_eq!(gltf.meshes[0].data.joint_weights[0], Vec4::splat(0.25));
    assert_eq!(gltf.meshes[0].data.joints[0], [0, 0, 0, 1]);
}

/// The translation of node 1 at a time, with the keys 0 s and 2 s.
fn translation_at(interpolation: &str, values: &[[f32; 3]], seconds: f32) -> Vec3 {
    let mut builder = animated();
    let output = builder.floats(values);
    builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    builder.json["animations"][0]["samplers"][0]["interpolation"] = json!(interpolation);
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    apply_animation(&mut world, &spawned, &gltf.clips[0], seconds);
    world
        .get::<Transform>(spawned.nodes.nodes[2].unwrap())
        .unwrap()
        .translation
}

#[test]
fn step_linear_and_cubic_spline_interpolate() {
    let ends = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
    assert_near(translation_at("STEP", &ends, 1.9), Vec3::ZERO);
    assert_near(translation_at("STEP", &ends, 2.0), Vec3::X * 4.0);
    assert_near(translation_at("LINEAR", &ends, 0.5), Vec3::X);
    assert_near(translation_at("LINEAR", &ends, -1.0), Vec3::ZERO);
    // at u = 1/2 the Hermite weights are 1/2, 1/8, 1/2, −1/8; tangents count times the 2 s between the keys
    let spline = [
        [9.0, 9.0, 9.0],
        [0.0; 3],
        [0.0, 8.0, 0.0],
        [0.0, 0.0, 8.0],
        [4.0, 0.0, 0.0],
        [9.0, 9.0, 9.0],
    ];
    assert_near(
        translation_at("CUBICSPLINE", &spline, 1.0),
        Vec3::new(2.0, 2.0, -2.0),
    );
    assert_near(translation_at("CUBICSPLINE", &spline, 0.0), Vec3::ZERO);
    assert_near(translation_at("CUBICSPLINE", &spline, 5.0), Vec3::X * 4.0);
}

#[test]
fn rotations_take_the_shorter_arc() {
    let mut builder = animated();
    let turn = Quat::from_rotation_z(1.0);
    let output = builder.floats(&[[0.0, 0.0, 0.0, 1.0], (-turn).to_array()]);
    builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    builder.json["animations"][0]["channels"][0]["target"]["path"] = json!("rotation");
    let gltf = builder.load();
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    apply_animation(&mut world, &spawned, &gltf.clips[0], 0.5);
    let rotation = world
        .get::<Transform>(spawned.nodes.nodes[2].unwrap())
        .unwrap()
        .rotation;
    assert!(
        rotation.dot(Quat::from_rotation_z(0.25)).abs() > 1.0 - 1e-6,
        "{rotation}"
    );
}

#[test]
fn matrices_become_transforms_even_when_they_flatten() {
    let mut builder = quad();
    let expected = Transform {
        translation: Vec3::new(1.0, 2.0, 3.0),
        rotation: Quat::from_rotation_y(0.5),
        scale: Vec3::new(-2.0, 3.0, 4.0),
    };
    builder.json["nodes"][0]["matrix"] = json!(glam::Mat4::from(expected.compute_affine()).to_cols_array());
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let transform = gltf.nodes[0].transform;
    assert_near(
        transform.transform_point(Vec3::ONE),
        expected.transform_point(Vec3::ONE),
    );

    let flat = Transform {
        scale: Vec3::new(2.0, 0.0, 4.0),
        ..expected
    };
    builder.json["nodes"][0]["matrix"] = json!(glam::Mat4::from(flat.compute_affine()).to_cols_array());
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::NodeTransform), 1);
    assert_near(
        gltf.nodes[0].transform.transform_point(Vec3::ONE),
        flat.transform_point(Vec3::ONE),
    );
}

#[test]
fn a_mesh_not_posed_yet_has_the_bounds_of_its_rest_pose() {
    let gltf = animated().load();
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let mut schedule = Schedule::default();
    schedule.add_systems(antumbra::scene::bounds::update_local_bounds);
    schedule.run(&mut world);
    assert_eq!(
        world.get::<LocalBounds>(spawned.meshes[0]).unwrap().0.max,
        Vec3::new(1.0, 1.0, 0.0)
    );
}

#[test]
fn every_model_loads_spawns_and_poses() {
    let Ok(folder) = std::env::var("ANTUMBRA_MODELS") else {
        eprintln!("skipped: ANTUMBRA_MODELS names no folder of models");
        return;
    };
    let folder = std::path::Path::new(&folder);
    let manifest = std::fs::read_to_string(folder.join("MANIFEST.json")).unwrap();
    let manifest: Vec<Value> = serde_json::from_str(&manifest).unwrap();
    let mut model_count = 0;
    for entry in &manifest {
        let name = entry["file"].as_str().unwrap();
        if !name.ends_with(".glb") && !name.ends_with(".gltf") {
            continue;
        }
        let says = |key: &str| entry[key].as_u64().map(|count| count as usize);
        let gltf = load_gltf(folder.join(name)).unwrap_or_else(|error| panic!("{error}"));
        let skips: Vec<_> = gltf
            .report
            .skips
            .iter()
            .filter(|skip| skip.kind != SkipKind::Extension)
            .collect();
        if !skips.is_empty() {
            eprintln!("{name}\n{}", gltf.report);
        }
        let morph_targets: usize = gltf.meshes.iter().map(|mesh| mesh.data.morph_targets.len()).sum();
        for (key, count) in [
            ("triangles", gltf.triangle_count()),
            ("meshes", gltf.meshes.len()),
            ("nodes", gltf.nodes.len()),
            ("materials", gltf.materials.len()),
            ("skins", gltf.skins.len()),
            ("joints", gltf.skins.iter().map(|skin| skin.joints.len()).sum()),
            ("animations", gltf.clips.len()),
            ("morph_targets", morph_targets),
        ] {
            if let Some(expected) = says(key) {
                assert_eq!(count, expected, "{name}: {key}");
            }
        }
        let (mut world, mut schedule) = frame();
        let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
        let times = [0.0, 0.3]
            .into_iter()
            .chain(gltf.clips.iter().map(|clip| clip.duration()));
        let clips = gltf.clips.iter().cycle();
        for (clip, seconds) in clips.zip(times) {
            apply_animation(&mut world, &spawned, clip, seconds);
            schedule.run(&mut world);
        }
        schedule.run(&mut world);
        if let Some(expected) = says("instances") {
            assert_eq!(spawned.meshes.len(), expected, "{name}: instances");
        }
        for &mesh in &spawned.meshes {
            let data = &world.get::<SceneMesh>(mesh).unwrap().0;
            assert_eq!(
                world.get::<SceneMaterials>(mesh).unwrap().0.len(),
                data.submeshes.len()
            );
            assert_eq!(
                world.get::<WorldBounds>(mesh).unwrap().0.is_empty(),
                data.indices.is_empty(),
                "{name}: {}",
                data.name
            );
            if let Some(posed) = world.get::<PosedMesh>(mesh) {
                assert_eq!(posed.positions.len(), data.positions.len());
                let finite = posed
                    .positions
                    .iter()
                    .chain(&posed.normals)
                    .all(|vertex| vertex.is_finite());
                assert!(finite, "{name}: {}", data.name);
            }
        }
        if let Some(expected) = says("lights") {
            assert_eq!(
                gltf.lights.len().max(spawned.lights.len()),
                expected,
                "{name}: lights"
            );
        }
        // 0 where the tool that counted draws nothing of a mesh without indices
        if let Some(expected) = says("scene_triangles").filter(|&count| count > 0) {
            let spawned_triangles = |&mesh: &Entity| world.get::<SceneMesh>(mesh).unwrap().0.triangle_count();
            assert_eq!(
                spawned.meshes.iter().map(spawned_triangles).sum::<usize>(),
                expected,
                "{name}"
            );
        }
        model_count += 1;
    }
    assert!(model_count > 0, "no model in {}", folder.display());
}

//! Compressed meshes and buffer views.

use serde_json::json;

use crate::gltf_builder::*;

/// A bent sheet of `side` × `side` vertices with normals and texture coordinates.
struct Sheet {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    faces: Vec<[u32; 3]>,
}

fn sheet(side: u32) -> Sheet {
    let at = |x: u32, y: u32| [x as f32 / (side - 1) as f32, y as f32 / (side - 1) as f32];
    let grid = (0..side * side).map(|i| at(i % side, i / side));
    let mut faces = Vec::new();
    for (x, y) in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y))) {
        let corner = y * side + x;
        faces.extend([
            [corner, corner + 1, corner + side],
            [corner + side, corner + 1, corner + side + 1],
        ]);
    }
    Sheet {
        positions: grid.clone().map(|[x, y]| [x, y, x * x * 0.5]).collect(),
        normals: grid
            .clone()
            .map(|[x, _]| glam::Vec3::new(-x, 0.0, 1.0).normalize().to_array())
            .collect(),
        uv: grid.collect(),
        faces,
    }
}

/// The centres of all triangles of a mesh, in a fixed order. Compression renumbers vertices and triangles.
fn centers(positions: &[glam::Vec3], indices: &[u32]) -> Vec<[i64; 3]> {
    let mut centers: Vec<[i64; 3]> = indices
        .as_chunks::<3>()
        .0
        .iter()
        .map(|corners| {
            let sum: glam::Vec3 = corners.iter().map(|&corner| positions[corner as usize]).sum();
            (sum * 300.0).round().as_i64vec3().to_array()
        })
        .collect();
    centers.sort_unstable();
    centers
}

#[cfg(feature = "gltf-draco")]
mod draco {
    use antumbra::scene::gltf_import::load_gltf_slice;
    use draco_core::{
        DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
        PointIndex,
    };

    use super::*;

    fn attribute<const N: usize>(kind: GeometryAttributeType, values: &[[f32; N]]) -> PointAttribute {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, N as u8, DataType::Float32, false, values.len());
        for (i, value) in values.iter().enumerate() {
            let bytes: Vec<u8> = value.iter().flat_map(|x| x.to_le_bytes()).collect();
            attribute.buffer_mut().write(i * 4 * N, &bytes);
        }
        attribute
    }

    fn encode(sheet: &Sheet, speed: i32) -> Vec<u8> {
        let mut mesh = Mesh::new();
        mesh.add_attribute(attribute(GeometryAttributeType::Position, &sheet.positions));
        mesh.add_attribute(attribute(GeometryAttributeType::Normal, &sheet.normals));
        mesh.add_attribute(attribute(GeometryAttributeType::TexCoord, &sheet.uv));
        for face in &sheet.faces {
            mesh.add_face(face.map(PointIndex));
        }
        let mut encoder = MeshEncoder::new();
        encoder.set_mesh(mesh);
        let mut options = EncoderOptions::new();
        options.set_compression_level(10 - speed);
        let mut out = EncoderBuffer::new();
        encoder.encode(&options, &mut out).unwrap();
        out.data().to_vec()
    }

    /// A file whose only primitive is compressed, as exporters write it: accessors without data.
    fn file(stream: &[u8], sheet: &Sheet) -> Builder {
        let mut builder = Builder::new();
        let view = builder.view(stream);
        let accessor = |builder: &mut Builder, kind: &str, component: u32, count: usize| {
            builder.push(
                "accessors",
                json!({"componentType": component, "type": kind, "count": count}),
            )
        };
        let vertices = sheet.positions.len();
        let positions = accessor(&mut builder, "VEC3", F32, vertices);
        let normals = accessor(&mut builder, "VEC3", F32, vertices);
        let uv = accessor(&mut builder, "VEC2", F32, vertices);
        let indices = accessor(&mut builder, "SCALAR", U16, sheet.faces.len() * 3);
        let extension =
            json!({"bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}});
        builder.mesh(json!({
            "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uv},
            "indices": indices,
            "extensions": {"KHR_draco_mesh_compression": extension},
        }));
        builder.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
        builder.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        builder
    }

    #[test]
    fn compressed_primitives_are_read() {
        let sheet = sheet(9);
        for speed in [0, 5, 10] {
            let mut builder = file(&encode(&sheet, speed), &sheet);
            let gltf = builder.load();
            assert!(gltf.report.is_empty(), "{}", gltf.report);
            let data = &gltf.meshes[0].data;
            assert_eq!((data.triangle_count(), data.positions.len()), (128, 81));
            let wanted: Vec<u32> = sheet.faces.iter().flatten().copied().collect();
            let positions: Vec<glam::Vec3> = sheet.positions.iter().map(|&p| p.into()).collect();
            let near = |a: &[i64; 3], b: &[i64; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
            let (got, wanted) = (
                centers(&data.positions, &data.indices),
                centers(&positions, &wanted),
            );
            let unmatched = got
                .iter()
                .filter(|got| !wanted.iter().any(|wanted| near(got, wanted)))
                .count();
            assert_eq!(unmatched, 0, "speed {speed}");
            // Attributes belong to their vertices.
            for (vertex, position) in data.positions.iter().enumerate() {
                let normal = glam::Vec3::new(-position.x, 0.0, 1.0).normalize();
                assert!(
                    data.normals[vertex].distance(normal) < 0.02,
                    "speed {speed}, vertex {vertex}"
                );
                assert!(
                    data.uv0[vertex].distance(position.truncate()) < 0.01,
                    "speed {speed}, vertex {vertex}"
                );
            }
            // Triangles without an accessor of indices, and counts that are out of date.
            let primitive = builder.json["meshes"][0]["primitives"][0]
                .as_object_mut()
                .unwrap();
            primitive.remove("indices");
            builder.json["accessors"][0]["count"] = json!(3);
            assert_eq!(builder.load().meshes[0].data.positions, data.positions);
        }
    }

    #[test]
    fn streams_without_a_meaning_are_errors_that_name_the_primitive() {
        let sheet = sheet(4);
        let stream = encode(&sheet, 5);
        let names = |builder: &Builder, part: &str| {
            let error = builder.error();
            for part in ["mesh 0 primitive 0", "KHR_draco_mesh_compression", part] {
                assert!(error.contains(part), "{error}");
            }
        };
        names(&file(&stream[..stream.len() / 2], &sheet), "cannot be decoded");
        names(&file(b"no mesh at all", &sheet), "cannot be decoded");
        let edited = |path: &str, value: serde_json::Value| {
            let mut builder = file(&stream, &sheet);
            builder.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"][path] =
                value;
            builder
        };
        names(
            &edited("attributes", json!({"POSITION": 9})),
            "has no attribute 9 for POSITION",
        );
        names(&edited("bufferView", json!("first")), "bufferView");
        let missing = edited("bufferView", json!(9)).error();
        assert!(missing.contains("buffer view 9"), "{missing}");
    }

    /// A stream that another primitive decodes has given the shared accessors its own order of vertices.
    #[test]
    fn a_broken_stream_beside_a_good_one_of_the_same_accessors_is_an_error() {
        let sheet = sheet(4);
        let mut builder = file(&encode(&sheet, 5), &sheet);
        builder.json.as_object_mut().unwrap().remove("extensionsRequired");
        let view = builder.view(&[0; 1024]);
        for accessor in 0..4 {
            builder.json["accessors"][accessor]["bufferView"] = json!(view);
        }
        assert!(builder.load().report.is_empty());
        let mut second = builder.json["meshes"][0]["primitives"][0].clone();
        second["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = json!(99);
        builder.json["meshes"][0]["primitives"]
            .as_array_mut()
            .unwrap()
            .push(second);
        let error = builder.error();
        assert!(error.contains("mesh 0 primitive 1: buffer view 99"), "{error}");
    }

    #[test]
    fn broken_streams_never_panic() {
        let sheet = sheet(5);
        let (mut state, mut loaded) = (1u32, 0);
        let mut random = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        for speed in [0, 5, 10] {
            let stream = encode(&sheet, speed);
            for _ in 0..400 {
                let mut broken = stream.clone();
                for _ in 0..1 + random() % 4 {
                    let at = random() as usize % broken.len();
                    broken[at] = random() as u8;
                }
                let bytes = file(&broken, &sheet).glb();
                loaded += usize::from(load_gltf_slice(&bytes, None, "broken.glb").is_ok());
            }
        }
        assert!(loaded > 20, "{loaded} of 1200 load: nothing is tested");
    }
}

/// Elements of four bytes from 16-bit numbers, and so on: the bytes of numbers.
#[cfg(feature = "gltf-meshopt")]
fn bytes_of<const N: usize>(elements: &[[f32; N]]) -> Vec<u8> {
    elements.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

#[cfg(feature = "gltf-meshopt")]
mod meshopt_views {
    use super::*;

    /// Adds a compressed view whose own range is in a buffer without bytes.
    fn view(
        builder: &mut Builder,
        name: &str,
        stream: &[u8],
        extension: serde_json::Value,
        length: usize,
    ) -> usize {
        let own = builder.view(stream);
        let offset = builder.json["bufferViews"][own]["byteOffset"].clone();
        let mut object = json!({"buffer": 0, "byteOffset": offset, "byteLength": stream.len()});
        for (key, value) in extension.as_object().unwrap() {
            object[key] = value.clone();
        }
        builder.push(
            "bufferViews",
            json!({"buffer": 1, "byteLength": length, "extensions": {name: object}}),
        )
    }

    fn file(name: &str) -> (Builder, Sheet) {
        let sheet = sheet(9);
        let mut builder = Builder::new();
        let count = sheet.positions.len();
        let attributes = |filter: &str, stride: usize| json!({"count": count, "byteStride": stride, "mode": "ATTRIBUTES", "filter": filter});

        let stream = meshopt::encode_vertex_buffer_level(
            &sheet.positions,
            2,
            Some(i32::from(name.starts_with("KHR"))),
        )
        .unwrap();
        let positions = view(&mut builder, name, &stream, attributes("NONE", 12), count * 12);
        let normals: Vec<[f32; 4]> = sheet.normals.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        let packed = meshopt::encode_filter_oct::<i16>(&normals, 16);
        let stream = meshopt::encode_vertex_buffer_level(&packed, 2, Some(0)).unwrap();
        let normals = view(
            &mut builder,
            name,
            &stream,
            attributes("OCTAHEDRAL", 8),
            count * 8,
        );
        let packed = meshopt::encode_filter_exp(&sheet.uv, 15, meshopt::EncodeExpMode::SharedVector);
        let stream = meshopt::encode_vertex_buffer_level(&packed, 2, Some(0)).unwrap();
        let uv = view(
            &mut builder,
            name,
            &stream,
            attributes("EXPONENTIAL", 8),
            count * 8,
        );
        let indices: Vec<u32> = sheet.faces.iter().flatten().copied().collect();
        let stream = meshopt::encode_index_buffer(&indices, count).unwrap();
        let triangles = json!({"count": indices.len(), "byteStride": 2, "mode": "TRIANGLES"});
        let indices_view = view(&mut builder, name, &stream, triangles, indices.len() * 2);

        let accessor = |builder: &mut Builder, view: usize, kind: &str, component: u32, count: usize| {
            builder.push(
                "accessors",
                json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
            )
        };
        let positions = accessor(&mut builder, positions, "VEC3", F32, count);
        let normals_accessor = accessor(&mut builder, normals, "VEC3", 5122, count);
        builder.json["accessors"][normals_accessor]["normalized"] = json!(true);
        builder.json["bufferViews"][normals]["byteStride"] = json!(8);
        let uv = accessor(&mut builder, uv, "VEC2", F32, count);
        let indices = accessor(&mut builder, indices_view, "SCALAR", U16, indices.len());
        builder.mesh(json!({
            "attributes": {"POSITION": positions, "NORMAL": normals_accessor, "TEXCOORD_0": uv}, "indices": indices,
        }));
        builder.json["extensionsUsed"] = json!([name, "KHR_mesh_quantization"]);
        builder.json["extensionsRequired"] = json!([name]);
        (builder, sheet)
    }

    /// The file with its buffers: that of the streams, and a placeholder for what they become.
    fn with_buffers(mut builder: Builder) -> Builder {
        builder.json["buffers"] = json!([
            {"byteLength": builder.binary.len()},
            {"byteLength": 4096, "extensions": {"EXT_meshopt_compression": {"fallback": true}}},
        ]);
        builder
    }

    #[test]
    fn compressed_views_are_read() {
        for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
            let (builder, sheet) = file(name);
            let gltf = with_buffers(builder).load();
            assert!(gltf.report.is_empty(), "{}", gltf.report);
            let data = &gltf.meshes[0].data;
            let positions: Vec<[f32; 3]> = data.positions.iter().map(|p| p.to_array()).collect();
            assert_eq!(bytes_of(&positions), bytes_of(&sheet.positions), "{name}");
            for (vertex, normal) in data.normals.iter().enumerate() {
                assert!(normal.distance(sheet.normals[vertex].into()) < 1e-3, "{name}");
                assert!(
                    data.uv0[vertex].distance(sheet.uv[vertex].into()) < 1e-3,
                    "{name}"
                );
            }
            let wanted: Vec<u32> = sheet.faces.iter().flatten().copied().collect();
            assert_eq!(
                centers(&data.positions, &data.indices),
                centers(&data.positions, &wanted)
            );
        }
    }

    #[test]
    fn views_without_a_meaning_are_errors_that_name_them() {
        let name = "EXT_meshopt_compression";
        for (key, value, part) in [
            ("mode", json!("POINTS"), "mode \"POINTS\""),
            ("filter", json!("BLUR"), "filter \"BLUR\""),
            ("byteStride", json!(13), "13 bytes"),
            ("count", json!(5), "broken"),
            ("count", json!("many"), "count is not"),
            ("byteLength", json!(20), "broken"),
            ("byteLength", json!(1 << 20), "runs past the end"),
            ("count", json!(1u64 << 40), "limit"),
        ] {
            let mut builder = with_buffers(file(name).0);
            builder.json["bufferViews"][1]["extensions"][name][key] = value;
            let error = builder.error();
            assert!(
                error.contains("buffer view 1") && error.contains(part),
                "{key}: {error}"
            );
        }
    }
}

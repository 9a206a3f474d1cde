//! What Rust writes into GPU buffers is what WGSL reads: structs by name, offset and size, and shared constants by value.

use std::collections::HashMap;
use std::mem::offset_of;

use antumbra::conventions;
use antumbra::insides::constants as mirrored;
use antumbra::insides::{
    COMMON, MapShape, PASSES, gpu_types, occlusion_textures, records, silhouette_layers, smoothies,
};
use antumbra::techniques::maps::{MapFilter, MapFormat, MapSurface};
use antumbra::techniques::{SliceCombination, SliceFilter};
use wgpu::naga;

use crate::harness::shaders;

/// A `#[repr(C)]` struct as Rust lays it out.
#[derive(Clone, Debug)]
struct Mirror {
    name: &'static str,
    size: usize,
    /// Name and offset.
    fields: Vec<(&'static str, usize)>,
    /// A pass that uses the WGSL struct.
    pass: &'static str,
    /// It is an element of a storage array, whose stride counts too.
    in_array: bool,
}

/// Describes a struct; a field that is left out does not compile.
macro_rules! mirror {
    ($name:ident { $($field:ident),* $(,)? } in $pass:literal, array: $in_array:literal) => {
        mirror!(gpu_types, $name { $($field),* } in $pass, array: $in_array)
    };
    ($module:ident, $name:ident { $($field:ident),* $(,)? } in $pass:literal, array: $in_array:literal) => {{
        let $module::$name { $($field: _),* } = $module::$name::default();
        Mirror {
            name: stringify!($name),
            size: size_of::<$module::$name>(),
            fields: vec![$((stringify!($field), offset_of!($module::$name, $field))),*],
            pass: $pass,
            in_array: $in_array,
        }
    }};
}

fn mirrors() -> Vec<Mirror> {
    vec![
        mirror!(View { ambient, relative_from_ndc, size, origin, eye } in "passes/ambient.wgsl", array: false),
        mirror!(Object {
            clip_from_local,
            relative_from_local_x,
            relative_from_local_y,
            relative_from_local_z,
            handedness,
        } in "passes/ambient.wgsl", array: true),
        mirror!(HostDepth { numerator, denominator, rounding } in "passes/host_depth.wgsl", array: false),
        mirror!(LightShape {
            light_from_relative_x,
            light_from_relative_y,
            light_from_relative_z,
            semi_axes,
            distance,
            form,
        } in "passes/light_model.wgsl", array: false),
        mirror!(LightModel { shape, barn_map } in "passes/light_model.wgsl", array: false),
        mirror!(Light {
            point_relative,
            emission,
            axis,
            cone,
            half_right,
            half_up,
            weights,
            shadow_emission,
            shape,
        } in "passes/light_accumulate.wgsl", array: false),
        mirror!(LightTexture {
            light_from_relative_x,
            light_from_relative_y,
            light_from_relative_z,
            uv_matrix,
            uv_origin,
            density,
            unused,
            light_from_cube_x,
            light_from_cube_y,
            light_from_cube_z,
            profile_axes_pole,
            profile_axes_zero,
            profile_axes_quarter,
            profile_steps,
            profile_last,
        } in "passes/light_texture.wgsl", array: false),
        mirror!(Slot { uv_matrix, uv_offset, uv_set, present } in "passes/ambient.wgsl", array: false),
        mirror!(Material {
            base_color,
            emissive,
            alpha_cutoff,
            metallic,
            roughness,
            normal_scale,
            occlusion_strength,
            unlit,
            opaque,
            clearcoat,
            clearcoat_roughness,
            base_color_slot,
            metallic_roughness_slot,
            normal_slot,
            occlusion_slot,
            emissive_slot,
            clearcoat_slot,
            clearcoat_roughness_slot,
        } in "passes/ambient.wgsl", array: false),
        mirror!(MapFace { row_x, row_y, row_z, projection, clip_from_relative, relative_from_clip } in "techniques/maps/resolve.wgsl", array: true),
        mirror!(MapLight { faces, size, bias, limits, ending } in "techniques/maps/resolve.wgsl", array: false),
        mirror!(Window { spans, inverse_width, last_texel, shining, unused }
            in "techniques/occlusion_interval/resolve.wgsl", array: false),
        mirror!(smoothies, SmoothieEdge { start, width_start, end, width_end, next, kind }
            in "techniques/smoothie/edge.wgsl", array: true),
        mirror!(smoothies, SmoothieFace { row_x, row_y, row_z, projection, limits }
            in "techniques/smoothie/edge.wgsl", array: false),
        mirror!(occlusion_textures, OcclusionFace { row_x, row_y, row_z, projection, depth, bottoms }
            in "techniques/occlusion_texture/caster.wgsl", array: false),
        mirror!(occlusion_textures, OcclusionLight { faces, kernel, point_relative, half_right, half_up, limits }
            in "techniques/occlusion_texture/resolve.wgsl", array: false),
        mirror!(Grounds { planes, along, across, middle } in "techniques/perspective_map/blur.wgsl", array: false),
        mirror!(MapCaster { clip_from_centered, center_local } in "techniques/maps/caster.wgsl", array: true),
        mirror!(Caster {
            light_local,
            object,
            extrusion,
            corners_per_edge,
            first_edge,
            single_count,
            padding_a,
            padding_b,
            padding_c,
        } in "techniques/stencil_volume/volume.wgsl", array: true),
        mirror!(records, WedgeCaster { light_local, end_local, end_light, object, extrusion, padding }
            in "techniques/penumbra_wedge/wedge.wgsl", array: true),
        mirror!(records, Wedge {
            start_local,
            caster,
            end_local,
            flags,
            start_light,
            padding_a,
            end_light,
            padding_b,
            rims,
            sides,
        } in "techniques/penumbra_wedge/wedge.wgsl", array: true),
        mirror!(records, WedgeLight {
            clip_from_light,
            light_from_relative_x,
            light_from_relative_y,
            light_from_relative_z,
            half_size,
            table,
            reach,
            place,
            whole,
        } in "techniques/penumbra_wedge/wedge.wgsl", array: false),
    ]
}

/// The first difference between a mirror and its struct in a composed module.
fn difference(mirror: &Mirror, module: &naga::Module) -> Option<String> {
    let name = mirror.name;
    let imported = format!("{name}X_naga_oil_mod_"); // what the composer makes of an imported name
    let found = module.types.iter().find_map(|(handle, ty)| {
        let known = ty.name.as_deref()?;
        let naga::TypeInner::Struct { members, span } = &ty.inner else {
            return None;
        };
        (known == name || known.starts_with(&imported)).then_some((handle, members, *span as usize))
    });
    let Some((handle, members, span)) = found else {
        return Some(format!("{name}: {} has no such struct", mirror.pass));
    };
    if members.len() != mirror.fields.len() {
        return Some(format!(
            "{name}: {} members, Rust has {}",
            members.len(),
            mirror.fields.len()
        ));
    }
    for (member, (field, offset)) in members.iter().zip(&mirror.fields) {
        let known = member.name.as_deref().unwrap_or_default();
        if known != *field || member.offset as usize != *offset {
            return Some(format!(
                "{name}: member {known} at {}, Rust has {field} at {offset}",
                member.offset
            ));
        }
    }
    if span != mirror.size {
        return Some(format!("{name}: {span} bytes, Rust has {}", mirror.size));
    }
    if mirror.in_array {
        let stride = module.types.iter().find_map(|(_, ty)| match ty.inner {
            naga::TypeInner::Array { base, stride, .. } if base == handle => Some(stride as usize),
            _ => None,
        });
        if stride != Some(mirror.size) {
            return Some(format!(
                "{name}: array stride {stride:?}, Rust has {}",
                mirror.size
            ));
        }
    }
    None
}

fn compose(path: &str) -> naga::Module {
    let (_, source) = PASSES
        .iter()
        .find(|(name, _)| *name == path)
        .unwrap_or_else(|| panic!("{path} is not listed"));
    shaders().compose(path, source).expect("the pass composes")
}

#[test]
fn offsets_sizes_and_names_match_wgsl() {
    for mirror in mirrors() {
        let difference = difference(&mirror, &compose(mirror.pass));
        assert_eq!(difference, None);
    }
}

#[test]
fn comparison_finds_a_moved_renamed_missing_and_grown_field() {
    let caster = |mirror: &Mirror| mirror.name == "Caster";
    let good = mirrors().into_iter().find(caster).expect("it is compared");
    let module = compose(good.pass);
    assert_eq!(difference(&good, &module), None);
    let spoilt = |spoil: fn(&mut Mirror)| {
        let mut bad = good.clone();
        spoil(&mut bad);
        difference(&bad, &module).expect("the difference is found")
    };
    assert!(spoilt(|m| m.fields[2].1 += 4).contains("at 24"));
    assert!(spoilt(|m| m.fields[2].0 = "thickness").contains("thickness"));
    assert!(spoilt(|m| m.fields.truncate(1)).contains("members"));
    assert!(spoilt(|m| m.size += 16).contains("bytes"));
    assert!(spoilt(|m| m.name = "Blocker").contains("no such struct"));
    let view = compose("passes/ambient.wgsl");
    let mut not_an_array = mirrors().swap_remove(0);
    not_an_array.in_array = true;
    assert!(
        difference(&not_an_array, &view)
            .expect("found")
            .contains("stride")
    );
}

/// Every struct that a shader says is mirrored is one that this test compares, and the other way round.
#[test]
fn every_mirror_is_compared() {
    let known: Vec<&str> = mirrors().iter().map(|mirror| mirror.name).collect();
    let mut named = Vec::new();
    for (path, source) in COMMON.iter().chain(PASSES.iter()) {
        for line in source.lines() {
            let Some((_, path_of_mirror)) = line.split_once("mirror: ") else {
                continue;
            };
            if line.starts_with("const ") {
                continue; // see `every_mirrored_constant_is_compared`
            }
            let (_, name) = path_of_mirror.trim_end().rsplit_once("::").expect("a path");
            assert!(known.contains(&name), "{path}: {name} is not compared");
            assert!(
                line.contains(&format!("struct {name}")),
                "{path}: {line}: says {name}"
            );
            named.push(name);
        }
    }
    for name in known {
        assert!(named.contains(&name), "{name} is in no shader");
    }
}

/// A constant of a shader, and what Rust has for it.
struct Constant {
    /// The shader that declares it.
    file: &'static str,
    name: &'static str,
    value: f64,
}

fn mirrored_constants() -> Vec<Constant> {
    let mut all = Vec::new();
    let mut of = |file, rows: &[(&'static str, f64)]| {
        all.extend(rows.iter().map(|&(name, value)| Constant { file, name, value }));
    };
    let filter = |filter| f64::from(mirrored::filter_constant(filter));
    let jittered = |adaptive| {
        filter(MapFilter::Jittered {
            softness: 0.0,
            adaptive,
        })
    };
    of(
        "techniques/maps/resolve.wgsl",
        &[
            ("BILINEAR", filter(MapFilter::Bilinear)),
            ("BRUTE", filter(MapFilter::Brute4x4)),
            ("DITHERED", filter(MapFilter::Dithered4)),
            ("JITTERED", jittered(false)),
            ("SOFT", filter(MapFilter::Soft4 { softness: 0.0 })),
            ("ADAPTIVE", jittered(true)),
            ("TILE", f64::from(mirrored::TILE)),
            ("RIM_TEXELS", f64::from(mirrored::RIM / 2)),
            ("JITTER_TEXELS", f64::from(mirrored::DEPTH)),
        ],
    );
    of(
        "common/map_site.wgsl",
        &[
            ("SPOT", f64::from(MapShape::Spot as u32)),
            ("CUBE", f64::from(MapShape::Cube as u32)),
            ("CASCADES", f64::from(MapShape::Cascades as u32)),
            ("MATRICES", f64::from(MapShape::Matrices as u32)),
        ],
    );
    of(
        "common/map.wgsl",
        &[
            ("FORMAT_DEPTH", f64::from(MapFormat::Depth as u32)),
            ("FORMAT_FLOAT", f64::from(MapFormat::R32Float as u32)),
            ("FORMAT_TWO_BYTES", f64::from(MapFormat::Rgba8TwoBytes as u32)),
            ("FORMAT_FOUR_BYTES", f64::from(MapFormat::Rgba8FourBytes as u32)),
        ],
    );
    of(
        "techniques/maps/convert.wgsl",
        &[
            ("NEAREST", f64::from(MapSurface::Nearest as u32)),
            ("MIDPOINT", f64::from(MapSurface::Midpoint as u32)),
        ],
    );
    of(
        "common/receiver.wgsl",
        &[("NO_PLANE", f64::from(mirrored::NO_PLANE))],
    );
    of(
        "common/wedge_light.wgsl",
        &[
            ("ANGLE_STEPS", mirrored::ANGLE_STEPS as f64),
            ("SECTOR_STEPS", mirrored::SECTOR_STEPS as f64),
            ("BORDER_STEPS", mirrored::BORDER_STEPS as f64),
            ("NODES", mirrored::NODES as f64),
        ],
    );
    of(
        "techniques/smoothie/edge.wgsl",
        &[
            ("SECTOR", f64::from(smoothies::SECTOR)),
            ("DISC", f64::from(smoothies::DISC)),
            ("DISC_ALONE", f64::from(smoothies::DISC_ALONE)),
            ("CORNER_TRIANGLES", f64::from(smoothies::CORNER_TRIANGLES)),
            ("OVERLAP", f64::from(smoothies::OVERLAP)),
            ("HALF_TURN", f64::from(smoothies::HALF_TURN)),
            ("INSIDE_TEXELS", f64::from(smoothies::INSIDE_TEXELS)),
        ],
    );
    of(
        "techniques/smoothie/resolve.wgsl",
        &[("SCALE_OF_NEAR", f64::from(smoothies::SCALE_OF_NEAR))],
    );
    of(
        "techniques/perspective_map/blur.wgsl",
        &[("REACH", mirrored::BLUR_REACH)],
    );
    of(
        "techniques/perspective_map/ground.wgsl",
        &[("NO_GROUND", mirrored::MOST_GROUNDS as f64)],
    );
    of(
        "common/smoothie.wgsl",
        &[
            ("LEAST", f64::from(smoothies::LEAST)),
            ("FARTHEST", f64::from(smoothies::FARTHEST)),
        ],
    );
    of(
        "techniques/occlusion_texture/kernel.wgsl",
        &[
            ("PRODUCT", f64::from(SliceCombination::Product as u32)),
            ("MAXIMUM", f64::from(SliceCombination::Maximum as u32)),
            ("SUM", f64::from(SliceCombination::Sum as u32)),
            ("OVERLAP", f64::from(SliceCombination::Overlap as u32)),
            ("TOUCHED", f64::from(occlusion_textures::TOUCHED)),
            ("WIDER", f64::from(occlusion_textures::WIDER)),
            ("BEGINS", f64::from(occlusion_textures::BEGINS)),
            ("WHOLE", f64::from(occlusion_textures::WHOLE)),
        ],
    );
    of(
        "techniques/occlusion_texture/resolve.wgsl",
        &[
            ("SMOOTHED", f64::from(occlusion_textures::SMOOTHED)),
            ("DENSE_LEVEL", f64::from(occlusion_textures::DENSE_LEVEL)),
            ("N_BUFFERS", f64::from(SliceFilter::NBuffers as u32)),
            ("MIPMAPS", f64::from(SliceFilter::Mipmaps as u32)),
            ("SUMMED_AREAS", f64::from(SliceFilter::SummedAreas as u32)),
        ],
    );
    of(
        "techniques/occlusion_texture/filter.wgsl",
        &[("RADIX", f64::from(mirrored::RADIX))],
    );
    of(
        "common/wedge_sums.wgsl",
        &[
            ("FACING", f64::from(silhouette_layers::FACING)),
            ("AVERTED", f64::from(silhouette_layers::AVERTED)),
        ],
    );
    of(
        "techniques/penumbra_wedge/wedge.wgsl",
        &[
            ("HARD", f64::from(records::HARD)),
            ("PIECE", f64::from(records::PIECE)),
            ("SOFT", f64::from(records::SOFT)),
            ("ONLY_OUTER", f64::from(records::ONLY_OUTER)),
            ("ONLY_INNER", f64::from(records::ONLY_INNER)),
            ("CLOSED", f64::from(records::CLOSED)),
            ("CUT", f64::from(records::CUT)),
            ("LAYERS_SHIFT", f64::from(records::LAYERS_SHIFT)),
            ("SOFT_LAYERS_SHIFT", f64::from(records::SOFT_LAYERS_SHIFT)),
            ("END", f64::from(mirrored::END)),
            ("FAR_START", f64::from(mirrored::FAR_START)),
            ("FAR_END", f64::from(mirrored::FAR_END)),
            ("FIRST_RIM", f64::from(mirrored::FIRST_RIM)),
            ("FIRST_APEX", f64::from(mirrored::FIRST_APEX)),
            ("RIM", mirrored::RIM_POINTS as f64),
        ],
    );
    all
}

/// Rows that the composed module has otherwise or not at all; `edit` changes the shaders before.
fn wrong_constants(rows: &[Constant], edit: impl Fn(&str) -> String) -> Vec<String> {
    let shaders = shaders();
    let mut composed = HashMap::new();
    let mut wrong = Vec::new();
    for row in rows {
        let listed = |list: &[(&'static str, &'static str)]| {
            list.iter()
                .find(|(file, _)| *file == row.file)
                .map(|(_, source)| *source)
        };
        // Of what a pass imports, only what is left after folding keeps its name. A variable keeps all.
        let source = listed(&PASSES).map_or_else(
            || {
                let source = listed(&COMMON).expect("the file is listed");
                let path = source
                    .lines()
                    .find_map(|line| line.strip_prefix("#define_import_path "));
                let path = path.expect("it can be imported");
                let name = row.name;
                format!("#import {path}::{name}\nfn probe() {{ var value = {name}; }}\n")
            },
            &edit,
        );
        let constants = composed.entry(source).or_insert_with_key(|source| {
            constants_of(&shaders.compose(row.file, source).expect("it composes"))
        });
        let imported = format!("{}X_naga_oil_mod_", row.name); // what the composer makes of an imported name
        let found = constants
            .iter()
            .find(|(name, _)| name == row.name || name.starts_with(&imported));
        match found {
            None => wrong.push(format!("{}: {} has none", row.name, row.file)),
            Some((_, value)) if *value != row.value => {
                wrong.push(format!(
                    "{}: {value} in {}, {} in Rust",
                    row.name, row.file, row.value
                ));
            }
            Some(_) => {}
        }
    }
    wrong
}

#[test]
fn constants_are_equal() {
    let rows = mirrored_constants();
    assert!(rows.len() >= 38, "{} constants are compared", rows.len());
    assert_eq!(wrong_constants(&rows, str::to_owned), Vec::<String>::new());
}

#[test]
fn comparison_finds_a_constant_that_changes_in_either_language() {
    let mut rows = mirrored_constants();
    let at = |name: &str| {
        rows.iter()
            .position(|row| row.name == name)
            .expect("it is compared")
    };
    let (nodes, flag, gone) = (at("NODES"), at("CLOSED"), at("RIM"));
    rows[nodes].value = 17.0;
    rows[flag].value = 256.0;
    rows[gone].name = "RIMS";
    let wrong = wrong_constants(&rows, str::to_owned);
    assert_eq!(wrong.len(), 3, "{wrong:?}");
    for (name, wrong) in ["NODES: 16", "CLOSED: 512", "RIMS"].iter().zip(&wrong) {
        assert!(wrong.starts_with(name), "{wrong}");
    }
    let edit = |source: &str| source.replace("const TILE: u32 = 16u;", "const TILE: u32 = 8u;");
    assert_eq!(
        wrong_constants(&mirrored_constants(), edit),
        ["TILE: 8 in techniques/maps/resolve.wgsl, 16 in Rust"]
    );
}

/// Every constant that a shader says is mirrored is compared, and the other way round.
#[test]
fn every_mirrored_constant_is_compared() {
    let mut said = Vec::new();
    for &(file, source) in COMMON.iter().chain(PASSES.iter()) {
        let constants = source
            .lines()
            .filter(|line| line.starts_with("const ") && line.contains("mirror: "));
        said.extend(constants.map(|line| {
            let name = line["const ".len()..].split(':').next().expect("a name");
            (file, name)
        }));
    }
    let mut compared: Vec<_> = mirrored_constants()
        .iter()
        .map(|row| (row.file, row.name))
        .collect();
    said.sort_unstable();
    compared.sort_unstable();
    assert_eq!(said, compared);
}

/// Name and value of the scalar constants of a file without imports.
fn constants(source: &str) -> Vec<(String, f64)> {
    let plain: String = source
        .lines()
        .filter(|line| !line.starts_with('#')) // the composer's lines
        .map(|line| format!("{line}\n"))
        .collect();
    constants_of(&naga::front::wgsl::parse_str(&plain).expect("the file parses"))
}

/// Name and value of the scalar constants of a module.
fn constants_of(module: &naga::Module) -> Vec<(String, f64)> {
    let constants = module.constants.iter().filter_map(|(_, constant)| {
        let naga::Expression::Literal(literal) = module.global_expressions[constant.init] else {
            return None;
        };
        let value = match literal {
            naga::Literal::F32(value) => f64::from(value),
            naga::Literal::U32(value) => f64::from(value),
            naga::Literal::I32(value) => f64::from(value),
            _ => return None,
        };
        Some((constant.name.clone()?, value))
    });
    constants.collect()
}

/// What Rust has for a constant of `conventions.wgsl`.
fn rust_constant(name: &str) -> Option<f64> {
    match name {
        "DEPTH_NEAR" => Some(f64::from(conventions::DEPTH_NEAR)),
        "DEPTH_INFINITY" => Some(f64::from(conventions::DEPTH_INFINITY)),
        "STENCIL_LIT" => Some(f64::from(conventions::STENCIL_LIT)),
        "STENCIL_IN_BOUNDS" => Some(f64::from(conventions::STENCIL_IN_BOUNDS)),
        "STENCIL_COUNT_MASK" => Some(f64::from(conventions::STENCIL_COUNT_MASK)),
        "RADIANCE_MAX" => Some(f64::from(conventions::RADIANCE_MAX)),
        "PI" => Some(f64::from(std::f32::consts::PI)),
        _ => None,
    }
}

/// Names of constants that are not equal.
fn unequal(source: &str) -> Vec<String> {
    constants(source)
        .into_iter()
        .filter(|(name, value)| rust_constant(name) != Some(*value))
        .map(|(name, _)| name)
        .collect()
}

#[test]
fn conventions_are_equal() {
    let (path, source) = COMMON[0];
    assert_eq!(path, "common/conventions.wgsl");
    let written = source.lines().filter(|line| line.starts_with("const ")).count();
    assert!(
        written >= 3 && constants(source).len() == written,
        "not all constants were read"
    );
    assert_eq!(unequal(source), Vec::<String>::new());
    // The depth of the near plane and of infinity are also what the projection gives.
    let clip_from_view = antumbra::scene::Camera::default().clip_from_view();
    let near = clip_from_view * glam::DVec4::new(0.0, 0.0, -f64::from(0.1_f32), 1.0);
    let infinity = clip_from_view * glam::DVec4::new(0.0, 0.0, -1.0, 0.0);
    assert_eq!(near.z / near.w, f64::from(conventions::DEPTH_NEAR));
    assert_eq!(infinity.z / infinity.w, f64::from(conventions::DEPTH_INFINITY));
}

#[test]
fn comparison_finds_a_changed_and_an_unknown_constant() {
    let source = "#define_import_path x\nconst DEPTH_NEAR: f32 = 0.5;\nconst DEPTH_INFINITY: f32 = 0.0;\nconst E: f32 = 2.7;";
    assert_eq!(unequal(source), ["DEPTH_NEAR", "E"]);
}

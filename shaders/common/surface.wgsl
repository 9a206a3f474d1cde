// Drawn surfaces: the vertex stage and the material, shared by the passes that draw them.
// Host    src/render/pools/{meshes,materials,gpu_types}.rs
// Groups  0 view, 2 material
#define_import_path antumbra::surface

#import antumbra::view::{clip_position, relative_position, relative_vector, relative_normal}

struct Slot {                       // mirror: render::pools::gpu_types::Slot
    uv_matrix: vec4f,               // columns of the 2×2 part
    uv_offset: vec2f,
    uv_set: u32,                    // 0 or 1
    present: u32,                   // 0: the texture is a placeholder
}

struct Material {                   // mirror: render::pools::gpu_types::Material
    base_color: vec4f,
    emissive: vec3f,
    alpha_cutoff: f32,              // 0 for opaque and blended surfaces
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    unlit: u32,
    opaque: u32,                    // 1: alpha is ignored
    clearcoat: f32,
    clearcoat_roughness: f32,
    base_color_slot: Slot,
    metallic_roughness_slot: Slot,
    normal_slot: Slot,
    occlusion_slot: Slot,
    emissive_slot: Slot,
    clearcoat_slot: Slot,
    clearcoat_roughness_slot: Slot,
}

@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var base_color_texture: texture_2d<f32>;
@group(2) @binding(2) var base_color_sampler: sampler;
@group(2) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(2) @binding(4) var metallic_roughness_sampler: sampler;
@group(2) @binding(5) var normal_texture: texture_2d<f32>;
@group(2) @binding(6) var normal_sampler: sampler;
@group(2) @binding(7) var occlusion_texture: texture_2d<f32>;
@group(2) @binding(8) var occlusion_sampler: sampler;
@group(2) @binding(9) var emissive_texture: texture_2d<f32>;
@group(2) @binding(10) var emissive_sampler: sampler;
@group(2) @binding(11) var clearcoat_texture: texture_2d<f32>;
@group(2) @binding(12) var clearcoat_sampler: sampler;
@group(2) @binding(13) var clearcoat_roughness_texture: texture_2d<f32>;
@group(2) @binding(14) var clearcoat_roughness_sampler: sampler;

struct VertexIn {
    @location(0) position_local: vec3f,
    @location(1) normal_local: vec3f,
    @location(2) tangent_local: vec4f,
    @location(3) uv: vec4f,         // set 0 in xy, set 1 in zw
    @location(4) color: vec4f,
    @location(5) object: u32,
}

struct Fragment {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) position_relative: vec3f,
    @location(1) normal_relative: vec3f,
    @location(2) tangent_relative: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
}

fn surface_vertex(in: VertexIn) -> Fragment {
    var out: Fragment;
    out.position_clip = clip_position(in.object, in.position_local);
    out.position_relative = relative_position(in.object, in.position_local);
    out.normal_relative = relative_normal(in.object, in.normal_local);
    out.tangent_relative = vec4f(relative_vector(in.object, in.tangent_local.xyz), in.tangent_local.w);
    out.uv = in.uv;
    out.color = in.color;
    return out;
}

fn slot_uv(slot: Slot, uv: vec4f) -> vec2f {
    let coordinates = select(uv.xy, uv.zw, slot.uv_set == 1u);
    return mat2x2f(slot.uv_matrix.xy, slot.uv_matrix.zw) * coordinates + slot.uv_offset;
}

// Base colour, linear RGBA; the alpha of opaque materials is 1.
fn base_color(in: Fragment) -> vec4f {
    let texel = textureSample(base_color_texture, base_color_sampler, slot_uv(material.base_color_slot, in.uv));
    let color = material.base_color * in.color * texel;
    return vec4f(color.rgb, select(color.a, 1.0, material.opaque == 1u));
}

fn emissive(in: Fragment) -> vec3f {
    let texel = textureSample(emissive_texture, emissive_sampler, slot_uv(material.emissive_slot, in.uv));
    return material.emissive * texel.rgb;
}

// Share of the ambient light that arrives: 1 where nothing occludes it.
fn ambient_occlusion(in: Fragment) -> f32 {
    let texel = textureSample(occlusion_texture, occlusion_sampler, slot_uv(material.occlusion_slot, in.uv));
    return 1.0 + material.occlusion_strength * (texel.r - 1.0);
}

// Metallic in x, perceptual roughness in y.
fn metallic_roughness(in: Fragment) -> vec2f {
    let texel = textureSample(
        metallic_roughness_texture,
        metallic_roughness_sampler,
        slot_uv(material.metallic_roughness_slot, in.uv),
    );
    return vec2f(material.metallic * texel.b, material.roughness * texel.g);
}

// Clearcoat in x, its perceptual roughness in y. Only passes with `COATED` sample them: both textures are placeholders
// on nearly all surfaces.
fn clearcoat(in: Fragment) -> vec2f {
    let share = textureSample(clearcoat_texture, clearcoat_sampler, slot_uv(material.clearcoat_slot, in.uv)).r;
    let roughness = textureSample(
        clearcoat_roughness_texture,
        clearcoat_roughness_sampler,
        slot_uv(material.clearcoat_roughness_slot, in.uv),
    ).g;
    return vec2f(material.clearcoat * share, material.clearcoat_roughness * roughness);
}

// Unit normal on the visible side, interpolated and without the normal texture. A clearcoat is as smooth as this.
fn smooth_normal(in: Fragment, front_facing: bool) -> vec3f {
    let side = select(-1.0, 1.0, front_facing);
    // Opposite normals may interpolate to zero; no light reaches such a point.
    let normal = in.normal_relative;
    return normal * (side * inverseSqrt(max(dot(normal, normal), 1e-30)));
}

// Unit shading normal on the visible side. A mesh without tangents gets its frame from the derivatives of
// position and texture coordinates.
// Source: Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU".
fn shading_normal(in: Fragment, front_facing: bool) -> vec3f {
    let side = select(-1.0, 1.0, front_facing);
    let normal = smooth_normal(in, front_facing);
    let uv = slot_uv(material.normal_slot, in.uv);
    let texel = textureSample(normal_texture, normal_sampler, uv).xyz * 2.0 - 1.0;
    let dp_dx = dpdx(in.position_relative);
    let dp_dy = dpdy(in.position_relative);
    let duv_dx = dpdx(uv);
    let duv_dy = dpdy(uv);
    let bump = vec3f(texel.xy * material.normal_scale, texel.z);
    var tangent = in.tangent_relative.xyz;
    var bitangent = cross(in.normal_relative, tangent) * in.tangent_relative.w;
    if in.tangent_relative.w == 0.0 {
        let across_x = cross(dp_dy, normal);
        let across_y = cross(normal, dp_dx);
        tangent = across_x * duv_dx.x + across_y * duv_dy.x;
        bitangent = across_x * duv_dx.y + across_y * duv_dy.y;
        // Screen y points down, which reverses both axes; the green axis points against texture v.
        let scale = inverseSqrt(max(max(dot(tangent, tangent), dot(bitangent, bitangent)), 1e-30));
        tangent *= -scale;
        bitangent *= scale;
    } else {
        tangent = normalize(tangent);
        bitangent = normalize(bitangent);
        tangent *= side;
        bitangent *= side;
    }
    let bent = tangent * bump.x + bitangent * bump.y + normal * bump.z;
    // Selects instead of branches: lavapipe compiles a shader again for each value of a uniform on which it
    // branches.
    let is_bent = material.normal_slot.present == 1u;
    return select(normal, bent * inverseSqrt(max(dot(bent, bent), 1e-30)), is_bent);
}

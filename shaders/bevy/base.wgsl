// Bevy's own deferred lighting, without the lights that antumbra adds one by one.
// Host    src/bevy_adapter/pipelines.rs; composed by Bevy, with Bevy's own shader definitions
// Groups  0 and 1 are Bevy's, 2 managed lights
// Reads   Bevy's G-buffer and view
// Writes  radiance of the pixels that Bevy's own deferred lighting would write
//
// The overrides replace every call of Bevy's light functions: a light that antumbra manages gives 0 here.
// Without managed lights each call goes through, and the picture equals Bevy's bit for bit.
#import bevy_pbr::{
    prepass_utils,
    pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT,
    pbr_functions,
    pbr_deferred_functions::pbr_input_from_deferred_gbuffer,
    lighting,
    lighting::LightingInput,
    mesh_view_bindings::{view, lights, deferred_prepass_texture},
}
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
#import bevy_pbr::mesh_view_bindings::screen_space_ambient_occlusion_texture
#import bevy_pbr::ssao_utils::ssao_multibounce
#endif

// A light without an index from Bevy, identified by the values that Bevy uploads for it.
struct Unindexed {
    color: vec4<f32>,
    place: vec4<f32>,        // direction to a directional light, or position of a rectangle
    right: vec4<f32>,        // of a rectangle; w: its width
    up: vec4<f32>,           // of a rectangle; w: its height
}
struct Managed {
    counts: vec4<u32>,       // directional lights, rectangles, words of managed_bits
    directional: array<Unindexed, 10>,
    rect: array<Unindexed, 8>,
}

@group(2) @binding(0) var<storage, read> managed: Managed;
// One bit for each point and spot light, by Bevy's index.
@group(2) @binding(1) var<storage, read> managed_bits: array<u32>;
@group(2) @binding(2) var pass_id: texture_2d<u32>;

fn is_managed(light_id: u32) -> bool {
    let word = light_id >> 5u;
    let inside = word < managed.counts.z;
    let bits = managed_bits[select(0u, word, inside)];
    return inside && (bits & (1u << (light_id & 31u))) != 0u;
}

override fn bevy_pbr::lighting::point_light(
    light_id: u32, input: ptr<function, LightingInput>, enable_diffuse: bool, enable_texture: bool
) -> vec3<f32> {
    if is_managed(light_id) { return vec3<f32>(0.0); }
    return lighting::point_light(light_id, input, enable_diffuse, enable_texture);
}

fn is_same_directional(known: Unindexed, light_id: u32) -> bool {
    return all(known.place.xyz == lights.directional_lights[light_id].direction_to_light)
        && all(known.color == lights.directional_lights[light_id].color);
}

// Whether a light is managed. Lights with equal values cannot be told apart: the first of them count as managed, as many
// as are managed.
fn is_managed_directional(light_id: u32) -> bool {
    var left = 0u; // equal managed lights that no light before this one stands for
    var equal = Unindexed();
    for (var i = 0u; i < managed.counts.x; i = i + 1u) {
        if is_same_directional(managed.directional[i], light_id) {
            equal = managed.directional[i];
            left = left + 1u;
        }
    }
    for (var i = 0u; i < light_id && left > 0u; i = i + 1u) {
        left = left - u32(is_same_directional(equal, i));
    }
    return left > 0u;
}

override fn bevy_pbr::lighting::directional_light(
    light_id: u32, input: ptr<function, LightingInput>, enable_diffuse: bool
) -> vec3<f32> {
    if is_managed_directional(light_id) { return vec3<f32>(0.0); }
    return lighting::directional_light(light_id, input, enable_diffuse);
}

#ifdef AREA_LIGHT_LUTS
fn is_same_rect(known: Unindexed, light_id: u32) -> bool {
    let rect = lights.rect_lights[light_id];
    return all(known.place.xyz == rect.position) && all(known.color == rect.color)
        && all(known.right == vec4<f32>(rect.right, rect.width))
        && all(known.up == vec4<f32>(rect.up, rect.height));
}

// As `is_managed_directional`.
fn is_managed_rect(light_id: u32) -> bool {
    var left = 0u;
    var equal = Unindexed();
    for (var i = 0u; i < managed.counts.y; i = i + 1u) {
        if is_same_rect(managed.rect[i], light_id) {
            equal = managed.rect[i];
            left = left + 1u;
        }
    }
    for (var i = 0u; i < light_id && left > 0u; i = i + 1u) {
        left = left - u32(is_same_rect(equal, i));
    }
    return left > 0u;
}

override fn bevy_pbr::lighting::rect_light(
    light_id: u32, input: ptr<function, LightingInput>, enable_diffuse: bool
) -> vec3<f32> {
    if is_managed_rect(light_id) { return vec3<f32>(0.0); }
    return lighting::rect_light(light_id, input, enable_diffuse);
}
#endif

// The place of a pixel in the whole viewport, where Bevy's functions expect it. An upscaler lets the main pass
// draw into a part of the viewport.
fn in_viewport(pixel: vec2<f32>) -> vec2<f32> {
    let whole = view.viewport;
    let part = view.main_pass_viewport.zw;
    if all(whole.zw == part) { return pixel; }
    return whole.xy + (pixel - whole.xy) * (whole.zw / part);
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = vec2<i32>(position.xy);
    if textureLoad(pass_id, texel, 0).x != #{DEFERRED_PASS_ID}u { discard; }
    let gbuffer = textureLoad(deferred_prepass_texture, texel, 0);
    let frag_coord = vec4<f32>(in_viewport(position.xy), prepass_utils::prepass_depth(position, 0u), 0.0);
    var input = pbr_input_from_deferred_gbuffer(frag_coord, gbuffer);
    var color = input.material.base_color;
    if (input.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
#ifdef SCREEN_SPACE_AMBIENT_OCCLUSION
        let ssao = textureLoad(screen_space_ambient_occlusion_texture, texel, 0).r;
        input.diffuse_occlusion = min(input.diffuse_occlusion, ssao_multibounce(ssao, input.material.base_color.rgb));
        // Source: Lagarde & de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", as Bevy applies it.
        let n_dot_v = max(dot(input.N, input.V), 0.0001);
        let roughness = lighting::perceptualRoughnessToRoughness(input.material.perceptual_roughness);
        input.specular_occlusion = saturate(pow(n_dot_v + ssao, exp2(-16.0 * roughness - 1.0)) - 1.0 + ssao);
#endif
        color = pbr_functions::apply_pbr_lighting(input);
    }
    return pbr_functions::main_pass_post_lighting_processing(input, color);
}

// Appended to the shaders of materials that Bevy draws forward: managed lights are multiplied by their visibility.
// Host    src/bevy_adapter/forward_shaders.rs; composed by Bevy, with the material's own shader definitions
// Groups  0 to 3 are Bevy's and the material's, 4 the masks
// Reads   the visibility of the managed lights, one layer each
//
// Overrides count in the root module alone, so this text follows the material's own. All names begin with
// `antumbra`, because the text shares a module with them. A light that has no layer goes through as it is.
#import bevy_pbr::lighting as antumbra_lighting
#import bevy_pbr::mesh_view_bindings as antumbra_bindings

struct AntumbraUnindexed {
    color: vec4<f32>,
    place: vec4<f32>,        // xyz as in base.wgsl; w: the layer plus 1, or 0
    right: vec4<f32>,        // as in base.wgsl
    up: vec4<f32>,           // as in base.wgsl
}
struct AntumbraManaged {
    counts: vec4<u32>,       // directional lights, rectangles, length of antumbra_layers
    directional: array<AntumbraUnindexed, 10>,
    rect: array<AntumbraUnindexed, 8>,
}

@group(4) @binding(0) var<storage, read> antumbra_managed: AntumbraManaged;
// For each point and spot light, by Bevy's index: the layer plus 1, or 0.
@group(4) @binding(1) var<storage, read> antumbra_layers: array<u32>;
@group(4) @binding(2) var antumbra_masks: texture_2d_array<f32>;

// The visibility that the surface at a position has, which is the visible one: it is in the depth prepass.
fn antumbra_visibility(layer: u32, position: vec3<f32>) -> vec3<f32> {
    let clip = antumbra_bindings::view.clip_from_world * vec4<f32>(position, 1.0);
    let part = antumbra_bindings::view.main_pass_viewport.zw;
    let pixel = floor((clip.xy / clip.w * vec2<f32>(0.5, -0.5) + 0.5) * part);
    let texel = antumbra_bindings::view.viewport.xy + clamp(pixel, vec2<f32>(0.0), part - 1.0);
    return textureLoad(antumbra_masks, vec2<i32>(texel), i32(layer) - 1, 0).rgb;
}

override fn bevy_pbr::lighting::point_light(
    light_id: u32, input: ptr<function, antumbra_lighting::LightingInput>, enable_diffuse: bool, enable_texture: bool
) -> vec3<f32> {
    let light = antumbra_lighting::point_light(light_id, input, enable_diffuse, enable_texture);
    let is_known = light_id < antumbra_managed.counts.z;
    let layer = antumbra_layers[select(0u, light_id, is_known)];
    if !is_known || layer == 0u { return light; }
    return light * antumbra_visibility(layer, (*input).P);
}

fn antumbra_is_same_directional(known: AntumbraUnindexed, light_id: u32) -> bool {
    return all(known.place.xyz == antumbra_bindings::lights.directional_lights[light_id].direction_to_light)
        && all(known.color == antumbra_bindings::lights.directional_lights[light_id].color);
}

// The layer of a light plus 1, or 0. Lights with equal values cannot be told apart: the first of them have the layers of the
// equal managed ones, in order.
fn antumbra_layer_of_directional(light_id: u32) -> u32 {
    var layer = 0u;
    var rank = 0u; // of the next equal managed light
    for (var i = 0u; i < antumbra_managed.counts.x; i = i + 1u) {
        let known = antumbra_managed.directional[i];
        if antumbra_is_same_directional(known, light_id) {
            var before = 0u; // equal lights before this one
            for (var j = 0u; j < light_id; j = j + 1u) { before = before + u32(antumbra_is_same_directional(known, j)); }
            layer = select(layer, u32(known.place.w), rank == before);
            rank = rank + 1u;
        }
    }
    return layer;
}

override fn bevy_pbr::lighting::directional_light(
    light_id: u32, input: ptr<function, antumbra_lighting::LightingInput>, enable_diffuse: bool
) -> vec3<f32> {
    let light = antumbra_lighting::directional_light(light_id, input, enable_diffuse);
    let layer = antumbra_layer_of_directional(light_id);
    if layer == 0u { return light; }
    return light * antumbra_visibility(layer, (*input).P);
}

#ifdef AREA_LIGHT_LUTS
fn antumbra_is_same_rect(known: AntumbraUnindexed, light_id: u32) -> bool {
    let rect = antumbra_bindings::lights.rect_lights[light_id];
    return all(known.place.xyz == rect.position) && all(known.color == rect.color)
        && all(known.right == vec4<f32>(rect.right, rect.width))
        && all(known.up == vec4<f32>(rect.up, rect.height));
}

// As `antumbra_layer_of_directional`.
fn antumbra_layer_of_rect(light_id: u32) -> u32 {
    var layer = 0u;
    var rank = 0u;
    for (var i = 0u; i < antumbra_managed.counts.y; i = i + 1u) {
        let known = antumbra_managed.rect[i];
        if antumbra_is_same_rect(known, light_id) {
            var before = 0u;
            for (var j = 0u; j < light_id; j = j + 1u) { before = before + u32(antumbra_is_same_rect(known, j)); }
            layer = select(layer, u32(known.place.w), rank == before);
            rank = rank + 1u;
        }
    }
    return layer;
}

override fn bevy_pbr::lighting::rect_light(
    light_id: u32, input: ptr<function, antumbra_lighting::LightingInput>, enable_diffuse: bool
) -> vec3<f32> {
    let light = antumbra_lighting::rect_light(light_id, input, enable_diffuse);
    let layer = antumbra_layer_of_rect(light_id);
    if layer == 0u { return light; }
    return light * antumbra_visibility(layer, (*input).P);
}
#endif

// One managed light: Bevy's own light function times our visibility, added to the radiance.
// Host    src/bevy_adapter/pipelines.rs; composed by Bevy, with Bevy's own shader definitions
// Groups  0 and 1 are Bevy's, 2 the light, 3 its mask
// Reads   Bevy's G-buffer and view, the stencil or the mask of the light
// Writes  radiance, blended ONE ONE
//
// Variants are made by shader definitions. LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL or LIGHT_RECT is the
// kind of the light. VISIBILITY_MASK reads visibility from the mask; without it, the stencil test has
// decided. MASK_HOLDS_FOR_ALL reads the mask on surfaces that receive no shadows too. UNSHADOWED_ONLY lights
// pixels that the stencil test calls shadowed but whose mesh, according to Bevy, receives no shadows. SEPARATE_TERMS
// weights ambient, diffuse and specular light and gives shadows their colour; a second mask then scales them all.
#import bevy_pbr::{
    prepass_utils,
    mesh_types::MESH_FLAGS_SHADOW_RECEIVER_BIT,
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
    pbr_functions,
    pbr_deferred_functions::pbr_input_from_deferred_gbuffer,
    lighting,
    lighting::{LightingInput, LAYER_BASE, LAYER_CLEARCOAT},
    mesh_view_types::{POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE, POINT_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT},
    mesh_view_types::DIRECTIONAL_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT,
    mesh_view_bindings::{view, lights, clustered_lights, deferred_prepass_texture},
}
#ifdef CONTACT_SHADOWS
#import bevy_pbr::mesh_view_bindings::contact_shadows_settings
#endif

#ifdef SEPARATE_TERMS
const PI: f32 = 3.141592653589793;
#endif

struct LightDraw {
    color: vec4<f32>,        // as Bevy uploads it; for directional lights and rectangles
    place: vec4<f32>,        // direction to a directional light, or position of a rectangle
    right: vec4<f32>,        // of a rectangle; w: its width
    up: vec4<f32>,           // of a rectangle; w: its height
    index: vec4<u32>,        // x: Bevy's index of a point or spot light; y: 1 if surfaces have weights of their own
    weights: vec4<f32>,      // of ambient, diffuse and specular light; w: darkness of shadows
    shadow: vec4<f32>,       // colour of shadows, for a light whose largest component is 1
}

@group(2) @binding(0) var<uniform> draw: LightDraw;
@group(2) @binding(1) var pass_id: texture_2d<u32>;
#ifdef VISIBILITY_MASK
@group(3) @binding(0) var visibility_mask: texture_2d<f32>;
#endif
#ifdef SEPARATE_TERMS
@group(3) @binding(1) var factor_mask: texture_2d<f32>;
@group(3) @binding(2) var surface_weights: texture_2d<f32>;
#endif

// The surface as Bevy's light functions expect it: what `apply_pbr_lighting` computes before the first light.
fn lighting_input(surface: PbrInput) -> LightingInput {
    let material = surface.material;
    let n_dot_v = max(dot(surface.N, surface.V), 0.0001);
    var input: LightingInput;
    input.P = surface.world_position.xyz;
    input.V = surface.V;
    input.layers[LAYER_BASE].N = surface.N;
    input.layers[LAYER_BASE].R = reflect(-surface.V, surface.N);
    input.layers[LAYER_BASE].NdotV = n_dot_v;
    input.layers[LAYER_BASE].perceptual_roughness = material.perceptual_roughness;
    input.layers[LAYER_BASE].roughness = lighting::perceptualRoughnessToRoughness(material.perceptual_roughness);
    input.metallic = material.metallic;
    input.diffuse_color = pbr_functions::calculate_diffuse_color(
        material.base_color.rgb, material.metallic, material.specular_transmission, material.diffuse_transmission);
    input.F0_dielectric = pbr_functions::calculate_F0_dielectric(material.reflectance);
    input.F0_metallic = material.base_color.rgb;
    input.F_ab = lighting::F_AB(material.perceptual_roughness, n_dot_v);
#ifdef STANDARD_MATERIAL_CLEARCOAT
    let coat = surface.clearcoat_N;
    input.layers[LAYER_CLEARCOAT].N = coat;
    input.layers[LAYER_CLEARCOAT].R = reflect(-surface.V, coat);
    input.layers[LAYER_CLEARCOAT].NdotV = max(dot(coat, surface.V), 0.0001);
    input.layers[LAYER_CLEARCOAT].perceptual_roughness = material.clearcoat_perceptual_roughness;
    input.layers[LAYER_CLEARCOAT].roughness =
        lighting::perceptualRoughnessToRoughness(material.clearcoat_perceptual_roughness);
    input.clearcoat_strength = material.clearcoat;
#endif
    return input;
}

// Finds Bevy's index of a light whose index the CPU cannot see. Of equal lights it is the first.
#ifdef LIGHT_DIRECTIONAL
fn find_light() -> u32 {
    let count = lights.n_directional_lights;
    var found = count;
    for (var i = 0u; i < count; i = i + 1u) {
        let same = all(lights.directional_lights[i].direction_to_light == draw.place.xyz)
            && all(lights.directional_lights[i].color == draw.color);
        found = select(found, i, same && found == count);
    }
    return found;
}
#endif
#ifdef LIGHT_RECT
fn find_light() -> u32 {
    let count = lights.n_rect_lights;
    var found = count;
    for (var i = 0u; i < count; i = i + 1u) {
        let rect = lights.rect_lights[i];
        let same = all(rect.position == draw.place.xyz) && all(rect.color == draw.color)
            && all(vec4<f32>(rect.right, rect.width) == draw.right) && all(vec4<f32>(rect.up, rect.height) == draw.up);
        found = select(found, i, same && found == count);
    }
    return found;
}
#endif

fn radiance(input: ptr<function, LightingInput>, diffuse: bool) -> vec3<f32> {
#ifdef LIGHT_POINT
    return lighting::point_light(draw.index.x, input, diffuse, true);
#endif
#ifdef LIGHT_SPOT
    return lighting::spot_light(draw.index.x, input, diffuse);
#endif
#ifdef LIGHT_DIRECTIONAL
    let index = find_light();
    if index >= lights.n_directional_lights { return vec3<f32>(0.0); }
    return lighting::directional_light(index, input, diffuse);
#endif
#ifdef LIGHT_RECT
    let index = find_light();
    if index >= lights.n_rect_lights { return vec3<f32>(0.0); }
#ifdef AREA_LIGHT_LUTS
    return lighting::rect_light(index, input, diffuse);
#else
    return vec3<f32>(0.0);
#endif
#endif
}

#ifdef SEPARATE_TERMS
// The light's colour times its brightness, as Bevy uploads it.
fn emitted() -> vec3<f32> {
#ifdef LIGHT_POINT
    return clustered_lights.data[draw.index.x].color_inverse_square_range.rgb;
#endif
#ifdef LIGHT_SPOT
    return clustered_lights.data[draw.index.x].color_inverse_square_range.rgb;
#endif
#ifdef LIGHT_DIRECTIONAL
    return draw.color.rgb;
#endif
#ifdef LIGHT_RECT
    return draw.color.rgb;
#endif
}

// Irradiance on a surface that faces a light which emits 1, by Bevy's falloffs. Rectangles have none.
fn facing_irradiance(position: vec3<f32>) -> f32 {
    var result = 0.0;
#ifdef LIGHT_DIRECTIONAL
    result = 1.0;
#endif
#ifdef LIGHT_POINT
    let light = &clustered_lights.data[draw.index.x];
    let to_light = (*light).position_radius.xyz - position;
    result = lighting::getDistanceAttenuation(dot(to_light, to_light), (*light).color_inverse_square_range.w);
#endif
#ifdef LIGHT_SPOT
    let light = &clustered_lights.data[draw.index.x];
    let to_light = (*light).position_radius.xyz - position;
    let custom = (*light).light_custom_data;
    let down = ((*light).flags & POINT_LIGHT_FLAGS_SPOT_LIGHT_Y_NEGATIVE) != 0u;
    let height = sqrt(max(0.0, 1.0 - custom.x * custom.x - custom.y * custom.y));
    let axis = vec3<f32>(custom.x, select(height, -height, down), custom.y);
    let cone = saturate(dot(-axis, normalize(to_light)) * custom.z + custom.w);
    result = cone * cone
        * lighting::getDistanceAttenuation(dot(to_light, to_light), (*light).color_inverse_square_range.w);
#endif
    return result;
}

// Ambient light without shadow, diffuse light of the mixed colour, and highlights that are off in the shadow. Bevy's
// function answers with the light's colour; a white surface tells what it would answer to any other colour.
// Source: Pellacini & Vidimce 2004, "Cinematic Lighting", GPU Gems ch. 10, listing 10-2.
// The weights of the surface are multiplied by those of the light.
fn separate_terms(input: ptr<function, LightingInput>, seen: vec3<f32>, of_surface: vec3<f32>) -> vec3<f32> {
    let specular = radiance(input, false);
    var white = *input;
    white.diffuse_color = vec3<f32>(1.0);
    let answer = radiance(&white, true) - specular;
    let emission = emitted();
    let largest = max(max(emission.r, emission.g), max(emission.b, 1e-20));
    let of_largest = select(select(answer.b, answer.g, emission.g == largest), answer.r, emission.r == largest);
    let unit_answer = max(of_largest / largest, 0.0);
    let passing = 1.0 - draw.weights.w * (1.0 - seen);
    let mixed = mix(draw.shadow.rgb * largest, emission, passing);
    let ambient = (*input).diffuse_color / PI * facing_irradiance((*input).P) * emission;
    let diffuse = (*input).diffuse_color * unit_answer * mixed;
    let weights = draw.weights.xyz * of_surface;
    return ambient * weights.x + diffuse * weights.y + specular * seen * weights.z;
}
#endif

// Whether a point or spot light is beyond its range or wholly below the surface's horizon. Bevy's functions
// return 0 there, but only after all of their work.
fn is_out_of_reach(surface: PbrInput) -> bool {
    var out_of_reach = false;
#ifdef LIGHT_POINT
    out_of_reach = true;
#endif
#ifdef LIGHT_SPOT
    out_of_reach = true;
#endif
    if out_of_reach {
        let light = &clustered_lights.data[draw.index.x];
        let to_light = (*light).position_radius.xyz - surface.world_position.xyz;
        var is_below = dot(surface.N, to_light) + (*light).position_radius.w <= 0.0;
#ifdef SEPARATE_TERMS
        is_below = false; // ambient light has no horizon
#endif
        out_of_reach = is_below
            || dot(to_light, to_light) * (*light).color_inverse_square_range.w >= 1.0;
    }
    return out_of_reach;
}

// The share of the light that Bevy's contact shadows let through; 1 if the camera or the light has none.
// `apply_pbr_lighting` multiplies by it beside the light functions, so they do not hold it.
fn contact_visibility(surface: PbrInput) -> f32 {
#ifdef CONTACT_SHADOWS
#ifdef DEPTH_PREPASS
#ifndef LIGHT_RECT
#ifdef LIGHT_DIRECTIONAL
    let index = find_light();
    if index >= lights.n_directional_lights { return 1.0; }
    let flags = lights.directional_lights[index].flags & DIRECTIONAL_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT;
    let to_light = lights.directional_lights[index].direction_to_light;
#else
    let light = &clustered_lights.data[draw.index.x];
    let flags = (*light).flags & POINT_LIGHT_FLAGS_CONTACT_SHADOWS_ENABLED_BIT;
    let to_light = normalize((*light).position_radius.xyz - surface.world_position.xyz);
#endif
    let steps = contact_shadows_settings.linear_steps;
    if flags != 0u && steps > 0u {
        let place = surface.world_position.xyz;
        return pbr_functions::calculate_contact_shadow(place, surface.frag_coord.xy, to_light, steps);
    }
#endif
#endif
#endif
    return 1.0;
}

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
    let surface = pbr_input_from_deferred_gbuffer(frag_coord, gbuffer);
    if (surface.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) != 0u { discard; }
    let shows_shadows = (surface.flags & MESH_FLAGS_SHADOW_RECEIVER_BIT) != 0u;
#ifdef UNSHADOWED_ONLY
    if shows_shadows { discard; }
#endif
    var visibility = vec3<f32>(1.0);
#ifdef VISIBILITY_MASK
    var reads_mask = shows_shadows;
#ifdef MASK_HOLDS_FOR_ALL
    reads_mask = true;
#endif
    visibility = select(visibility, textureLoad(visibility_mask, texel, 0).rgb, reads_mask);
#ifndef SEPARATE_TERMS
    if all(visibility == vec3<f32>(0.0)) { discard; }
#endif
#endif
    if is_out_of_reach(surface) { discard; }
    if shows_shadows && any(visibility > vec3<f32>(0.0)) { visibility *= contact_visibility(surface); }
    var input = lighting_input(surface);
#ifdef SEPARATE_TERMS
    let factors = textureLoad(factor_mask, texel, 0).rgb;
    var of_surface = vec3<f32>(1.0);
    if draw.index.y != 0u { of_surface = textureLoad(surface_weights, texel, 0).rgb; }
    let color = separate_terms(&input, visibility, of_surface) * factors * view.exposure;
#else
    let color = radiance(&input, true) * (visibility * view.exposure);
#endif
    // Fog is affine in the colour, and the base pass has added the fog's own colour once.
    let foggy = pbr_functions::main_pass_post_lighting_processing(surface, vec4<f32>(color, 1.0));
    let fog = pbr_functions::main_pass_post_lighting_processing(surface, vec4<f32>(0.0, 0.0, 0.0, 1.0));
    return vec4<f32>(foggy.rgb - fog.rgb, 0.0);
}

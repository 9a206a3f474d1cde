// The factor by which the cookie and the profile of one light scale what it gives to each surface. It is multiplied
// into the mask of the light.
// Host    src/render/light_model/textures/function.rs
// Groups  0 view, 1 receiver, 2 light texture
#import antumbra::receiver::receiver_position
#import antumbra::light_texture::{LightTexture, picture_place, cube_place, profile_place, CUBE}

// Where the cookie lies; 0 without a cookie.
override PROJECTION: u32 = 0u;
override HAS_PROFILE: bool = false;

@group(2) @binding(0) var<uniform> light: LightTexture;
@group(2) @binding(1) var cookie_texture: texture_2d<f32>;
@group(2) @binding(2) var cookie_sampler: sampler;
@group(2) @binding(3) var profile_texture: texture_2d<f32>;
@group(2) @binding(4) var cube_texture: texture_cube<f32>;

// The step on the surface from a pixel to the next one along an axis. Of both neighbours the nearer one is on the same
// surface, so the footprint of a texel does not jump at the edges of objects.
fn surface_step(pixel: vec2f, position: vec3f, axis: vec2f) -> vec3f {
    let next = receiver_position(pixel + axis);
    let last = receiver_position(pixel - axis);
    let ahead = next.xyz - position;
    let behind = position - last.xyz;
    let is_next_nearer = next.w > 0.0 && (last.w <= 0.0 || dot(ahead, ahead) <= dot(behind, behind));
    return select(select(vec3f(0.0), behind, last.w > 0.0), ahead, is_next_nearer);
}

fn cookie(pixel: vec2f, position: vec3f) -> vec3f {
    let step_x = surface_step(pixel, position, vec2f(1.0, 0.0));
    let step_y = surface_step(pixel, position, vec2f(0.0, 1.0));
    if PROJECTION == CUBE {
        let at = cube_place(position, step_x, step_y, light);
        let faces = textureSampleGrad(cube_texture, cookie_sampler, at.direction, at.direction_dx, at.direction_dy).rgb;
        return mix(vec3f(1.0), faces, light.density);
    }
    let place = picture_place(position, step_x, step_y, light, PROJECTION);
    let picture = textureSampleGrad(cookie_texture, cookie_sampler, place.uv, place.uv_dx, place.uv_dy).rgb;
    return mix(vec3f(1.0), picture, light.density);
}

// Linear in both angles. Loads are exact, where the filters of devices have steps of 1/256.
fn profile(position: vec3f) -> f32 {
    let place = profile_place(position, light);
    let last = vec2i(light.profile_last);
    let low = min(vec2i(place.texel), last);
    let high = min(low + 1, last);
    let part = place.texel - vec2f(low);
    let a = textureLoad(profile_texture, low, 0).r;
    let b = textureLoad(profile_texture, vec2i(high.x, low.y), 0).r;
    let c = textureLoad(profile_texture, vec2i(low.x, high.y), 0).r;
    let d = textureLoad(profile_texture, high, 0).r;
    return select(0.0, mix(mix(a, b, part.x), mix(c, d, part.x), part.y), place.is_inside);
}

@fragment
fn fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let position = receiver_position(pixel.xy).xyz;
    var factor = vec3f(1.0);
    if PROJECTION != 0u {
        factor = cookie(pixel.xy, position);
    }
    if HAS_PROFILE {
        factor *= profile(position);
    }
    return vec4f(factor, 1.0);
}

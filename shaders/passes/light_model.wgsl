// The factor by which the light model of one light scales what it gives to each surface. It is multiplied into
// the mask of the light. `barn_map` makes the texture that `mapped` looks the shape up in.
// Host    src/render/light_model/function.rs, src/render/light_model/barn_maps.rs
// Groups  0 view, 1 receiver, 2 light model; `mapped` also 3 barn map; `barn_map` 2 alone
#import antumbra::receiver::receiver_at
#import antumbra::light_shape::{LightShape, light_position, shape_factor, doors_factor, depth_fades}

struct LightModel {                 // mirror: render::pools::gpu_types::LightModel
    shape: LightShape,
    barn_map: vec4f,                // texture coordinates from outer semi-axes: factor, offset; places from texels: factor
}

@group(2) @binding(0) var<uniform> model: LightModel;
@group(3) @binding(0) var barn_map_texture: texture_2d<f32>;
@group(3) @binding(1) var barn_map_sampler: sampler;

@fragment
fn fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let position = light_position(receiver_at(pixel.xy).position, model.shape);
    return vec4f(shape_factor(position, model.shape));
}

// The shape from its map. Twin: scene::BarnMap::sample.
@fragment
fn mapped(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let position = light_position(receiver_at(pixel.xy).position, model.shape);
    let at = abs(position.xy) / max(position.z, 1e-20);
    let part = min(at / max(model.shape.semi_axes.zw, vec2f(1e-12)), vec2f(1.0));
    let uv = part * model.barn_map.x + model.barn_map.y;
    let passed = textureSampleLevel(barn_map_texture, barn_map_sampler, uv, 0.0).r;
    let fades = depth_fades(position, model.shape);
    return vec4f(select(0.0, passed, position.z > 0.0) * fades.x * (1.0 - fades.y));
}

// One quadrant of the shape: the first texel of each axis is its middle, the last one its outer end.
@fragment
fn barn_map(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let at = (pixel.xy - 0.5) * model.barn_map.z * model.shape.semi_axes.zw;
    return vec4f(doors_factor(at, model.shape));
}

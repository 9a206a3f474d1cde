// The factor by which the light model of one light scales what it gives to each surface. It is multiplied into
// the mask of the light.
// Host    src/render/light_model/function.rs
// Groups  0 view, 1 receiver, 2 light model
#import antumbra::receiver::receiver_at
#import antumbra::light_shape::{LightShape, light_position, shape_factor}

struct LightModel {                 // mirror: render::pools::gpu_types::LightModel
    shape: LightShape,
}

@group(2) @binding(0) var<uniform> model: LightModel;

@fragment
fn fragment(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let position = light_position(receiver_at(pixel.xy).position, model.shape);
    return vec4f(shape_factor(position, model.shape));
}

//! The constants of each light's model in shaders.

use glam::{DVec3, Vec2};

use crate::render::pools::gpu_types;
use crate::scene::{LightDistance, LightShape};
use crate::sets::FrameLight;

/// Makes the shader's constants of a light's shape and distances. A light without them gets a factor of 1.
pub fn shape_constants(light: &FrameLight, eye_world: DVec3) -> gpu_types::LightShape {
    let center = light.shining.emitter.point.truncate();
    let [x, y, z] = light.shining.axes.map(|axis| {
        let offset = axis.dot(eye_world - center);
        axis.as_vec3().extend(offset as f32).to_array()
    });
    let shape = light.model.shape.unwrap_or_default();
    let distance = light.model.distance.unwrap_or_default();
    gpu_types::LightShape {
        light_from_relative_x: x,
        light_from_relative_y: y,
        light_from_relative_z: z,
        semi_axes: semi_axes(&shape),
        distance: edges(light, &distance),
        form: [
            shape.exponent(),
            shape.exponent().recip(),
            f32::from(light.model.shape.is_some()),
            f32::from(shape.inner().min_element() > 0.0),
        ],
    }
}

/// Makes the shader's constants of a light's model: those of its shape and distances, and of its barn map.
pub fn model_constants(light: &FrameLight, eye_world: DVec3) -> gpu_types::LightModel {
    let texels = light.model.barn_map.map_or(0, |map| map.resolution) as f32;
    let barn_map = if texels > 1.0 {
        [(texels - 1.0) / texels, 0.5 / texels, (texels - 1.0).recip(), 0.0]
    } else {
        [0.0; 4]
    };
    gpu_types::LightModel {
        shape: shape_constants(light, eye_world),
        barn_map,
    }
}

fn semi_axes(shape: &LightShape) -> [f32; 4] {
    let [inner, outer]: [Vec2; 2] = [shape.inner(), shape.outer()];
    [inner.x, inner.y, outer.x, outer.y]
}

/// Distances of directional lights bound nothing, and their depth has no meaning.
fn edges(light: &FrameLight, distance: &LightDistance) -> [f32; 4] {
    let bounded = light.shining.emitter.point.w != 0.0;
    if bounded {
        *distance
    } else {
        LightDistance::default()
    }
    .edges()
}

// The weights of ambient, diffuse and specular light of the object that each pixel of a host's picture shows.
// Host    src/render/nodes/host_weights.rs
// Groups  0 view
#import antumbra::surface::{VertexIn, surface_vertex}
#import antumbra::view::objects

struct Weights {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) @interpolate(flat) weights: vec3f,
}

@vertex
fn vertex(in: VertexIn) -> Weights {
    return Weights(surface_vertex(in).position_clip, objects[in.object].handedness.yzw);
}

@fragment
fn fragment(in: Weights) -> @location(0) vec4f {
    // The largest half float; infinity times 0 would be no number.
    return vec4f(min(in.weights, vec3f(65504.0)), 1.0);
}

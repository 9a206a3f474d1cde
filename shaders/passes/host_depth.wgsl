// The depth of a host's picture: copied, then replaced by our own wherever the host shows a surface that we
// know.
// Host    src/render/nodes/host_depth.rs; host_select.rs, which draws the same surfaces into the stencil
// Groups  0 view, 2 material (not read), 3 the host's depth
#import antumbra::view::ndc_from_pixel
#import antumbra::surface::{VertexIn, Fragment, surface_vertex}

struct HostDepth {                  // mirror: render::pools::gpu_types::HostDepth
    numerator: vec4f,               // our depth is the quotient, each dotted with (NDC, host's depth, 1)
    denominator: vec4f,
    rounding: vec4f,                // tolerance within one surface: factors of 1, our depth, its square
}

@group(3) @binding(0) var host_texture: texture_depth_2d;
@group(3) @binding(1) var<uniform> host: HostDepth;

// Pixels by which two rasterizers may differ in the position of a vertex.
const SUBPIXEL: f32 = 1.0/64.0;

fn host_depth(pixel: vec2f) -> f32 {
    let theirs = textureLoad(host_texture, vec2u(pixel), 0);
    let p = vec4f(ndc_from_pixel(pixel), theirs, 1.0);
    let ours = dot(host.numerator, p) / dot(host.denominator, p);
    return select(0.0, clamp(ours, 0.0, 1.0), theirs > 0.0);
}

@fragment
fn copy(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
    return host_depth(position.xy);
}

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

// Writes nothing: the colour target's write mask is empty.
@fragment
fn no_color() -> @location(0) vec4f {
    return vec4f(0.0);
}

// Keeps a fragment where the host shows the same surface, and discards it elsewhere.
@fragment
fn surface(in: Fragment) {
    let ours = in.position_clip.z;
    let slope = abs(dpdx(ours)) + abs(dpdy(ours));
    let away = abs(ours - host_depth(in.position_clip.xy));
    let rounding = dot(host.rounding.xyz, vec3f(1.0, ours, ours * ours));
    if away > rounding + SUBPIXEL * slope {
        discard;
    }
}

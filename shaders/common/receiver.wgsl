// The surface that each pixel shows: bind group 1 of passes that resolve a mask.
// Host    src/render/gpu/bind_groups.rs, src/render/frame/targets.rs
// Spaces  relative: world axes, origin at the eye
#define_import_path antumbra::receiver

#import antumbra::view::{view, relative_from_pixel}

@group(1) @binding(0) var receiver_depth: texture_2d<f32>;
@group(1) @binding(1) var receiver_plane: texture_2d<u32>;

// Value of the plane texture where nothing was drawn. No normal packs to it, because -32768 is no snorm.
const NO_PLANE: u32 = 0x80008000u;  // mirror: render::nodes::receiver_plane::NO_PLANE

struct Receiver {
    depth: f32,                     // 0: no surface
    position: vec3f,                // relative
    normal: vec3f,                  // unit, of the triangle, on the visible side; 0 if unknown
    offset: f32,                    // of the triangle's plane: dot(normal, point) for all its points
}

// Maps a unit vector to the square [−1, 1]².
// Source: Meyer et al. 2010, "On Floating-Point Normal Vectors": octahedral coordinates.
fn octahedral_from_unit(n: vec3f) -> vec2f {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    return select(folded, p, n.z >= 0.0);
}

fn unit_from_octahedral(p: vec2f) -> vec3f {
    let z = 1.0 - abs(p.x) - abs(p.y);
    let fold = max(-z, 0.0);
    let xy = p + select(vec2f(fold), vec2f(-fold), p >= vec2f(0.0));
    return normalize(vec3f(xy, z));
}

fn receiver_at(pixel: vec2f) -> Receiver {
    var out: Receiver;
    let texel = vec2u(pixel);
    out.depth = textureLoad(receiver_depth, texel, 0).r;
    out.position = relative_from_pixel(pixel, max(out.depth, 1e-30));
    let plane = textureLoad(receiver_plane, texel, 0).rg;
    let known = plane.x != NO_PLANE;
    out.normal = select(vec3f(0.0), unit_from_octahedral(unpack2x16snorm(plane.x)), known);
    out.offset = select(0.0, bitcast<f32>(plane.y), known);
    return out;
}

// The point that a pixel shows, relative, and its depth in w. Pixels outside of the view and those without a surface
// have depth 0 and some finite point.
fn receiver_position(pixel: vec2f) -> vec4f {
    let inside = pixel - view.origin.xy;
    let is_inside = all(inside >= vec2f(0.0)) && all(inside < view.size.xy);
    let depth = textureLoad(receiver_depth, vec2u(select(view.origin.xy, pixel, is_inside)), 0).r;
    let position = relative_from_pixel(pixel, max(depth, 1e-30));
    return vec4f(position, select(0.0, depth, is_inside));
}

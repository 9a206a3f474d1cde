// Visibility of blurred grounds, written into the mask over that of the map.
// Host    src/techniques/perspective_map/gpu/passes.rs
// Groups  0 view, 1 channels of objects, 2 map, 3 picture
// Spaces  as in common/map.wgsl. The depth test is "equal", so triangles that are hidden are not drawn.
#import antumbra::view::{clip_position, relative_position}
#import antumbra::map_matrix::{NO_FACE, clip_in_face, ray_at, showing}

@group(1) @binding(0) var<storage, read> channels: array<u32>;
@group(3) @binding(0) var picture: texture_2d_array<f32>;
@group(3) @binding(1) var bilinear: sampler;

// Value of `channels` for an object that is no ground.
const NO_GROUND: u32 = 4u;          // mirror: techniques::perspective_map::grounds::MOST_GROUNDS

struct Seen {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) position_relative: vec3f,
    @location(1) @interpolate(flat) channel: u32,
}

@vertex
fn vertex(@location(0) position_local: vec3f, @location(5) object: u32) -> Seen {
    let channel = channels[min(object, arrayLength(&channels) - 1u)];
    var out: Seen;
    out.position_clip = clip_position(object, position_local);
    if channel >= NO_GROUND {
        out.position_clip = vec4f(0.0, 0.0, -1.0, 1.0); // outside: all three corners are here, and nothing is drawn
    }
    out.position_relative = relative_position(object, position_local);
    out.channel = channel;
    return out;
}

@fragment
fn fragment(in: Seen) -> @location(0) vec4f {
    let p = in.position_relative;
    let across = cross(dpdx(p), dpdy(p));
    let face = showing(p);
    let shown = select(face, 0u, face == NO_FACE);
    let clip = clip_in_face(shown, p);
    let uv = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
    let blurred = textureSampleLevel(picture, bilinear, uv, shown, 0.0)[min(in.channel, 3u)];
    // The side that is seen has a normal towards the eye.
    let normal = select(across, -across, dot(across, p) > 0.0);
    let faces_light = dot(normal, ray_at(shown, p)) < 0.0;
    let lit = select(0.0, blurred, faces_light);
    return vec4f(select(lit, 1.0, face == NO_FACE));
}

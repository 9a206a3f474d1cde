// Depth of the casters as one face of a map sees them.
// Host    src/techniques/maps/gpu/pipelines.rs
// Groups  0 casters, 1 first surface (`peel` alone), 2 material (`masked` alone)
// Spaces  in: local; out: clip of the face, reversed depth
#import antumbra::map_caster::clip_position
#import antumbra::surface::{Fragment, base_color, material}

@group(1) @binding(0) var first_depth: texture_depth_2d;

// Share by which a surface must be beyond the first to count as another. Both passes round alike, but not at
// edges.
const BEYOND: f32 = 1e-5;
// Least difference of depth instead of that share where depth is linear (parallel faces). Towards the far end depth is a
// small difference of large terms, and a share of it would be less than their rounding.
const BEYOND_PARALLEL: f32 = 1e-6;

override PARALLEL: bool = false;

@vertex
fn solid(@location(0) position_local: vec3f, @builtin(instance_index) caster: u32) -> @builtin(position) @invariant vec4f {
    return clip_position(position_local, caster);
}

struct Masked {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
}

@vertex
fn masked_vertex(
    @location(0) position_local: vec3f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @builtin(instance_index) caster: u32,
) -> Masked {
    return Masked(clip_position(position_local, caster), uv, color);
}

fn is_hole(in: Masked) -> bool {
    var surface: Fragment;
    surface.uv = in.uv;
    surface.color = in.color;
    return base_color(surface).a < material.alpha_cutoff;
}

fn is_first(position: vec4f) -> bool {
    let first = textureLoad(first_depth, vec2u(position.xy), 0);
    let share = first * (1.0 - BEYOND);
    return position.z >= select(share, min(share, first - BEYOND_PARALLEL), PARALLEL);
}

@fragment
fn masked(in: Masked) {
    if is_hole(in) {
        discard;
    }
}

@fragment
fn peel(@builtin(position) position: vec4f) {
    if is_first(position) {
        discard;
    }
}

@fragment
fn masked_peel(in: Masked) {
    let hole = is_hole(in);
    if hole || is_first(in.position_clip) {
        discard;
    }
}

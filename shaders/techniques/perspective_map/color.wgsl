// Colour of the casters as one face of a map sees them: 1 in the channel of a blurred ground, 0 elsewhere.
// Host    src/techniques/perspective_map/gpu/pipelines.rs
// Groups  0 casters, 1 channels, 2 material (`masked` alone)
// Spaces  in: local; out: clip of the face, reversed depth. The depth test is "equal" for what cast.
// Source: Kozlov 2004, GPU Gems ch. 14, §14.3.2.
#import antumbra::map_caster::clip_position
#import antumbra::surface::{Fragment, base_color, material}

@group(1) @binding(0) var<storage, read> channels: array<u32>;

struct Solid {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) @interpolate(flat) channel: u32,
}

@vertex
fn solid_vertex(@location(0) position_local: vec3f, @builtin(instance_index) caster: u32) -> Solid {
    return Solid(clip_position(position_local, caster), channels[caster]);
}

// Channels from 4 on are those of casters that are no ground.
fn color_of(channel: u32) -> vec4f {
    return select(vec4f(0.0), vec4f(1.0), vec4u(0u, 1u, 2u, 3u) == vec4u(channel));
}

@fragment
fn solid(in: Solid) -> @location(0) vec4f {
    return color_of(in.channel);
}

struct Masked {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) uv: vec4f,
    @location(1) color: vec4f,
    @location(2) @interpolate(flat) channel: u32,
}

@vertex
fn masked_vertex(
    @location(0) position_local: vec3f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @builtin(instance_index) caster: u32,
) -> Masked {
    let clip = clip_position(position_local, caster);
    return Masked(clip, uv, color, channels[caster]);
}

@fragment
fn masked(in: Masked) -> @location(0) vec4f {
    var surface: Fragment;
    surface.uv = in.uv;
    surface.color = in.color;
    if base_color(surface).a < material.alpha_cutoff {
        discard;
    }
    return color_of(in.channel);
}

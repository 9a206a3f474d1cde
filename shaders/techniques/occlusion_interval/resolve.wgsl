// Visibility of a light's receivers, looked up in occlusion interval maps and drawn into the mask.
// Host    src/techniques/occlusion_interval/gpu/recorder.rs
// Twin    techniques::occlusion_interval::intervals::{seen_share, blended}
// Groups  0 view, 1 maps and window of time
// Spaces  in: local position; page: texels
//
// The depth test is `equal`: the surface that a pixel shows writes its visibility, whichever it is.
// Source: Donnelly & Demers 2004, "Generating Soft Shadows Using Occlusion Interval Maps", listing 13-1. Unlike there,
// the four texels around a point are evaluated and then blended.
#import antumbra::view::clip_position

struct Window {                     // mirror: techniques::occlusion_interval::gpu::gpu_types::Window
    spans: vec4f,                   // start and end of the first span, start and end of the second
    inverse_width: f32,
    last_texel: f32,                // of a page, along each side
    shining: f32,                   // share of the window in which the light shines at all
    unused: f32,
}

@group(1) @binding(0) var<uniform> window: Window;
// Four intervals of a texel: the first step of each in the lower byte, the last one in the upper byte.
@group(1) @binding(1) var intervals: texture_2d_array<u32>;

struct VertexIn {
    @location(0) position_local: vec3f,
    @location(1) texel: vec2f,
    @location(2) layers: u32,       // first layer of the page in the lower half, number of its pairs in the upper (none: no page)
    @location(3) object: u32,
}

struct Fragment {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) texel: vec2f,
    @location(1) @interpolate(flat) layers: u32,
}

@vertex
fn vertex(in: VertexIn) -> Fragment {
    var out: Fragment;
    out.position_clip = clip_position(in.object, in.position_local);
    out.texel = in.texel;
    out.layers = in.layers;
    return out;
}

const STEP: f32 = 1.0 / 256.0;

// Lengths of time within one span, of four intervals at once.
fn within(rise: vec4f, fall: vec4f, span: vec2f) -> vec4f {
    return saturate(min(fall, vec4f(span.y)) - max(rise, vec4f(span.x)));
}

// Share of the window in which a texel sees the light.
fn seen_share(texel: vec2i, first: i32, pairs: i32) -> f32 {
    let is_wrapped = window.spans.w > window.spans.z;
    let end = max(window.spans.y, window.spans.w);
    var share = 0.0;
    for (var pair = 0; pair < pairs; pair++) {
        let steps = textureLoad(intervals, texel, first + pair, 0);
        let rise = vec4f(steps & vec4u(0xffu)) * STEP;
        let fall = vec4f(steps >> vec4u(8u)) * STEP + STEP;
        var lit = within(rise, fall, window.spans.xy);
        if is_wrapped {
            lit += within(rise, fall, window.spans.zw);
        }
        share += dot(vec4f(window.inverse_width), lit);
        if fall.w <= rise.w || rise.w >= end {
            break;                  // the last channel is empty, and so are all further pairs; or all of them rise too late
        }
    }
    return min(share, 1.0);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    let first = i32(in.layers & 0xffffu);
    let pairs = i32(in.layers >> 16u);
    if pairs == 0 {
        return vec4f(window.shining);
    }
    let corner = in.texel - 0.5;
    let between = fract(corner);
    let low = vec2i(clamp(floor(corner), vec2f(0.0), vec2f(window.last_texel)));
    let high = vec2i(clamp(floor(corner) + 1.0, vec2f(0.0), vec2f(window.last_texel)));
    let top = mix(
        seen_share(low, first, pairs),
        seen_share(vec2i(high.x, low.y), first, pairs),
        between.x,
    );
    let bottom = mix(
        seen_share(vec2i(low.x, high.y), first, pairs),
        seen_share(high, first, pairs),
        between.x,
    );
    return vec4f(mix(top, bottom, between.y));
}

// The visibility of one light, kept for a host's own shaders: one layer of an array. It is cleared to 0, and written
// where the stencil test finds lit pixels.
// Host    src/render/nodes/keep_visibility.rs
// Groups  3 mask (`masked` alone)
#import antumbra::mask::visibility

@fragment
fn lit() -> @location(0) vec4f {
    return vec4f(1.0);
}

@fragment
fn masked(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return visibility(position.xy);
}

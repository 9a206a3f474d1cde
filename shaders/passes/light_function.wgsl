// Makes of the stencil of a light what its mask would be: 1 where the stencil test passes, over a mask of 0.
// Host    src/render/nodes/light_function.rs
// Groups  none

@fragment
fn lit() -> @location(0) vec4f {
    return vec4f(1.0);
}

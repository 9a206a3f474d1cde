// Clears the stencil inside one light's scissor and marks the pixels inside its depth bounds.
// Host    src/render/nodes/light_begin.rs
// Groups  none: the depth of the quad is its instance index, read as a float's bits
// Writes nothing: the colour target's write mask is empty.
@fragment
fn no_color() -> @location(0) vec4f {
    return vec4f(0.0);
}

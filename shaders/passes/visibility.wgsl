// The visibility that the light pass used, as a picture: the target is cleared to 1, and the shadowed surfaces
// of the light's set I (chosen by the stencil test) write 0.
// Host    src/render/nodes/visibility.rs
// Groups  0 view, 2 material
#import antumbra::surface::{VertexIn, Fragment, surface_vertex}

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    return vec4f(0.0);
}

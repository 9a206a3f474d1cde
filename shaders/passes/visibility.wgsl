// The visibility that the light pass used, as a picture: the target is cleared to 1; of the light's set I, surfaces
// that the stencil test finds shadowed write 0, or all write their mask.
// Host    src/render/nodes/visibility.rs
// Groups  0 view, 2 material; `masked` also 3 mask
#import antumbra::surface::{VertexIn, Fragment, surface_vertex}
#import antumbra::mask::visibility

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    return vec4f(0.0);
}

// The front layer lies before what was there.
@fragment
fn lit(in: Fragment) -> @location(0) vec4f {
    return vec4f(1.0);
}

@fragment
fn masked(in: Fragment) -> @location(0) vec4f {
    return vec4f(visibility(in.position_clip.xy).a);
}

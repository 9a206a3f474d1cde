// The visibility that the light pass used, as a picture. The target is cleared to 1. Surfaces of the light's
// set I then write 0 where the stencil test finds them shadowed, or their mask.
// Host    src/render/nodes/visibility.rs
// Groups  0 view, 2 material; `masked` and `darker` also 3 mask
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

// Resets visibility to 1 for the front layer, which is in front of the surface that was written before.
@fragment
fn lit(in: Fragment) -> @location(0) vec4f {
    return vec4f(1.0);
}

@fragment
fn masked(in: Fragment) -> @location(0) vec4f {
    return vec4f(visibility(in.position_clip.xy).a);
}

// All of a companion's mask, by which it darkens the mask of its light.
@fragment
fn darker(in: Fragment) -> @location(0) vec4f {
    return visibility(in.position_clip.xy);
}

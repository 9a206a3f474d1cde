// Ambient and emissive light, and the depth that all later passes test against.
// Host    src/render/nodes/ambient.rs
// Groups  0 view, 2 material
#import antumbra::view::view
#import antumbra::surface::{VertexIn, Fragment, material, surface_vertex, base_color, emissive, ambient_occlusion}

// Blended surfaces write colour times alpha.
override BLENDED: bool = false;

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

// Writes depth alone, for the nearest of blended surfaces; where one is wholly transparent it is not there.
@fragment
fn depth_of_blended(in: Fragment) {
    if base_color(in).a < 1.0 / 256.0 {
        discard;
    }
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    let color = base_color(in);
    let glow = emissive(in);
    let occlusion = ambient_occlusion(in);
    if color.a < material.alpha_cutoff {
        discard;
    }
    let arriving = select(view.ambient.rgb * occlusion, vec3f(1.0), material.unlit == 1u);
    let radiance = color.rgb * arriving;
    let alpha = select(1.0, color.a, BLENDED);
    return vec4f(radiance * alpha + glow, alpha);
}

// Ambient and emissive light, and the depth against which all later passes test.
// Host    src/render/nodes/ambient.rs
// Groups  0 view, 2 material
#import antumbra::view::{view, to_eye}
#import antumbra::surface::{VertexIn, Fragment, material, surface_vertex, base_color, emissive, ambient_occlusion, clearcoat, smooth_normal}
#import antumbra::brdf::coat_share

// Blended surfaces write colour times alpha.
override BLENDED: bool = false;
// The material has a clearcoat.
override COATED: bool = false;

@vertex
fn vertex(in: VertexIn) -> Fragment {
    return surface_vertex(in);
}

// Writes depth only, for the nearest blended surface. A fragment that is wholly transparent writes none.
@fragment
fn depth_of_blended(in: Fragment) {
    if base_color(in).a < 1.0 / 256.0 {
        discard;
    }
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    let color = base_color(in);
    var glow = emissive(in);
    let occlusion = ambient_occlusion(in);
    var share = 0.0;
    if COATED {
        share = coat_share(clearcoat(in).x, smooth_normal(in, true), to_eye(in.position_relative));
    }
    if color.a < material.alpha_cutoff {
        discard;
    }
    let arriving = select(view.ambient.rgb * occlusion, vec3f(1.0), material.unlit == 1u);
    var radiance = color.rgb * arriving;
    if COATED {
        // Ambient light is equal from all sides, so the coat mirrors as much of it as it keeps from the base.
        radiance = mix(radiance, arriving, share);
        glow *= 1.0 - share;
    }
    let alpha = select(1.0, color.a, BLENDED);
    return vec4f((radiance + glow) * alpha, alpha);
}

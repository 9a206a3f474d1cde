// Metallic-roughness reflection: GGX specular over Lambert diffuse.
#define_import_path antumbra::brdf

#import antumbra::conventions::PI

// Distribution of microfacet normals. `alpha` is the squared perceptual roughness.
// Source: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces".
fn ggx_distribution(n_dot_h: f32, alpha: f32) -> f32 {
    let a_sq = alpha * alpha;
    let d = n_dot_h * n_dot_h * (a_sq - 1.0) + 1.0;
    return a_sq / (PI * d * d);
}

// Height-correlated masking and shadowing, divided by 4 (n·l)(n·v).
// Source: Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
fn ggx_visibility(n_dot_l: f32, n_dot_v: f32, alpha: f32) -> f32 {
    let a_sq = alpha * alpha;
    let view = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a_sq) + a_sq);
    let light = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a_sq) + a_sq);
    return 0.5 / max(view + light, 1e-7);
}

// Source: Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
fn schlick_fresnel(f0: vec3f, v_dot_h: f32) -> vec3f {
    return f0 + (1.0 - f0) * pow(1.0 - v_dot_h, 5.0);
}

// Radiance per irradiance, times n·l. All vectors unit, `l` towards the light, `v` towards the eye.
// The model of glTF 2.0 appendix B.
fn reflect(base_color: vec3f, metallic: f32, roughness: f32, n: vec3f, v: vec3f, l: vec3f) -> vec3f {
    let n_dot_l = dot(n, l);
    if n_dot_l <= 0.0 {
        return vec3f(0.0);
    }
    let n_dot_v = max(abs(dot(n, v)), 1e-4);
    let h = (v + l) * inverseSqrt(max(dot(v + l, v + l), 1e-12)); // 0 where the eye looks along the light
    let n_dot_h = clamp(dot(n, h), 0.0, 1.0);
    let v_dot_h = clamp(dot(v, h), 0.0, 1.0);
    let alpha = max(roughness * roughness, 1e-3); // below, the highlight of a point light is under a pixel
    let fresnel = schlick_fresnel(mix(vec3f(0.04), base_color, metallic), v_dot_h);
    let diffuse = (1.0 - fresnel) * (1.0 - metallic) * base_color / PI;
    let specular = fresnel * ggx_distribution(n_dot_h, alpha) * ggx_visibility(n_dot_l, n_dot_v, alpha);
    return (diffuse + specular) * n_dot_l;
}

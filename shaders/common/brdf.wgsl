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

// Radiance that a surface reflects, by kind of reflection.
struct Reflected {
    diffuse: vec3f,
    specular: vec3f,
}

// Radiance that a surface reflects. All vectors are unit vectors; `v` points towards the eye.
// Diffuse light comes from the whole light, with `irradiance` on the surface and `l` towards the light's
// centre.
// Specular light comes from the direction `highlight`, with `highlight_irradiance` on a plane that faces it.
// `radius` is the light's radius over its distance, 0 for points.
//
// An area light widens the lobe and must not brighten it: the factor (α / α')² preserves its energy.
// The model is that of glTF 2.0 appendix B. Source of the factor: Karis 2013, "Real Shading in Unreal Engine
// 4".
fn reflected_parts(
    base_color: vec3f,
    metallic: f32,
    roughness: f32,
    n: vec3f,
    v: vec3f,
    l: vec3f,
    irradiance: vec3f,
    highlight: vec3f,
    highlight_irradiance: vec3f,
    radius: f32,
) -> Reflected {
    let n_dot_v = max(abs(dot(n, v)), 1e-4);
    let h = (v + highlight) * inverseSqrt(max(dot(v + highlight, v + highlight), 1e-12)); // 0 where the eye looks along it
    let n_dot_h = clamp(dot(n, h), 0.0, 1.0);
    let v_dot_h = clamp(dot(v, h), 0.0, 1.0);
    let n_dot_l = max(dot(n, highlight), 0.0);
    let alpha = max(roughness * roughness, 1e-3); // below it, a point light's highlight is under a pixel
    let widened = clamp(alpha + 0.5 * radius, 0.0, 1.0);
    let kept = alpha / widened;
    let f0 = mix(vec3f(0.04), base_color, metallic);
    let fresnel = schlick_fresnel(f0, v_dot_h);
    let middle = (v + l) * inverseSqrt(max(dot(v + l, v + l), 1e-12));
    let entering = 1.0 - schlick_fresnel(f0, clamp(dot(v, middle), 0.0, 1.0));
    let diffuse = entering * (1.0 - metallic) * base_color / PI;
    let specular = fresnel * ggx_distribution(n_dot_h, alpha) * ggx_visibility(n_dot_l, n_dot_v, alpha) * (kept * kept);
    return Reflected(diffuse * irradiance, specular * highlight_irradiance * n_dot_l);
}

// The sum of both kinds of reflection.
fn reflected(
    base_color: vec3f,
    metallic: f32,
    roughness: f32,
    n: vec3f,
    v: vec3f,
    l: vec3f,
    irradiance: vec3f,
    highlight: vec3f,
    highlight_irradiance: vec3f,
    radius: f32,
) -> vec3f {
    let parts = reflected_parts(base_color, metallic, roughness, n, v, l, irradiance, highlight, highlight_irradiance, radius);
    return parts.diffuse + parts.specular;
}

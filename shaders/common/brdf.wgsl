// Metallic-roughness reflection: GGX specular over Lambert diffuse; and a clearcoat over both.
// Twin    tests/gpu/clearcoat/twin.rs
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

// The angles of a highlight on a surface with normal `n`, by their cosines.
struct Angles {
    n_dot_v: f32,
    n_dot_h: f32,
    v_dot_h: f32,
    n_dot_l: f32,
}

fn angles(n: vec3f, v: vec3f, highlight: vec3f) -> Angles {
    let n_dot_v = max(abs(dot(n, v)), 1e-4);
    let h = (v + highlight) * inverseSqrt(max(dot(v + highlight, v + highlight), 1e-12)); // 0 where the eye looks along it
    let n_dot_h = clamp(dot(n, h), 0.0, 1.0);
    let v_dot_h = clamp(dot(v, h), 0.0, 1.0);
    let n_dot_l = max(dot(n, highlight), 0.0);
    return Angles(n_dot_v, n_dot_h, v_dot_h, n_dot_l);
}

// Squared perceptual roughness.
fn alpha_of(roughness: f32) -> f32 {
    return max(roughness * roughness, 1e-3); // below it, a point light's highlight is under a pixel
}

// An area light widens the lobe and must not brighten it: this factor, squared, preserves its energy.
// Source: Karis 2013, "Real Shading in Unreal Engine 4".
fn kept_of(alpha: f32, radius: f32) -> f32 {
    let widened = clamp(alpha + 0.5 * radius, 0.0, 1.0);
    return alpha / widened;
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
// The model is that of glTF 2.0 appendix B.
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
    let at = angles(n, v, highlight);
    let alpha = alpha_of(roughness);
    let kept = kept_of(alpha, radius);
    let f0 = mix(vec3f(0.04), base_color, metallic);
    let fresnel = schlick_fresnel(f0, at.v_dot_h);
    let middle = (v + l) * inverseSqrt(max(dot(v + l, v + l), 1e-12));
    let entering = 1.0 - schlick_fresnel(f0, clamp(dot(v, middle), 0.0, 1.0));
    let diffuse = entering * (1.0 - metallic) * base_color / PI;
    let specular = fresnel * ggx_distribution(at.n_dot_h, alpha) * ggx_visibility(at.n_dot_l, at.n_dot_v, alpha) * (kept * kept);
    return Reflected(diffuse * irradiance, specular * highlight_irradiance * at.n_dot_l);
}

// Share of the light that a clearcoat reflects instead of passing it to the base below; `n` is the coat's normal. The
// coat's index of refraction is 1.5.
// Source: Khronos, KHR_materials_clearcoat: the weight of `fresnel_coat`.
fn coat_share(clearcoat: f32, n: vec3f, v: vec3f) -> f32 {
    return clearcoat * schlick_fresnel(vec3f(0.04), clamp(abs(dot(n, v)), 0.0, 1.0)).x;
}

// Radiance of the base `base`, seen through a clearcoat that reflects `share` of the light. Parameters are those of
// `reflected_parts`; `n`, `roughness` and `highlight` are the coat's.
// Source: Khronos, KHR_materials_clearcoat: `mix(base, layer, share)`, the layer being a GGX lobe without Fresnel's
// factor. What is not in it: the base is not dimmed a second time by the light's own way through the coat.
fn coated(
    base: Reflected,
    share: f32,
    roughness: f32,
    n: vec3f,
    v: vec3f,
    highlight: vec3f,
    highlight_irradiance: vec3f,
    radius: f32,
) -> Reflected {
    let at = angles(n, v, highlight);
    let alpha = alpha_of(roughness);
    let kept = kept_of(alpha, radius);
    let lobe = ggx_distribution(at.n_dot_h, alpha) * ggx_visibility(at.n_dot_l, at.n_dot_v, alpha) * (kept * kept);
    let layer = lobe * highlight_irradiance * at.n_dot_l;
    return Reflected(base.diffuse * (1.0 - share), mix(base.specular, layer, share));
}

// The visibility of one light, kept for a host's own shaders: one layer of an array. It is cleared to 0, and written
// where the stencil test finds lit pixels.
// Host    src/render/nodes/keep_visibility.rs
// Groups  3 mask (`masked`); 1 light, 3 mask and factors (`tinted`)
#import antumbra::mask::visibility
#import antumbra::factors::factors
#import antumbra::light::light

@fragment
fn lit() -> @location(0) vec4f {
    return vec4f(1.0);
}

@fragment
fn masked(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return visibility(position.xy);
}

// The share that diffuse light has of the light's own colour, where shadows have a colour or let light pass; as `lit` in
// `light_modelled.wgsl`. A host's shader multiplies all of the light by it.
@fragment
fn tinted(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let emission = light.emission.rgb;
    let passing = 1.0 - light.weights.w * (1.0 - visibility(position.xy).rgb);
    let mixed = mix(light.shadow_emission.rgb, emission, passing);
    let share = select(vec3f(1.0), mixed / max(emission, vec3f(1e-30)), emission > vec3f(0.0));
    return vec4f(min(share, vec3f(1.0)) * factors(position.xy), 1.0);
}

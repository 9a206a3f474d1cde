// The radiance that one light adds to surfaces, where ambient, diffuse and specular light have weights, or where
// shadows have a colour. It does the work of `light_accumulate` for such lights and objects.
// Host    src/render/nodes/light_accumulate.rs
// Groups  0 view, 1 light, 2 material; `masked` and `tinted` also 3 mask, `behind_front` 3 front depth
#import antumbra::surface::{VertexIn, Fragment, surface_vertex, base_color, metallic_roughness, shading_normal}
#import antumbra::view::{objects, to_eye}
#import antumbra::light::{light, incidence_of}
#import antumbra::light_shape::{light_position, shape_factor}
#import antumbra::brdf::reflected_parts
#import antumbra::coat::with_coat
#import antumbra::conventions::{PI, RADIANCE_MAX}
#import antumbra::mask::visibility
#import antumbra::factors::factors
#import antumbra::front::is_front

override BLENDED: bool = false;
// The material has a clearcoat.
override COATED: bool = false;

struct Weighted {
    @builtin(position) @invariant position_clip: vec4f,
    @location(0) position_relative: vec3f,
    @location(1) normal_relative: vec3f,
    @location(2) tangent_relative: vec4f,
    @location(3) uv: vec4f,
    @location(4) color: vec4f,
    @location(5) @interpolate(flat) weights: vec3f,
}

@vertex
fn vertex(in: VertexIn) -> Weighted {
    let surface = surface_vertex(in);
    return Weighted(
        surface.position_clip,
        surface.position_relative,
        surface.normal_relative,
        surface.tangent_relative,
        surface.uv,
        surface.color,
        objects[in.object].handedness.yzw,
    );
}

// Radiance that the light adds to a surface. `seen` is the share of the light that the surface sees, by colour.
// Ambient light has no shadows. Diffuse light has the colour of the light mixed with that of its shadow. Highlights
// have the light's colour, scaled by what is seen, so they are off in the shadow.
// Source: Pellacini & Vidimce 2004, "Cinematic Lighting", GPU Gems ch. 10, listing 10-2. The listing also mixes the
// colour of highlights, which counts a penumbra twice; where nothing or all is seen, both agree.
fn lit(in: Weighted, front_facing: bool, seen: vec3f) -> vec4f {
    let surface = Fragment(
        in.position_clip,
        in.position_relative,
        in.normal_relative,
        in.tangent_relative,
        in.uv,
        in.color,
    );
    let color = base_color(surface);
    let mr = metallic_roughness(surface);
    let normal = shading_normal(surface, front_facing);
    let towards_eye = to_eye(in.position_relative);
    // The answer to white light of 1 candela or lux: a shadow may have colours that the light lacks.
    let arriving = incidence_of(vec3f(1.0), in.position_relative, normal, towards_eye);
    var answer = reflected_parts(
        color.rgb,
        mr.x,
        mr.y,
        normal,
        towards_eye,
        arriving.towards,
        arriving.irradiance,
        arriving.highlight,
        arriving.highlight_irradiance,
        arriving.radius,
    );
    var share = 0.0;
    if COATED {
        let covered = with_coat(answer, surface, front_facing, towards_eye, arriving);
        answer = covered.parts;
        share = covered.share;
    }
    let emission = light.emission.rgb;
    let passing = 1.0 - light.weights.w * (1.0 - seen);
    let mixed = mix(light.shadow_emission.rgb, emission, passing);
    let albedo = color.rgb * (1.0 - mr.x) * (1.0 - share);
    let ambient = albedo / PI * arriving.highlight_irradiance * emission;
    let weights = light.weights.xyz * in.weights;
    let radiance = ambient * weights.x + answer.diffuse * mixed * weights.y + answer.specular * emission * seen * weights.z;
    let alpha = select(1.0, color.a, BLENDED);
    let added = min(radiance, vec3f(RADIANCE_MAX)); // infinity would spread
    return vec4f(added * alpha, 0.0);
}

// The surface sees the whole light, or the stencil test has decided that it does.
@fragment
fn fragment(in: Weighted, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    return lit(in, front_facing, vec3f(1.0));
}

// A mask scales the whole light: what it lets pass has one colour, and its shadow is black.
@fragment
fn masked(in: Weighted, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    return lit(in, front_facing, vec3f(1.0)) * vec4f(visibility(in.position_clip.xy).rgb, 1.0);
}

// The mask holds what the surface sees, and a second one the factors of light functions.
@fragment
fn tinted(in: Weighted, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let radiance = lit(in, front_facing, visibility(in.position_clip.xy).rgb);
    return radiance * vec4f(factors(in.position_clip.xy), 1.0);
}

// A surface that shows no shadows, of a light that functions may scale.
@fragment
fn tinted_unshadowed(in: Weighted, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    return lit(in, front_facing, vec3f(1.0)) * vec4f(factors(in.position_clip.xy), 1.0);
}

// A blended surface has no mask. The light's shape is evaluated here.
@fragment
fn blended(in: Weighted, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let shape = shape_factor(light_position(in.position_relative, light.shape), light.shape);
    return lit(in, front_facing, vec3f(1.0)) * vec4f(vec3f(shape), 1.0);
}

// Lights surfaces behind the nearest blended surface. That surface is lit in a pass of its own.
@fragment
fn behind_front(in: Weighted, @builtin(front_facing) front_facing: bool) -> @location(0) vec4f {
    let shape = shape_factor(light_position(in.position_relative, light.shape), light.shape);
    let radiance = lit(in, front_facing, vec3f(1.0)) * vec4f(vec3f(shape), 1.0);
    if is_front(in.position_clip) {
        discard;
    }
    return radiance;
}

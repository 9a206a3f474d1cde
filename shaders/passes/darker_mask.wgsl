// Darkens the mask of a light by that of its companion: the blending keeps the lesser of both.
// Host    src/render/nodes/darker_mask.rs
// Groups  3 the companion's mask
#import antumbra::mask::visibility

@fragment
fn darker(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return visibility(position.xy);
}

// The contents of a texel of the smoothie buffer, and the lookup by a receiver.
// Twin    techniques::smoothie::shade, functions of the same names
//
// A smoothie with alpha a at distance b from the light leaves a receiver at distance r the visibility
// a' = a / (1 - b / r). Its reciprocal is a straight line in 1 / r; for a directional light, a straight line in
// r up to the drop at which the smoothie is at its softest. Two points of that line are stored, so that a
// buffer of minima is right for many smoothies at once:
// - x: least a' at the nearest still caster behind, the receiver that matters most;
// - y: minus the farthest distance, in front of that caster, at which any smoothie begins to darken.
// One smoothie is reproduced exactly for every receiver, and any number of them at the caster. A receiver in
// front of the caster and behind several smoothies may be darker than the darkest of them makes it.
// Source: Chan & Durand 2003, "Rendering Fake Soft Shadows with Smoothies", for a' and for the minimum. The two
// points instead of alpha and depth are ours: the minimum of either alone belongs to another smoothie.
#define_import_path antumbra::smoothie

// Content of a texel that no smoothie darkens.
const CLEAR: vec2f = vec2f(1.0, 0.0);

// Least visibility that is stored, so that its reciprocal stays in range.
const LEAST: f32 = 1e-4;            // mirror: techniques::smoothie::shade::LEAST

// Largest distance that is stored: half floats end at 65504.
const FARTHEST: f32 = 60000.0;      // mirror: techniques::smoothie::shade::FARTHEST

// Returns the texel that a smoothie draws; CLEAR if it does not darken the caster behind. `behind` is the reciprocal
// of the caster's distance, 0 if there is none, and `scale` scales reciprocals of distances.
fn resolve_from_point(alpha: f32, along: f32, behind: f32, scale: f32) -> vec2f {
    let share = 1.0 - along * behind;
    let begins = ((1.0 - alpha) / along - behind) * scale;
    let stored = vec2f(max(alpha / max(share, 1e-6), LEAST), -min(begins, FARTHEST));
    return select(CLEAR, stored, share > 0.0 && begins > 0.0);
}

// Returns the texel that a smoothie of a directional light draws. `behind` is the caster's distance.
fn resolve_parallel(alpha: f32, along: f32, behind: f32, drop: f32) -> vec2f {
    let share = (behind - along) / drop;
    let begins = share - alpha;
    let stored = vec2f(max(alpha / clamp(share, 1e-6, 1.0), LEAST), -min(begins, FARTHEST));
    return select(CLEAR, stored, share > 0.0 && begins > 0.0);
}

// Visibility of a receiver from what a texel holds. `receiver` is the reciprocal of its distance.
fn visibility_from_point(stored: vec2f, receiver: f32, behind: f32, scale: f32) -> f32 {
    let share = min(1.0 - (receiver - behind) * scale / max(-stored.y, 1e-7), 1.0);
    let inverse = 1.0 + (1.0 / max(stored.x, LEAST) - 1.0) * share;
    return select(1.0, 1.0 / max(inverse, 1.0), stored.y < 0.0);
}

// Returns the visibility of a receiver under a directional light. `receiver` is the receiver's distance.
fn visibility_parallel(stored: vec2f, receiver: f32, behind: f32, drop: f32) -> f32 {
    let softest = 1.0 / max(stored.x, LEAST);
    let begins = max(-stored.y, 1e-7);
    let beyond = min(begins - (behind - receiver) / drop, begins);
    let slope = max(softest, (softest - 1.0) / begins);
    return select(1.0, 1.0 / clamp(1.0 + beyond * slope, 1.0, softest), stored.y < 0.0);
}

//! The contents of a texel of the smoothie buffer, and the lookup by a receiver: twin of the functions of the same names in
//! `shaders/common/smoothie.wgsl`, which says why these two values are stored.
//!
//! Source: Chan & Durand 2003, "Rendering Fake Soft Shadows with Smoothies": α′ = α / (1 − b/r), and the minimum.

use glam::Vec2;

/// Content of a texel that no smoothie darkens.
pub const CLEAR: Vec2 = Vec2::new(1.0, 0.0);

/// Least visibility that is stored, so that its reciprocal stays in range.
pub const LEAST: f32 = 1e-4;

/// Largest distance that is stored: half floats end at 65504.
pub const FARTHEST: f32 = 60_000.0;

/// Returns what a smoothie leaves at a texel of a light at a position. `behind` is the reciprocal of the distance of
/// the still caster behind the smoothie, 0 if there is none, and `scale` scales reciprocals of distances.
pub fn resolve_from_point(alpha: f32, along: f32, behind: f32, scale: f32) -> Vec2 {
    let share = 1.0 - along * behind;
    let begins = ((1.0 - alpha) / along - behind) * scale;
    if share > 0.0 && begins > 0.0 {
        Vec2::new((alpha / share.max(1e-6)).max(LEAST), -begins.min(FARTHEST))
    } else {
        CLEAR
    }
}

/// Returns what a smoothie leaves at a texel of a directional light. `behind` is the distance of the still caster
/// behind the smoothie.
pub fn resolve_parallel(alpha: f32, along: f32, behind: f32, drop: f32) -> Vec2 {
    let share = (behind - along) / drop;
    let begins = share - alpha;
    if share > 0.0 && begins > 0.0 {
        Vec2::new((alpha / share.clamp(1e-6, 1.0)).max(LEAST), -begins.min(FARTHEST))
    } else {
        CLEAR
    }
}

/// Returns the visibility of a receiver of a light at a position. `receiver` is the reciprocal of its distance.
pub fn visibility_from_point(stored: Vec2, receiver: f32, behind: f32, scale: f32) -> f32 {
    if stored.y >= 0.0 {
        return 1.0;
    }
    let share = (1.0 - (receiver - behind) * scale / (-stored.y).max(1e-7)).min(1.0);
    let inverse = 1.0 + (stored.x.max(LEAST).recip() - 1.0) * share;
    inverse.max(1.0).recip()
}

/// Returns the visibility of a receiver of a directional light. `receiver` is its distance.
pub fn visibility_parallel(stored: Vec2, receiver: f32, behind: f32, drop: f32) -> f32 {
    if stored.y >= 0.0 {
        return 1.0;
    }
    let softest = stored.x.max(LEAST).recip();
    let begins = (-stored.y).max(1e-7);
    let beyond = (begins - (behind - receiver) / drop).min(begins);
    let slope = softest.max((softest - 1.0) / begins);
    (1.0 + beyond * slope).clamp(1.0, softest.max(1.0)).recip()
}

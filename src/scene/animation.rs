//! Animation clips: keyframed translations, rotations, scales and morph weights of a scene's nodes.
//!
//! Interpolation follows glTF 2.0, appendix C.

use std::ops::{Add, Mul};
use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{DVec4, Quat, Vec3, Vec4};

use super::MorphWeights;

/// The clips of a spawned scene. This component is on the scene's root entity, beside [`SceneNodes`].
#[derive(Component, Clone, Debug)]
pub struct AnimationClips(pub Arc<[AnimationClip]>);

/// The entities of a spawned scene, by node index. This component is on the scene's root entity.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct SceneNodes {
    /// Entity of each node. `None` for a node that belongs to another scene.
    pub nodes: Vec<Option<Entity>>,
    /// Entity that has the mesh of each node. `None` for a mesh that is drawn by instances. It is the node's own entity, except that a skinned mesh has a
    /// separate one.
    pub meshes: Vec<Option<Entity>>,
}

impl AsRef<Self> for SceneNodes {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// A named set of animation channels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnimationClip {
    /// Name of the clip, used in messages and menus.
    pub name: String,
    /// The animated properties.
    pub channels: Vec<Channel>,
}

/// One animated property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Index of the node in [`SceneNodes`].
    pub node: usize,
    /// Interpolation between the keys.
    pub interpolation: Interpolation,
    /// Times of the keys, seconds, ascending.
    pub times: Vec<f32>,
    /// Values at the keys.
    pub values: ChannelValues,
}

/// How the value between two keys is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// The value stays that of the previous key.
    Step,
    /// The value runs along a straight line; for rotations along the shorter great arc.
    #[default]
    Linear,
    /// The value runs along a cubic Hermite spline. Each key has three values: incoming tangent, value,
    /// outgoing tangent.
    CubicSpline,
}

/// Values at the keys of a channel: one for each key, or three with [`Interpolation::CubicSpline`].
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelValues {
    /// Translations, metres, relative to the parent.
    Translation(Vec<Vec3>),
    /// Rotations as unit quaternions. Spline tangents need not have unit length.
    Rotation(Vec<Quat>),
    /// Scale factors along the axes.
    Scale(Vec<Vec3>),
    /// Weights of the morph targets.
    Weights {
        /// Number of morph targets, and so of weights in one value.
        target_count: usize,
        /// The weights: all of the first value, then all of the second, and so on.
        values: Vec<f32>,
    },
}

impl AnimationClip {
    /// Time of the last key of any channel, seconds; 0 without keys.
    pub fn duration(&self) -> f32 {
        let ends = self.channels.iter().filter_map(|channel| channel.times.last());
        ends.copied().fold(0.0, f32::max)
    }
}

/// The place of a time among the keys.
#[derive(Clone, Copy)]
enum Segment {
    At(usize),
    After { key: usize, share: f32, seconds: f32 },
}

impl Channel {
    /// Checks that the values are finite and that there are as many as the keys need.
    ///
    /// # Errors
    /// A description of the fault, for a message.
    pub fn check(&self) -> Result<(), String> {
        let (count, is_finite) = match &self.values {
            ChannelValues::Translation(values) | ChannelValues::Scale(values) => {
                (values.len(), values.iter().all(|value| value.is_finite()))
            }
            ChannelValues::Rotation(values) => (values.len(), values.iter().all(|value| value.is_finite())),
            ChannelValues::Weights { values, .. } => {
                (values.len(), values.iter().all(|value| value.is_finite()))
            }
        };
        let per_key = if self.interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        };
        let width = match self.values {
            ChannelValues::Weights { target_count, .. } => target_count,
            _ => 1,
        };
        let needed = self.times.len().saturating_mul(per_key).saturating_mul(width);
        if count != needed {
            return Err(format!(
                "it has {count} values, its {} keys need {needed}",
                self.times.len()
            ));
        }
        if is_finite {
            Ok(())
        } else {
            Err("its values are not finite".to_owned())
        }
    }

    /// The segment at a time, clamped to the first and the last key. `None` without keys.
    fn segment(&self, seconds: f32) -> Option<Segment> {
        let after = self.times.partition_point(|&time| time <= seconds);
        let Some(key) = after.checked_sub(1) else {
            return (!self.times.is_empty()).then_some(Segment::At(0));
        };
        let start = self.times[key];
        Some(match self.times.get(after) {
            Some(&end) => Segment::After {
                key,
                share: (seconds - start) / (end - start),
                seconds: end - start,
            },
            None => Segment::At(key),
        })
    }

    /// The value within a segment. `value_at` returns the n-th of the channel's values, `between`
    /// interpolates linearly.
    fn sample<T>(
        &self,
        segment: Segment,
        value_at: impl Fn(usize) -> Option<T>,
        between: impl Fn(T, T, f32) -> T,
    ) -> Option<T>
    where
        T: Copy + Add<Output = T> + Mul<f32, Output = T>,
    {
        let is_spline = self.interpolation == Interpolation::CubicSpline;
        let key_value = |key: usize| value_at(if is_spline { key * 3 + 1 } else { key });
        let (key, u, seconds) = match segment {
            Segment::At(key) => return key_value(key),
            Segment::After { key, share, seconds } => (key, share, seconds),
        };
        let (start, end) = (key_value(key)?, key_value(key + 1)?);
        Some(match self.interpolation {
            Interpolation::Step => start,
            Interpolation::Linear => between(start, end, u),
            Interpolation::CubicSpline => {
                let leaving = value_at(key * 3 + 2)? * seconds;
                let arriving = value_at(key * 3 + 3)? * seconds;
                let (u2, u3) = (u * u, u * u * u);
                start * (2.0 * u3 - 3.0 * u2 + 1.0)
                    + leaving * (u3 - 2.0 * u2 + u)
                    + end * (3.0 * u2 - 2.0 * u3)
                    + arriving * (u3 - u2)
            }
        })
    }
}

/// Poses a scene: sets its `Transform`s and [`MorphWeights`] to the clip at a time, which is clamped to the
/// range of each channel. Values that do not differ are not written, so change detection sees only what
/// moved.
///
/// Channels of nodes that the scene does not have, or whose entity is gone, are skipped.
pub fn apply_animation(
    world: &mut World,
    scene: &impl AsRef<SceneNodes>,
    clip: &AnimationClip,
    seconds: f32,
) {
    let scene = scene.as_ref();
    for channel in &clip.channels {
        let Some(segment) = channel.segment(seconds) else {
            continue;
        };
        let list = match channel.values {
            ChannelValues::Weights { .. } => &scene.meshes,
            _ => &scene.nodes,
        };
        let Some(entity) = list.get(channel.node).copied().flatten() else {
            continue;
        };
        match &channel.values {
            ChannelValues::Weights { target_count, values } => {
                if let Some(weights) = world.get_mut::<MorphWeights>(entity) {
                    set_weights(weights, channel, segment, *target_count, values);
                }
            }
            _ => {
                if let Some(transform) = world.get_mut::<Transform>(entity) {
                    set_transform(transform, channel, segment);
                }
            }
        }
    }
}

fn set_transform(mut transform: Mut<'_, Transform>, channel: &Channel, segment: Segment) {
    let mut posed = *transform;
    let vector = |values: &[Vec3], rest: Vec3| {
        let value = channel.sample(segment, |i| values.get(i).copied(), Vec3::lerp);
        value.filter(|value| value.is_finite()).unwrap_or(rest)
    };
    match &channel.values {
        ChannelValues::Translation(values) => posed.translation = vector(values, posed.translation),
        ChannelValues::Scale(values) => posed.scale = vector(values, posed.scale),
        ChannelValues::Rotation(values) => {
            let value = channel.sample(segment, |i| values.get(i).map(|&q| Vec4::from(q)), slerp);
            // A spline leaves the unit sphere, and exporters round, so the quaternion is normalised.
            let unit = value
                .map(|value| Quat::from_vec4(value).normalize())
                .filter(|value| value.is_finite());
            posed.rotation = unit.unwrap_or(posed.rotation);
        }
        ChannelValues::Weights { .. } => {}
    }
    transform.set_if_neq(posed);
}

fn set_weights(
    mut weights: Mut<'_, MorphWeights>,
    channel: &Channel,
    segment: Segment,
    target_count: usize,
    values: &[f32],
) {
    for target in 0..target_count.min(weights.0.len()) {
        let value_at = |i: usize| values.get(i * target_count + target).copied();
        let value = channel.sample(segment, value_at, |a, b, u| a + (b - a) * u);
        if let Some(value) = value.filter(|value| value.is_finite() && *value != weights.0[target]) {
            weights.0[target] = value;
        }
    }
}

/// Spherical interpolation along the shorter great arc. It is computed in `f64` with an exact arc cosine,
/// because glam's `slerp` approximates it.
///
/// Source: Shoemake 1985, "Animating Rotation with Quaternion Curves".
fn slerp(start: Vec4, end: Vec4, share: f32) -> Vec4 {
    let (start, mut end, share): (DVec4, DVec4, f64) = (start.as_dvec4(), end.as_dvec4(), share.into());
    let mut cosine = start.dot(end);
    if cosine < 0.0 {
        end = -end;
        cosine = -cosine;
    }
    let angle = cosine.min(1.0).acos();
    // Below this angle the sines cancel, and the line differs from the arc by less than an `f32` can hold.
    if angle < 1e-6 {
        return start.lerp(end, share).as_vec4();
    }
    let mixed = start * ((1.0 - share) * angle).sin() + end * (share * angle).sin();
    (mixed / angle.sin()).as_vec4()
}

//! Animation clips. A channel is either read whole, or left out and reported.

use glam::{Quat, Vec3};
use gltf::json::animation::{
    Animation, Channel as JsonChannel, Interpolation as JsonInterpolation, Property,
};
use gltf::json::validation::Checked;

use super::accessors::Accessors;
use super::nodes::GltfNode;
use super::{Element, GltfError, Report, SkipKind};
use crate::scene::animation::{AnimationClip, Channel, ChannelValues, Interpolation};

/// All clips of the file. A channel whose keys do not fit is reported and left out.
///
/// # Errors
/// An index that is out of range, or a broken accessor.
pub(super) fn load(
    accessors: &Accessors<'_>,
    nodes: &[GltfNode],
    report: &mut Report,
) -> Result<Vec<AnimationClip>, GltfError> {
    let mut clips = Vec::with_capacity(accessors.root.animations.len());
    for (index, animation) in accessors.root.animations.iter().enumerate() {
        let mut channels = Vec::with_capacity(animation.channels.len());
        for (channel_index, channel) in animation.channels.iter().enumerate() {
            let element = Element::Channel {
                animation: index,
                channel: channel_index,
            };
            match load_channel(accessors, nodes, element, animation, channel)? {
                Ok(channel) => channels.push(channel),
                Err(reason) => report.add(SkipKind::AnimationChannel, element, 1, reason),
            }
        }
        let name = animation
            .name
            .clone()
            .unwrap_or_else(|| Element::Animation(index).to_string());
        clips.push(AnimationClip { name, channels });
    }
    Ok(clips)
}

fn load_channel(
    accessors: &Accessors<'_>,
    nodes: &[GltfNode],
    element: Element,
    animation: &Animation,
    channel: &JsonChannel,
) -> Result<Result<Channel, String>, GltfError> {
    let sampler = accessors.get(&animation.samplers, channel.sampler, element, "sampler")?;
    let node = accessors.get(nodes, channel.target.node, element, "node")?;
    for accessor in [sampler.input, sampler.output] {
        accessors.get(&accessors.root.accessors, accessor, element, "accessor")?;
    }
    let (Checked::Valid(interpolation), Checked::Valid(property)) =
        (&sampler.interpolation, &channel.target.path)
    else {
        return Ok(Err("its interpolation or target path is unknown".to_owned()));
    };
    let interpolation = match interpolation {
        JsonInterpolation::Step => Interpolation::Step,
        JsonInterpolation::Linear => Interpolation::Linear,
        JsonInterpolation::CubicSpline => Interpolation::CubicSpline,
    };
    let times = accessors
        .read_f32::<1>(sampler.input.value(), element)?
        .into_flattened();
    let is_ascending = times.windows(2).all(|pair| pair[0] < pair[1]);
    if times.is_empty() || !is_ascending || !times.iter().all(|time| time.is_finite()) {
        return Ok(Err("its times are none, not finite or not ascending".to_owned()));
    }

    let output = sampler.output.value();
    let vectors = || -> Result<Vec<Vec3>, GltfError> {
        Ok(accessors
            .read_f32::<3>(output, element)?
            .into_iter()
            .map(Vec3::from)
            .collect())
    };
    let values = match property {
        Property::Translation => ChannelValues::Translation(vectors()?),
        Property::Scale => ChannelValues::Scale(vectors()?),
        Property::Rotation => ChannelValues::Rotation(
            accessors
                .read_f32::<4>(output, element)?
                .into_iter()
                .map(Quat::from_array)
                .collect(),
        ),
        Property::MorphTargetWeights => {
            if node.weights.is_empty() {
                return Ok(Err("its node has no morph targets".to_owned()));
            }
            ChannelValues::Weights {
                target_count: node.weights.len(),
                values: accessors.read_f32::<1>(output, element)?.into_flattened(),
            }
        }
    };
    let channel = Channel {
        node: channel.target.node.value(),
        interpolation,
        times,
        values,
    };
    Ok(channel.check().map(|()| channel))
}

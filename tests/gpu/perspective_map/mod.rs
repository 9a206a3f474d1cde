//! Perspective maps: their shadows are those of the ray caster up to a texel, wherever casters, lights and the viewer
//! are; and their texels are where the pixels are.

mod around_the_eye;
mod bad_input;
mod casters;
mod ceiling_lamps;
mod contacts;
mod far_worlds;
mod fits;
mod ground_channels;
mod grounds;
mod models;
mod quality;

use antumbra::prelude::*;
use antumbra::techniques::maps::MapResolution;
use antumbra::techniques::perspective_map::{MapFocus, PerspectiveFaces, PerspectiveProjection};

pub const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.5,
    outer_angle: 0.8,
};

pub const KINDS: [LightKind; 3] = [SPOT, LightKind::Directional, LightKind::Point];

/// Maps of a fixed resolution with each setting that changes the pictures.
pub fn variants(resolution: u32) -> [PerspectiveMap; 5] {
    let map = PerspectiveMap {
        resolution: MapResolution::Fixed(resolution),
        ..Default::default()
    };
    [
        map,
        PerspectiveMap {
            projection: PerspectiveProjection::SlideBack,
            ..map
        },
        PerspectiveMap {
            faces: PerspectiveFaces::Cube,
            ..map
        },
        PerspectiveMap {
            focus: MapFocus::All,
            ..map
        },
        PerspectiveMap {
            slide: Some(0.0),
            cached: true,
            ..map
        },
    ]
}

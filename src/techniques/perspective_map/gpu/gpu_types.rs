//! `#[repr(C)]` mirrors of WGSL structs; `tests/gpu/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::techniques::perspective_map::grounds::{Ground, MOST_GROUNDS};

/// Mirror of `Grounds` in `shaders/techniques/perspective_map/blur.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Grounds {
    /// Unit normal and offset of each ground's plane. World axes, origin at the eye.
    pub planes: [[f32; 4]; MOST_GROUNDS],
    /// A unit vector in the plane of each ground, and the standard deviation of its blur in metres. The deviation is 0
    /// where there is no ground.
    pub along: [[f32; 4]; MOST_GROUNDS],
    /// The unit vector in the plane at right angles to `along`, and half the size of the ground along it, metres.
    pub across: [[f32; 4]; MOST_GROUNDS],
    /// Middle of each ground, and half its size along `along`, metres.
    pub middle: [[f32; 4]; MOST_GROUNDS],
}

impl Grounds {
    /// Makes the constants of the grounds of a view.
    pub fn new(grounds: &[Ground], eye: DVec3) -> Self {
        let mut out = Self::default();
        for (at, ground) in grounds.iter().take(MOST_GROUNDS).enumerate() {
            let offset = ground.normal.dot(ground.point - eye);
            out.planes[at] = ground.normal.extend(offset).as_vec4().to_array();
            let [along, across] = ground.axes;
            out.along[at] = along.extend(ground.radius).as_vec4().to_array();
            out.across[at] = across.extend(ground.half[1]).as_vec4().to_array();
            out.middle[at] = (ground.point - eye).extend(ground.half[0]).as_vec4().to_array();
        }
        out
    }
}

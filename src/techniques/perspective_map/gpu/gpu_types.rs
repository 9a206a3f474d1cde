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
}

impl Grounds {
    /// Makes the constants of the grounds of a view.
    pub fn new(grounds: &[Ground], eye: DVec3) -> Self {
        let mut out = Self::default();
        for (at, ground) in grounds.iter().take(MOST_GROUNDS).enumerate() {
            let offset = ground.normal.dot(ground.point - eye);
            out.planes[at] = ground.normal.extend(offset).as_vec4().to_array();
            let along = ground.normal.any_orthonormal_vector();
            out.along[at] = along.extend(ground.radius).as_vec4().to_array();
        }
        out
    }
}

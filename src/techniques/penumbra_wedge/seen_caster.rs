//! A caster as one part of a light sees it: its transforms and the planes of its triangles.

use glam::{DMat4, DVec3, Vec4};

use super::light_parts::{LightPart, PartShape};
use crate::silhouettes::cache::light_in_local;
use crate::silhouettes::{CasterShapeItem, FacingBits, LightExtent};

/// Returns the transform from a caster's space to light space; `None` if one of the two has no inverse.
pub(super) fn light_from_local(part: &LightPart, world_from_local: &DMat4) -> Option<DMat4> {
    let light_from_local = part.world_from_light.inverse() * *world_from_local;
    light_from_local.is_finite().then_some(light_from_local)
}

/// Returns the extent of a part around its centre, in the caster's space; `None` for a point.
pub(super) fn extent_local(shape: PartShape, local_from_light: &DMat4) -> Option<LightExtent> {
    let axis = |axis: DVec3| local_from_light.transform_vector3(axis).as_vec3();
    match shape {
        PartShape::Point => None,
        PartShape::Rect { half } => Some(LightExtent::Sides([
            axis(DVec3::X * half.x),
            axis(DVec3::Y * half.y),
        ])),
        PartShape::Sphere { radius } => Some(LightExtent::Ellipsoid(
            DVec3::AXES.map(|unit| axis(unit * radius)),
        )),
    }
}

/// A caster where it stands, as one part of a light sees it.
pub(super) struct SeenCaster<'a, 'w, 's> {
    pub(super) part: &'a LightPart,
    pub(super) caster: &'a CasterShapeItem<'w, 's>,
    pub(super) world_from_local: &'a DMat4,
    pub(super) light_from_local: DMat4,
    pub(super) local_from_light: DMat4,
    pub(super) light_local: Vec4,
}

impl<'a, 'w, 's> SeenCaster<'a, 'w, 's> {
    /// Returns `None` if the transform of the caster has no inverse.
    pub(super) fn new(
        part: &'a LightPart,
        caster: &'a CasterShapeItem<'w, 's>,
        world_from_local: &'a DMat4,
        light_from_local: DMat4,
    ) -> Option<Self> {
        Some(Self {
            part,
            caster,
            world_from_local,
            light_from_local,
            local_from_light: light_from_local.inverse(),
            light_local: light_in_local(world_from_local, part.point_world)?,
        })
    }

    pub(super) fn is_directional(&self) -> bool {
        self.part.point_world.w == 0.0
    }

    /// Returns the plane of a triangle in light space, with the centre of the light, which is the origin, strictly on
    /// the side for which the hard shadow is made.
    pub(super) fn plane_light(&self, slot: u32, facing: &FacingBits) -> [f32; 4] {
        let plane = self.caster.planes().plane(slot as usize).as_dvec4();
        let plane = self.local_from_light.transpose() * plane;
        let [x, y, z, offset] = (plane / plane.truncate().length()).as_vec4().to_array();
        let offset = if facing.is_facing(slot as usize) {
            offset.max(f32::MIN_POSITIVE)
        } else {
            offset.min(-f32::MIN_POSITIVE)
        };
        [x, y, z, offset]
    }
}

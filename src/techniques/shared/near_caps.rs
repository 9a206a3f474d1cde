//! A test of whether a caster's own drawn surface hides its near cap. If so, depth-pass need not draw the
//! cap.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::scene::FaceCulling;
use crate::sets::{Objects, SeeThrough, SeenInto};

/// The sets that decide whether near caps are hidden.
#[derive(SystemParam)]
pub struct NearCaps<'w> {
    seen_into: Res<'w, SeenInto>,
    see_through: Res<'w, SeeThrough>,
    face_culling: Res<'w, FaceCulling>,
}

impl NearCaps<'_> {
    /// Returns whether an object's near cap is nowhere visible, because its whole surface is drawn there and
    /// nothing looks into the object.
    pub fn are_hidden(&self, objects: &Objects, object: usize, is_closed: impl FnOnce() -> bool) -> bool {
        objects.drawn.contains(object)
            && !self.seen_into.0.contains(object)
            && (*self.face_culling == FaceCulling::None
                || self.see_through.two_sided.contains(object)
                || is_closed())
    }
}

//! Whether a caster's own, drawn surface hides its near cap, so that counting towards the viewer need not draw it.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::scene::FaceCulling;
use crate::sets::{Objects, SeeThrough, SeenInto};

/// What is asked of a caster's surface.
#[derive(SystemParam)]
pub struct NearCaps<'w> {
    seen_into: Res<'w, SeenInto>,
    see_through: Res<'w, SeeThrough>,
    face_culling: Res<'w, FaceCulling>,
}

impl NearCaps<'_> {
    /// Whether the cap is nowhere seen: all of the surface is drawn where it is, and nothing looks into the caster.
    pub fn are_hidden(&self, objects: &Objects, object: usize, is_closed: impl FnOnce() -> bool) -> bool {
        objects.drawn.contains(object)
            && !self.seen_into.0.contains(object)
            && (*self.face_culling == FaceCulling::None
                || self.see_through.two_sided.contains(object)
                || is_closed())
    }
}

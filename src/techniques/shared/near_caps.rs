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
    ///
    /// `shows_fronts_alone`: whether from outside nothing but fronts are seen of its mesh. Where backs are not drawn, a cap
    /// is else to be seen through them: a mesh that is inside out in part, or that a joint mirrors in part, hides nothing.
    pub fn are_hidden(
        &self,
        objects: &Objects,
        object: usize,
        shows_fronts_alone: impl FnOnce() -> bool,
    ) -> bool {
        objects.drawn.contains(object)
            && !self.seen_into.0.contains(object)
            && (*self.face_culling == FaceCulling::None
                || self.see_through.two_sided.contains(object)
                || shows_fronts_alone())
    }
}

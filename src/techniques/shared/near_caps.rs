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
    /// Whether an object's near cap is nowhere seen, because its whole surface is drawn there and nothing
    /// looks into the object.
    ///
    /// `shows_fronts_alone` returns whether only fronts of its mesh are seen from outside. Where backs are not drawn,
    /// a cap would be seen through them, so a mesh that is partly inside out, or partly mirrored by a joint, does not
    /// hide its cap.
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

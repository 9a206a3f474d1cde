//! A test of whether a caster's own drawn surface hides its near cap. If so, depth-pass need not draw the
//! cap.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use fixedbitset::FixedBitSet;

use crate::scene::FaceCulling;
use crate::sets::{Objects, SeeThrough, SeenInto};

/// The sets that decide whether near caps are hidden.
#[derive(SystemParam)]
pub struct NearCaps<'w> {
    seen_into: Res<'w, SeenInto>,
    see_through: Res<'w, SeeThrough>,
    face_culling: Res<'w, FaceCulling>,
}

/// A copy of the sets that decide whether near caps are hidden.
#[derive(Clone, Debug, Default)]
pub struct KeptNearCaps {
    seen_into: FixedBitSet,
    two_sided: FixedBitSet,
    face_culling: FaceCulling,
}

impl NearCaps<'_> {
    /// Brings a copy of the sets up to date, and returns whether it was up to date. The sets are by dense object index, so the
    /// answer holds as long as indices keep their meaning. Cost: two bits an object.
    pub fn keep(&self, copy: &mut KeptNearCaps) -> bool {
        let (seen_into, two_sided) = (&self.seen_into.0, &self.see_through.two_sided);
        let is_same = copy.seen_into == *seen_into
            && copy.two_sided == *two_sided
            && copy.face_culling == *self.face_culling;
        if !is_same {
            copy.seen_into.clone_from(seen_into);
            copy.two_sided.clone_from(two_sided);
            copy.face_culling = *self.face_culling;
        }
        is_same
    }

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

//! What may be seen of each object, and what that spares the lights.
//!
//! A floor is seen in one room of ten. Where the camera's depth buffer knows that, a light in another room need not draw
//! the floor, and no caster that shadows the floor there matters.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use crate::geometry::Aabb;
use crate::sets::index::boxes::WORD;
use crate::sets::index::clusters::for_bits;
use crate::sets::index::lit_bounds::lit_bounds;
use crate::sets::index::objects::Objects;
use crate::sets::light::frame_lights::FrameLight;
use crate::sets::occlusion::{Occluders, Viewpoint};

/// Bounds of the part of each object of V that may be seen. Written by
/// [`collect_visible_set`](crate::sets::collect_visible_set).
#[derive(Resource, Clone, Debug, Default)]
pub struct VisibleParts {
    /// By dense index, those of objects of V; not used while nothing occludes.
    parts: Vec<Aabb>,
    in_use: bool,
}

impl VisibleParts {
    /// Bounds of what may be seen of an object of V, world space: of all of it while nothing occludes.
    pub fn get(&self, objects: &Objects, object: usize) -> Aabb {
        if self.in_use {
            self.parts[object]
        } else {
            objects.boxes.get(object)
        }
    }

    /// Whether something occludes, so that parts are less than the whole.
    pub(in crate::sets) fn in_use(&self) -> bool {
        self.in_use
    }

    /// All is seen whole.
    pub(in crate::sets) fn forget(&mut self) {
        self.in_use = false;
    }

    /// Parts are about to be set, of objects of this layout.
    pub(in crate::sets) fn begin(&mut self, len: usize) {
        if self.parts.len() != len {
            self.parts.clear();
            self.parts.resize(len, Aabb::EMPTY);
        }
        self.in_use = true;
    }

    /// Sets a part; whether it is another than before.
    pub(in crate::sets) fn set(&mut self, object: usize, part: Aabb) -> bool {
        std::mem::replace(&mut self.parts[object], part) != part
    }

    /// The box around the visible parts of a set's objects that lie in `cut`; `words` has every word of the set that is
    /// not 0.
    pub(in crate::sets) fn lit_bounds(
        &self,
        objects: &Objects,
        words: &FixedBitSet,
        set: impl Fn(usize) -> usize,
        cut: &Aabb,
    ) -> Aabb {
        if !self.in_use {
            return lit_bounds(&objects.boxes, &objects.clusters, words, set, cut);
        }
        let mut lit = Aabb::EMPTY;
        for word in words.ones() {
            for_bits(set(word), |bit| {
                let part = self.parts[word * WORD + bit].intersection(*cut);
                if !part.is_empty() {
                    lit = lit.union(part);
                }
            });
        }
        lit
    }

    /// Takes objects out of I of which no visible point is in the light's volume, or which show nothing that the light
    /// sees.
    pub(in crate::sets) fn cut_illumination(
        &self,
        light: &mut FrameLight,
        viewpoint: Option<&Viewpoint>,
        occluders: &Occluders,
    ) {
        if !self.in_use {
            return;
        }
        let reach = light.volume.aabb();
        for word in light.touched.ones() {
            let mut rest = light.i.as_slice()[word];
            while rest != 0 {
                let object = word * usize::BITS as usize + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let part = self.parts[object].intersection(reach);
                let hidden = || {
                    let (center, half) = (part.center().as_dvec3(), part.half_size().as_dvec3());
                    occluders.shadeable.contains(object)
                        && viewpoint.is_some_and(|viewpoint| viewpoint.hides_box(center, half))
                };
                if part.is_empty() {
                    light.i.remove(object);
                } else if hidden() {
                    light.dark.insert(object);
                    light.i.remove(object);
                }
            }
        }
    }
}

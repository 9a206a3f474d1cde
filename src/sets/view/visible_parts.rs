//! Finds the visible part of each object, which spares work for lights.
//!
//! A floor may be visible in only one room of ten. Where the camera's depth buffer shows this, a light in
//! another room need not draw the floor, and casters that shadow the floor there do not matter.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use crate::geometry::Aabb;
use crate::sets::index::boxes::WORD;
use crate::sets::index::clusters::for_bits;
use crate::sets::index::lit_bounds::lit_bounds;
use crate::sets::index::objects::Objects;
use crate::sets::light::frame_light::FrameLight;
use crate::sets::occlusion::{Occluders, Viewpoint};

/// Bounds of the part of each object of V that may be visible. Written by
/// [`collect_visible_set`](crate::sets::collect_visible_set).
#[derive(Resource, Clone, Debug, Default)]
pub struct VisibleParts {
    /// Bounds of the visible part of each object of V, by dense index. Unused while nothing occludes.
    parts: Vec<Aabb>,
    in_use: bool,
}

impl VisibleParts {
    /// Bounds of the visible part of an object of V, world space. While nothing occludes, this is the whole
    /// object.
    pub fn get(&self, objects: &Objects, object: usize) -> Aabb {
        if self.in_use {
            self.parts[object]
        } else {
            objects.boxes.get(object)
        }
    }

    /// Whether something occludes, so that parts may be smaller than their objects.
    pub(in crate::sets) fn in_use(&self) -> bool {
        self.in_use
    }

    /// Declares that every object is visible as a whole.
    pub(in crate::sets) fn forget(&mut self) {
        self.in_use = false;
    }

    /// Prepares for setting the parts of `len` objects.
    pub(in crate::sets) fn begin(&mut self, len: usize) {
        if self.parts.len() != len {
            self.parts.clear();
            self.parts.resize(len, Aabb::EMPTY);
        }
        self.in_use = true;
    }

    /// Sets the part of an object. Returns whether it differs from the part before.
    pub(in crate::sets) fn set(&mut self, object: usize, part: Aabb) -> bool {
        std::mem::replace(&mut self.parts[object], part) != part
    }

    /// The box around the visible parts, cut by `cut`, of a set's objects. `words` must have a bit for every
    /// word of the set that is not 0.
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

    /// Removes objects from I that have no visible point in the light's volume, or whose visible points the
    /// light cannot see.
    pub(in crate::sets) fn cut_illumination(
        &self,
        light: &mut FrameLight,
        viewpoint: Option<&Viewpoint>,
        occluders: &Occluders,
    ) {
        if !self.in_use {
            return;
        }
        let reach = light.lit.aabb();
        for word in light.scratch.touched.ones() {
            let mut rest = light.sets.i.as_slice()[word];
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
                    light.sets.i.remove(object);
                } else if hidden() {
                    light.sets.dark.insert(object);
                    light.sets.i.remove(object);
                }
            }
        }
    }
}

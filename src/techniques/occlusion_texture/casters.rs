//! The scene that a light reaches, and its casters without those that shadow nothing.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;

use super::scene_box::{OwnBox, SceneBox};
use super::shadowless::Lit;
use crate::geometry::{Aabb, Emitter};
use crate::sets::{FrameLight, Objects};

/// Coordinates from which on a box says nothing about the scene, metres.
const FARTHEST: f32 = 1e9;

/// The objects of a frame, as the pictures of all lights look at them.
pub(super) struct FrameObjects<'a> {
    pub objects: &'a Objects,
    /// Objects whose mesh or material was exchanged in this frame.
    pub exchanged: &'a FixedBitSet,
    /// Whether only fronts of a caster are seen from outside.
    pub is_closed: &'a dyn Fn(Entity) -> bool,
    /// Whether a caster is a shell around a light and a box that holds everything else lit; up to a rounding, metres.
    pub is_shell: &'a dyn Fn(Entity, &Aabb, &Emitter, f64) -> bool,
    /// The box of an object along its own axes.
    pub own_box: &'a dyn Fn(Entity) -> Option<OwnBox>,
}

/// Memory that is kept for its allocation.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    pub scene: Vec<SceneBox>,
    /// Object of each box of the scene.
    indices: Vec<usize>,
    /// Indices of the boxes of shells around everything lit.
    shells: Vec<usize>,
}

impl Scratch {
    /// Collects the scene of a light, and its casters without those that shadow nothing. `sun` is the sine of half the angle
    /// of a directional light.
    pub fn collect(&mut self, light: &FrameLight, sun: f64, frame: &FrameObjects, casters: &mut FixedBitSet) {
        let objects = frame.objects;
        casters.clear();
        casters.grow(objects.len());
        for object in light.reached_casters(objects) {
            casters.insert(object);
        }
        let volume = light.volume.aabb();
        let Self {
            scene,
            indices,
            shells,
        } = self;
        scene.clear();
        indices.clear();
        let (mut all, mut is_known) = (Aabb::EMPTY, true);
        for object in light.sets.l.ones() {
            let bounds = objects.boxes.get(object).intersection(volume);
            if bounds.is_empty() {
                casters.set(object, false);
                continue;
            }
            if !(bounds.min.abs().max(bounds.max.abs()).max_element() < FARTHEST) {
                is_known = false;
                continue;
            }
            all = all.union(bounds);
            indices.push(object);
            scene.push(SceneBox {
                bounds,
                own: (frame.own_box)(objects.entities[object]),
                casts: casters.contains(object),
            });
        }
        let lit = |scene| Lit {
            scene,
            all,
            emitter: &light.emitter,
            sun,
        };
        shells.clear();
        let whole = lit(scene.as_slice());
        let is_shell = |index: &usize| {
            let entity = objects.entities[indices[*index]];
            let rest = whole.all_but_shell(*index).filter(|_| scene[*index].casts);
            rest.is_some_and(|rest| (frame.is_shell)(entity, &rest, &light.emitter, whole.rounding()))
        };
        if is_known {
            shells.extend((0..scene.len()).filter(is_shell));
        }
        for index in (0..scene.len()).filter(|index| is_known && scene[*index].casts) {
            if shells.contains(&index) || whole.is_shadowless(index) {
                casters.set(indices[index], false);
            }
        }
        for (scene, object) in scene.iter_mut().zip(&*indices) {
            scene.casts = casters.contains(*object);
        }
        if !shells.is_empty() {
            self.leave_out_grounds(light, sun);
        }
    }

    /// Fits no slices to casters that shadow nothing but the shells behind them, if there are others. A ground under a sky dome
    /// hides the part of the dome that it shadows.
    fn leave_out_grounds(&mut self, light: &FrameLight, sun: f64) {
        let Self { scene, shells, .. } = self;
        let inside = || (0..scene.len()).filter(|index| !shells.contains(index));
        let within: Vec<SceneBox> = inside().map(|index| scene[index]).collect();
        let all = within.iter().fold(Aabb::EMPTY, |all, one| all.union(one.bounds));
        let lit = Lit {
            scene: &within,
            all,
            emitter: &light.emitter,
            sun,
        };
        let is_ground = |(at, _): &(usize, usize)| within[*at].casts && lit.is_shadowless(*at);
        let grounds: Vec<usize> = inside()
            .enumerate()
            .filter(is_ground)
            .map(|(_, index)| index)
            .collect();
        if grounds.len() < within.iter().filter(|one| one.casts).count() {
            grounds.into_iter().for_each(|index| scene[index].casts = false);
        }
    }
}

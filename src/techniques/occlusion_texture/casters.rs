//! The scene that a light reaches, and its casters without those that shadow nothing.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::DVec3;

use super::scene_box::{OwnBox, SceneBox};
use super::shadowless::Lit;
use crate::geometry::{Aabb, Emitter};
use crate::sets::{FrameLight, Objects};

/// Coordinates from which on a box says nothing about the scene, metres.
const FARTHEST: f32 = 1e9;

/// Casters of which even the nearest point is this many times as far from a light as the farthest point of most others count as
/// far: they get a ten-thousandth of the light, less than a step of a picture of 8 bits.
const FAR: f64 = 100.0;

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
    /// Distances of casters from a light, metres.
    distances: Vec<f64>,
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
            distances,
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
        if is_known && light.emitter.point.w != 0.0 {
            let is_far = farther(scene, light.emitter.point.truncate(), distances);
            shells.extend((0..scene.len()).filter(|index| is_far(&scene[*index])));
        }
        if !shells.is_empty() {
            self.leave_out_grounds(light, sun);
        }
    }

    /// Fits no slices to what is far, nor to casters that shadow nothing but that and the shells behind them, if there are
    /// others. A ground under a sky dome hides the part of the dome that it shadows.
    fn leave_out_grounds(&mut self, light: &FrameLight, sun: f64) {
        let Self { scene, shells, .. } = self;
        shells.iter().for_each(|index| scene[*index].casts = false);
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

/// Tells which objects are far from a light at a position, compared with most casters.
fn farther(scene: &[SceneBox], from: DVec3, distances: &mut Vec<f64>) -> impl Fn(&SceneBox) -> bool {
    let range = move |scene: &SceneBox| {
        let half = 0.5 * (scene.bounds.max.as_dvec3() - scene.bounds.min.as_dvec3());
        let middle = scene.bounds.min.as_dvec3() + half - from;
        [
            (middle.abs() - half).max(DVec3::ZERO).length(),
            (middle.abs() + half).length(),
        ]
    };
    distances.clear();
    distances.extend(
        scene
            .iter()
            .filter(|scene| scene.casts)
            .map(|scene| range(scene)[1]),
    );
    distances.sort_unstable_by(f64::total_cmp);
    let middle = distances.len().saturating_sub(1) / 2;
    let most = distances.get(middle).copied().unwrap_or(f64::INFINITY);
    move |scene: &SceneBox| range(scene)[0] > FAR * most
}

//! The receivers of a frame whose shadows are blurred, in up to four channels.

use bevy_ecs::prelude::*;
use glam::{DVec3, Mat3A, Vec3A};
use smallvec::SmallVec;

use crate::geometry::Aabb;
use crate::scene::placement::Placement;
use crate::scene::{BlurredGround, LocalBounds, ShadowReceiver};
use crate::sets::Objects;

/// Number of grounds that a view can have: the channels of a picture.
pub const MOST_GROUNDS: usize = 4;

/// Distance from a point at which a blur's weights end, in standard deviations. 1.2 % of the Gaussian is beyond.
pub const BLUR_REACH: f64 = 2.5;

/// Sine of the angle between two planes, and their distance as a share of the receivers' size, up to which they are one.
const SAME_PLANE: f64 = 1e-3;

/// Receivers in one plane whose shadows are blurred alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Unit normal of the plane, world space. Its sign has no meaning.
    pub normal: DVec3,
    /// Middle of the ground, world space, metres.
    pub point: DVec3,
    /// Two unit vectors in the plane, at right angles.
    pub axes: [DVec3; 2],
    /// Half the size of the ground along each of them, metres. A blur ends there: what lies beyond, behind a wall or below
    /// a floor, is not of the ground.
    pub half: [f64; 2],
    /// Standard deviation of the Gaussian, metres.
    pub radius: f64,
}

impl Ground {
    /// Returns the plane in which a box of local space is longest, placed in the world.
    fn of_bounds(local: &Aabb, axes: &Mat3A, translation: DVec3, radius: f64) -> Option<Self> {
        let half = local.half_size().as_dvec3();
        let sides = [0, 1, 2].map(|axis| axes.col(axis).as_dvec3() * half[axis]);
        let thinnest =
            (0..3).min_by(|&a, &b| sides[a].length_squared().total_cmp(&sides[b].length_squared()))?;
        let axis = |at: usize| axes.col((thinnest + at) % 3).as_dvec3();
        let normal = axis(1).cross(axis(2)).try_normalize()?;
        let along = axis(1).try_normalize()?;
        let mut ground = Self {
            normal,
            point: (*axes * Vec3A::from(local.center())).as_dvec3() + translation,
            axes: [along, normal.cross(along)],
            half: [0.0; 2],
            radius,
        };
        let corners = [1.0, -1.0].map(|sign| sides[(thinnest + 1) % 3] + sides[(thinnest + 2) % 3] * sign);
        for (half, axis) in ground.half.iter_mut().zip(ground.axes) {
            *half = corners
                .iter()
                .map(|corner| corner.dot(axis).abs())
                .fold(0.0, f64::max);
        }
        Some(ground)
    }

    /// Grows so that it holds another ground of the same plane.
    fn include(&mut self, other: &Self) {
        for at in 0..2 {
            let axis = self.axes[at];
            let reach = (0..2)
                .map(|i| other.axes[i].dot(axis).abs() * other.half[i])
                .sum::<f64>();
            let place = axis.dot(other.point - self.point);
            let (low, high) = (
                (place - reach).min(-self.half[at]),
                (place + reach).max(self.half[at]),
            );
            self.point += axis * (0.5 * (low + high));
            self.half[at] = 0.5 * (high - low);
        }
    }

    /// Whether two grounds are one.
    fn is_one_with(&self, other: &Self, size: f64) -> bool {
        self.radius == other.radius
            && self.normal.cross(other.normal).length() < SAME_PLANE
            && self.normal.dot(other.point - self.point).abs() < SAME_PLANE * size.max(self.radius)
    }
}

/// The blurred grounds of this frame. Written by [`collect_blurred_grounds`].
#[derive(Resource, Clone, Debug, Default)]
pub struct BlurredGrounds {
    /// The grounds, each of which is a channel.
    pub grounds: SmallVec<[Ground; MOST_GROUNDS]>,
    /// Dense index and channel of each receiver on a ground, ascending.
    pub receivers: Vec<(usize, u32)>,
    /// Receivers that keep the map's filter because four other grounds are there, and those with a bad radius.
    pub left_out: Vec<(Entity, LeftOut)>,
    /// Marked receivers and their dense indices, ascending.
    marked: Vec<(Entity, usize)>,
}

/// Why a receiver's shadows are not blurred.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// Four other grounds are there.
    TooMany,
    /// The radius is not a finite number greater than 0.
    Radius,
}

impl BlurredGrounds {
    /// Returns the channel of an object.
    #[cfg(feature = "render")]
    pub fn channel_of(&self, object: usize) -> Option<u32> {
        let at = self
            .receivers
            .binary_search_by_key(&object, |(object, _)| *object)
            .ok()?;
        Some(self.receivers[at].1)
    }

    fn channel(&mut self, ground: Ground, size: f64) -> Option<u32> {
        let known = self
            .grounds
            .iter()
            .position(|known| known.is_one_with(&ground, size));
        if let Some(known) = known {
            self.grounds[known].include(&ground);
            return Some(known as u32);
        }
        (self.grounds.len() < MOST_GROUNDS).then(|| {
            self.grounds.push(ground);
            self.grounds.len() as u32 - 1
        })
    }
}

/// Collects the receivers with a [`BlurredGround`], and gives each a channel, in the order of their entities.
///
/// Set: `BuildTechniques`, before `request_perspective_maps`. Reads [`Objects`]; writes [`BlurredGrounds`].
pub fn collect_blurred_grounds(
    mut blurred: ResMut<BlurredGrounds>,
    objects: Res<Objects>,
    marked: Query<(Entity, &BlurredGround, &LocalBounds, Placement), With<ShadowReceiver>>,
) {
    let blurred = &mut *blurred;
    blurred.grounds.clear();
    blurred.receivers.clear();
    blurred.left_out.clear();
    let mut order = std::mem::take(&mut blurred.marked);
    order.clear();
    let known = marked.iter().map(|(entity, ..)| entity);
    order.extend(known.filter_map(|entity| Some((entity, objects.index_of(entity)?))));
    order.sort_unstable();
    for &(entity, object) in &order {
        let Ok((_, ground, local, placement)) = marked.get(entity) else {
            continue;
        };
        if !(ground.radius > 0.0 && ground.radius.is_finite()) {
            blurred.left_out.push((entity, LeftOut::Radius));
            continue;
        }
        let Some(affine) = placement.affine().filter(|_| !local.0.is_empty()) else {
            continue;
        };
        let (translation, radius) = (affine.translation.as_dvec3(), f64::from(ground.radius));
        let size = objects.boxes.get(object).half_size().length();
        let Some(ground) = Ground::of_bounds(&local.0, &affine.matrix3, translation, radius) else {
            continue;
        };
        match blurred.channel(ground, f64::from(size)) {
            Some(channel) => blurred.receivers.push((object, channel)),
            None => blurred.left_out.push((entity, LeftOut::TooMany)),
        }
    }
    blurred.receivers.sort_unstable();
    blurred.marked = order;
}

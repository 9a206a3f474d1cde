//! Levels of detail: which meshes with a `VisibilityRange` a camera shows, and which of them cast shadows.
//!
//! A camera draws a mesh if its distance is within the mesh's range. In the margins of the range Bevy draws a
//! share of the mesh's pixels, and the other pixels show the next level. A shadow cannot be drawn in shares:
//! the levels of an object shadow each other. So a mesh casts from the middle of its first margin to the
//! middle of its last, and at each distance one level of an object casts.

use bevy::camera::primitives::Aabb as BevyAabb;
use bevy::camera::visibility::VisibilityRange;
use bevy::ecs::prelude::*;
use bevy::mesh::Mesh3d;
use bevy::render::Extract;
use bevy::transform::components::GlobalTransform;

use super::camera::AntumbraCamera;
use super::mirror::Mirrors;

/// How a camera shows a mesh at its distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Level {
    /// The mesh has no range, or its distance is within the range and beyond the margins.
    #[default]
    Whole,
    /// The distance is in a margin: a share of the pixels is drawn. The mesh casts in the inner half of the
    /// margin.
    Fading {
        /// Whether the mesh casts.
        casts: bool,
    },
    /// The distance is out of the range: the mesh is not drawn.
    Out,
}

impl Level {
    /// Returns the level of a mesh at a distance from the camera, metres.
    pub fn at(range: &VisibilityRange, distance: f32) -> Self {
        if range.is_culled(distance) {
            return Self::Out;
        }
        let (start, end) = (&range.start_margin, &range.end_margin);
        if distance >= start.end && distance < end.start {
            return Self::Whole;
        }
        let middle = |margin: &std::ops::Range<f32>| 0.5 * (margin.start + margin.end);
        Self::Fading {
            casts: distance >= middle(start) && distance < middle(end),
        }
    }

    /// Whether the mesh is drawn, wholly or in part.
    pub fn is_drawn(self) -> bool {
        self != Self::Out
    }

    /// Whether the mesh casts shadows.
    pub fn casts(self) -> bool {
        matches!(self, Self::Whole | Self::Fading { casts: true })
    }
}

/// The meshes of the game that have a range.
type Ranged<'w, 's> = Query<
    'w,
    's,
    (
        Entity,
        &'static GlobalTransform,
        Option<&'static BevyAabb>,
        &'static VisibilityRange,
    ),
    With<Mesh3d>,
>;

/// Finds the level of each mesh with a range for each camera. Meshes whose level changed are synchronised
/// again.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync), before the objects. Cost: the
/// meshes with a range, for each marked camera.
pub(super) fn sync_levels(
    mut mirrors: ResMut<Mirrors>,
    cameras: Extract<Query<&GlobalTransform, With<AntumbraCamera>>>,
    ranged: Extract<Ranged>,
    mut removed: Extract<RemovedComponents<VisibilityRange>>,
    mut ended: Local<Vec<Entity>>,
) {
    ended.clear();
    ended.extend(removed.read().filter(|&entity| !ranged.contains(entity)));
    for (camera, mirror) in mirrors.iter_mut_with_camera() {
        for &entity in &*ended {
            mirror.set_level(entity, Level::Whole);
        }
        let Ok(eye) = cameras.get(camera).map(GlobalTransform::translation_vec3a) else {
            continue;
        };
        for (entity, transform, aabb, range) in &ranged {
            let place = match aabb {
                Some(aabb) if range.use_aabb => transform.affine().transform_point3a(aabb.center),
                _ => transform.translation_vec3a(),
            };
            mirror.set_level(entity, Level::at(range, (eye - place).length()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_level_casts_at_each_distance_and_bevy_draws_it() {
        let fine = VisibilityRange {
            start_margin: 0.0..0.0,
            end_margin: 20.0..24.0,
            use_aabb: false,
        };
        let coarse = VisibilityRange {
            start_margin: 20.0..24.0,
            end_margin: 70.0..80.0,
            use_aabb: false,
        };
        for step in 0..1000 {
            let distance = step as f32 * 0.1;
            let levels = [&fine, &coarse].map(|range| Level::at(range, distance));
            let casting = levels.iter().filter(|level| level.casts()).count();
            assert_eq!(casting, usize::from(distance < 75.0), "{distance}: {levels:?}");
            for (level, range) in levels.iter().zip([&fine, &coarse]) {
                assert_eq!(level.is_drawn(), range.is_visible_at_all(distance));
            }
        }
        assert_eq!(Level::at(&fine, 10.0), Level::Whole);
        assert_eq!(Level::at(&coarse, 23.0), Level::Fading { casts: true });
        let abrupt = VisibilityRange::abrupt(5.0, 10.0);
        let levels = [4.9, 5.0, 9.9, 10.0].map(|distance| Level::at(&abrupt, distance));
        assert_eq!(levels, [Level::Out, Level::Whole, Level::Whole, Level::Out]);
    }
}

//! Casts the rays of a texel: one towards each point of the path.

use glam::DVec3;

use crate::reference::RayScene;
use crate::scene::{LightPath, PathPoint};
use crate::techniques::occlusion_interval::intervals::{Intervals, STEPS, intervals_of, middle_of};

/// Where the light is in one step of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    /// The light does not shine.
    Dark,
    /// The light is this way.
    Towards(DVec3),
    /// The light is here, and triangles nearer to it than the second number, metres, do not block it.
    At(DVec3, f64),
}

/// The path of a light as targets of rays: the middle of each step.
#[derive(Clone, Debug)]
pub struct Targets {
    targets: Vec<Target>,
    casts_for: u32,
}

/// A point of a surface from which rays are cast.
#[derive(Clone, Copy, Debug)]
pub struct RayOrigin {
    /// Position, metres.
    pub position: DVec3,
    /// Unit normal of the front.
    pub normal: DVec3,
    /// Whether the light counts behind the surface, too.
    pub is_two_sided: bool,
    /// Index of the triangle in the rays' scene.
    pub triangle: Option<u32>,
}

impl Targets {
    /// The targets of a path in the scene that blocks its rays. `casts_for` is the mask of
    /// [`LightSelection`](crate::scene::LightSelection).
    pub fn new(path: &LightPath, scene: &RayScene, casts_for: u32) -> Self {
        let target = |step: usize| {
            let time = middle_of(step);
            match path.at(time) {
                _ if !path.shines(time) => Target::Dark,
                PathPoint::Direction(direction) => Target::Towards(-direction.as_dvec3()),
                PathPoint::Position(position) => {
                    let position = position.as_dvec3();
                    Target::At(position, scene.clearance(position, f64::INFINITY, casts_for))
                }
            }
        };
        Self {
            targets: (0..STEPS).map(target).collect(),
            casts_for,
        }
    }

    /// Finds the intervals in which a point sees the light. Adds the number of rays to `rays`.
    ///
    /// Steps for which the surface faces away from the light take no ray and store nothing. The blocker of one step is
    /// tried first in the next one.
    pub fn trace(&self, scene: &RayScene, origin: &RayOrigin, rays: &mut u64) -> Intervals {
        let mut blocker = None;
        let mut seen = [false; STEPS];
        for (seen, target) in seen.iter_mut().zip(&self.targets) {
            let towards = match *target {
                Target::Dark => continue,
                Target::Towards(towards) => towards,
                Target::At(position, _) => position - origin.position,
            };
            if !origin.is_two_sided && origin.normal.dot(towards) <= 0.0 {
                continue;
            }
            *rays += 1;
            let (from, triangle, casts_for) = (origin.position, origin.triangle, self.casts_for);
            let found = match *target {
                Target::At(position, clearance) => {
                    scene.segment_blocker(from, position, clearance, triangle, casts_for, blocker)
                }
                _ => scene.direction_blocker(from, towards, triangle, casts_for, blocker),
            };
            *seen = found.is_none();
            blocker = found.or(blocker);
        }
        intervals_of(|step| seen[step])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// The sun passes overhead from +X to −X. A wall stands at x = 1 up to a height of 1.
    fn traced(normal: DVec3, is_two_sided: bool, with_wall: bool) -> (Intervals, u64) {
        let path = LightPath::Arc {
            direction: Vec3::NEG_X,
            axis: Vec3::Z,
            degrees: 180.0,
        };
        let far = 100.0;
        let corner = |y: f64, z: f64| DVec3::new(1.0, y, z);
        let wall = [
            corner(-far, -far),
            corner(1.0, -far),
            corner(1.0, far),
            corner(-far, far),
        ];
        let [a, b, c, d] = wall;
        let triangles = if with_wall {
            vec![[a, b, c], [a, c, d]]
        } else {
            Vec::new()
        };
        let scene = RayScene::from_triangles(triangles);
        let origin = RayOrigin {
            position: DVec3::ZERO,
            normal,
            is_two_sided,
            triangle: None,
        };
        let mut rays = 0;
        let intervals = Targets::new(&path, &scene, u32::MAX).trace(&scene, &origin, &mut rays);
        (intervals, rays)
    }

    #[test]
    fn the_wall_hides_the_sun_until_it_stands_45_degrees_high() {
        let (intervals, rays) = traced(DVec3::Y, false, true);
        assert_eq!(rays, 256);
        let edges: Vec<_> = intervals
            .iter()
            .map(|interval| (interval.rise, interval.fall))
            .collect();
        assert_eq!(edges, [(64, 255)]);
        let (without, _) = traced(DVec3::Y, false, false);
        assert_eq!((without[0].rise, without[0].fall), (0, 255));
    }

    #[test]
    fn what_faces_away_takes_no_rays_and_stores_nothing() {
        let (intervals, rays) = traced(DVec3::X, false, false);
        assert_eq!(rays, 128);
        assert_eq!((intervals[0].rise, intervals[0].fall), (0, 127));
        let (both, rays) = traced(DVec3::X, true, false);
        assert_eq!((both[0].rise, both[0].fall, rays), (0, 255, 256));
        assert_eq!(traced(DVec3::NEG_Y, false, false), (Intervals::new(), 0));
    }

    #[test]
    fn a_sun_below_the_horizon_is_not_seen_from_below_either() {
        let path = LightPath::Sun {
            latitude_degrees: 80.0,
            day: 355.0,
            hours: [0.0, 24.0],
        };
        let origin = RayOrigin {
            position: DVec3::ZERO,
            normal: DVec3::NEG_Y,
            is_two_sided: true,
            triangle: None,
        };
        let scene = RayScene::from_triangles([]);
        assert!(
            Targets::new(&path, &scene, u32::MAX)
                .trace(&scene, &origin, &mut 0)
                .is_empty()
        );
    }

    #[test]
    fn lights_at_positions_end_rays() {
        let path = LightPath::Positions(vec![Vec3::new(0.5, 0.5, 0.0), Vec3::new(3.0, 0.5, 0.0)]);
        let far = 5.0;
        let corner = |y: f64, z: f64| DVec3::new(1.0, y, z);
        let [a, b, c] = [corner(-far, -far), corner(far, -far), corner(0.0, far)];
        let scene = RayScene::from_triangles([[a, b, c]]);
        let origin = RayOrigin {
            position: DVec3::ZERO,
            normal: DVec3::Y,
            is_two_sided: false,
            triangle: None,
        };
        let intervals = Targets::new(&path, &scene, u32::MAX).trace(&scene, &origin, &mut 0);
        // The light passes through the wall after a fifth of the way.
        assert_eq!((intervals[0].rise, intervals[0].fall), (0, 50));
    }
}

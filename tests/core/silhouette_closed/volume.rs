//! The whole shadow volume, built from nothing but a contour as a technique would build it, and its checks.

use antumbra::silhouettes::Contour;
use glam::{DVec3, DVec4, Vec3, Vec4};
use rustc_hash::FxHashMap;

/// A vertex: the bits of its position, and whether it is pushed to infinity.
pub type Key = ([u32; 3], bool);

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    pub position: Vec3,
    pub is_far: bool,
}

impl Corner {
    pub fn key(self) -> Key {
        // −0 is drawn where 0 is.
        (self.position.to_array().map(|x| (x + 0.0).to_bits()), self.is_far)
    }
}

/// Polygons of the volume, fronts outward.
pub fn volume(contour: &Contour, positions: &[Vec3]) -> Vec<Vec<Corner>> {
    let near = |position| Corner {
        position,
        is_far: false,
    };
    let far = |position| Corner {
        position,
        is_far: true,
    };
    let mut polygons = Vec::new();
    for edge in contour.all_edges() {
        let [a, b] = edge.map(|i| positions[i as usize]);
        polygons.push(vec![near(b), near(a), far(a), far(b)]);
    }
    assert_eq!(contour.caps.len() % 3, 0);
    for (i, corners) in contour.caps.chunks_exact(3).enumerate() {
        let [a, mut b, mut c] = [0, 1, 2].map(|k| positions[corners[k] as usize]);
        if i * 3 >= contour.caps_away_start {
            (b, c) = (c, b);
        }
        polygons.push(vec![near(a), near(b), near(c)]);
        polygons.push(vec![far(c), far(b), far(a)]);
    }
    polygons
}

/// The first directed edge that is not there as often as its reverse.
pub fn unbalanced_edge(polygons: &[Vec<Corner>]) -> Option<(Key, Key)> {
    let mut sums: FxHashMap<(Key, Key), i64> = FxHashMap::default();
    for polygon in polygons {
        for (i, corner) in polygon.iter().enumerate() {
            let (from, to) = (corner.key(), polygon[(i + 1) % polygon.len()].key());
            let sign = if from < to { 1 } else { -1 };
            *sums.entry((from.min(to), from.max(to))).or_default() += sign;
        }
    }
    sums.into_iter()
        .filter(|&((a, b), sum)| a != b && sum != 0)
        .map(|(edge, _)| edge)
        .min()
}

/// How often the volume winds around `point`, from solid angles; a far vertex is a direction. `None` if the point is
/// so near to the surface that the angles do not add up.
///
/// Source: Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle".
pub fn winding(polygons: &[Vec<Corner>], light: Vec4, point: DVec3) -> Option<i64> {
    let light: DVec4 = light.as_dvec4();
    let direction = |corner: &Corner| {
        let position = corner.position.as_dvec3();
        if corner.is_far {
            position * light.w - light.truncate()
        } else {
            position - point
        }
    };
    let mut turns = 0.0;
    for polygon in polygons {
        let rays: Vec<DVec3> = polygon
            .iter()
            .map(|corner| direction(corner).normalize_or_zero())
            .collect();
        for i in 1..rays.len() - 1 {
            let [a, b, c] = [rays[0], rays[i], rays[i + 1]];
            let sine = a.dot(b.cross(c));
            let cosine = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
            if sine.abs() > 1e-12 || cosine > 1e-9 {
                turns += sine.atan2(cosine) / std::f64::consts::TAU;
            } else {
                return None;
            }
        }
    }
    ((turns - turns.round()).abs() < 1e-4).then_some(turns.round() as i64)
}

/// Whether the segment from `point` to the light meets the triangle; `None` if it does so near its border or plane.
pub fn is_crossed(triangle: [Vec3; 3], light: Vec4, point: DVec3) -> Option<bool> {
    const NEAR: f64 = 1e-4;
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    let ray = light.truncate().as_dvec3() - point * f64::from(light.w);
    let determinant = ab.dot(ray.cross(ac));
    if ab.cross(ac).length() == 0.0 {
        return Some(false);
    }
    if determinant.abs() < NEAR * ab.length() * ac.length() * ray.length() {
        return None;
    }
    let from_a = point - a;
    let u = from_a.dot(ray.cross(ac)) / determinant;
    let v = ray.dot(from_a.cross(ab)) / determinant;
    let t = ac.dot(from_a.cross(ab)) / determinant;
    let end = if light.w == 0.0 { f64::INFINITY } else { 1.0 };
    let values = [u, v, 1.0 - u - v, t, end - t];
    if values.iter().all(|&value| value > NEAR) {
        Some(true)
    } else if values.iter().any(|&value| value < -NEAR) {
        Some(false)
    } else {
        None
    }
}

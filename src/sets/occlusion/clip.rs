//! Clipping of triangles and segments to what a picture can hold.

use smallvec::SmallVec;

use super::projection::{ClipPoint, Projection};

/// Half pictures from the centre at which coordinates are cut off, so that `f32` is precise enough for the
/// rest.
const GUARD: f64 = 3.0;

/// Signed distances of a point from the planes, positive inside: near, left, right, bottom, top.
fn distances(point: &ClipPoint, near: f64) -> [f64; 5] {
    let ClipPoint { x, y, w, .. } = *point;
    [
        w - near,
        GUARD * w + x,
        GUARD * w - x,
        GUARD * w + y,
        GUARD * w - y,
    ]
}

/// A bit for each plane that the point lies outside of.
pub(super) fn outside(point: &ClipPoint, near: f64) -> u8 {
    distances(point, near)
        .iter()
        .enumerate()
        .map(|(plane, distance)| u8::from(!(*distance >= 0.0)) << plane)
        .sum()
}

/// A convex polygon in a picture.
pub(super) type Polygon = SmallVec<[ClipPoint; 8]>;

/// The part of a triangle behind the near plane and inside the guard band. The second value is the side that
/// the near plane created, which is a boundary edge that the mesh does not have.
///
/// Source: Sutherland & Hodgman 1974, "Reentrant Polygon Clipping".
pub(super) fn clip_triangle(
    projection: &Projection,
    corners: [ClipPoint; 3],
) -> (Polygon, Option<[ClipPoint; 2]>) {
    let mut polygon = Polygon::from_slice(&corners);
    let mut cut = None;
    for plane in 0..5 {
        let distance = |point: &ClipPoint| distances(point, projection.near())[plane];
        let mut kept = Polygon::new();
        let mut crossings: SmallVec<[ClipPoint; 2]> = SmallVec::new();
        for (i, to) in polygon.iter().enumerate() {
            let from = &polygon[(i + polygon.len() - 1) % polygon.len()];
            let (a, b) = (distance(from), distance(to));
            if (a >= 0.0) != (b >= 0.0) {
                // Interpolates from the inner to the outer point, so that both triangles at an edge cut it at
                // the same point.
                let (inside, outer, d_in, d_out) = if a >= 0.0 {
                    (from, to, a, b)
                } else {
                    (to, from, b, a)
                };
                let crossing = ClipPoint::mix(*inside, *outer, d_in / (d_in - d_out));
                kept.push(crossing);
                crossings.push(crossing);
            }
            if b >= 0.0 {
                kept.push(*to);
            }
        }
        if plane == 0 && crossings.len() == 2 {
            cut = Some([crossings[0], crossings[1]]);
        }
        polygon = kept;
        if polygon.len() < 3 {
            return (Polygon::new(), cut);
        }
    }
    (polygon, cut)
}

/// The part of a segment behind the near plane and inside the guard band.
pub(super) fn clip_segment(
    projection: &Projection,
    [mut a, mut b]: [ClipPoint; 2],
) -> Option<[ClipPoint; 2]> {
    for plane in 0..5 {
        let distance = |point: &ClipPoint| distances(point, projection.near())[plane];
        let (da, db) = (distance(&a), distance(&b));
        match (da >= 0.0, db >= 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (true, false) => b = ClipPoint::mix(a, b, da / (da - db)),
            (false, true) => a = ClipPoint::mix(b, a, db / (db - da)),
        }
    }
    Some([a, b])
}

//! Convex polygons, given by their corners in order, and linear functions that cut them.

use glam::DVec3;
use smallvec::SmallVec;

/// The part of the polygon where a linear function is not negative.
///
/// Source: Sutherland & Hodgman 1974, "Reentrant Polygon Clipping".
pub fn clip(corners: &[DVec3], side: impl Fn(DVec3) -> f64) -> SmallVec<[DVec3; 8]> {
    let mut kept = SmallVec::new();
    for (i, &to) in corners.iter().enumerate() {
        let from = corners[(i + corners.len() - 1) % corners.len()];
        kept.extend(crossing(from, to, &side));
        if side(to) >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

/// The two points of the polygon's border where the function is 0. `None` unless there are exactly two.
pub fn chord(corners: &[DVec3], side: impl Fn(DVec3) -> f64) -> Option<[DVec3; 2]> {
    let sides = (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]);
    let mut crossings = sides.filter_map(|[from, to]| crossing(from, to, &side));
    match (crossings.next(), crossings.next(), crossings.next()) {
        (Some(one), Some(other), None) => Some([one, other]),
        _ => None,
    }
}

fn crossing(from: DVec3, to: DVec3, side: impl Fn(DVec3) -> f64) -> Option<DVec3> {
    let (at_from, at_to) = (side(from), side(to));
    ((at_from >= 0.0) != (at_to >= 0.0)).then(|| from + (to - from) * (at_from / (at_from - at_to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [DVec3; 4] = [
        DVec3::new(0.0, 0.0, 0.0),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(0.0, 1.0, 0.0),
    ];

    #[test]
    fn a_corner_is_cut_off() {
        let side = |p: DVec3| 1.5 - p.x - p.y;
        let kept = clip(&SQUARE, side);
        assert_eq!(kept.len(), 5);
        assert!(kept.iter().all(|p| side(*p) >= -1e-12) && !kept.contains(&SQUARE[2]));
        let [one, other] = chord(&SQUARE, side).expect("it is cut");
        assert_eq!(
            (one, other),
            (DVec3::new(1.0, 0.5, 0.0), DVec3::new(0.5, 1.0, 0.0))
        );
    }

    #[test]
    fn what_is_not_cut_is_kept_or_gone() {
        assert_eq!(clip(&SQUARE, |_| 1.0).len(), 4);
        assert!(clip(&SQUARE, |_| -1.0).is_empty());
        assert!(chord(&SQUARE, |_| 1.0).is_none() && chord(&[], |p| p.x).is_none());
    }
}

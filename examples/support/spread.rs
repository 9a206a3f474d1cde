//! Evenly spread points.

use glam::DVec3;

/// Returns a point of a low-discrepancy sequence in the unit cube. Source: Roberts 2018, "The Unreasonable
/// Effectiveness of Quasirandom Sequences" (R3).
pub fn spread(index: usize) -> DVec3 {
    const G: f64 = 1.220_744_084_605_759_5;
    DVec3::new(1.0 / G, 1.0 / (G * G), 1.0 / (G * G * G)).map(|step| (0.5 + step * index as f64).fract())
}

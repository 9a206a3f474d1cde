//! Welding of vertices.

use glam::Vec3;

/// For every vertex, the lowest-numbered vertex that it welds with. That is the vertex itself if it is alone.
///
/// Without an epsilon, vertices weld if their positions are bit-exactly equal, with −0 equal to 0. With an
/// epsilon, space is cut into cubes of that width, centred on multiples of it, and vertices in one cube weld.
/// Two vertices nearer than the epsilon may lie in different cubes; two in one cube are less than √3 epsilon
/// apart. Unlike a test of distances, this is transitive and does not depend on the order of the vertices.
///
/// Vertices with different pose keys never weld. The result for positions that are not finite is unspecified.
pub(super) fn weld(positions: &[Vec3], pose_keys: Option<&[u32]>, epsilon: Option<f32>) -> Vec<u32> {
    // Sorting instead of hashing puts the lowest index first and gives a unique result.
    let mut order: Vec<([u64; 3], u32, u32)> = (0u32..)
        .zip(positions)
        .map(|(vertex, &position)| {
            let pose_key = pose_keys.map_or(0, |keys| keys[vertex as usize]);
            (place(position, epsilon), pose_key, vertex)
        })
        .collect();
    order.sort_unstable();
    let mut welded = vec![0; positions.len()];
    let mut first = order.first().copied().unwrap_or_default();
    for entry in order {
        if (entry.0, entry.1) != (first.0, first.1) {
            first = entry;
        }
        welded[entry.2 as usize] = first.2;
    }
    welded
}

/// A key that is equal for positions that weld. Adding 0 turns −0 into 0. `f64` keeps neighbouring
/// coordinates apart, however far they are from the origin and however small the cells.
fn place(position: Vec3, epsilon: Option<f32>) -> [u64; 3] {
    position.to_array().map(|coordinate| {
        let coordinate = f64::from(coordinate);
        let place = epsilon.map_or(coordinate, |width| (coordinate / f64::from(width)).round());
        (place + 0.0).to_bits()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lowest_vertex_names_the_welded_one_and_zero_has_no_sign() {
        let positions = [Vec3::ONE, Vec3::ZERO, Vec3::new(-0.0, 0.0, -0.0), Vec3::ONE];
        assert_eq!(weld(&positions, None, None), [0, 1, 1, 0]);
    }

    #[test]
    fn different_pose_keys_never_weld() {
        let positions = [Vec3::ONE; 4];
        assert_eq!(weld(&positions, Some(&[7, 3, 7, 3]), None), [0, 1, 0, 1]);
        assert_eq!(weld(&positions, Some(&[7, 3, 7, 3]), Some(0.5)), [0, 1, 0, 1]);
    }

    #[test]
    fn epsilon_welds_by_cell() {
        let positions = [0.0, 0.04, 0.06, 0.14, -0.04].map(|x| Vec3::new(x, 0.0, 0.0));
        assert_eq!(weld(&positions, None, Some(0.1)), [0, 0, 2, 2, 0]);
        assert_eq!(weld(&positions, None, None), [0, 1, 2, 3, 4]);
    }
}

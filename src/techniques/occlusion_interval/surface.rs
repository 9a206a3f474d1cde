//! How a surface of the scene is recognized: by its triangles and by its place.

use glam::{Affine3A, Vec3};

use crate::scene::{MeshData, Submesh};

/// Largest difference of axes that count as the same, as a share of the longest one, and of origins, metres. Compilers round
/// products differently.
const SAME: f32 = 1e-5;

/// Number of roundings by which origins that count as the same may differ.
const ULPS: f32 = 8.0;

/// Offset and factor of the hash. Source: Fowler, Noll, Vo, FNV-1a with 64 bits, over words instead of bytes.
const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FACTOR: u64 = 0x0000_0100_0000_01b3;

/// A hash that is the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StableHash(u64);

impl Default for StableHash {
    fn default() -> Self {
        Self(OFFSET)
    }
}

impl StableHash {
    /// Adds a number.
    pub fn add(&mut self, value: u64) {
        self.0 = (self.0 ^ value).wrapping_mul(FACTOR);
        // Multiplication moves differences upwards only.
        self.0 ^= self.0 >> 29;
    }

    /// Adds a number's bits. The two zeros count as one.
    pub fn add_float(&mut self, value: f32) {
        self.add(u64::from((value + 0.0).to_bits()));
    }

    /// Adds bytes and their number.
    #[cfg(any(feature = "render", feature = "reference", test))]
    pub fn add_bytes(&mut self, bytes: &[u8]) {
        self.add(bytes.len() as u64);
        for word in bytes.chunks(8) {
            let mut padded = [0; 8];
            padded[..word.len()].copy_from_slice(word);
            self.add(u64::from_le_bytes(padded));
        }
    }

    /// The hash of everything added.
    pub fn value(self) -> u64 {
        self.0
    }
}

/// Yields the corners of a submesh's triangles in its own space; `None` for a triangle that names a missing vertex or is
/// not finite.
pub fn local_triangles<'a>(
    mesh: &'a MeshData,
    submesh: &Submesh,
) -> impl Iterator<Item = Option<[Vec3; 3]>> + 'a {
    let triangles = mesh.indices[mesh.submesh_range(submesh)].chunks_exact(3);
    triangles.map(|corners| {
        let corner = |at: usize| {
            let position = mesh.positions.get(corners[at] as usize).copied();
            position.filter(|position| position.is_finite())
        };
        Some([corner(0)?, corner(1)?, corner(2)?])
    })
}

/// The hash of a submesh: the positions of all corners in their order. It does not depend on how vertices are shared, so
/// importers that split or merge vertices and meshes agree on it.
pub fn surface_hash(mesh: &MeshData, submesh: &Submesh) -> u64 {
    let mut hash = StableHash::default();
    for triangle in local_triangles(mesh, submesh) {
        let Some(corners) = triangle else {
            hash.add(u64::MAX);
            continue;
        };
        for value in corners.into_iter().flat_map(|corner| corner.to_array()) {
            hash.add_float(value);
        }
    }
    hash.value()
}

/// Whether two transforms are the same but for rounding.
///
/// Axes may differ by [`SAME`] of the longest one. Origins may differ by [`SAME`] metres and by [`ULPS`] roundings of their
/// largest coordinate, because a parent's transform is rounded as well.
pub fn is_same_place(baked: &[f32; 12], now: &Affine3A) -> bool {
    let now = now.to_cols_array();
    let largest = |values: &[f32]| {
        values
            .iter()
            .fold(0.0f32, |largest, value| largest.max(value.abs()))
    };
    let (axes, origin) = now.split_at(9);
    let axis_tolerance = SAME * largest(axes);
    let origin_tolerance = SAME + ULPS * f32::EPSILON * largest(origin);
    let is_near = |baked: &[f32], now: &[f32], tolerance: f32| {
        let mut pairs = baked.iter().zip(now);
        pairs.all(|(baked, now)| (baked - now).abs() <= tolerance)
    };
    is_near(&baked[..9], axes, axis_tolerance) && is_near(&baked[9..], origin, origin_tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_surface_is_known_by_its_corners_however_its_vertices_are_shared() {
        let mesh = MeshData::icosphere(1.0, 1);
        let positions = mesh.indices.iter().map(|&i| mesh.positions[i as usize]).collect();
        let split = MeshData::from_triangles("split", positions, (0..mesh.indices.len() as u32).collect());
        let hash = |mesh: &MeshData| surface_hash(mesh, &mesh.submeshes[0]);
        assert_eq!(hash(&mesh), hash(&split));
        let mut moved = mesh.clone();
        moved.positions[5].y += 1e-6;
        assert_ne!(hash(&mesh), hash(&moved));
        let mut swapped = mesh.clone();
        swapped.indices.swap(0, 1);
        assert_ne!(hash(&mesh), hash(&swapped));
    }

    #[test]
    fn rounding_keeps_a_place_and_a_millimetre_does_not() {
        let place =
            Affine3A::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::new(3.0, 0.0, -7.0));
        let mut baked = place.to_cols_array();
        baked[4] += 1e-7;
        assert!(is_same_place(&baked, &place));
        baked[10] += 1e-3;
        assert!(!is_same_place(&baked, &place));
    }

    #[test]
    fn a_place_far_away_is_told_from_one_that_is_turned_or_moved_a_little() {
        let at = |angle: f32, x: f32| {
            Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), Vec3::new(x, 0.0, 0.0))
        };
        let baked = at(0.7, 2000.0).to_cols_array();
        assert!(is_same_place(&baked, &at(0.7, 2000.0)));
        assert!(is_same_place(&baked, &at(0.7, 2000.001)), "some roundings");
        assert!(
            !is_same_place(&baked, &at(0.701, 2000.0)),
            "a millimetre at a metre"
        );
        assert!(!is_same_place(&baked, &at(0.7, 2000.01)));
        let small = |scale: f32| Affine3A::from_scale(Vec3::splat(scale));
        assert!(!is_same_place(&small(0.001).to_cols_array(), &small(0.00101)));
    }

    #[test]
    fn bytes_count_with_their_length() {
        let hash = |bytes: &[u8]| {
            let mut hash = StableHash::default();
            hash.add_bytes(bytes);
            hash.value()
        };
        assert_ne!(hash(&[1, 2]), hash(&[1, 2, 0]));
        assert_ne!(hash(&[]), hash(&[0]));
    }
}

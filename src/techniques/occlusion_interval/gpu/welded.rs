//! Vertices and indices of the surfaces of maps. Corners with the same position and place on the page share one vertex, which
//! is transformed once for all of their triangles. Meshes need not share it: those with a normal for each face do not.

use std::collections::HashMap;

use super::gpu_types::IntervalVertex;

/// Vertices and indices, while surfaces are added.
#[derive(Debug, Default)]
pub struct Welded {
    /// The vertices of all surfaces.
    pub vertices: Vec<IntervalVertex>,
    /// Three indices for each triangle.
    pub indices: Vec<u32>,
    /// The vertices of the current surface, by their bits.
    known: HashMap<[u32; WORDS], u32>,
}

/// Number of words of a vertex.
const WORDS: usize = size_of::<IntervalVertex>() / 4;

impl Welded {
    /// Begins a surface. It shares no vertex with the surfaces before.
    pub fn begin(&mut self) {
        self.known.clear();
    }

    /// Adds a corner of a triangle.
    pub fn add(&mut self, corner: IntervalVertex) {
        let next = self.vertices.len() as u32;
        let index = *self.known.entry(bytemuck::cast(corner)).or_insert(next);
        if index == next {
            self.vertices.push(corner);
        }
        self.indices.push(index);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_corners_share_vertices_and_those_of_other_charts_do_not() {
        let corner = |x: f32, u: f32| IntervalVertex {
            position_local: [x, 0.0, 0.0],
            texel: [u, 1.0],
            layers: 1 << 16,
        };
        let mut welded = Welded::default();
        welded.begin();
        for (x, u) in [
            (0.0, 3.0),
            (1.0, 4.0),
            (2.0, 5.0),
            (2.0, 5.0),
            (1.0, 4.0),
            (3.0, 6.0),
            (1.0, 9.0),
            (1.0, 4.0),
        ] {
            welded.add(corner(x, u));
        }
        assert_eq!(welded.indices, [0, 1, 2, 2, 1, 3, 4, 1]);
        assert_eq!(welded.vertices.len(), 5);
        welded.begin();
        welded.add(corner(0.0, 3.0));
        assert_eq!(welded.indices[8..], [5], "another surface");
    }
}

//! Vertices and indices of the surfaces of maps. Triangles that share a vertex of the mesh and its place on the page share one
//! vertex, which is transformed once for all of them.

use super::gpu_types::IntervalVertex;

/// The end of a list of vertices.
const END: u32 = u32::MAX;

/// Vertices and indices, while surfaces are added.
#[derive(Debug, Default)]
pub struct Welded {
    /// The vertices of all surfaces.
    pub vertices: Vec<IntervalVertex>,
    /// Three indices for each triangle.
    pub indices: Vec<u32>,
    /// For each vertex of the mesh, the last vertex that was made of it.
    last: Vec<u32>,
    /// For each vertex, the one before that was made of the same vertex of the mesh.
    before: Vec<u32>,
}

impl Welded {
    /// Begins a surface of a mesh with a number of vertices. It shares none with the surfaces before.
    pub fn begin(&mut self, vertex_count: usize) {
        self.last.clear();
        self.last.resize(vertex_count, END);
    }

    /// Adds a corner of a triangle, which is a vertex of the mesh.
    pub fn add(&mut self, mesh_vertex: u32, corner: IntervalVertex) {
        let Some(last) = self.last.get_mut(mesh_vertex as usize) else {
            return;
        };
        let mut known = *last;
        while known != END && self.vertices[known as usize] != corner {
            known = self.before[known as usize];
        }
        if known == END {
            known = self.vertices.len() as u32;
            self.vertices.push(corner);
            self.before.push(*last);
            *last = known;
        }
        self.indices.push(known);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_one_chart_share_vertices_and_those_of_others_do_not() {
        let corner = |x: f32, u: f32| IntervalVertex {
            position_local: [x, 0.0, 0.0],
            texel: [u, 1.0],
            layers: 1 << 16,
        };
        let mut welded = Welded::default();
        welded.begin(4);
        for (vertex, texel) in [
            (0, 3.0),
            (1, 4.0),
            (2, 5.0),
            (2, 5.0),
            (1, 4.0),
            (3, 6.0),
            (1, 9.0),
            (1, 4.0),
        ] {
            welded.add(vertex, corner(vertex as f32, texel));
        }
        assert_eq!(welded.indices, [0, 1, 2, 2, 1, 3, 4, 1]);
        assert_eq!(welded.vertices.len(), 5);
        welded.begin(1);
        welded.add(0, corner(0.0, 3.0));
        welded.add(7, corner(0.0, 3.0));
        assert_eq!(welded.indices[8..], [5], "another surface; no such vertex");
    }
}

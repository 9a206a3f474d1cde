//! The contour as closed loops.

/// Closed loops over a contour's edges. Each edge is in exactly one loop; no loop visits a vertex twice.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Loops {
    /// Indices of edges, one loop after the other. Each edge of a loop starts where the edge before it ends.
    pub edges: Vec<u32>,
    /// Where each loop starts in `edges`, and where the last one ends. Empty if there are no loops.
    pub starts: Vec<u32>,
    scratch: Scratch,
}

/// Memory that lasts from one call to the next.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Scratch {
    /// Edges, sorted by the vertex from which they start.
    outgoing: Vec<u32>,
    /// All vertices, ascending. The other lists refer to a vertex by its place in this one.
    vertices: Vec<u32>,
    /// For each edge, the place of the vertex where it ends.
    ends: Vec<u32>,
    /// For each vertex, its next unused entry of `outgoing`.
    next: Vec<u32>,
    /// For each vertex, the end of its entries of `outgoing`.
    last: Vec<u32>,
    /// For each vertex, 1 + its position on the path, or 0.
    on_path: Vec<u32>,
    path: Vec<u32>,
}

/// Why edges do not make closed loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoopError {
    /// A vertex starts more or fewer edges than it ends; in a contour the numbers are equal.
    #[error("vertex {vertex} starts {starting} edges and ends {ending}")]
    Unbalanced {
        /// The vertex.
        vertex: u32,
        /// Edges that start at it.
        starting: usize,
        /// Edges that end at it.
        ending: usize,
    },
}

/// Splits the directed edges of a [`Contour`](super::Contour) into closed loops.
///
/// # Errors
/// [`LoopError::Unbalanced`]; it never occurs for the edges of a contour.
pub fn link_loops(edge_vertices: &[[u32; 2]]) -> Result<Loops, LoopError> {
    let mut loops = Loops::default();
    loops.link(edge_vertices)?;
    Ok(loops)
}

impl Loops {
    /// Iterates over the loops, each a list of edges.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts
            .windows(2)
            .map(|ends| &self.edges[ends[0] as usize..ends[1] as usize])
    }

    /// Number of loops.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are no loops.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Does what [`link_loops`] does, in memory that is there already. After an error there are no loops.
    ///
    /// It walks along unused edges, lowest first, and cuts a loop off as soon as the walk meets itself. In a
    /// balanced graph it can only get stuck where it began. O(n log n); the same edges give the same loops.
    /// Source: Hierholzer 1873, without joining the loops into one.
    ///
    /// # Errors
    /// [`LoopError::Unbalanced`], as in [`link_loops`].
    pub fn link(&mut self, edge_vertices: &[[u32; 2]]) -> Result<(), LoopError> {
        self.edges.clear();
        self.starts.clear();
        self.scratch.index(edge_vertices)?;
        if edge_vertices.is_empty() {
            return Ok(());
        }
        self.starts.push(0);
        for vertex in 0..self.scratch.vertices.len() {
            while self.scratch.next[vertex] < self.scratch.last[vertex] {
                self.walk(vertex);
            }
        }
        Ok(())
    }

    /// Walks from `start` until the path has dissolved into loops.
    fn walk(&mut self, start: usize) {
        let Scratch {
            outgoing,
            vertices: _,
            ends,
            next,
            last: _,
            on_path,
            path,
        } = &mut self.scratch;
        let mut vertex = start;
        on_path[vertex] = 1;
        loop {
            let edge = outgoing[next[vertex] as usize];
            next[vertex] += 1;
            path.push(edge);
            vertex = ends[edge as usize] as usize;
            if on_path[vertex] == 0 {
                on_path[vertex] = path.len() as u32 + 1;
                continue;
            }
            let first = on_path[vertex] as usize - 1;
            // The loop's other vertices leave the path; the path continues from the vertex where the loop
            // closes.
            for &edge in &path[first..path.len() - 1] {
                on_path[ends[edge as usize] as usize] = 0;
            }
            self.edges.extend(path.drain(first..));
            self.starts.push(self.edges.len() as u32);
            if path.is_empty() {
                on_path[vertex] = 0;
                return;
            }
        }
    }
}

impl Scratch {
    /// Lists the vertices and the edges that leave each. It fails at a vertex where fewer or more edges
    /// arrive than leave.
    fn index(&mut self, edge_vertices: &[[u32; 2]]) -> Result<(), LoopError> {
        self.vertices.clear();
        self.vertices.extend(edge_vertices.as_flattened());
        self.vertices.sort_unstable();
        self.vertices.dedup();
        self.outgoing.clear();
        self.outgoing.extend(0..edge_vertices.len() as u32);
        self.outgoing
            .sort_unstable_by_key(|&edge| (edge_vertices[edge as usize][0], edge));

        let place = |vertex: u32| self.vertices.partition_point(|&other| other < vertex);
        self.ends.clear();
        self.ends
            .extend(edge_vertices.iter().map(|&[_, end]| place(end) as u32));
        // `on_path` first counts the edges that arrive at each vertex.
        self.on_path.clear();
        self.on_path.resize(self.vertices.len(), 0);
        for &end in &self.ends {
            self.on_path[end as usize] += 1;
        }
        self.next.clear();
        self.last.clear();
        let mut first = 0;
        for (place, &vertex) in self.vertices.iter().enumerate() {
            let starting = self.outgoing[first..]
                .iter()
                .take_while(|&&edge| edge_vertices[edge as usize][0] == vertex)
                .count();
            let ending = self.on_path[place] as usize;
            if starting != ending {
                return Err(LoopError::Unbalanced {
                    vertex,
                    starting,
                    ending,
                });
            }
            self.next.push(first as u32);
            first += starting;
            self.last.push(first as u32);
        }
        self.on_path.fill(0);
        self.path.clear();
        Ok(())
    }
}

//! The contour as closed loops.

/// Closed loops over a contour's edges. Each edge is in exactly one; no loop visits a vertex twice.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Loops {
    /// Indices of edges, loop after loop, each edge starting where the one before it ends.
    pub edges: Vec<u32>,
    /// Where each loop starts in `edges`, and the end of the last; empty without loops.
    pub starts: Vec<u32>,
    scratch: Scratch,
}

/// Memory that lasts from one call to the next.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Scratch {
    /// Edges by the vertex that they start from.
    outgoing: Vec<u32>,
    /// The vertices, ascending; a vertex is named by its place here.
    vertices: Vec<u32>,
    /// For each edge the place of its end.
    ends: Vec<u32>,
    /// For each vertex its next unused entry of `outgoing`; then where they end.
    next: Vec<u32>,
    last: Vec<u32>,
    /// For each vertex 1 + where it is on the path, or 0.
    on_path: Vec<u32>,
    path: Vec<u32>,
}

/// Edges that do not make closed loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoopError {
    /// Every vertex of a contour starts as many edges as it ends.
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
/// [`LoopError::Unbalanced`]; a contour never is.
pub fn link_loops(edge_vertices: &[[u32; 2]]) -> Result<Loops, LoopError> {
    let mut loops = Loops::default();
    loops.link(edge_vertices)?;
    Ok(loops)
}

impl Loops {
    /// The loops, each a list of edges.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts
            .windows(2)
            .map(|ends| &self.edges[ends[0] as usize..ends[1] as usize])
    }

    /// Number of loops.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// As [`link_loops`], into memory that is there already. After an error there are no loops.
    ///
    /// Walks along unused edges, lowest first, and cuts a loop off as soon as the walk meets itself: in a balanced
    /// graph it can only get stuck where it began. O(n log n); the same edges give the same loops.
    /// Source: Hierholzer 1873, without joining the loops into one.
    ///
    /// # Errors
    /// As [`link_loops`].
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
            // The loop's other vertices leave the path; where the loop closes, the path goes on.
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
    /// Lists the vertices and the edges that leave each; fails where fewer or more arrive than leave.
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
        // As balances first: arriving edges.
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

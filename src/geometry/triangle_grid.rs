//! A grid over a plane whose cells list the triangles that may touch them.

use glam::DVec2;

/// The greatest mean number of cells that list a triangle. Triangles that are as large as the whole, such as those of a fan,
/// would otherwise be in as many cells as there are triangles.
const CELLS_PER_TRIANGLE: usize = 64;

/// The largest number of cells along a side.
const MOST_CELLS: f64 = 1024.0;

/// The triangles whose bounds touch each cell of a grid, which spans the bounds of all triangles.
#[derive(Debug)]
pub struct TriangleGrid {
    min: DVec2,
    size: DVec2,
    side: usize,
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl TriangleGrid {
    /// Lists triangles in the cells of a grid. It has about as many cells as there are triangles, or fewer if these are large:
    /// in the mean, at most 64 cells list a triangle.
    pub fn new(triangles: &[[DVec2; 3]]) -> Self {
        let corners = || triangles.iter().flatten().copied();
        let min = corners().fold(DVec2::INFINITY, DVec2::min);
        let max = corners().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut grid = Self {
            min,
            size: max - min,
            side: (triangles.len() as f64).sqrt().ceil().clamp(1.0, MOST_CELLS) as usize,
            starts: Vec::new(),
            triangles: Vec::new(),
        };
        while grid.side > 1 && grid.needed_entries(triangles) > CELLS_PER_TRIANGLE * triangles.len() {
            grid.side /= 2;
        }
        let mut entries: Vec<(u32, u32)> = Vec::with_capacity(grid.needed_entries(triangles));
        for (triangle, corners) in triangles.iter().enumerate() {
            let [low, high] = grid.cells_of(corners);
            for row in low.1..=high.1 {
                let cells = low.0..=high.0;
                entries.extend(cells.map(|column| ((row * grid.side + column) as u32, triangle as u32)));
            }
        }
        entries.sort_unstable();
        grid.starts = vec![0; grid.side * grid.side + 1];
        for &(cell, _) in &entries {
            grid.starts[cell as usize + 1] += 1;
        }
        for cell in 0..grid.side * grid.side {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        grid.triangles = entries.into_iter().map(|(_, triangle)| triangle).collect();
        grid
    }

    /// The size of the bounds of all triangles.
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// The first and the last cell whose lists hold a triangle, column and row.
    pub fn cells_of(&self, [a, b, c]: &[DVec2; 3]) -> [(usize, usize); 2] {
        [self.cell(a.min(*b).min(*c)), self.cell(a.max(*b).max(*c))]
    }

    /// The triangles that a point may be in, ascending.
    pub fn at(&self, at: DVec2) -> &[u32] {
        self.listed(self.cell(at))
    }

    /// All cells, column and row.
    #[cfg_attr(
        not(feature = "reference"),
        allow(dead_code, reason = "baking alone walks over cells")
    )]
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let side = self.side;
        (0..side).flat_map(move |row| (0..side).map(move |column| (column, row)))
    }

    /// The triangles that a cell lists, ascending.
    pub fn listed(&self, (column, row): (usize, usize)) -> &[u32] {
        let cell = row * self.side + column;
        &self.triangles[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    fn cell(&self, at: DVec2) -> (usize, usize) {
        let cell = (at - self.min) * self.side as f64 / self.size.max(DVec2::splat(f64::MIN_POSITIVE));
        let index = |x: f64| (x.max(0.0) as usize).min(self.side - 1);
        (index(cell.x), index(cell.y))
    }

    /// The number of pairs of a triangle and a cell that lists it.
    fn needed_entries(&self, triangles: &[[DVec2; 3]]) -> usize {
        let cells = |triangle| {
            let [low, high] = self.cells_of(triangle);
            (high.0 - low.0 + 1) * (high.1 - low.1 + 1)
        };
        triangles.iter().map(cells).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_is_bounded_where_all_triangles_are_large() {
        let count = 20_000;
        let rim = |i: usize| DVec2::from_angle(std::f64::consts::TAU * i as f64 / count as f64);
        let fan: Vec<[DVec2; 3]> = (0..count).map(|i| [DVec2::ZERO, rim(i), rim(i + 1)]).collect();
        let grid = TriangleGrid::new(&fan);
        assert!(grid.triangles.len() <= CELLS_PER_TRIANGLE * count && grid.side > 8);
        // Triangles of the size of cells leave the grid as fine as it is.
        let fine: Vec<[DVec2; 3]> = (0..count)
            .map(|i| DVec2::new((i % 141) as f64, (i / 141) as f64))
            .map(|at| [at, at + DVec2::X, at + DVec2::Y])
            .collect();
        assert_eq!(TriangleGrid::new(&fine).side, 142);
    }

    #[test]
    fn every_triangle_is_listed_in_its_cells_alone() {
        let triangles: Vec<[DVec2; 3]> = (0..500)
            .map(|i| {
                let at = |k: i32| f64::from((i * k + 7) % 101) / 101.0;
                let corner = DVec2::new(at(3), 0.01 * at(5));
                [0, 1, 2].map(|k| corner + 0.05 * DVec2::new(at(11 + k), 0.01 * at(17 + k)))
            })
            .collect();
        let grid = TriangleGrid::new(&triangles);
        assert!(grid.side > 20, "a narrow strip has as many cells as a square");
        let mut listed = 0;
        for cell in grid.cells() {
            assert!(grid.listed(cell).is_sorted());
            for &triangle in grid.listed(cell) {
                let [low, high] = grid.cells_of(&triangles[triangle as usize]);
                assert!((low.0..=high.0).contains(&cell.0) && (low.1..=high.1).contains(&cell.1));
                listed += 1;
            }
        }
        assert_eq!(listed, grid.needed_entries(&triangles));
        for (index, [a, b, c]) in (0..).zip(&triangles) {
            assert!(grid.at((*a + *b + *c) / 3.0).contains(&index));
        }
    }

    #[test]
    fn triangles_in_one_place_or_none_have_one_cell_or_are_found() {
        let point = [DVec2::ONE; 3];
        assert_eq!(TriangleGrid::new(&[point; 3]).at(DVec2::ONE), [0, 1, 2]);
        let none = TriangleGrid::new(&[]);
        assert!(none.cells().all(|cell| none.listed(cell).is_empty()));
    }
}

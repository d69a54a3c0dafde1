//! Contact clusters: connected sets of cells with p > 0.

use ndarray::Array2;

use crate::{Boundary, Solution};
use asperity_base::map::Grid;

/// Definition of neighbouring cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Neighbours {
    /// Cells that share an edge.
    #[default]
    Edges,
    /// Cells that share an edge or a corner.
    EdgesAndCorners,
}

impl Neighbours {
    /// Returns the row and column offsets of the neighbours that come earlier in row order.
    fn earlier(self) -> &'static [(isize, isize)] {
        match self {
            Self::Edges => &[(0, -1), (-1, 0)],
            Self::EdgesAndCorners => &[(0, -1), (-1, 0), (-1, -1), (-1, 1)],
        }
    }
}

/// Contact clusters, numbered from 1 in the order of their first cells, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Clusters {
    labels: Array2<u32>,
    cells: Vec<usize>,
    loads_n: Vec<f64>,
    cell_area_m2: f64,
}

impl Clusters {
    /// Finds the clusters of the cells with p > 0 of `pressure_pa`, shape `[ny, nx]`. On the periodic boundary opposite
    /// borders are neighbours. The time is nearly proportional to the number of cells.
    ///
    /// # References
    /// R. E. Tarjan, *J. ACM* **22** (1975) 215 (union and find), <https://doi.org/10.1145/321879.321884>. J. Hoshen and
    /// R. Kopelman, *Phys. Rev. B* **14** (1976) 3438 (clusters on grids), <https://doi.org/10.1103/PhysRevB.14.3438>.
    ///
    /// # Panics
    /// If the field does not fit the grid, or has 2³² cells or more.
    pub fn new(pressure_pa: &Array2<f64>, grid: Grid, boundary: Boundary, neighbours: Neighbours) -> Self {
        assert_eq!(pressure_pa.dim(), grid.shape(), "the pressure does not fit the grid");
        let mut forest = Forest::new(grid.points());
        let wrap = matches!(boundary, Boundary::Periodic { .. });
        let (ny, nx) = (grid.ny() as isize, grid.nx() as isize);
        for ((row, column), _) in pressure_pa.indexed_iter().filter(|(_, p)| **p > 0.0) {
            for (down, right) in neighbours.earlier() {
                let (y, x) = (row as isize + down, column as isize + right);
                let inside = (0..ny).contains(&y) && (0..nx).contains(&x);
                if !inside && !wrap {
                    continue;
                }
                let (y, x) = (y.rem_euclid(ny) as usize, x.rem_euclid(nx) as usize);
                if pressure_pa[[y, x]] > 0.0 {
                    forest.unite(row * grid.nx() + column, y * grid.nx() + x);
                }
            }
        }
        let mut clusters = Self {
            labels: Array2::zeros(grid.shape()),
            cells: Vec::new(),
            loads_n: Vec::new(),
            cell_area_m2: grid.cell_area_m2(),
        };
        let mut label_of_root = vec![0; grid.points()];
        for (cell, (label, p)) in
            clusters.labels.iter_mut().zip(pressure_pa).enumerate().filter(|(_, (_, p))| **p > 0.0)
        {
            let root = forest.root(cell);
            if label_of_root[root] == 0 {
                clusters.cells.push(0);
                clusters.loads_n.push(0.0);
                label_of_root[root] = clusters.cells.len() as u32;
            }
            *label = label_of_root[root];
            let place = *label as usize - 1;
            clusters.cells[place] += 1;
            clusters.loads_n[place] += p * clusters.cell_area_m2;
        }
        clusters
    }

    /// Returns the number of clusters.
    pub fn count(&self) -> usize {
        self.cells.len()
    }

    /// Returns the number of the cluster of each cell, from 1, shape `[ny, nx]`; 0 out of contact.
    pub fn labels(&self) -> &Array2<u32> {
        &self.labels
    }

    /// Returns the labels without a copy.
    pub fn into_labels(self) -> Array2<u32> {
        self.labels
    }

    /// Returns the number of cells of each cluster, starting with cluster 1.
    pub fn cells(&self) -> &[usize] {
        &self.cells
    }

    /// Returns the area of each cluster in square metre, cells counted whole.
    pub fn areas_m2(&self) -> Vec<f64> {
        self.cells.iter().map(|cells| *cells as f64 * self.cell_area_m2).collect()
    }

    /// Returns the load of each cluster in newton.
    pub fn loads_n(&self) -> &[f64] {
        &self.loads_n
    }

    /// Returns the number, from 1, of the cluster with the most cells (the first of equal ones); `None` without contact.
    pub fn largest(&self) -> Option<u32> {
        let largest = self.cells.iter().max()?;
        let place = self.cells.iter().position(|cells| cells == largest)?;
        Some(place as u32 + 1)
    }

    /// Returns the area of the largest cluster in square metre; 0 without contact.
    pub fn largest_m2(&self) -> f64 {
        self.cells.iter().max().map_or(0.0, |cells| *cells as f64 * self.cell_area_m2)
    }

    /// Returns the number of cells of the largest cluster over that of all cells in contact; `None` without contact.
    pub fn largest_fraction(&self) -> Option<f64> {
        let largest = self.cells.iter().max()?;
        Some(*largest as f64 / self.cells.iter().sum::<usize>() as f64)
    }
}

impl Solution {
    /// Returns the contact clusters; see [`Clusters::new`].
    pub fn clusters(&self, neighbours: Neighbours) -> Clusters {
        Clusters::new(&self.pressure_pa, self.grid, self.boundary, neighbours)
    }
}

/// Disjoint sets of cells as trees. Each cell points to an earlier one or, at the root, to itself; the root is the
/// first cell.
struct Forest(Vec<u32>);

impl Forest {
    fn new(cells: usize) -> Self {
        assert!(u32::try_from(cells).is_ok(), "{cells} cells are too many to number");
        Self((0..cells as u32).collect())
    }

    fn root(&mut self, cell: usize) -> usize {
        let Self(parent) = self;
        let mut cell = cell;
        while parent[cell] as usize != cell {
            // Path halving: every other cell now points closer to the root.
            parent[cell] = parent[parent[cell] as usize];
            cell = parent[cell] as usize;
        }
        cell
    }

    fn unite(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    const PERIODIC: Boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.0 };

    /// Labels clusters by flood filling one after the other.
    fn flooded(pressure: &Array2<f64>, boundary: Boundary, neighbours: Neighbours) -> Array2<u32> {
        let (ny, nx) = pressure.dim();
        let wrap = boundary != Boundary::Free;
        let mut labels = Array2::zeros((ny, nx));
        let mut count = 0;
        for start in 0..ny * nx {
            let start = (start / nx, start % nx);
            if pressure[start] <= 0.0 || labels[start] > 0 {
                continue;
            }
            count += 1;
            let mut dry = vec![start];
            while let Some((row, column)) = dry.pop() {
                if pressure[(row, column)] <= 0.0 || labels[(row, column)] > 0 {
                    continue;
                }
                labels[(row, column)] = count;
                for down in -1..=1 {
                    for right in -1..=1_i32 {
                        if neighbours == Neighbours::Edges && down != 0 && right != 0 {
                            continue;
                        }
                        let (y, x) = (row as i32 + down, column as i32 + right);
                        let (inner_y, inner_x) = (y.rem_euclid(ny as i32), x.rem_euclid(nx as i32));
                        if wrap || (y, x) == (inner_y, inner_x) {
                            dry.push((inner_y as usize, inner_x as usize));
                        }
                    }
                }
            }
        }
        labels
    }

    #[test]
    fn clusters_equal_those_of_a_flood_fill() {
        let shapes = [(2, 2), (2, 9), (9, 2), (3, 3), (17, 23), (40, 31)];
        let mut stream = random::stream(4, "clusters", 0);
        let mut several = 0;
        for (ny, nx) in shapes {
            let grid = Grid::new(nx, ny, 0.5, 2.0).unwrap();
            for threshold in [-9.0, -1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0, 2.0, 9.0] {
                let values = random::standard_normal(&mut stream, nx * ny);
                let field = Array2::from_shape_vec((ny, nx), values).unwrap();
                let pressure = field.mapv(|v| f64::max(v - threshold, 0.0));
                for boundary in [Boundary::Free, PERIODIC] {
                    for neighbours in [Neighbours::Edges, Neighbours::EdgesAndCorners] {
                        let clusters = Clusters::new(&pressure, grid, boundary, neighbours);
                        let wanted = flooded(&pressure, boundary, neighbours);
                        assert_eq!(clusters.labels(), wanted, "{ny} × {nx}, {threshold}, {boundary:?} {neighbours:?}");
                        check_sums(&clusters, &pressure);
                        several += usize::from(clusters.count() > 1);
                    }
                }
            }
        }
        assert!(several > 100, "{several}");
    }

    fn check_sums(clusters: &Clusters, pressure: &Array2<f64>) {
        let most = clusters.labels().iter().copied().max().unwrap_or(0);
        assert_eq!(clusters.count(), most as usize);
        for label in 1..=most {
            let own = || clusters.labels().iter().zip(pressure).filter(|(other, _)| **other == label);
            let place = label as usize - 1;
            assert_eq!(clusters.cells()[place], own().count());
            assert_eq!(clusters.areas_m2()[place], own().count() as f64);
            let load_n: f64 = own().map(|(_, p)| *p).sum();
            assert!((clusters.loads_n()[place] / load_n - 1.0).abs() < 1e-13);
        }
        let contact = pressure.iter().filter(|p| **p > 0.0).count();
        assert_eq!(clusters.cells().iter().sum::<usize>(), contact);
        let Some(largest) = clusters.largest() else {
            assert_eq!((contact, clusters.largest_m2(), clusters.largest_fraction()), (0, 0.0, None));
            return;
        };
        let cells = clusters.cells()[largest as usize - 1];
        assert!(clusters.cells().iter().all(|other| *other <= cells));
        assert_eq!(clusters.largest_m2(), cells as f64);
        assert_eq!(clusters.largest_fraction(), Some(cells as f64 / contact as f64));
    }

    #[test]
    fn a_chequerboard_is_connected_by_corners_only() {
        let grid = Grid::new(8, 6, 1.0, 1.0).unwrap();
        let board = Array2::from_shape_fn((6, 8), |(row, column)| if (row + column) % 2 == 0 { 1.0 } else { 0.0 });
        for boundary in [Boundary::Free, PERIODIC] {
            assert_eq!(Clusters::new(&board, grid, boundary, Neighbours::Edges).count(), 24);
            assert_eq!(Clusters::new(&board, grid, boundary, Neighbours::EdgesAndCorners).count(), 1);
        }
    }

    #[test]
    fn a_spiral_is_one_cluster() {
        // The worst case for row scans: arms that meet only at the centre.
        let n = 101_isize;
        let mut spiral = Array2::zeros((n as usize, n as usize));
        let ((mut y, mut x), (mut down, mut right)) = ((0_isize, 0_isize), (0, 1));
        let free = |spiral: &Array2<f64>, y: isize, x: isize| {
            (0..n).contains(&y) && (0..n).contains(&x) && spiral[[y as usize, x as usize]] == 0.0
        };
        loop {
            spiral[[y as usize, x as usize]] = 1.0;
            let open = |down: isize, right: isize| {
                let beyond = (y + 2 * down, x + 2 * right);
                let outside = !(0..n).contains(&beyond.0) || !(0..n).contains(&beyond.1);
                free(&spiral, y + down, x + right) && (outside || free(&spiral, beyond.0, beyond.1))
            };
            if !open(down, right) {
                (down, right) = (right, -down);
                if !open(down, right) {
                    break;
                }
            }
            (y, x) = (y + down, x + right);
        }
        let cells = spiral.iter().filter(|p| **p > 0.0).count();
        assert!(cells > 5000, "{cells}");
        let grid = Grid::new(n as usize, n as usize, 1.0, 1.0).unwrap();
        let clusters = Clusters::new(&spiral, grid, Boundary::Free, Neighbours::Edges);
        assert_eq!((clusters.count(), clusters.largest_fraction()), (1, Some(1.0)));
    }
}

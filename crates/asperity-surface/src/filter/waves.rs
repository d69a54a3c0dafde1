//! Random surfaces without their shortest waves, or on a finer grid.

use ndarray::Array2;

use super::GaussianFilter;
use crate::RandomSurface;
use asperity_base::fourier::{Complex64, RealFft2, signed_index};
use asperity_base::map::{Grid, HeightMap, MapError};

/// Continuation of a map beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edges {
    /// Periodic continuation.
    Periodic,
    /// Continuation by its mirror image, which has no step at the edges.
    Mirrored,
}

/// Change of the spectrum of every map of a random surface.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// Removes short waves gradually.
    Smooth(GaussianFilter),
    /// Removes all waves shorter than a length in metre, and no others.
    Cut(f64),
    /// Adds points between the points, without new waves.
    HalvePitch,
}

/// A random surface with a changed spectrum: without its shortest waves, or on a grid of half the pitch.
///
/// The changed maps are functions of the same standard normal variables as the original maps.
pub struct Respaced<'a> {
    surface: &'a dyn RandomSurface,
    grid: Grid,
    edges: Edges,
    change: Change,
}

impl<'a> Respaced<'a> {
    /// Creates the maps of `surface` after the Gaussian filter of ISO 16610-61: waves of length `cutoff_m` keep half of
    /// their amplitude.
    pub fn smoothed(surface: &'a dyn RandomSurface, edges: Edges, cutoff_m: f64) -> Self {
        let change = Change::Smooth(GaussianFilter::linear(cutoff_m));
        Self { surface, grid: surface.grid(), edges, change }
    }

    /// Creates the maps of `surface` without the waves that are shorter than a length in metre.
    pub fn cut(surface: &'a dyn RandomSurface, edges: Edges, shortest_m: f64) -> Self {
        Self { surface, grid: surface.grid(), edges, change: Change::Cut(shortest_m) }
    }

    /// Creates the maps of `surface` with half the pitch along either side, by trigonometric interpolation. Every
    /// second point of every second row keeps its height, and no wave is shorter than twice the pitch of `surface`.
    ///
    /// # Errors
    /// The finer pitch is out of range.
    pub fn with_half_the_pitch(surface: &'a dyn RandomSurface, edges: Edges) -> Result<Self, MapError> {
        let own = surface.grid();
        let grid = Grid::with_size(2 * own.nx(), 2 * own.ny(), own.width_m(), own.height_m())?;
        Ok(Self { surface, grid, edges, change: Change::HalvePitch })
    }

    /// Returns the heights of a complete map, in metre, after the change.
    fn changed_m(&self, map: &HeightMap) -> Array2<f64> {
        let grid = map.grid();
        let (nx, ny) = (grid.nx(), grid.ny());
        let extended = match self.edges {
            Edges::Periodic => map.heights_m().clone(),
            Edges::Mirrored => Array2::from_shape_fn((2 * ny, 2 * nx), |(row, column)| {
                map.heights_m()[[row.min(2 * ny - 1 - row), column.min(2 * nx - 1 - column)]]
            }),
        };
        let (rows, columns) = extended.dim();
        let fft = RealFft2::new(columns, rows);
        let mut spectrum = fft.spectrum();
        let values: Vec<f64> = extended.iter().copied().collect();
        fft.forward(&values, &mut spectrum, &mut fft.workspace());
        let (fft, mut spectrum) = match self.change {
            Change::Smooth(_) | Change::Cut(_) => {
                let transmission = |frequency: f64| match self.change {
                    Change::Smooth(filter) => filter.transmission(frequency),
                    Change::Cut(shortest_m) if frequency * shortest_m > 1.0 + 1e-9 => 0.0,
                    Change::Cut(_) | Change::HalvePitch => 1.0,
                };
                for (kx, waves) in spectrum.chunks_exact_mut(rows).enumerate() {
                    let along_x = kx as f64 / (columns as f64 * grid.dx_m());
                    for (ky, wave) in waves.iter_mut().enumerate() {
                        let along_y = signed_index(ky, rows) / (rows as f64 * grid.dy_m());
                        *wave *= transmission(along_x.hypot(along_y));
                    }
                }
                (fft, spectrum)
            }
            Change::HalvePitch => (RealFft2::new(2 * columns, 2 * rows), padded(&spectrum, rows, columns)),
        };
        let mut heights_m = Array2::zeros(self.grid.shape());
        if let Some(out) = heights_m.as_slice_mut() {
            fft.inverse_cropped(&mut spectrum, out, self.grid.ny(), self.grid.nx(), &mut fft.workspace());
        }
        heights_m
    }
}

/// Returns the spectrum of a map with twice the rows and columns and the same waves. A wave at the Nyquist wavenumber is
/// divided equally between both signs.
fn padded(spectrum: &[Complex64], rows: usize, columns: usize) -> Vec<Complex64> {
    let mut fine = vec![Complex64::default(); (columns + 1) * 2 * rows];
    for (kx, waves) in spectrum.chunks_exact(rows).enumerate() {
        // The inverse transform divides by four times as many points.
        let scale = if 2 * kx == columns { 2.0 } else { 4.0 };
        let place = kx * 2 * rows;
        for (ky, wave) in waves.iter().enumerate() {
            let value = wave * scale;
            match (2 * ky).cmp(&rows) {
                std::cmp::Ordering::Less => fine[place + ky] += value,
                std::cmp::Ordering::Greater => fine[place + rows + ky] += value,
                std::cmp::Ordering::Equal => {
                    fine[place + ky] += 0.5 * value;
                    fine[place + rows + ky] += 0.5 * value;
                }
            }
        }
    }
    fine
}

impl RandomSurface for Respaced<'_> {
    fn xi_len(&self) -> usize {
        self.surface.xi_len()
    }

    fn grid(&self) -> Grid {
        self.grid
    }

    fn generate(&self, xi: &[f64]) -> HeightMap {
        let map = self.surface.generate(xi);
        match HeightMap::new(self.grid, self.changed_m(&map)) {
            Ok(map) => map,
            Err(_) => unreachable!("a generator fills its grid with finite heights"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SpectralField;
    use asperity_base::correlation::{CorrelationModel, Covariance};
    use asperity_base::random;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_periodic_wave_has_the_gaussian_transmission_up_to_the_edges() {
        let grid = Grid::new(60, 48, 1e-6, 1.25e-6).unwrap();
        let (qx, qy) = (TAU * 4.0 / grid.width_m(), -TAU * 3.0 / grid.height_m());
        let wave = HeightMap::from_function(grid, |x, y| 2e-6 + 1e-7 * (qx * x + qy * y + 0.4).cos()).unwrap();
        // 60 µm/4 along x and 60 µm/3 along y: 12 µm across the crests. The transmission at the cutoff's length is one
        // half.
        for (cutoff_m, passed) in [(12e-6, 0.5), (24e-6, 0.5_f64.powi(4)), (3e-6, 0.5_f64.powf(1.0 / 16.0))] {
            let surface = wave.clone();
            let smooth = Respaced::smoothed(&surface, Edges::Periodic, cutoff_m).generate(&[]);
            for (smooth, before) in smooth.heights_m().iter().zip(wave.heights_m()) {
                assert!((smooth - 2e-6 - passed * (before - 2e-6)).abs() < 1e-19, "{cutoff_m:e}: {smooth:e}");
            }
        }
    }

    #[test]
    fn a_mirrored_map_is_smoothed_by_the_weights_of_the_filter() {
        let grid = Grid::new(64, 48, 1e-6, 1e-6).unwrap();
        let values = random::standard_normal(&mut random::stream(3, "waves", 0), grid.points());
        let map = HeightMap::new(grid, Array2::from_shape_vec(grid.shape(), values).unwrap()).unwrap();
        let weighted = GaussianFilter::linear(12e-6).smooth(&map).unwrap().map;
        let surface = map;
        let found = Respaced::smoothed(&surface, Edges::Mirrored, 12e-6).generate(&[]);
        // Away from the edges the mirror images have no effect; the weights reach 1.45 cutoffs.
        for row in 18..30 {
            for column in 18..46 {
                let (a, b) = (found.heights_m()[[row, column]], weighted.heights_m()[[row, column]]);
                assert!((a - b).abs() < 1e-9, "({row}, {column}): {a} {b}");
            }
        }
        // A slope has no step at its edges. It is unchanged except for the bend within a cutoff of them.
        let slope = HeightMap::from_function(grid, |x, y| 0.1 * x + 0.05 * y).unwrap();
        let found = Respaced::smoothed(&slope, Edges::Mirrored, 8e-6).generate(&[]);
        let bend = found.heights_m() - slope.heights_m();
        assert!(bend.iter().all(|d| d.abs() < 0.15 * 2e-6), "{:e}", bend.iter().fold(0.0_f64, |m, d| m.max(d.abs())));
        assert!(bend[[24, 32]].abs() < 1e-12);
    }

    #[test]
    fn half_the_pitch_has_the_wave_between_the_points() {
        for (nx, ny) in [(24, 20), (15, 21)] {
            let grid = Grid::new(nx, ny, 0.5, 0.25).unwrap();
            let (kx, ky) = (3.0, -4.0);
            let wave = |x: f64, y: f64| (TAU * (kx * x / grid.width_m() + ky * y / grid.height_m()) + 0.3).cos();
            let at = |row: f64, column: f64| wave(0.5 * column, 0.25 * row);
            let heights = Array2::from_shape_fn(grid.shape(), |(row, column)| 1.0 + at(row as f64, column as f64));
            let surface = HeightMap::new(grid, heights).unwrap();
            let fine = Respaced::with_half_the_pitch(&surface, Edges::Periodic).unwrap();
            assert_eq!((fine.grid().nx(), fine.grid().ny(), fine.grid().dx_m()), (2 * nx, 2 * ny, 0.25));
            for ((row, column), z) in fine.generate(&[]).heights_m().indexed_iter() {
                let wanted = 1.0 + at(0.5 * row as f64, 0.5 * column as f64);
                assert!((z - wanted).abs() < 1e-12, "({row}, {column}): {z} {wanted}");
            }
        }
    }

    #[test]
    fn half_the_pitch_keeps_every_point_of_a_rough_map_and_its_waves() {
        let grid = Grid::new(32, 24, 1.0, 1.0).unwrap();
        let covariance = Covariance::isotropic(CorrelationModel::Exponential, 1.0, 4.0).unwrap();
        let surface = SpectralField::periodic(&covariance, grid);
        let xi = random::standard_normal(&mut random::stream(4, "waves", 0), surface.xi_len());
        let coarse = surface.generate(&xi);
        for edges in [Edges::Periodic, Edges::Mirrored] {
            let fine = Respaced::with_half_the_pitch(&surface, edges).unwrap().generate(&xi);
            for ((row, column), z) in coarse.heights_m().indexed_iter() {
                assert!((fine.heights_m()[[2 * row, 2 * column]] - z).abs() < 1e-12, "{edges:?} ({row}, {column})");
            }
        }
        // A wave at the Nyquist wavenumber is a cosine between its points.
        let alternating = Array2::from_shape_fn((8, 8), |(_, column)| if column % 2 == 0 { 1.0 } else { -1.0 });
        let nyquist = HeightMap::new(Grid::new(8, 8, 1.0, 1.0).unwrap(), alternating).unwrap();
        let fine = Respaced::with_half_the_pitch(&nyquist, Edges::Periodic).unwrap().generate(&[]);
        for ((_, column), z) in fine.heights_m().indexed_iter() {
            assert!((z - (PI * 0.5 * column as f64).cos()).abs() < 1e-12, "{column}: {z}");
        }
    }
}

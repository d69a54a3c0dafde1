//! Rough maps and indenters.

use asperity_base::fourier::{RealFft2, signed_index};
use asperity_base::map::Grid;
use asperity_base::random::{self, Stream};
use ndarray::Array2;

/// Returns white noise with the amplitude of each wavevector multiplied by `filter` and without mean, row by row. The
/// arguments of `filter` are cycles per longer side of the grid along x and y.
pub fn filtered_noise(grid: Grid, stream: &mut Stream, filter: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let (nx, ny) = (grid.nx(), grid.ny());
    let fft = RealFft2::new(nx, ny);
    let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
    let mut map = random::standard_normal(stream, grid.points());
    fft.forward(&map, &mut spectrum, &mut work);
    let longest_m = grid.width_m().max(grid.height_m());
    for (i, value) in spectrum.iter_mut().enumerate() {
        let along_x = longest_m * (i / ny) as f64 / grid.width_m();
        let along_y = longest_m * signed_index(i % ny, ny) / grid.height_m();
        *value *= if i == 0 { 0.0 } else { filter(along_x, along_y) };
    }
    fft.inverse(&mut spectrum, &mut map, &mut work);
    map
}

/// Returns a periodic Gaussian map of `n` × `n` heights of order one. Its spectral density falls as q^{−3.6} (Hurst
/// exponent 0.8) beyond a roll-off in cycles per side, and is zero below wavelengths of four points.
///
/// # Panics
/// If `n` is less than 2.
pub fn self_affine(n: usize, roll_off: f64, stream: &mut Stream) -> Array2<f64> {
    let grid = square(n, 1.0);
    let heights = filtered_noise(grid, stream, |qx, qy| {
        let q = qx.hypot(qy);
        if q > n as f64 / 4.0 { 0.0 } else { q.max(roll_off).powf(-1.8) }
    });
    Array2::from_shape_fn(grid.shape(), |(row, column)| heights[row * n + column])
}

/// Returns a paraboloid of radius 1 m with its summit at height 0 on a square, `offset` cells from the centre along x and
/// y.
///
/// # Panics
/// If `n` is less than 2.
pub fn paraboloid(n: usize, side_m: f64, offset: f64) -> (Grid, Array2<f64>) {
    let grid = square(n, side_m);
    let centre_m = 0.5 * side_m + offset * grid.dx_m();
    let heights_m = Array2::from_shape_fn(grid.shape(), |(row, column)| {
        let (x, y) = ((column as f64 + 0.5) * grid.dx_m(), (row as f64 + 0.5) * grid.dy_m());
        -0.5 * ((x - centre_m).powi(2) + (y - centre_m).powi(2))
    });
    (grid, heights_m)
}

fn square(n: usize, side_m: f64) -> Grid {
    match Grid::with_size(n, n, side_m, side_m) {
        Ok(grid) => grid,
        Err(error) => panic!("{error}"),
    }
}

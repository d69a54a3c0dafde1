//! Products with a correlation matrix of points of a grid, and its solves.

use super::factor::SparseInverse;
use crate::spectral::FourierModes;
use asperity_base::fourier::{Complex64, RealFft2, Workspace};
use asperity_base::map::Grid;

/// The correlation matrix of a stationary field between the points of a grid, with noise on some of them.
#[derive(Debug)]
pub(super) struct Kernel {
    grid: Grid,
    fft: RealFft2,
    /// Eigenvalues of the correlation matrix of the domain.
    eigenvalues: Vec<f64>,
    lags: Lags,
    places: Vec<usize>,
    nugget: f64,
    preconditioner: SparseInverse,
}

/// Correlations at lags in points.
#[derive(Debug)]
pub(super) struct Lags {
    nx: usize,
    ny: usize,
    values: Vec<f64>,
}

impl Lags {
    /// The lags of the field of these modes on its periodic domain.
    pub(super) fn of(modes: &FourierModes) -> Self {
        let mut spectrum: Vec<Complex64> = modes.spectrum_m2().into_iter().map(Complex64::from).collect();
        let fft = modes.fft();
        let mut values = vec![0.0; fft.nx() * fft.ny()];
        fft.inverse(&mut spectrum, &mut values, &mut fft.workspace());
        let variance = values[0];
        values.iter_mut().for_each(|value| *value /= variance);
        Self { nx: fft.nx(), ny: fft.ny(), values }
    }

    /// Correlation at a lag of less than the grid.
    pub(super) fn at(&self, lag_x: isize, lag_y: isize) -> f64 {
        let (nx, ny) = (self.nx as isize, self.ny as isize);
        let column = if lag_x < 0 { lag_x + nx } else { lag_x };
        let row = if lag_y < 0 { lag_y + ny } else { lag_y };
        self.values[(row * nx + column) as usize]
    }
}

/// How far a solve came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SolveError {
    pub(super) iterations: usize,
    pub(super) misfit: f64,
}

/// Scratch memory of one solve.
struct Work {
    map: Vec<f64>,
    spectrum: Vec<Complex64>,
    fft: Workspace,
}

impl Kernel {
    /// The kernel of the field of these modes, with noise of variance `nugget` at `places`.
    pub(super) fn new(modes: &FourierModes, grid: Grid, places: Vec<usize>, nugget: f64) -> Self {
        let fft = modes.fft().clone();
        let cell = grid.cell_area_m2();
        let eigenvalues: Vec<f64> = modes.spectrum_m2().into_iter().map(|value| value / cell).collect();
        let lags = Lags::of(modes);
        let preconditioner = SparseInverse::new(&lags, grid, &places, nugget);
        Self { grid, fft, eigenvalues, lags, places, nugget, preconditioner }
    }

    /// Places of the points with noise, in row order.
    pub(super) fn places(&self) -> &[usize] {
        &self.places
    }

    /// Correlation between two places.
    pub(super) fn correlation(&self, p: usize, q: usize) -> f64 {
        let nx = self.grid.nx();
        self.lags.at((p % nx) as isize - (q % nx) as isize, (p / nx) as isize - (q / nx) as isize)
    }

    /// K_{·d} w with (K_dd + nugget) w = `misses`, to a largest misfit of `tolerance`, on the whole grid in row order.
    pub(super) fn interpolate(
        &self,
        misses: &[f64],
        tolerance: f64,
        iterations: usize,
    ) -> Result<Vec<f64>, SolveError> {
        let mut work =
            Work { map: vec![0.0; self.grid.points()], spectrum: self.fft.spectrum(), fft: self.fft.workspace() };
        let weights = self.solve(misses, tolerance, iterations, &mut work)?;
        self.spread(&weights, &mut work);
        Ok(work.map)
    }

    /// Preconditioned conjugate gradients.
    fn solve(
        &self,
        misses: &[f64],
        tolerance: f64,
        iterations: usize,
        work: &mut Work,
    ) -> Result<Vec<f64>, SolveError> {
        let mut weights = vec![0.0; misses.len()];
        let mut residual = misses.to_vec();
        let mut direction = vec![0.0; misses.len()];
        let (mut scaled, mut image) = (direction.clone(), direction.clone());
        let mut before = 0.0;
        let mut done = 0;
        loop {
            let mut misfit = largest(&residual);
            if misfit <= tolerance && done > 0 {
                // The updated residual drifts from the true one by rounding.
                self.apply(&weights, &mut image, work);
                for ((residual, miss), image) in residual.iter_mut().zip(misses).zip(&image) {
                    *residual = miss - image;
                }
                misfit = largest(&residual);
                before = 0.0;
            }
            if misfit <= tolerance {
                return Ok(weights);
            }
            self.preconditioner.apply(&residual, &mut scaled);
            let now = dot(&residual, &scaled);
            let momentum = if before > 0.0 { now / before } else { 0.0 };
            for (direction, scaled) in direction.iter_mut().zip(&scaled) {
                *direction = scaled + momentum * *direction;
            }
            self.apply(&direction, &mut image, work);
            let curvature = dot(&direction, &image);
            if done == iterations || curvature.is_nan() || curvature <= 0.0 {
                return Err(SolveError { iterations: done, misfit });
            }
            let step = now / curvature;
            for i in 0..weights.len() {
                weights[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            before = now;
            done += 1;
        }
    }

    /// (K_dd + nugget) w.
    fn apply(&self, weights: &[f64], image: &mut [f64], work: &mut Work) {
        self.spread(weights, work);
        for ((image, weight), place) in image.iter_mut().zip(weights).zip(&self.places) {
            *image = work.map[*place] + self.nugget * weight;
        }
    }

    /// K_{·d} w into the map of the workspace.
    fn spread(&self, weights: &[f64], work: &mut Work) {
        let (ny, nx) = self.grid.shape();
        work.map.fill(0.0);
        for (place, weight) in self.places.iter().zip(weights) {
            work.map[*place] = *weight;
        }
        self.fft.forward_padded(&work.map, ny, nx, &mut work.spectrum, &mut work.fft);
        for (value, eigenvalue) in work.spectrum.iter_mut().zip(&self.eigenvalues) {
            *value *= eigenvalue;
        }
        self.fft.inverse_cropped(&mut work.spectrum, &mut work.map, ny, nx, &mut work.fft);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |m, v| m.max(v.abs()))
}

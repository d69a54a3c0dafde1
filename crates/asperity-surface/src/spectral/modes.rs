//! Real Fourier modes of a periodic domain.

use ndarray::Array2;

use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{Complex64, RealFft2, signed_index};
use asperity_base::map::Grid;

/// One real mode: cos(q·x) or sin(q·x), normalised to unit L² norm, with its place in the stored spectrum.
#[derive(Debug, Clone, Copy)]
struct Mode {
    /// Eigenvalue of the unit-variance covariance operator in m².
    eigenvalue_m2: f64,
    /// Place of the wavevector in the spectrum.
    place: usize,
    /// Place of −q if the spectrum stores it too; `place` itself if q = −q.
    mirror: Option<usize>,
    sine: bool,
}

/// Real Fourier modes sorted by falling eigenvalue: the eigenfunctions of every periodic stationary covariance.
#[derive(Debug, Clone)]
pub(crate) struct FourierModes {
    fft: RealFft2,
    area_m2: f64,
    modes: Vec<Mode>,
}

/// Eigenvalues of all stored wavevectors of a wrapped covariance, clipped at zero.
pub(crate) struct WrappedSpectrum {
    /// Clipped eigenvalues of the unit-variance operator in m², laid out as the spectrum of [`RealFft2`].
    pub(crate) eigenvalues_m2: Vec<f64>,
    /// Fraction of the variance in negative eigenvalues, before clipping.
    pub(crate) clipped: f64,
}

/// Returns the unclipped eigenvalues of the covariance wrapped onto the periodic `domain`: the transform of ρ at the
/// least image.
///
/// ρ is even under a change of both signs, so eigenvalues are real. A mirror-symmetric ρ has λ(k_x, k_y) = λ(k_x, −k_y).
/// A ρ that is symmetric under an exchange of x and y, on a square domain, has λ(k_x, k_y) = λ(k_y, k_x). All symmetries
/// are imposed against rounding, which would otherwise order equal eigenvalues. Lags of half the domain have two or
/// four images of equal length; their mean is used.
pub(crate) fn wrapped_eigenvalues_m2(covariance: &dyn StationaryCovariance, domain: Grid, fft: &RealFft2) -> Vec<f64> {
    let (nx, ny) = (domain.nx(), domain.ny());
    let mirrors = covariance.mirror_symmetric();
    let rho = |column: f64, row: f64| covariance.correlation(column * domain.dx_m(), row * domain.dy_m());
    let mut wrapped = vec![0.0; nx * ny];
    // Only one quadrant or half plane is evaluated, because a Bessel function costs more than a transform.
    for row in 0..=ny / 2 {
        for column in 0..=nx / 2 {
            let (x, y) = (column as f64, row as f64);
            let mut same = rho(x, y);
            let mut crossed = if mirrors || row == 0 || column == 0 { same } else { rho(-x, y) };
            if 2 * row == ny || 2 * column == nx {
                same = 0.5 * (same + crossed);
                crossed = same;
            }
            let (opposite_row, opposite_column) = ((ny - row) % ny, (nx - column) % nx);
            wrapped[row * nx + column] = same;
            wrapped[opposite_row * nx + opposite_column] = same;
            wrapped[row * nx + opposite_column] = crossed;
            wrapped[opposite_row * nx + column] = crossed;
        }
    }
    let mut spectrum = fft.spectrum();
    fft.forward(&wrapped, &mut spectrum, &mut fft.workspace());
    let cell = domain.cell_area_m2();
    let mirrored = |kx: usize, ky: usize| {
        let here = spectrum[kx * ny + ky].re;
        // For the mean and Nyquist columns (k_x, −k_y) is also −k: equal for every covariance.
        let paired = mirrors || kx == 0 || 2 * kx == nx;
        if paired { 0.5 * (here + spectrum[kx * ny + (ny - ky) % ny].re) } else { here }
    };
    let equal = |a: f64, b: f64| (a - b).abs() <= 1e-12;
    let exchanged = nx == ny && (0..ny).all(|i| (0..i).all(|j| equal(wrapped[i * nx + j], wrapped[j * nx + i])));
    (0..fft.stored_kx())
        .flat_map(|kx| (0..ny).map(move |ky| (kx, ky)))
        .map(|(kx, ky)| {
            let here = mirrored(kx, ky);
            if !exchanged {
                return cell * here;
            }
            // (k_x, k_y) becomes (k_y, k_x), and (k_x, −k_y) becomes (k_y, −k_x), the negative of its exchange.
            let (ox, oy) = if 2 * ky <= ny { (ky, kx) } else { (ny - ky, (ny - kx) % ny) };
            cell * 0.5 * (here + mirrored(ox, oy))
        })
        .collect()
}

/// Computes [`wrapped_eigenvalues_m2`], sets negative eigenvalues to zero and scales the others to unit variance.
pub(crate) fn wrapped_spectrum(covariance: &dyn StationaryCovariance, domain: Grid, fft: &RealFft2) -> WrappedSpectrum {
    let mut eigenvalues_m2 = wrapped_eigenvalues_m2(covariance, domain, fft);
    let ny = domain.ny();
    let fraction = |values: &[f64], part: fn(f64) -> f64| {
        let sum: f64 = values.iter().enumerate().map(|(i, &l)| fft.multiplicity(i / ny) * part(l)).sum();
        sum / domain.area_m2()
    };
    let clipped = fraction(&eigenvalues_m2, |l| (-l).max(0.0));
    let kept = fraction(&eigenvalues_m2, |l| l.max(0.0));
    for eigenvalue in &mut eigenvalues_m2 {
        *eigenvalue = eigenvalue.max(0.0) / kept;
    }
    WrappedSpectrum { eigenvalues_m2, clipped }
}

impl FourierModes {
    /// Creates all real modes of the periodic `domain` from the eigenvalues of its stored wavevectors.
    ///
    /// Ties are broken by the wavevector's place, the cosine first.
    pub(crate) fn new(domain: Grid, fft: RealFft2, eigenvalues_m2: &[f64]) -> Self {
        let (nx, ny) = (domain.nx(), domain.ny());
        let mut modes = Vec::with_capacity(nx * ny);
        for kx in 0..fft.stored_kx() {
            let mirrored = kx == 0 || 2 * kx == nx;
            for ky in 0..ny {
                let opposite = (ny - ky) % ny;
                if mirrored && opposite < ky {
                    continue;
                }
                let place = kx * ny + ky;
                let mode = Mode {
                    eigenvalue_m2: eigenvalues_m2[place],
                    place,
                    mirror: mirrored.then_some(kx * ny + opposite),
                    sine: false,
                };
                modes.push(mode);
                if mode.mirror != Some(place) {
                    modes.push(Mode { sine: true, ..mode });
                }
            }
        }
        modes.sort_by(|a, b| b.eigenvalue_m2.total_cmp(&a.eigenvalue_m2).then(a.place.cmp(&b.place)));
        Self { fft, area_m2: domain.area_m2(), modes }
    }

    /// Sorts the modes by the place of the wavevector, the cosine first, regardless of their eigenvalues.
    pub(crate) fn sort_by_place(&mut self) {
        self.modes.sort_by_key(|mode| (mode.place, mode.sine));
    }

    /// Keeps the first `count` modes.
    pub(crate) fn truncate(&mut self, count: usize) {
        self.modes.truncate(count);
    }

    /// Returns the fraction of the variance in modes without their partner (the sine of a cosine); at most the last
    /// mode. All others together have the same variance everywhere.
    pub(crate) fn unpaired_fraction(&self) -> f64 {
        let total: f64 = self.eigenvalues_m2().sum();
        match self.modes.last() {
            Some(mode) if !mode.sine && mode.mirror != Some(mode.place) => mode.eigenvalue_m2 / total,
            _ => 0.0,
        }
    }

    /// Removes the constant mode and scales the others to the whole variance.
    pub(crate) fn without_constant(&mut self) {
        let whole: f64 = self.eigenvalues_m2().sum();
        self.modes.retain(|mode| mode.place != 0);
        let scale = whole / self.eigenvalues_m2().sum::<f64>();
        self.modes.iter_mut().for_each(|mode| mode.eigenvalue_m2 *= scale);
    }

    /// Sets the eigenvalues of waves shorter than a length in metre to zero and scales the others to the whole variance. Returns the
    /// fraction of the variance in these; does nothing and returns 1 if there is none beside the mean. `grid` has the pitches of the domain.
    pub(crate) fn remove_waves_below(&mut self, shortest_m: f64, grid: Grid) -> f64 {
        let (nx, ny) = (self.fft.nx(), self.fft.ny());
        let along = |index: f64, n: usize, pitch_m: f64| index / (n as f64 * pitch_m);
        // Rounding must not remove the wave of the length itself.
        let most = (1.0 + 1e-9) / shortest_m;
        let is_kept = |mode: &Mode| {
            let (kx, ky) = (mode.place / ny, mode.place % ny);
            let x = along(kx as f64, nx, grid.dx_m());
            x.hypot(along(signed_index(ky, ny), ny, grid.dy_m())) <= most
        };
        let whole: f64 = self.eigenvalues_m2().sum();
        let kept: f64 = self.modes.iter().filter(|mode| is_kept(mode)).map(|mode| mode.eigenvalue_m2).sum();
        if !self.modes.iter().any(|mode| mode.place != 0 && is_kept(mode)) {
            return 1.0;
        }
        for mode in &mut self.modes {
            mode.eigenvalue_m2 = if is_kept(mode) { mode.eigenvalue_m2 * whole / kept } else { 0.0 };
        }
        // The removed waves follow in their order.
        self.modes.sort_by(|a, b| b.eigenvalue_m2.total_cmp(&a.eigenvalue_m2));
        kept / whole
    }

    /// Returns the transform of the domain.
    pub(crate) fn fft(&self) -> &RealFft2 {
        &self.fft
    }

    /// Returns the eigenvalues in m² of all stored wavevectors, in the order of [`RealFft2`]; zero for removed modes.
    pub(crate) fn spectrum_m2(&self) -> Vec<f64> {
        let mut spectrum = vec![0.0; self.fft.spectrum_len()];
        for mode in &self.modes {
            spectrum[mode.place] = mode.eigenvalue_m2;
            if let Some(mirror) = mode.mirror {
                spectrum[mirror] = mode.eigenvalue_m2;
            }
        }
        spectrum
    }

    /// Returns the number of modes.
    pub(crate) fn len(&self) -> usize {
        self.modes.len()
    }

    /// Returns the eigenvalues in m², falling.
    pub(crate) fn eigenvalues_m2(&self) -> impl Iterator<Item = f64> + '_ {
        self.modes.iter().map(|mode| mode.eigenvalue_m2)
    }

    /// Computes Σ_j √λ_j φ_j ξ_j, cropped to the first `rows` × `columns` points, in row order.
    pub(crate) fn synthesise(&self, xi: &[f64], rows: usize, columns: usize) -> Vec<f64> {
        self.superpose(
            self.modes.iter().zip(xi).map(|(mode, xi)| (mode, mode.eigenvalue_m2.sqrt() * xi)),
            rows,
            columns,
        )
    }

    /// Computes √λ_j Σ_x w(x) φ_j(x) for every j by one transform: the adjoint of [`FourierModes::synthesise`].
    pub(crate) fn analyse(&self, weights: &[f64], rows: usize, columns: usize) -> Vec<f64> {
        let mut spectrum = self.fft.spectrum();
        self.fft.forward_padded(weights, rows, columns, &mut spectrum, &mut self.fft.workspace());
        let product = |mode: &Mode| {
            let norm = if mode.mirror == Some(mode.place) { 1.0 } else { 2.0 };
            let sum = spectrum[mode.place];
            (norm * mode.eigenvalue_m2 / self.area_m2).sqrt() * if mode.sine { -sum.im } else { sum.re }
        };
        self.modes.iter().map(product).collect()
    }

    /// Returns Σ_j λ_j φ_j(x₀) φ_j(x) for the domain's point x₀ = (`row`, `column`), cropped.
    pub(crate) fn covariance_with(&self, row: usize, column: usize, rows: usize, columns: usize) -> Vec<f64> {
        let ny = self.fft.ny();
        let weights = self.modes.iter().map(|mode| (mode, mode.eigenvalue_m2 * self.value(mode, row, column, ny)));
        self.superpose(weights, rows, columns)
    }

    /// Returns Σ_j λ_j φ_j², cropped. Complete pairs of cosine and sine are uniform, so only an incomplete pair depends
    /// on the point.
    pub(crate) fn pointwise_variance(&self, rows: usize, columns: usize) -> Array2<f64> {
        let ny = self.fft.ny();
        let cut = self.modes.last().filter(|mode| !mode.sine && mode.mirror != Some(mode.place));
        let whole = self.modes.len() - usize::from(cut.is_some());
        // A mode that is its own mirror image is ±1/√A everywhere; a pair has cos² + sin² = 1.
        let uniform = self.modes[..whole].iter().map(|mode| mode.eigenvalue_m2).sum::<f64>() / self.area_m2;
        Array2::from_shape_fn((rows, columns), |(row, column)| {
            uniform + cut.map_or(0.0, |mode| mode.eigenvalue_m2 * self.value(mode, row, column, ny).powi(2))
        })
    }

    /// Returns φ_j at a point of the domain, in 1/m.
    fn value(&self, mode: &Mode, row: usize, column: usize, ny: usize) -> f64 {
        let (kx, ky) = ((mode.place / ny) as f64, signed_index(mode.place % ny, ny));
        let turns = kx * column as f64 / self.fft.nx() as f64 + ky * row as f64 / ny as f64;
        let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
        let norm = if mode.mirror == Some(mode.place) { 1.0 } else { 2.0 };
        (norm / self.area_m2).sqrt() * if mode.sine { sin } else { cos }
    }

    /// Returns Σ a_j φ_j by one inverse transform.
    fn superpose<'a>(&self, weights: impl Iterator<Item = (&'a Mode, f64)>, rows: usize, columns: usize) -> Vec<f64> {
        let points = (self.fft.nx() * self.fft.ny()) as f64;
        let mut spectrum = self.fft.spectrum();
        for (mode, weight) in weights {
            if mode.mirror == Some(mode.place) {
                spectrum[mode.place].re += points * weight / self.area_m2.sqrt();
                continue;
            }
            // a cos(q·x) + b sin(q·x) = Re (a − ib) e^{iq·x}, half of it at q and half at −q.
            let half = points * weight / (2.0 * self.area_m2).sqrt();
            let term = if mode.sine { Complex64::new(0.0, -half) } else { Complex64::new(half, 0.0) };
            spectrum[mode.place] += term;
            if let Some(mirror) = mode.mirror {
                spectrum[mirror] += term.conj();
            }
        }
        let mut map = vec![0.0; rows * columns];
        self.fft.inverse_cropped(&mut spectrum, &mut map, rows, columns, &mut self.fft.workspace());
        map
    }
}

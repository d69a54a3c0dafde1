//! Real Fourier modes of a periodic domain.

use ndarray::Array2;

use asperity_base::correlation::StationaryCovariance;
use asperity_base::fourier::{Complex64, RealFft2, even_spectrum, signed_index};
use asperity_base::map::Grid;

/// One real mode: cos(q·x) or sin(q·x), normalised to unit L² norm. Twice the place of q in the stored spectrum, plus 1
/// for the sine: a map has as many modes as points, so they are small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Mode(u32);

impl Mode {
    fn new(place: usize, sine: bool) -> Self {
        Self((2 * place + usize::from(sine)) as u32)
    }

    /// Place of the wavevector in the spectrum.
    fn place(self) -> usize {
        (self.0 / 2) as usize
    }

    fn sine(self) -> bool {
        self.0 % 2 == 1
    }
}

/// Real Fourier modes sorted by falling eigenvalue: the eigenfunctions of every periodic stationary covariance.
#[derive(Debug, Clone)]
pub(crate) struct FourierModes {
    fft: RealFft2,
    area_m2: f64,
    /// Eigenvalues of the unit-variance covariance operator in m² by the place of their wavevector.
    by_place_m2: Vec<f64>,
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
    let spectrum = even_spectrum(nx, ny, |row, out| out.copy_from_slice(&wrapped[row * nx..(row + 1) * nx]));
    let cell = domain.cell_area_m2();
    let mirrored = |kx: usize, ky: usize| {
        let here = spectrum[kx * ny + ky];
        // For the mean and Nyquist columns (k_x, −k_y) is also −k: equal for every covariance.
        let paired = mirrors || kx == 0 || 2 * kx == nx;
        if paired { 0.5 * (here + spectrum[kx * ny + (ny - ky) % ny]) } else { here }
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
        assert!(2 * fft.spectrum_len() <= u32::MAX as usize, "a domain of {} points is too large", domain.points());
        let (nx, ny) = (domain.nx(), domain.ny());
        let mut modes = Vec::with_capacity(nx * ny);
        for kx in 0..fft.stored_kx() {
            for ky in 0..ny {
                let (place, opposite) = (kx * ny + ky, (ny - ky) % ny);
                let mirrored = fft.multiplicity(kx) == 1.0;
                if mirrored && opposite < ky {
                    continue;
                }
                modes.push(Mode::new(place, false));
                if !(mirrored && opposite == ky) {
                    modes.push(Mode::new(place, true));
                }
            }
        }
        let of = |mode: &Mode| eigenvalues_m2[mode.place()];
        modes.sort_unstable_by(|a, b| of(b).total_cmp(&of(a)).then(a.cmp(b)));
        Self { fft, area_m2: domain.area_m2(), by_place_m2: eigenvalues_m2.to_vec(), modes }
    }

    fn eigenvalue_m2(&self, mode: Mode) -> f64 {
        self.by_place_m2[mode.place()]
    }

    /// Returns the place of −q if the spectrum stores it too; that of q if q = −q.
    fn mirror(&self, mode: Mode) -> Option<usize> {
        let (nx, ny, place) = (self.fft.nx(), self.fft.ny(), mode.place());
        let nyquist = if nx.is_multiple_of(2) { nx / 2 * ny } else { usize::MAX };
        // First place of a column that is its own mirror image.
        let first = match place {
            _ if place < ny => 0,
            _ if place >= nyquist => nyquist,
            _ => return None,
        };
        Some(if place == first { place } else { 2 * first + ny - place })
    }

    /// Returns whether q = −q, so that the mode is ±1/√A everywhere.
    fn is_own_mirror(&self, mode: Mode) -> bool {
        self.mirror(mode) == Some(mode.place())
    }

    /// Sorts the modes by the place of the wavevector, the cosine first, regardless of their eigenvalues.
    pub(crate) fn sort_by_place(&mut self) {
        self.modes.sort_unstable();
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
            Some(&mode) if !mode.sine() && !self.is_own_mirror(mode) => self.eigenvalue_m2(mode) / total,
            _ => 0.0,
        }
    }

    /// Removes the constant mode and scales the others to the whole variance.
    pub(crate) fn without_constant(&mut self) {
        let whole: f64 = self.eigenvalues_m2().sum();
        self.modes.retain(|mode| mode.place() != 0);
        let scale = whole / self.eigenvalues_m2().sum::<f64>();
        self.by_place_m2.iter_mut().for_each(|eigenvalue_m2| *eigenvalue_m2 *= scale);
    }

    /// Sets the eigenvalues of waves shorter than a length in metre to zero and scales the others to the whole variance. Returns the
    /// fraction of the variance in these; does nothing and returns 1 if there is none beside the mean. `grid` has the pitches of the domain.
    pub(crate) fn remove_waves_below(&mut self, shortest_m: f64, grid: Grid) -> f64 {
        let (nx, ny) = (self.fft.nx(), self.fft.ny());
        let along = |index: f64, n: usize, pitch_m: f64| index / (n as f64 * pitch_m);
        // Rounding must not remove the wave of the length itself.
        let most = (1.0 + 1e-9) / shortest_m;
        let is_kept = |place: usize| {
            let (kx, ky) = (place / ny, place % ny);
            let x = along(kx as f64, nx, grid.dx_m());
            x.hypot(along(signed_index(ky, ny), ny, grid.dy_m())) <= most
        };
        let whole: f64 = self.eigenvalues_m2().sum();
        let of_kept = self.modes.iter().filter(|mode| is_kept(mode.place())).map(|mode| self.eigenvalue_m2(*mode));
        let kept: f64 = of_kept.sum();
        if !self.modes.iter().any(|mode| mode.place() != 0 && is_kept(mode.place())) {
            return 1.0;
        }
        for (place, eigenvalue_m2) in self.by_place_m2.iter_mut().enumerate() {
            *eigenvalue_m2 = if is_kept(place) { *eigenvalue_m2 * whole / kept } else { 0.0 };
        }
        // The removed waves follow in their order.
        let of = |mode: &Mode| self.by_place_m2[mode.place()];
        self.modes.sort_by(|a, b| of(b).total_cmp(&of(a)));
        kept / whole
    }

    /// Returns the transform of the domain.
    pub(crate) fn fft(&self) -> &RealFft2 {
        &self.fft
    }

    /// Returns the eigenvalues in m² of all stored wavevectors, in the order of [`RealFft2`]; zero for removed modes.
    pub(crate) fn spectrum_m2(&self) -> Vec<f64> {
        let mut spectrum = vec![0.0; self.fft.spectrum_len()];
        for &mode in &self.modes {
            spectrum[mode.place()] = self.eigenvalue_m2(mode);
            if let Some(mirror) = self.mirror(mode) {
                spectrum[mirror] = self.eigenvalue_m2(mode);
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
        self.modes.iter().map(|mode| self.eigenvalue_m2(*mode))
    }

    /// Computes Σ_j √λ_j φ_j ξ_j, cropped to the first `rows` × `columns` points, in row order.
    pub(crate) fn synthesise(&self, xi: &[f64], rows: usize, columns: usize) -> Vec<f64> {
        self.inverse(self.excited(xi), rows, columns)
    }

    /// Returns the spectrum of Σ_j √λ_j φ_j ξ_j.
    pub(crate) fn excited(&self, xi: &[f64]) -> Vec<Complex64> {
        self.superposed(self.modes.iter().zip(xi).map(|(&mode, xi)| (mode, self.eigenvalue_m2(mode).sqrt() * xi)))
    }

    /// Transforms a spectrum back, cropped to the first `rows` × `columns` points, in row order.
    pub(crate) fn inverse(&self, mut spectrum: Vec<Complex64>, rows: usize, columns: usize) -> Vec<f64> {
        let mut map = vec![0.0; rows * columns];
        self.fft.inverse_cropped(&mut spectrum, &mut map, rows, columns, &mut self.fft.workspace());
        map
    }

    /// Computes √λ_j Σ_x w(x) φ_j(x) for every j by one transform: the adjoint of [`FourierModes::synthesise`].
    pub(crate) fn analyse(&self, weights: &[f64], rows: usize, columns: usize) -> Vec<f64> {
        let mut spectrum = self.fft.spectrum();
        self.fft.forward_padded(weights, rows, columns, &mut spectrum, &mut self.fft.workspace());
        let product = |&mode: &Mode| {
            let norm = if self.is_own_mirror(mode) { 1.0 } else { 2.0 };
            let sum = spectrum[mode.place()];
            (norm * self.eigenvalue_m2(mode) / self.area_m2).sqrt() * if mode.sine() { -sum.im } else { sum.re }
        };
        self.modes.iter().map(product).collect()
    }

    /// Returns Σ_j λ_j φ_j(x₀) φ_j(x) for the domain's point x₀ = (`row`, `column`), cropped.
    pub(crate) fn covariance_with(&self, row: usize, column: usize, rows: usize, columns: usize) -> Vec<f64> {
        let ny = self.fft.ny();
        let weight = |&mode: &Mode| (mode, self.eigenvalue_m2(mode) * self.value(mode, row, column, ny));
        let weights = self.modes.iter().map(weight);
        self.inverse(self.superposed(weights), rows, columns)
    }

    /// Returns Σ_j λ_j φ_j², cropped. Complete pairs of cosine and sine are uniform, so only an incomplete pair depends
    /// on the point.
    pub(crate) fn pointwise_variance(&self, rows: usize, columns: usize) -> Array2<f64> {
        let ny = self.fft.ny();
        let cut = self.modes.last().copied().filter(|mode| !mode.sine() && !self.is_own_mirror(*mode));
        let whole = self.modes.len() - usize::from(cut.is_some());
        // A mode that is its own mirror image is ±1/√A everywhere; a pair has cos² + sin² = 1.
        let uniform = self.eigenvalues_m2().take(whole).sum::<f64>() / self.area_m2;
        Array2::from_shape_fn((rows, columns), |(row, column)| {
            uniform + cut.map_or(0.0, |mode| self.eigenvalue_m2(mode) * self.value(mode, row, column, ny).powi(2))
        })
    }

    /// Returns φ_j at a point of the domain, in 1/m.
    fn value(&self, mode: Mode, row: usize, column: usize, ny: usize) -> f64 {
        let (kx, ky) = ((mode.place() / ny) as f64, signed_index(mode.place() % ny, ny));
        let turns = kx * column as f64 / self.fft.nx() as f64 + ky * row as f64 / ny as f64;
        let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
        let norm = if self.is_own_mirror(mode) { 1.0 } else { 2.0 };
        (norm / self.area_m2).sqrt() * if mode.sine() { sin } else { cos }
    }

    /// Returns the spectrum of Σ a_j φ_j.
    fn superposed(&self, weights: impl Iterator<Item = (Mode, f64)>) -> Vec<Complex64> {
        let points = (self.fft.nx() * self.fft.ny()) as f64;
        let mut spectrum = self.fft.spectrum();
        for (mode, weight) in weights {
            let (place, mirror) = (mode.place(), self.mirror(mode));
            if mirror == Some(place) {
                spectrum[place].re += points * weight / self.area_m2.sqrt();
                continue;
            }
            // a cos(q·x) + b sin(q·x) = Re (a − ib) e^{iq·x}, half of it at q and half at −q.
            let half = points * weight / (2.0 * self.area_m2).sqrt();
            let term = if mode.sine() { Complex64::new(0.0, -half) } else { Complex64::new(half, 0.0) };
            spectrum[place] += term;
            if let Some(mirror) = mirror {
                spectrum[mirror] += term.conj();
            }
        }
        spectrum
    }
}

//! Spectra averaged over logarithmic bins, with confidence bands of the mean.

use std::f64::consts::TAU;

use crate::blocks;
use crate::correlation::profiles;
use crate::correlation::{Autocorrelation, Axis, EstimateError, SpectrumRoute};
use crate::distribution::chi_square_quantile;
use crate::fourier::{good_length, power, signed_index};
use crate::map::HeightMap;
use crate::stats::Extent;

use super::area::{AreaSpectrum, RadialSpectrum};
use super::{hann, lag_window_end, missing_per_profile, parzen, profile_spectrum};

/// Bins per octave, where they contain a wavenumber each.
const PER_OCTAVE: f64 = 6.0;
/// Neighbours on either side that Parzen's lag window over half a side correlates with a coefficient.
const PARZEN_REACH: usize = 5;
/// Bins on either side over which the effective fraction of the coefficients is averaged.
const POOLED: usize = 2;
/// Degrees of freedom of a single coefficient.
const LEAST: f64 = 2.0;
/// Wavenumbers along x summed per task.
const COLUMNS: usize = 16;

/// Spectrum in bins of a sixth of an octave, or of one wavenumber 2π/L where that is wider, with its 95 % band.
///
/// # The band
/// The density of a bin is the mean over its Fourier coefficients. A periodogram of Gaussian heights is distributed at
/// every coefficient as the true density P times χ²₂/2, and two coefficients at a distance of d wavenumbers have the
/// correlation κ(d), so the sum over a bin (with both signs of q) has the relative variance 2 ΣΣ P P′κ/(ΣP)². The
/// chi-square distribution of the same variance (Welch and Satterthwaite) has
///
/// > ν = (Σ P)² / ΣΣ P P′ κ(q − q′)
///
/// degrees of freedom, two for every independent coefficient, and the interval [νP̂/χ²(ν; 97.5 %), νP̂/χ²(ν; 2.5 %)].
///
/// *The window.* κ = |Σ w² e^{−2πidj/n}/Σ w²|²: for a Hann window 1, 4/9 and 1/36 at d = 0, ±1 and ±2, and in a map the
/// product of both directions. In a wide bin Σκ = 35/18 per direction: half of the degrees of freedom are lost along a
/// profile, and 74 % in a map. A thin ring contains fewer neighbours and loses fewer. The periodogram of profiles is
/// the sum of the map's over the other direction, without a window, where coefficients are independent: profiles
/// correlated with their neighbours concentrate their power in few of these, and have few degrees of freedom.
///
/// *Missing points.* Under Parzen's lag window w over lags below M, κ(d) = Σ w² cos(2πdl/n)/(n − |l|) per direction. In
/// the double sum P is replaced by the periodogram of the map with zeros at missing points, which includes the power
/// that they scatter into a coefficient.
///
/// *Unequal densities.* On a directional surface most coefficients of a ring are negligible. The sums over P are
/// estimated from the periodogram I without bias: E I I′ = P P′(1 + κ), so ΣΣ P P′ κ is replaced by ΣΣ I I′ κ/(1 + κ),
/// and twice that is subtracted from (Σ I)². The ratio to ν of a flat ring is averaged over five neighbouring bins and
/// limited to 1.
///
/// The band refers to the mean of P at the resolution of the estimate, see [`SpectrumRoute`]; if the spectrum is curved
/// within the resolution, as at the lowest wavenumbers, the estimate is biased. Heights far from Gaussian scatter more.
///
/// On simulated Gaussian maps of 64 × 64 points the bands contain the true mean in 94 to 95 % of the bins of an
/// isotropic surface, 93 to 95 % of one four times as long along y, 91 to 94 % with missing points, and about 90 % if
/// the correlation is as long as the map, so that a bin has hardly more than one significant coefficient.
///
/// # References
/// Percival & Walden, *Spectral Analysis for Physical Applications*, Cambridge 1993, ch. 6; Satterthwaite, *Biometrics
/// Bulletin* **2** (1946) 110, <https://doi.org/10.2307/3002019>.
#[derive(Debug, Clone, PartialEq)]
pub struct BinnedSpectrum {
    /// Mean |q| of each bin in rad/m.
    pub q_rad_per_m: Vec<f64>,
    /// Mean two-sided density of each bin: P in m⁴ of a map, P₁ in m³ of profiles.
    pub psd: Vec<f64>,
    /// Lower limit of the 95 % band, in the unit of the density; NaN where the density is not positive.
    pub psd_low: Vec<f64>,
    /// Upper limit of the band.
    pub psd_high: Vec<f64>,
    /// Degrees of freedom ν of each bin.
    pub degrees_of_freedom: Vec<f64>,
    /// Number of coefficients of each bin, with both signs of q: wavevectors of a map, wavenumbers of profiles.
    pub coefficients: Vec<usize>,
    /// Estimator of the spectrum.
    pub route: SpectrumRoute,
}

/// Covariances of spectral estimates at a distance of 0, 1, … wavenumbers along one direction, relative to the squared
/// density.
#[derive(Debug, Clone)]
struct Kernel(Vec<f64>);

impl Kernel {
    /// Returns the covariances for a periodogram without a window.
    fn independent() -> Self {
        Self(vec![1.0])
    }

    /// Returns the covariances for a periodogram under the Hann window.
    fn hann() -> Self {
        Self(vec![1.0, 4.0 / 9.0, 1.0 / 36.0])
    }

    /// Returns the covariances for the transform of an autocovariance of `n` points under Parzen's window up to the lag
    /// `end`.
    fn parzen(n: usize, end: usize) -> Self {
        let reach = PARZEN_REACH.min((n - 1) / 2);
        let at = |distance: usize| {
            let term = |lag: usize| {
                let sides = if lag == 0 { 1.0 } else { 2.0 };
                let phase = TAU * (distance * lag) as f64 / n as f64;
                sides * parzen(lag as f64 / end as f64).powi(2) * phase.cos() / (n - lag) as f64
            };
            (0..end).map(term).sum::<f64>().max(0.0)
        };
        Self((0..=reach).map(at).collect())
    }

    fn reach(&self) -> isize {
        self.0.len() as isize - 1
    }

    fn at(&self, distance: isize) -> f64 {
        self.0.get(distance.unsigned_abs()).copied().unwrap_or(0.0)
    }
}

/// Non-negative spectrum over the half plane kx = 0 … nx/2 by all ky, its bins, and the correlation of its
/// coefficients.
struct Coefficients<'a> {
    nx: usize,
    ny: usize,
    /// In the layout of [`power`].
    weights: &'a [f64],
    /// Correlation of the weights along x and y.
    own: [Kernel; 2],
    /// Correlation of the estimate whose variance is computed, along x and y.
    estimate: [Kernel; 2],
}

/// Sums over the wavevectors of a bin, of both signs.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    q: f64,
    weight: f64,
    count: f64,
    /// ΣΣ I I′ κ/(1 + κ₀) with κ of the weights and of the estimate, κ₀ of the weights.
    own: f64,
    estimate: f64,
    /// ΣΣ κ of the estimate.
    flat: f64,
}

impl Coefficients<'_> {
    /// Returns the sums of every bin; `bin` returns the bin of the wavevector (kx, ky), if any, and `magnitude` its
    /// |q|.
    fn sums(
        &self,
        bins: usize,
        magnitude: impl Fn(f64, f64) -> f64 + Sync,
        bin: impl Fn(f64) -> Option<usize> + Sync,
    ) -> Vec<Sums> {
        const NONE: u32 = u32::MAX;
        let (nx, ny) = (self.nx, self.ny);
        let mut places = vec![NONE; self.weights.len()];
        blocks::for_each(places.chunks_mut(ny).enumerate(), |(kx, column)| {
            for (ky, place) in column.iter_mut().enumerate() {
                *place = bin(magnitude(kx as f64, signed_index(ky, ny))).map_or(NONE, |bin| bin as u32);
            }
        });
        // Neighbours with both correlations, without those where both are zero.
        let reach = |of: usize| self.own[of].reach().max(self.estimate[of].reach());
        let neighbours: Vec<(isize, isize, f64, f64)> = (-reach(0)..=reach(0))
            .flat_map(|dx| (-reach(1)..=reach(1)).map(move |dy| (dx, dy)))
            .map(|(dx, dy)| {
                let product = |kernels: &[Kernel; 2]| kernels[0].at(dx) * kernels[1].at(dy);
                (dx, dy, product(&self.own), product(&self.estimate))
            })
            .filter(|(_, _, own, estimate)| *own > 0.0 || *estimate > 0.0)
            .collect();
        let blocks: Vec<Vec<Sums>> = blocks::map(0..(nx / 2 + 1).div_ceil(COLUMNS), |block| {
            let mut sums = vec![Sums::default(); bins];
            for kx in block * COLUMNS..((block + 1) * COLUMNS).min(nx / 2 + 1) {
                let times = if kx == 0 || 2 * kx == nx { 1.0 } else { 2.0 };
                for ky in 0..ny {
                    let place = places[kx * ny + ky];
                    if place == NONE {
                        continue;
                    }
                    let weight = self.weights[kx * ny + ky];
                    let (mut own, mut estimate, mut flat) = (0.0, 0.0, 0.0);
                    for (dx, dy, own_correlation, correlation) in &neighbours {
                        let other = self.index(kx as isize + dx, ky as isize + dy);
                        if places[other] == place {
                            let product = self.weights[other] / (1.0 + own_correlation);
                            own += own_correlation * product;
                            estimate += correlation * product;
                            flat += correlation;
                        }
                    }
                    let sum = &mut sums[place as usize];
                    sum.q += times * magnitude(kx as f64, signed_index(ky, ny));
                    sum.weight += times * weight;
                    sum.count += times;
                    sum.own += times * weight * own;
                    sum.estimate += times * weight * estimate;
                    sum.flat += times * flat;
                }
            }
            sums
        });
        let mut sums = vec![Sums::default(); bins];
        for (bin, part) in blocks.iter().flat_map(|block| block.iter().enumerate()) {
            let sum = &mut sums[bin];
            *sum = Sums {
                q: sum.q + part.q,
                weight: sum.weight + part.weight,
                count: sum.count + part.count,
                own: sum.own + part.own,
                estimate: sum.estimate + part.estimate,
                flat: sum.flat + part.flat,
            };
        }
        sums
    }

    /// Returns the index of a wavevector on the periodic lattice, P(−q) = P(q).
    fn index(&self, kx: isize, ky: isize) -> usize {
        let (nx, ny) = (self.nx as isize, self.ny as isize);
        let kx = kx.rem_euclid(nx);
        let (kx, ky) = if 2 * kx > nx { (nx - kx, -ky) } else { (kx, ky) };
        kx as usize * self.ny + ky.rem_euclid(ny) as usize
    }
}

/// Returns the degrees of freedom of bins: for a flat density, times the averaged effective fraction for unequal
/// densities and missing points.
fn degrees_of_freedom(sums: &[Sums], densities: &[f64]) -> Vec<f64> {
    // ν of a flat density, and numerator and denominator of the fraction, both over (Σ P̂)². Summed before the division
    // they are unbiased for any number of equal coefficients, whose Σ I²/(Σ I)² has the mean 2/(N + 1).
    let parts: Vec<(f64, f64, f64)> = sums
        .iter()
        .zip(densities)
        .map(|(sum, density)| {
            let (flat, square) = (sum.count * sum.count / sum.flat, density * density);
            let (above, below) = (1.0 - 2.0 * sum.own / square, sum.estimate * flat / square);
            if above.is_finite() && below.is_finite() { (flat, above, below) } else { (flat, 0.0, 0.0) }
        })
        .collect();
    (0..parts.len())
        .map(|i| {
            let pooled = &parts[i.saturating_sub(POOLED)..(i + POOLED + 1).min(parts.len())];
            let (above, below) = pooled.iter().fold((0.0, 0.0), |sum, part| (sum.0 + part.1, sum.1 + part.2));
            let flat = parts[i].0;
            (flat * (above / below).min(1.0)).max(LEAST.min(flat))
        })
        .collect()
}

/// Returns the edges of bins from half a wavenumber to beyond the `last`, in wavenumbers: geometric, at least one
/// apart.
pub(in crate::correlation) fn edges(last: usize) -> Vec<f64> {
    let (ratio, end) = ((1.0 / PER_OCTAVE).exp2(), last as f64 + 0.5);
    let mut edges = vec![0.5];
    let mut edge: f64 = 0.5;
    while edge < end {
        let next = (edge + 1.0).max(edge * ratio);
        // A last bin shorter than half a bin is merged with the preceding one.
        let rest = end - next;
        edge = if rest < 0.5 * (next - edge) { end } else { next };
        edges.push(edge);
    }
    edges
}

/// Returns the bin of a wavenumber.
pub(in crate::correlation) fn bin_of(edges: &[f64], q: f64) -> Option<usize> {
    let above = edges.partition_point(|edge| *edge <= q);
    (above > 0 && above < edges.len()).then(|| above - 1)
}

impl BinnedSpectrum {
    /// Creates a spectrum from means and degrees of freedom, without empty bins.
    fn with_bands(bins: Vec<(f64, f64, f64, usize)>, route: SpectrumRoute) -> Self {
        let bins: Vec<_> = bins.into_iter().filter(|(_, _, _, coefficients)| *coefficients > 0).collect();
        let end = |probability: f64| -> Vec<f64> {
            let end = |(_, psd, nu, _): &(f64, f64, f64, usize)| {
                if *psd > 0.0 { nu * psd / chi_square_quantile(*nu, probability) } else { f64::NAN }
            };
            bins.iter().map(end).collect()
        };
        Self {
            psd_low: end(0.975),
            psd_high: end(0.025),
            q_rad_per_m: bins.iter().map(|bin| bin.0).collect(),
            psd: bins.iter().map(|bin| bin.1).collect(),
            degrees_of_freedom: bins.iter().map(|bin| bin.2).collect(),
            coefficients: bins.iter().map(|bin| bin.3).collect(),
            route,
        }
    }
}

/// Returns the spectrum of [`AreaSpectrum`] in rings of a sixth of an octave up to the smaller Nyquist wavenumber, with
/// bands.
///
/// # Errors
/// The heights present do not vary.
pub fn binned_radial_spectrum(map: &HeightMap) -> Result<BinnedSpectrum, EstimateError> {
    Ok(in_bins(map, edges)?.1)
}

/// Returns the radial spectrum with the bands of its rings.
///
/// # Errors
/// The heights present do not vary.
pub fn radial_spectrum_with_bands(map: &HeightMap) -> Result<(RadialSpectrum, BinnedSpectrum), EstimateError> {
    let (spectrum, rings) = in_bins(map, |last| (0..=last).map(|ring| ring as f64 + 0.5).collect())?;
    Ok((spectrum.radial(), rings))
}

/// Returns the spectrum of a map, and its means in bins with these edges up to a last ring.
fn in_bins(
    map: &HeightMap,
    edges: impl Fn(usize) -> Vec<f64>,
) -> Result<(AreaSpectrum, BinnedSpectrum), EstimateError> {
    let extent = Extent::new(map.values_m());
    let small_voids = if map.missing_points() > 0 { AreaSpectrum::of_small_voids(map, extent.mean) } else { None };
    let (spectrum, scatter) = match small_voids {
        Some(spectrum) => (spectrum, None),
        None if map.missing_points() > 0 => {
            let correlation = Autocorrelation::estimate(map)?;
            (AreaSpectrum::from_correlation(&correlation), Some(AreaSpectrum::with_scatter(&correlation)))
        }
        None => (AreaSpectrum::with_extent(map, &extent)?, None),
    };
    let (nx, ny) = (map.grid().nx(), map.grid().ny());
    let (qx_min, qy_min, nyquist) = spectrum.wavenumbers();
    let width = qx_min.max(qy_min);
    let edges = edges((nyquist / width).floor() as usize);
    let magnitude = |kx: f64, ky: f64| (kx * qx_min / width).hypot(ky * qy_min / width);
    let sums = |weights: &[f64], kernels: [Kernel; 2]| {
        let coefficients = Coefficients { nx, ny, weights, own: kernels.clone(), estimate: kernels };
        coefficients.sums(edges.len() - 1, magnitude, |q| bin_of(&edges, q))
    };
    let totals = |sums: &[Sums]| sums.iter().map(|sum| sum.weight).collect::<Vec<f64>>();
    let (sums, densities) = match scatter {
        None => {
            let found = sums(&spectrum.psd_m4, [Kernel::hann(), Kernel::hann()]);
            let densities = totals(&found);
            (found, densities)
        }
        Some(scatter) => {
            let densities = totals(&sums(&spectrum.psd_m4, [Kernel::independent(), Kernel::independent()]));
            (sums(&scatter.psd_m4, [nx, ny].map(|n| Kernel::parzen(n, (n - 1) / 2 + 1))), densities)
        }
    };
    let degrees = degrees_of_freedom(&sums, &densities);
    let bins =
        sums.iter().zip(degrees).zip(densities).map(|((sum, degrees), density)| {
            (width * sum.q / sum.count, density / sum.count, degrees, sum.count as usize)
        });
    let bins = BinnedSpectrum::with_bands(bins.collect(), spectrum.route);
    Ok((spectrum, bins))
}

/// Returns the spectrum of [`profile_spectrum`] in bins with bands.
///
/// # Errors
/// The heights present do not vary.
pub fn binned_profile_spectrum(map: &HeightMap, axis: Axis) -> Result<BinnedSpectrum, EstimateError> {
    let spectrum = profile_spectrum(map, axis)?;
    let (all, n, pitch_m) = profiles::dimensions(map, axis);
    let mean_m = Extent::new(map.values_m()).mean;
    let missing = missing_per_profile(map, axis);
    let periodogram = spectrum.route == SpectrumRoute::Periodogram;
    let window = hann(n);
    // The windowed profile with zeros at missing or excluded heights, and the sum of its w².
    let windowed = |profile: usize, out: &mut [f64]| {
        profiles::copy(map, axis, profile..profile + 1, out);
        let left_out = periodogram && missing[profile] > 0;
        let mut squares = 0.0;
        for (z, w) in out.iter_mut().zip(&window) {
            let present = !(left_out || z.is_nan());
            squares += if present { w * w } else { 0.0 };
            *z = if present { w * (*z - mean_m) } else { 0.0 };
        }
        squares
    };
    // Spectrum across the profiles at a wavenumber along them; its sum is the density of the profiles.
    let mut weights = power(n, all, |profile, out| {
        windowed(profile, out);
    });
    let squares: Vec<f64> = blocks::map(0..all, |profile| windowed(profile, &mut vec![0.0; n]));
    let squares: f64 = squares.iter().sum();
    let norm = pitch_m / (squares * all as f64);
    weights.iter_mut().for_each(|weight| *weight *= norm);
    let own = [Kernel::hann(), Kernel::independent()];
    let estimate = if periodogram {
        own.clone()
    } else {
        let padded = good_length(n + (n - 1) / 2);
        let counts = profiles::lag_sums(map, axis, padded, |z| if z.is_nan() { 0.0 } else { 1.0 });
        [Kernel::parzen(n, lag_window_end(&counts, (n - 1) / 2)), Kernel::independent()]
    };
    let coefficients = Coefficients { nx: n, ny: all, weights: &weights, own, estimate };
    let edges = edges(n / 2);
    let sums = coefficients.sums(edges.len() - 1, |k, _| k, |k| bin_of(&edges, k));
    // Densities and wavenumbers of both signs; the Nyquist wavenumber of an even number of points has only one.
    let mut totals = vec![(0.0, 0.0); sums.len()];
    for (k, psd) in spectrum.psd_m3.iter().enumerate() {
        if let Some(bin) = bin_of(&edges, k as f64) {
            let times = if 2 * k == n { 1.0 } else { 2.0 };
            totals[bin] = (totals[bin].0 + times * psd, totals[bin].1 + times);
        }
    }
    let densities: Vec<f64> = totals.iter().map(|total| total.0).collect();
    // Excluded profiles spread the power over more coefficients than there are profiles.
    let fraction = spectrum.profiles as f64 / all as f64;
    let q_min = TAU / (n as f64 * pitch_m);
    let bins =
        sums.iter().zip(degrees_of_freedom(&sums, &densities)).zip(totals).map(|((sum, degrees), (density, count))| {
            (q_min * sum.q / sum.count, density / count, (fraction * degrees).max(LEAST), count as usize)
        });
    Ok(BinnedSpectrum::with_bands(bins.collect(), spectrum.route))
}

#[cfg(test)]
mod tests;

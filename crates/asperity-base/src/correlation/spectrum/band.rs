//! Reliable band of a measured spectrum.

/// Bins per octave for the analysis of a spectrum, and number of bins for its slope: half an octave.
const PER_OCTAVE: usize = 6;
const SLOPE_OVER: usize = 3;
/// Excess of the exponent over that of H = 1 above which the fall is steeper than any self-affine surface's.
const STEEPER: f64 = 0.5;
/// Exponent over the last octave below which the spectrum is flat.
const FLAT: f64 = 0.5;
/// Ratio of the initial density to a flat end above which the end is a noise floor.
const ABOVE_FLOOR: f64 = 10.0;
/// Fraction of the density at the start of a roll-off to which the spectrum is used: less than 1 % of the squared
/// slopes of a smooth surface, and the leakage of the window, lie beyond.
const FOLLOWED: f64 = 1e-3;
/// Ratio of density to noise floor at which signal and noise are equal.
const FLOORS: f64 = 2.0;

/// Criterion that limits the reliable band of a spectrum towards short waves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpperLimit {
    /// Sampling: beyond half the Nyquist wavenumber aliasing matters. For a self-affine surface its fraction is at most
    /// 3^{−2(1+H)} ≤ 11 % there.
    Pixel,
    /// A fall steeper than that of any self-affine surface up to the end: the resolution of the instrument, a filter,
    /// or interpolated pixels. A surface that is smooth on that scale has the same spectrum.
    RollOff,
    /// A flat end: white noise of the instrument, or the scatter of a spectrum with missing points.
    NoiseFloor,
}

impl UpperLimit {
    /// Returns the name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pixel => "pixel",
            Self::RollOff => "roll_off",
            Self::NoiseFloor => "noise_floor",
        }
    }
}

/// Wavenumbers at which a spectrum represents the surface rather than the field, the sampling or the instrument.
///
/// The lower limit is the resolution of the estimate: ±2 wavenumbers 2π/L under the Hann window, ±4 under the Parzen
/// lag window; below it, the boundary of the field and the removed form dominate. The upper limit is half the Nyquist
/// wavenumber, or less if the spectrum rolls off or reaches a noise floor before. The band is empty if the upper limit
/// is not above the lower.
///
/// # References
/// Jacobs, Junge & Pastewka, *Surf. Topogr.: Metrol. Prop.* **5** (2017) 013001,
/// <https://doi.org/10.1088/2051-672X/aa51f8>, on the effects of field, sampling and tip on a spectrum. The criteria
/// for roll-off and noise floor are ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliableBand {
    /// Lower limit in rad/m.
    pub low_rad_per_m: f64,
    /// Upper limit in rad/m.
    pub high_rad_per_m: f64,
    /// Criterion of the upper limit.
    pub upper_limit: UpperLimit,
}

impl ReliableBand {
    /// Creates the band of the spectrum of a profile, with the exponent 3 for H = 1.
    pub(super) fn from_profile(
        q_rad_per_m: &[f64],
        psd_m3: &[f64],
        low_rad_per_m: f64,
        nyquist_rad_per_m: f64,
    ) -> Self {
        Self::new(q_rad_per_m, psd_m3, low_rad_per_m, nyquist_rad_per_m, 3.0)
    }

    /// Creates the band of a radial spectrum, with the exponent 4 for H = 1.
    pub(super) fn from_area(q_rad_per_m: &[f64], psd_m4: &[f64], low_rad_per_m: f64, nyquist_rad_per_m: f64) -> Self {
        Self::new(q_rad_per_m, psd_m4, low_rad_per_m, nyquist_rad_per_m, 4.0)
    }

    fn new(q: &[f64], psd: &[f64], low: f64, nyquist: f64, steepest: f64) -> Self {
        let pixel = 0.5 * nyquist;
        let bins = binned(q, psd, low, nyquist);
        let limits = [
            (pixel, UpperLimit::Pixel),
            (noise_floor(&bins).unwrap_or(f64::INFINITY), UpperLimit::NoiseFloor),
            (roll_off(&bins, pixel, steepest + STEEPER).unwrap_or(f64::INFINITY), UpperLimit::RollOff),
        ];
        let (high, upper_limit) = limits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or(limits[0]);
        Self { low_rad_per_m: low, high_rad_per_m: high, upper_limit }
    }
}

/// Returns the limit in rad/m up to which a radial spectrum that rolls off is used beyond its reliable band, at most
/// half the Nyquist wavenumber, and the negligible density there in m⁴; the end of the band and 0 if it does not roll
/// off.
pub(super) fn end_of_fall(q: &[f64], psd: &[f64], band: ReliableBand, nyquist: f64) -> (f64, f64) {
    let end = band.high_rad_per_m;
    if band.upper_limit != UpperLimit::RollOff {
        return (end, 0.0);
    }
    let bins = binned(q, psd, band.low_rad_per_m.min(end), nyquist);
    let little = FOLLOWED * bins.iter().take_while(|bin| bin.0 <= end).last().map_or(0.0, |bin| bin.1);
    let followed = bins.iter().find(|bin| bin.0 > end && bin.1 < little).map_or(f64::INFINITY, |bin| bin.0);
    (followed.min(0.5 * nyquist).max(end), little)
}

/// Returns the means (wavenumber, density) of the spectrum in bins of a sixth of an octave from `low` to `high`,
/// without empty bins.
fn binned(q: &[f64], psd: &[f64], low: f64, high: f64) -> Vec<(f64, f64)> {
    let mut bins: Vec<(f64, f64, f64)> = vec![];
    let mut last = None;
    for (q, psd) in q.iter().zip(psd).filter(|(q, _)| **q >= low && **q <= high) {
        let bin = ((q / low).log2() * PER_OCTAVE as f64).floor();
        if last != Some(bin) {
            bins.push((0.0, 0.0, 0.0));
            last = Some(bin);
        }
        if let Some(sums) = bins.last_mut() {
            *sums = (sums.0 + q.ln(), sums.1 + psd, sums.2 + 1.0);
        }
    }
    bins.into_iter().map(|(q, psd, n)| ((q / n).exp(), psd / n)).collect()
}

/// Returns the wavenumber at which the spectrum falls to twice its flat end, or to zero.
fn noise_floor(bins: &[(f64, f64)]) -> Option<f64> {
    if let Some(lost) = bins.iter().position(|bin| bin.1 <= 0.0) {
        return Some(bins[lost.saturating_sub(1)].0);
    }
    let end = bins.len().checked_sub(PER_OCTAVE + 1)?;
    let octave = &bins[end..];
    let floor = octave.iter().map(|bin| bin.1).sum::<f64>() / octave.len() as f64;
    let highest = bins[..end].iter().map(|bin| bin.1).fold(0.0, f64::max);
    if exponent(octave) > FLAT || highest < ABOVE_FLOOR * floor {
        return None;
    }
    bins.iter().find(|bin| bin.1 < FLOORS * floor).map(|bin| bin.0)
}

/// Returns the wavenumber from which the exponent stays above `steepest` up to `end`.
fn roll_off(bins: &[(f64, f64)], end: f64, steepest: f64) -> Option<f64> {
    let below = bins.iter().take_while(|bin| bin.0 <= end).count();
    let falls = |first: &usize| exponent(&bins[*first..first + SLOPE_OVER + 1]) > steepest;
    let first = (0..below.checked_sub(SLOPE_OVER)?).rev().take_while(falls).last()?;
    Some(bins[first].0)
}

/// Returns −d ln P/d ln q by least squares.
fn exponent(bins: &[(f64, f64)]) -> f64 {
    let n = bins.len() as f64;
    let points = || bins.iter().map(|(q, psd)| (q.ln(), psd.ln()));
    let (x, y) = points().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (xy, xx) = points().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - x) * (p.1 - y), xx + (p.0 - x).powi(2)));
    -xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOW: f64 = 2.0;
    const NYQUIST: f64 = 512.0;

    /// Returns the band of a spectrum at whole wavenumbers up to Nyquist.
    fn of(psd: impl Fn(f64) -> f64) -> (f64, UpperLimit) {
        let q: Vec<f64> = (1..=512).map(f64::from).collect();
        let psd: Vec<f64> = q.iter().map(|q| psd(*q)).collect();
        let band = ReliableBand::from_area(&q, &psd, LOW, NYQUIST);
        assert_eq!(band.low_rad_per_m, LOW);
        (band.high_rad_per_m, band.upper_limit)
    }

    /// Aliased about Nyquist as by sampling.
    fn folded(psd: impl Fn(f64) -> f64) -> impl Fn(f64) -> f64 {
        move |q| psd(q) + psd(2.0 * NYQUIST - q)
    }

    #[test]
    fn self_affine_spectra_end_at_half_the_nyquist_wavenumber_folded_or_not() {
        for hurst in [0.1, 0.5, 0.8, 1.0] {
            let power = |q: f64| q.powf(-2.0 - 2.0 * hurst);
            assert_eq!(of(power), (256.0, UpperLimit::Pixel));
            assert_eq!(of(folded(power)), (256.0, UpperLimit::Pixel));
        }
        assert_eq!(of(|_| 1.0), (256.0, UpperLimit::Pixel), "white heights have no floor to tell from them");
    }

    #[test]
    fn a_noise_floor_ends_the_band_where_it_equals_the_surface() {
        let (high, limit) = of(|q| q.powf(-3.6) + 60_f64.powf(-3.6));
        assert_eq!(limit, UpperLimit::NoiseFloor);
        // A sixth of an octave either way.
        assert!((high / 60.0).ln().abs() < 2_f64.ln() / 6.0, "{high}");
        // Scatter about zero counts as a noise floor as well.
        let (high, limit) = of(|q| if q < 50.0 { q.powf(-3.6) } else { -1e-9 });
        assert!(limit == UpperLimit::NoiseFloor && (40.0..50.0).contains(&high), "{high}");
    }

    #[test]
    fn a_spectrum_that_rolls_off_is_followed_until_a_thousandth_is_left() {
        let q: Vec<f64> = (1..=512).map(f64::from).collect();
        let end_of = |psd: &dyn Fn(f64) -> f64| {
            let psd: Vec<f64> = q.iter().map(|q| psd(*q)).collect();
            let band = ReliableBand::from_area(&q, &psd, LOW, NYQUIST);
            (band, end_of_fall(&q, &psd, band, NYQUIST).0)
        };
        // e^{−(q/40)²}: from the end of the band at b to √(b² + 40² ln 1000).
        let (band, end) = end_of(&|q| (-(q / 40.0).powi(2)).exp());
        let wanted = (band.high_rad_per_m.powi(2) + 1600.0 * 1000_f64.ln()).sqrt();
        assert!(band.upper_limit == UpperLimit::RollOff && (end / wanted).log2().abs() < 0.25, "{end} {wanted}");
        let (band, end) = end_of(&|q| q.powf(-3.0));
        assert!(band.upper_limit == UpperLimit::Pixel && end == band.high_rad_per_m);
    }

    #[test]
    fn gaussian_smoothing_limits_the_band_at_its_roll_off() {
        // q^{−3.6} e^{−(q/40)²}: the exponent 3.6 + 2(q/40)² passes 4.5 at q = 40·√0.45 = 26.8.
        let (high, limit) = of(|q| q.powf(-3.6) * (-(q / 40.0).powi(2)).exp());
        assert_eq!(limit, UpperLimit::RollOff);
        // The exponent is taken over half an octave from there.
        assert!((high / 26.8).log2().abs() < 0.5, "{high}");
    }
}

//! Height density, correlation and spectra of a map, at the abscissas of another map.

use crate::correlation::{Autocorrelation, Axis, profile_spectrum, radial_spectrum};
use crate::map::HeightMap;
use crate::stats::Histogram;

/// Kind of function that is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CurveKind {
    /// Probability density of the heights about their mean.
    HeightDensity,
    /// Autocorrelation along an axis, up to half of the map.
    Correlation(Axis),
    /// Power spectral density of the profiles along an axis.
    Spectrum(Axis),
    /// Radially averaged power spectral density.
    RadialSpectrum,
}

impl CurveKind {
    /// Functions of a map; the radial spectrum replaces profile spectra if no profile is complete.
    const ALL: [Self; 6] = [
        Self::HeightDensity,
        Self::Correlation(Axis::X),
        Self::Correlation(Axis::Y),
        Self::Spectrum(Axis::X),
        Self::Spectrum(Axis::Y),
        Self::RadialSpectrum,
    ];

    /// Returns the name of the table.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::HeightDensity => "height_pdf",
            Self::Correlation(Axis::X) => "acf_x",
            Self::Correlation(Axis::Y) => "acf_y",
            Self::Spectrum(Axis::X) => "psd_x",
            Self::Spectrum(Axis::Y) => "psd_y",
            Self::RadialSpectrum => "psd_radial",
        }
    }

    /// Returns the name in sentences.
    pub(super) fn label(self) -> &'static str {
        match self {
            Self::HeightDensity => "height density",
            Self::Correlation(Axis::X) => "autocorrelation along x",
            Self::Correlation(Axis::Y) => "autocorrelation along y",
            Self::Spectrum(Axis::X) => "power spectrum along x",
            Self::Spectrum(Axis::Y) => "power spectrum along y",
            Self::RadialSpectrum => "radial power spectrum",
        }
    }

    /// Returns the column of the abscissas.
    pub(super) fn abscissa(self) -> &'static str {
        match self {
            Self::HeightDensity => "height_m",
            Self::Correlation(_) => "lag_m",
            Self::Spectrum(_) | Self::RadialSpectrum => "wavenumber_rad_per_m",
        }
    }

    /// Returns the unit at the end of the columns of values.
    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::HeightDensity => "_per_m",
            Self::Correlation(_) => "",
            Self::Spectrum(_) => "_m3",
            Self::RadialSpectrum => "_m4",
        }
    }

    /// Returns whether the values are non-negative, apart from estimation noise.
    pub(super) fn is_density(self) -> bool {
        !matches!(self, Self::Correlation(_))
    }

    /// Returns whether the values vary by factors instead of differences.
    pub(super) fn is_spectrum(self) -> bool {
        matches!(self, Self::Spectrum(_) | Self::RadialSpectrum)
    }

    fn evaluate(self, map: &HeightMap, correlation: &Autocorrelation) -> Option<Curve> {
        let (x, y) = match self {
            Self::HeightDensity => {
                let centred: Vec<f64> = map.present_m().map(|z| z - correlation.mean_m()).collect();
                let centres = Histogram::new(&centred).ok().filter(|bins| bins.counts.len() > 1)?.centres();
                let density = density_in(&centres, &centred);
                (centres, density)
            }
            Self::Correlation(axis) => {
                let grid = map.grid();
                let (pitch_m, points) = match axis {
                    Axis::X => (grid.dx_m(), grid.nx()),
                    Axis::Y => (grid.dy_m(), grid.ny()),
                };
                let values = correlation.along(axis);
                (0..=points / 2).map(|lag| (lag as f64 * pitch_m, values[lag])).unzip()
            }
            Self::Spectrum(axis) => {
                let found = profile_spectrum(map, axis).ok()?;
                found.q_rad_per_m.into_iter().zip(found.psd_m3).filter(|(q, _)| *q > 0.0).unzip()
            }
            Self::RadialSpectrum => {
                let found = radial_spectrum(map).ok()?;
                (found.q_rad_per_m, found.psd_m4)
            }
        };
        Some(Curve { kind: self, x, y })
    }
}

/// Function of a map.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub(super) kind: CurveKind,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
}

impl Curve {
    /// Returns all functions of a map.
    pub(super) fn all(map: &HeightMap, correlation: &Autocorrelation) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        for kind in CurveKind::ALL {
            let stands_in = kind == CurveKind::RadialSpectrum;
            if !(stands_in && found.iter().any(|curve| curve.kind.is_spectrum())) {
                found.extend(kind.evaluate(map, correlation));
            }
        }
        found
    }

    /// Evaluates the same function of another map at the same abscissas; NaN beyond its range.
    pub(super) fn evaluate_on(&self, map: &HeightMap, correlation: &Autocorrelation) -> Vec<f64> {
        if self.kind == CurveKind::HeightDensity {
            let centred: Vec<f64> = map.present_m().map(|z| z - correlation.mean_m()).collect();
            return density_in(&self.x, &centred);
        }
        match self.kind.evaluate(map, correlation) {
            Some(own) if own.x == self.x => own.y,
            Some(own) => self.x.iter().map(|x| own.at(*x)).collect(),
            None => vec![f64::NAN; self.x.len()],
        }
    }

    /// Interpolates linearly between the abscissas; NaN beyond them.
    fn at(&self, x: f64) -> f64 {
        // Equal abscissas of two grids may differ by rounding.
        let slack = 1e-9 * x.abs();
        let right = self.x.partition_point(|own| *own < x - slack);
        match (right.checked_sub(1), self.x.get(right)) {
            (_, Some(&own)) if (own - x).abs() <= slack => self.y[right],
            (Some(left), Some(&own)) => {
                let along = (x - self.x[left]) / (own - self.x[left]);
                self.y[left] + along * (self.y[right] - self.y[left])
            }
            _ => f64::NAN,
        }
    }
}

/// Returns the density of values in equal bins around `centres`: the fraction of *all* values in a bin over its width.
fn density_in(centres: &[f64], values: &[f64]) -> Vec<f64> {
    let width = (centres[centres.len() - 1] - centres[0]) / (centres.len() - 1) as f64;
    let low = centres[0] - 0.5 * width;
    let mut counts = vec![0_usize; centres.len()];
    // The extremes of the sample that defines the bins lie on the outer edges, up to rounding.
    let (first, last) = (-1e-9, centres.len() as f64 + 1e-9);
    for value in values {
        let position = (value - low) / width;
        if position > first && position < last {
            counts[(position.max(0.0) as usize).min(centres.len() - 1)] += 1;
        }
    }
    counts.into_iter().map(|count| count as f64 / (values.len() as f64 * width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Grid;
    use crate::random;
    use ndarray::Array2;

    fn white(nx: usize, ny: usize, pitch_m: f64, index: u64) -> HeightMap {
        let values = random::standard_normal(&mut random::stream(8, "curve", index), nx * ny);
        let grid = Grid::new(nx, ny, pitch_m, pitch_m).unwrap();
        HeightMap::new(grid, Array2::from_shape_vec((ny, nx), values).unwrap()).unwrap()
    }

    #[test]
    fn the_density_equals_the_histogram_and_ignores_values_outside_the_bins() {
        let values = random::standard_normal(&mut random::stream(8, "density", 0), 4000);
        let histogram = Histogram::new(&values).unwrap();
        let found = density_in(&histogram.centres(), &values);
        let width = histogram.edges[1] - histogram.edges[0];
        // A value at an edge may fall to either side by rounding.
        for (found, wanted) in found.iter().zip(histogram.density()) {
            assert!((found - wanted).abs() * 4000.0 * width < 1.5, "{found} {wanted}");
        }
        assert!((found.iter().sum::<f64>() * width - 1.0).abs() < 1e-12, "no value is lost");
        // Half of these values lie far outside.
        let far: Vec<f64> = values.iter().enumerate().map(|(i, v)| if i % 2 == 0 { *v } else { 1e3 }).collect();
        assert!((density_in(&histogram.centres(), &far).iter().sum::<f64>() * width - 0.5).abs() < 1e-12);
    }

    #[test]
    fn maps_of_another_pitch_are_interpolated() {
        let (coarse, fine) = (white(16, 16, 2.0, 0), white(64, 24, 1.0, 1));
        let correlation = |map| Autocorrelation::estimate(map).unwrap();
        let curves = Curve::all(&coarse, &correlation(&coarse));
        let names: Vec<&str> = curves.iter().map(|curve| curve.kind.name()).collect();
        assert_eq!(names, ["height_pdf", "acf_x", "acf_y", "psd_x", "psd_y"]);
        let own = correlation(&fine);
        let along_x = curves[1].evaluate_on(&fine, &own);
        assert_eq!(along_x[3], own.correlation(6, 0));
        // Half of the fine map's 24 rows is 12: the lags 14 and 16 of the coarse one lie beyond.
        let along_y = curves[2].evaluate_on(&fine, &own);
        assert!(along_y[6].is_finite() && along_y[7].is_nan());
        let linear = Curve { kind: CurveKind::RadialSpectrum, x: vec![1.0, 2.0, 4.0], y: vec![0.0, 1.0, 3.0] };
        assert_eq!([linear.at(1.0), linear.at(3.0), linear.at(4.0 + 1e-12)], [0.0, 2.0, 3.0]);
        assert!(linear.at(0.5).is_nan() && linear.at(5.0).is_nan());
    }

    #[test]
    fn the_radial_spectrum_replaces_profiles_if_none_is_complete() {
        let complete = white(12, 12, 1.0, 2);
        let mut heights = complete.heights_m().clone();
        (0..12).for_each(|i| heights[[i, i]] = f64::NAN);
        let diagonal = HeightMap::new(complete.grid(), heights).unwrap();
        let curves = Curve::all(&diagonal, &Autocorrelation::estimate(&diagonal).unwrap());
        let spectra: Vec<&str> = curves.iter().filter(|c| c.kind.is_spectrum()).map(|c| c.kind.name()).collect();
        // An estimator that accepts incomplete profiles needs no substitute.
        assert!(spectra == ["psd_radial"] || spectra == ["psd_x", "psd_y"], "{spectra:?}");
    }
}

//! Linearisation of a fitted family of records: scores, information and goodness of fit.

use super::likelihood::{Likelihood, Spectra};
use crate::numeric::{dot, solution};

/// Least number of ordinates in a band of the goodness-of-fit test, and largest number of bands.
const LEAST_IN_BAND: f64 = 12.0;
const MOST_BANDS: f64 = 16.0;

/// Fitted family with ∂ ln E/∂θ for its parameters ln ℓ (if ℓ > 0) and noise (if fitted); the derivative by the log
/// variance is 1.
pub(super) struct Tangent<'a> {
    likelihood: &'a Likelihood,
    /// Expected periodograms at the most likely variance.
    expected: Spectra,
    directions: Vec<Spectra>,
    /// Variance of the values without filters, including noise.
    pub(super) variance: f64,
}

/// Sums over the ordinates of a band: of I/E − 1, of their number, and of the rows of derivatives.
struct Band {
    sum: f64,
    number: f64,
    row: Vec<f64>,
}

impl<'a> Tangent<'a> {
    /// Returns the family at a length and a noise fraction, with its derivatives by the parameters.
    pub(super) fn new(likelihood: &'a Likelihood, length_m: f64, noise: f64) -> Self {
        let step: f64 = 1e-3;
        let at = |length_m: f64| likelihood.with_noise(&likelihood.spectra(length_m), noise);
        let plain = likelihood.spectra(length_m);
        let mut expected = likelihood.with_noise(&plain, noise);
        let mut directions = Vec::new();
        if length_m > 0.0 {
            let (below, above) = (at(length_m * (-step).exp()), at(length_m * step.exp()));
            directions.push(combined(&below, &above, |low, high| (high / low).ln() / (2.0 * step)));
        }
        if noise > 0.0 {
            let rise = combined(&likelihood.with_noise(&plain, 1.0), &plain, |white, own| white - own);
            directions.push(combined(&rise, &expected, |rise, e| rise / e));
        }
        let variance = likelihood.variance(&expected);
        expected.iter_mut().flatten().for_each(|e| *e *= variance);
        Self { likelihood, expected, directions, variance }
    }

    /// Returns the row (1, ∂ ln E/∂θ_1, …) of an ordinate.
    fn row(&self, group: usize, place: usize) -> Vec<f64> {
        std::iter::once(1.0).chain(self.directions.iter().map(|direction| direction[group][place])).collect()
    }

    /// Returns the group, place and weight of all ordinates used.
    fn ordinates(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let of_group = |group: usize| {
            let fractions = &self.likelihood.groups[group].fractions;
            (0..fractions.len())
                .filter(|place| fractions[*place] > 0.0)
                .map(move |place| (group, place, fractions[place]))
        };
        (0..self.likelihood.groups.len()).flat_map(of_group)
    }

    /// Returns the sum of the outer products of rows over all ordinates: the information of variance, length and noise.
    fn information(&self) -> Vec<Vec<f64>> {
        let weighted = |(group, place, fraction): (usize, usize, f64)| {
            (fraction * self.likelihood.groups[group].records(), self.row(group, place))
        };
        outer_products(1 + self.directions.len(), self.ordinates().map(weighted))
    }

    /// Scores ∂ ln L/∂ ln ℓ of every record, orthogonal to variance and noise, and their expected information.
    pub(super) fn scores(&self, records: usize) -> (Vec<f64>, f64) {
        let all = self.information();
        let others: Vec<usize> = (0..all.len()).filter(|index| *index != 1).collect();
        let matrix = others.iter().map(|i| others.iter().map(|j| all[*i][*j]).collect()).collect();
        let parts = solution(matrix, &others.iter().map(|i| all[*i][1]).collect::<Vec<f64>>());
        let (mut scores, mut information) = (vec![0.0; records], 0.0);
        for (group, place, fraction) in self.ordinates() {
            let row = self.row(group, place);
            let rest = row[1] - others.iter().zip(&parts).map(|(i, part)| part * row[*i]).sum::<f64>();
            let powers = &self.likelihood.groups[group].powers;
            information += powers.len() as f64 * fraction * rest * rest;
            for (record, power) in powers {
                scores[*record] += fraction * (power[place] / self.expected[group][place] - 1.0) * rest;
            }
        }
        (scores, information)
    }

    /// Returns the variance of the noise fraction for Gaussian records and independent ordinates; `None` without noise.
    pub(super) fn noise_variance(&self, noise: f64) -> Option<f64> {
        let all = self.information();
        let last = all.len() - 1;
        let unit: Vec<f64> = (0..all.len()).map(|index| f64::from(u8::from(index == last))).collect();
        (noise > 0.0).then(|| solution(all, &unit)[last]).filter(|variance| *variance > 0.0)
    }

    /// Returns the weighted sum of squared deviations of periodogram over model from 1 in bands, and its degrees of
    /// freedom.
    ///
    /// The sums S of (I/E − 1) over the N ordinates of a band have the variance cN under the model, with c =
    /// `dispersion`. Their weighted regression on the mean derivatives of the bands takes away what the fitted
    /// parameters explain: the rest is χ² with the number of bands less the number of parameters.
    pub(super) fn lack_of_fit(&self, dispersion: f64) -> Option<(f64, f64)> {
        let (bands, size) = (self.bands(), 1 + self.directions.len());
        let freedom = bands.len().checked_sub(size).filter(|freedom| *freedom > 0)?;
        let information = outer_products(size, bands.iter().map(|band| (1.0 / band.number, band.row.clone())));
        let explained: Vec<f64> =
            (0..size).map(|k| bands.iter().map(|band| band.row[k] * band.sum / band.number).sum()).collect();
        let squares: f64 = bands.iter().map(|band| band.sum * band.sum / band.number).sum();
        let statistic = (squares - dot(&explained, &solution(information, &explained))) / dispersion;
        statistic.is_finite().then_some((statistic, freedom as f64))
    }

    /// Divides the ordinates into bands half an octave wide, or a sixteenth of the ordinates where that is less, with at
    /// least twelve ordinates.
    fn bands(&self) -> Vec<Band> {
        let groups = &self.likelihood.groups;
        let mut order: Vec<(usize, usize, f64)> = self.ordinates().collect();
        let frequency = |(group, place, _): &(usize, usize, f64)| groups[*group].frequency_per_m(*place);
        order.sort_by(|a, b| frequency(a).total_cmp(&frequency(b)));
        let count = |(group, _, fraction): &(usize, usize, f64)| fraction * groups[*group].records();
        let all: f64 = order.iter().map(count).sum();
        let (mut bands, mut start): (Vec<Band>, f64) = (Vec::new(), 0.0);
        let mut left = all;
        for ordinate in &order {
            let (group, place, fraction) = *ordinate;
            let full = bands.last().is_none_or(|band| {
                let wide = frequency(ordinate) > start * 2.0_f64.sqrt() || band.number >= all / MOST_BANDS;
                band.number >= LEAST_IN_BAND && left >= LEAST_IN_BAND && wide
            });
            if full {
                bands.push(Band { sum: 0.0, number: 0.0, row: vec![0.0; 1 + self.directions.len()] });
                start = frequency(ordinate);
            }
            left -= count(ordinate);
            if let Some(band) = bands.last_mut() {
                band.sum += fraction * groups[group].total[place] / self.expected[group][place] - count(ordinate);
                band.number += count(ordinate);
                let row = self.row(group, place);
                band.row.iter_mut().zip(row).for_each(|(sum, d)| *sum += count(ordinate) * d);
            }
        }
        bands
    }
}

fn combined(a: &Spectra, b: &Spectra, of: impl Fn(f64, f64) -> f64) -> Spectra {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect()).collect()
}

/// Returns the weighted sum of the outer products of rows.
fn outer_products(size: usize, rows: impl Iterator<Item = (f64, Vec<f64>)>) -> Vec<Vec<f64>> {
    let mut sums = vec![vec![0.0; size]; size];
    for (weight, row) in rows {
        for (sums, a) in sums.iter_mut().zip(&row) {
            sums.iter_mut().zip(&row).for_each(|(sum, b)| *sum += weight * a * b);
        }
    }
    sums
}

//! Linearisation of a fitted model of records: scores, information and goodness of fit.

use super::likelihood::{Likelihood, Spectra};
use crate::numeric::solution;

/// Least number of ordinates in a band of the goodness-of-fit test, and largest number of bands.
const LEAST_IN_BAND: f64 = 12.0;
const MOST_BANDS: f64 = 16.0;

/// Fitted model with ∂ ln E/∂θ for its parameters ln ℓ (if ℓ > 0) and noise (if fitted); the derivative by the log
/// variance is 1.
pub(super) struct Tangent<'a> {
    likelihood: &'a Likelihood,
    expected: Spectra,
    variance: f64,
    directions: Vec<Vec<Vec<f64>>>,
}

impl<'a> Tangent<'a> {
    /// Returns the model at a length and a noise fraction, with its derivatives by the parameters.
    pub(super) fn new(likelihood: &'a Likelihood, length_m: f64, noise: f64) -> Self {
        let step: f64 = 1e-3;
        let at = |length_m: f64| likelihood.with_noise(&likelihood.spectra(length_m), noise);
        let (plain, mut directions) = (likelihood.spectra(length_m), Vec::new());
        let expected = likelihood.with_noise(&plain, noise);
        if length_m > 0.0 {
            let (below, above) = (at(length_m * (-step).exp()), at(length_m * step.exp()));
            let slope = |(low, high): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                low.iter().zip(high).map(|(l, h)| (h / l).ln() / (2.0 * step)).collect()
            };
            directions.push(below.0.iter().zip(&above.0).map(slope).collect());
        }
        if noise > 0.0 {
            let all_noise = likelihood.with_noise(&plain, 1.0);
            let slope = |((white, own), e): ((&Vec<f64>, &Vec<f64>), &Vec<f64>)| -> Vec<f64> {
                white.iter().zip(own).zip(e).map(|((w, o), e)| (w - o) / e).collect()
            };
            directions.push(all_noise.0.iter().zip(&plain.0).zip(&expected.0).map(slope).collect());
        }
        let variance = likelihood.variance(&expected);
        Self { likelihood, expected, variance, directions }
    }

    /// Returns the variance of the values without filters, including noise.
    pub(super) fn variance(&self) -> f64 {
        self.variance
    }

    /// Returns the row (1, ∂ ln E/∂θ_1, …) of an ordinate.
    fn row(&self, group: usize, place: usize) -> Vec<f64> {
        std::iter::once(1.0).chain(self.directions.iter().map(|direction| direction[group][place])).collect()
    }

    /// Returns the sum of the outer products of rows over all ordinates: the information of variance, length and noise.
    fn information(&self) -> Vec<Vec<f64>> {
        let size = 1 + self.directions.len();
        let mut sums = vec![vec![0.0; size]; size];
        for (index, group) in self.likelihood.groups.iter().enumerate() {
            let records = group.powers.len() as f64;
            for (place, fraction) in group.fractions.iter().enumerate().filter(|(_, fraction)| **fraction > 0.0) {
                let row = self.row(index, place);
                for (sums, a) in sums.iter_mut().zip(&row) {
                    sums.iter_mut().zip(&row).for_each(|(sum, b)| *sum += records * fraction * a * b);
                }
            }
        }
        sums
    }

    /// Scores ∂ ln L/∂ ln ℓ of every group, orthogonal to variance and noise, and their expected information.
    pub(super) fn scores(&self, owners: usize) -> (Vec<f64>, f64) {
        let all = self.information();
        // The component of ln ℓ orthogonal to the other parameters.
        let others: Vec<usize> = (0..all.len()).filter(|index| *index != 1).collect();
        let matrix = others.iter().map(|i| others.iter().map(|j| all[*i][*j]).collect()).collect();
        let fractions = solution(matrix, &others.iter().map(|i| all[*i][1]).collect::<Vec<f64>>());
        let (mut scores, mut information) = (vec![0.0; owners], 0.0);
        for (index, group) in self.likelihood.groups.iter().enumerate() {
            for (place, fraction) in group.fractions.iter().enumerate().filter(|(_, fraction)| **fraction > 0.0) {
                let row = self.row(index, place);
                let rest = row[1] - others.iter().zip(&fractions).map(|(i, fraction)| fraction * row[*i]).sum::<f64>();
                information += group.powers.len() as f64 * fraction * rest * rest;
                let e = self.variance * self.expected.0[index][place];
                for (owner, power) in &group.powers {
                    scores[*owner] += fraction * (power[place] / e - 1.0) * rest;
                }
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
    /// Bands are half an octave wide, or a sixteenth of the ordinates where that is less, with at least twelve
    /// ordinates. Under the model the sums of (I/E − 1) have the covariance c (N − A M⁻¹ Aᵀ) with the variance c =
    /// `dispersion` of an ordinate, the information M and its parts A in the bands. The statistic is χ² with one degree
    /// of freedom less than bands.
    pub(super) fn lack_of_fit(&self, dispersion: f64) -> Option<(f64, f64)> {
        let groups = &self.likelihood.groups;
        let mut order: Vec<(f64, usize, usize)> = groups
            .iter()
            .enumerate()
            .flat_map(|(index, group)| {
                (0..group.fractions.len()).map(move |place| (group.frequency_per_m(place), index, place))
            })
            .filter(|(_, index, place)| groups[*index].fractions[*place] > 0.0)
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let count = |(_, index, place): &(f64, usize, usize)| {
            groups[*index].fractions[*place] * groups[*index].powers.len() as f64
        };
        let all: f64 = order.iter().map(count).sum();
        let size = 1 + self.directions.len();
        // Sum, number of ordinates, and part of the information of every band.
        let mut bands: Vec<(f64, f64, Vec<f64>)> = Vec::new();
        let mut start = 0.0;
        for ordinate in &order {
            let (frequency, index, place) = *ordinate;
            let full = bands.last().is_none_or(|(_, number, _)| {
                *number >= LEAST_IN_BAND && (frequency > start * 2.0_f64.sqrt() || *number >= all / MOST_BANDS)
            });
            if full {
                bands.push((0.0, 0.0, vec![0.0; size]));
                start = frequency;
            }
            let fraction = groups[index].fractions[place];
            let e = self.variance * self.expected.0[index][place];
            let powers = groups[index].powers.iter().map(|(_, power)| power[place] / e - 1.0).sum::<f64>();
            if let Some((sum, number, part)) = bands.last_mut() {
                *sum += fraction * powers;
                *number += count(ordinate);
                part.iter_mut().zip(self.row(index, place)).for_each(|(part, d)| *part += count(ordinate) * d);
            }
        }
        if bands.last().is_some_and(|(_, number, _)| *number < LEAST_IN_BAND) && bands.len() > 1 {
            let (sum, number, part) = bands.pop()?;
            let last = bands.last_mut()?;
            (last.0, last.1) = (last.0 + sum, last.1 + number);
            last.2.iter_mut().zip(part).for_each(|(a, b)| *a += b);
        }
        let free = bands.len().checked_sub(1).filter(|free| *free > size)?;
        let information = self.information();
        let solved: Vec<Vec<f64>> = bands.iter().map(|(_, _, part)| solution(information.clone(), part)).collect();
        let covariance = |i: usize, j: usize| {
            let taken: f64 = bands[i].2.iter().zip(&solved[j]).map(|(a, b)| a * b).sum();
            dispersion * (if i == j { bands[i].1 } else { 0.0 } - taken)
        };
        let matrix = (0..free).map(|i| (0..free).map(|j| covariance(i, j)).collect()).collect();
        let sums: Vec<f64> = bands[..free].iter().map(|(sum, _, _)| *sum).collect();
        let statistic = sums.iter().zip(solution(matrix, &sums)).map(|(a, b)| a * b).sum::<f64>();
        statistic.is_finite().then_some((statistic, free as f64))
    }
}

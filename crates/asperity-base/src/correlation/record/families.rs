//! The rough and the smooth family fitted to the same records, and whether the records tell them apart.

use super::length::{LengthFit, LengthSettings, fit_length};
use super::likelihood::WindowedRecords;
use super::model::RecordModel;
use crate::correlation::estimate::EstimateError;
use crate::stats::Interval;

/// Likelihood ratio from which records tell the families apart. For two stated processes Markov's inequality bounds the
/// probability of this ratio against the true one by 5 %; with fitted lengths the tests measure it.
const TELLING_RATIO: f64 = 20.0;

/// Fits of both families to the same records.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FamilyFits {
    /// The more likely family first.
    pub fits: [LengthFit; 2],
    /// Family to use. If the records do not tell the families apart, it is the exponential, and its interval covers the
    /// intervals of the integral scale of both.
    pub chosen: LengthFit,
}

impl FamilyFits {
    /// Compares the fits of the exponential and of the smooth family.
    pub(super) fn new([exponential, smooth]: [LengthFit; 2]) -> Self {
        let rough_first = exponential.log_likelihood >= smooth.log_likelihood;
        let fits = if rough_first { [exponential, smooth] } else { [smooth, exponential] };
        let found = Self { fits, chosen: fits[0] };
        let scale = |metre: f64| smooth.model.integral_scale_m(metre) / exponential.model.integral_scale_m(1.0);
        let of_smooth = Interval { low: scale(smooth.interval.low), high: scale(smooth.interval.high) };
        let covering = LengthFit { interval: exponential.interval.around(of_smooth), ..exponential };
        if found.told_apart() { found } else { Self { chosen: covering, ..found } }
    }

    /// Returns 2 ln of the likelihood ratio of the families, divided by the variance of the scores of the more likely
    /// one relative to Gaussian records. A smaller variance than theirs, with this redundancy of tracks, is chance and counts as theirs.
    pub fn evidence(&self) -> f64 {
        let [likely, other] = self.fits;
        2.0 * (likely.log_likelihood - other.log_likelihood) / likely.dispersion.max(likely.track_redundancy)
    }

    /// Returns whether the records tell the families apart: their likelihoods differ by a factor of 20 or more.
    pub fn told_apart(&self) -> bool {
        self.evidence() >= 2.0 * TELLING_RATIO.ln()
    }
}

/// Fits both families as [`fit_length`] does.
///
/// # Errors
/// See [`fit_length`].
pub fn fit_families(channels: &[WindowedRecords<'_>], settings: LengthSettings) -> Result<FamilyFits, EstimateError> {
    let fit = |model| fit_length(channels, model, settings);
    Ok(FamilyFits::new([fit(RecordModel::Exponential)?, fit(RecordModel::Smooth)?]))
}

#[cfg(test)]
mod tests {
    use super::super::model::WindowedModel;
    use super::super::{ObservedLengths, RecordEnds, RecordHistory};
    use super::*;
    use crate::fourier::RealFft2;
    use crate::monitor::Silent;
    use crate::random;

    /// Returns a periodic record of a normal process of unit step with the correlation ρ(lag), by its spectrum.
    fn periodic(correlation: &dyn Fn(f64) -> f64, values: usize, index: u64) -> Vec<f64> {
        let fft = RealFft2::new(values, 1);
        let turns = |lag: usize| (-3..=3).map(move |turn| (lag as f64 + f64::from(turn) * values as f64).abs());
        let folded: Vec<f64> = (0..values).map(|lag| turns(lag).map(correlation).sum()).collect();
        let (mut density, mut waves, mut work) = (fft.spectrum(), fft.spectrum(), fft.workspace());
        fft.forward(&folded, &mut density, &mut work);
        let mut record = random::standard_normal(&mut random::stream(61, "families", index), values);
        fft.forward(&record, &mut waves, &mut work);
        waves.iter_mut().zip(&density).for_each(|(wave, density)| *wave *= density.re.max(0.0).sqrt());
        fft.inverse(&mut waves, &mut record, &mut work);
        record
    }

    /// Records of a known family.
    struct Case {
        model: RecordModel,
        /// Integral scale in steps.
        scale: f64,
        /// Window in steps; 0 for none.
        window: usize,
        /// Number of values of a record.
        values: usize,
        strips: usize,
    }

    impl Case {
        /// Fits both families to the records of a run.
        fn fit(&self, run: usize) -> FamilyFits {
            let length = self.scale / self.model.integral_scale_m(1.0);
            let shape =
                WindowedModel::new(self.model, self.window as f64).with_cells(f64::from(u8::from(self.window > 0)));
            let correlation = |lag: f64| shape.correlation(lag, length);
            let index = |strip: usize| (run * self.strips + strip) as u64;
            if self.window == 0 {
                let mut record = periodic(&correlation, 2 * self.values, index(0));
                record.truncate(self.values);
                return ObservedLengths::fit(&[&record], 1.0, RecordHistory::default(), &Silent).unwrap().families;
            }
            let step = self.window / 8;
            let records: Vec<Vec<f64>> = (0..self.strips)
                .map(|strip| periodic(&correlation, self.values, index(strip)).into_iter().step_by(step).collect())
                .collect();
            let channel = WindowedRecords {
                window_m: self.window as f64,
                step_m: step as f64,
                cell_m: 1.0,
                tracks: 1,
                records: records.iter().map(Vec::as_slice).collect(),
            };
            fit_families(&[channel], LengthSettings { ends: RecordEnds::Periodic, ..LengthSettings::default() })
                .unwrap()
        }

        /// Returns the numbers of runs whose interval contains the integral scale, that told the families apart, and
        /// that chose the other one by that.
        fn count(&self, runs: usize) -> [usize; 3] {
            let mut counts = [0; 3];
            for run in 0..runs {
                let found = self.fit(run);
                let chosen = found.chosen;
                let interval = [chosen.interval.low, chosen.interval.high].map(|m| chosen.model.integral_scale_m(m));
                let wrong = found.told_apart() && chosen.model != self.model;
                let is = [interval[0] <= self.scale && self.scale <= interval[1], found.told_apart(), wrong];
                counts.iter_mut().zip(is).for_each(|(count, is)| *count += usize::from(is));
            }
            counts
        }
    }

    /// Windows, integral scales, values and strips: short and long records, well and poorly resolved.
    const RECORDS: [(&str, usize, f64, usize, usize); 8] = [
        ("20 lengths of 20 steps", 0, 20.0, 400, 1),
        ("200 lengths of 20 steps", 0, 20.0, 4000, 1),
        ("50 lengths of 3 steps", 0, 3.0, 150, 1),
        ("500 lengths of 3 steps", 0, 3.0, 1500, 1),
        ("window of 2 lengths, 2 strips", 32, 16.0, 640, 2),
        ("window of 2 lengths, 40 strips", 32, 16.0, 640, 40),
        ("window of 8 lengths, 4 strips", 32, 4.0, 320, 4),
        ("window of 8 lengths, 40 strips", 32, 4.0, 320, 40),
    ];

    #[test]
    #[ignore = "slow"]
    fn intervals_cover_the_integral_scale_of_records_of_both_families() {
        // Of 300 intervals of 95 %, fewer than 272 contain the scale with probability .002.
        let runs = 300;
        for (name, window, scale, values, strips) in RECORDS {
            for model in RecordModel::BOTH {
                let [covered, told, wrong] = Case { model, scale, window, values, strips }.count(runs);
                println!("{name}, {}: covered {covered}, told apart {told}, wrong {wrong} of {runs}", model.name());
                assert!(covered >= 272 && wrong <= 15, "{name} {model:?}: {covered}, wrong {wrong} of {runs}");
            }
        }
    }

    #[test]
    fn records_that_do_not_resolve_the_family_do_not_tell() {
        // Of 20 intervals of 95 %, fewer than 16 contain the scale with probability .003.
        for model in RecordModel::BOTH {
            let under_window = Case { model, scale: 16.0, window: 32, values: 640, strips: 4 };
            let [covered, told, _] = under_window.count(20);
            assert!(covered >= 16 && told == 0, "{model:?}: {covered}, told apart {told} of 20");
            let long = Case { model, scale: 20.0, window: 0, values: 1000, strips: 1 };
            let [covered, told, wrong] = long.count(20);
            assert!(covered >= 16 && told == 20 && wrong == 0, "{model:?}: {covered}, {told}, wrong {wrong} of 20");
        }
    }

    #[test]
    fn the_test_of_fit_has_its_level_for_periodic_strips_with_few_wavenumbers() {
        // Five wavenumbers below 1/(2W). Of 60 tests, 5 % are 3 ± 1.7 and a half is 30 ± 3.9.
        let case = Case { model: RecordModel::Exponential, scale: 16.0, window: 32, values: 320, strips: 40 };
        let tests: Vec<f64> = (0..60).map(|run| case.fit(run).chosen.lack_of_fit.unwrap().p_value).collect();
        let below = |level: f64| tests.iter().filter(|p| **p < level).count();
        assert!(below(0.05) <= 9 && below(0.5) >= 14 && below(0.5) <= 43, "{tests:?}");
    }

    #[test]
    fn the_interval_of_families_that_are_not_told_apart_covers_both() {
        let found = Case { model: RecordModel::Smooth, scale: 16.0, window: 32, values: 640, strips: 4 }.fit(0);
        assert!(!found.told_apart() && found.chosen.model == RecordModel::Exponential);
        for fit in found.fits {
            let scale = fit.model.integral_scale_m(1.0);
            let ends = [scale * fit.interval.low, scale * fit.interval.high];
            assert!(found.chosen.interval.low <= ends[0] && ends[1] <= found.chosen.interval.high, "{found:?}");
        }
    }
}

//! Ensembles over damping, and the damping ratios at which vibration ends under noise.

use asperity_results::CrossingResult;
use serde::{Deserialize, Serialize};

use super::{Count, Ensemble, EnsembleSettings, Oscillator, VibrationError, limit_cycle, limit_damping};
use asperity_base::monitor::{Cancelled, Monitor, Quiet};
use asperity_base::sentence;
use asperity_base::stats::NORMAL_95;
use asperity_process::FrictionProcess;

/// Relative and absolute width of the bracket of a crossing.
const TOLERANCE: f64 = 5e-4;
const LEAST_TOLERANCE: f64 = 1e-6;
/// Difference of φ at the ends of a bracket, over the half-width of its interval, below which sampling errors dominate.
const RESOLVED: f64 = 0.1;
/// Upper end of the search for crossings, relative to the largest damping ratio with vibration without fluctuation.
const REACH: f64 = 2.0;

/// Ensembles at rising damping ratios with the same realisations of friction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DampingSweep {
    /// Damping ratios, rising.
    pub damping_ratios: Vec<f64>,
    /// Ensemble at each damping ratio.
    pub ensembles: Vec<Ensemble>,
}

fn no_crossing(share: f64, reason: String) -> CrossingResult {
    CrossingResult { share, reason: Some(reason), ..CrossingResult::default() }
}

impl DampingSweep {
    /// Returns the crossings of φ through each of the levels.
    ///
    /// φ(ζ) is the mean, over the realisations of friction, of the fraction of the second half of the time spent in
    /// vibration ([`super::Passages::late_share`]). A crossing is the largest ζ at which φ equals the level. Without
    /// fluctuation φ is 1 or 0, and all crossings equal the largest damping ratio with vibration. The interval holds the
    /// damping ratios at which the level lies within 1.96 standard errors of the mean over the trajectories; an end that
    /// the search did not reach is the end of its range.
    ///
    /// Every crossing is bracketed by the damping ratios of the sweep, by 0, or by twice the damping ratio at which
    /// vibration ends without fluctuation. It is then bisected with further ensembles of the same realisations, until
    /// the bracket is narrower than 0.05 % of the damping ratio, or until φ differs between its ends by less than a
    /// tenth of the half-width of its interval. The ends of the interval are found in the same way.
    ///
    /// `oscillator`, `process` and `settings` must be the ones of the sweep. Fails if settings are out of range, or
    /// when cancelled. If an ensemble is invalid at a damping ratio, for example at 0 because friction does not stay
    /// positive, the crossing has a reason instead of a value.
    pub fn crossings(
        &self,
        oscillator: &Oscillator,
        process: &FrictionProcess,
        levels: &[f64],
        settings: &EnsembleSettings,
        monitor: &dyn Monitor,
    ) -> Result<Vec<CrossingResult>, VibrationError> {
        let settings = EnsembleSettings { sample_capacity: 0, ..*settings };
        let share = |damping: f64| {
            let ensemble = Ensemble::simulate(&oscillator.with_damping(damping)?, process, &settings, &Quiet(monitor))?;
            Ok(ensemble.passages.late_share)
        };
        let points = self.damping_ratios.iter().zip(&self.ensembles);
        let points =
            points.map(|(&damping, ensemble)| Point { damping, share: ensemble.passages.late_share }).collect();
        let last = self.damping_ratios.last().copied().unwrap_or(0.0);
        Search { points, top: top(oscillator, last), share: &share }.crossings(levels)
    }
}

/// Returns the end of the search for crossings, at least `least`.
fn top(oscillator: &Oscillator, least: f64) -> f64 {
    // If the limit cannot be computed, the search ends with the sweep.
    let limit = limit_damping(oscillator).unwrap_or(0.0);
    least.max(REACH * limit)
}

/// Returns the crossings of an oscillator without fluctuation, which all equal the largest damping ratio at which it
/// vibrates.
///
/// Under forcing this damping ratio is bisected between 0 and the larger of `least` and twice the limit without
/// forcing.
///
/// # Errors
/// Fails like [`super::critical_damping`] and [`super::limit_cycle`], or when cancelled.
pub fn crossings_without_fluctuation(
    oscillator: &Oscillator,
    levels: &[f64],
    least: f64,
    monitor: &dyn Monitor,
) -> Result<Vec<CrossingResult>, VibrationError> {
    if oscillator.forcing().is_some() {
        let share = |damping: f64| {
            if monitor.cancelled() {
                return Err(Cancelled.into());
            }
            let vibrates = limit_cycle(&oscillator.with_damping(damping)?)?.kind().is_vibration();
            Ok(Count { mean: if vibrates { 1.0 } else { 0.0 }, std: 0.0, se: 0.0 })
        };
        return Search { points: Vec::new(), top: top(oscillator, least), share: &share }.crossings(levels);
    }
    let limit = match limit_damping(oscillator) {
        Err(VibrationError::NotFound { .. }) => None,
        found => Some(found?).filter(|limit| *limit > 0.0),
    };
    let crossing = |&share: &f64| match limit {
        Some(limit) => CrossingResult {
            share,
            damping_ratio: Some(limit),
            damping_ratio_interval: Some([limit, limit]),
            reason: None,
        },
        None => no_crossing(share, "without fluctuation of friction there is no vibration at any damping ratio".into()),
    };
    Ok(levels.iter().map(crossing).collect())
}

/// φ at a damping ratio.
#[derive(Debug, Clone, Copy)]
struct Point {
    damping: f64,
    share: Count,
}

/// Neighbouring points between which φ falls through a level for the last time.
enum Fall {
    Between(Point, Point),
    /// φ is at least the level up to the end of the search.
    Above,
    /// φ is below the level from ζ = 0 on.
    Below,
}

struct Search<'a> {
    /// Points by rising damping ratio.
    points: Vec<Point>,
    top: f64,
    share: &'a dyn Fn(f64) -> Result<Count, VibrationError>,
}

impl Search<'_> {
    fn crossings(&mut self, levels: &[f64]) -> Result<Vec<CrossingResult>, VibrationError> {
        levels
            .iter()
            .map(|&level| match self.crossing(level) {
                Err(error @ (VibrationError::Cancelled(_) | VibrationError::Parameter { .. })) => Err(error),
                Err(error) => Ok(no_crossing(level, format!("the search ended: {error}"))),
                found => found,
            })
            .collect()
    }

    fn crossing(&mut self, level: f64) -> Result<CrossingResult, VibrationError> {
        let percent = sentence::digits(100.0 * level);
        let (low, high) = match self.fall(level)? {
            Fall::Between(low, high) => (low, high),
            Fall::Above => {
                let reason = format!(
                    "vibration takes more than {percent} % of the time up to the damping ratio {}, where the search ends",
                    sentence::digits(self.top)
                );
                return Ok(no_crossing(level, reason));
            }
            Fall::Below => {
                let reason = format!("vibration takes less than {percent} % of the time even without damping");
                return Ok(no_crossing(level, reason));
            }
        };
        // If all trajectories agree on both sides, φ jumps between them.
        let jumps = low.share.se == 0.0 && high.share.se == 0.0;
        let fraction = if jumps { 0.5 } else { (low.share.mean - level) / (low.share.mean - high.share.mean) };
        let damping_ratio = low.damping + fraction * (high.damping - low.damping);
        let half_width = NORMAL_95 * low.share.se.max(high.share.se);
        let first = match self.fall_within(level + half_width)? {
            Fall::Between(low, _) => low.damping,
            Fall::Above => self.top,
            Fall::Below => 0.0,
        };
        let last = match self.fall_within(level - half_width)? {
            Fall::Between(_, high) => high.damping,
            Fall::Above => self.top,
            Fall::Below => 0.0,
        };
        Ok(CrossingResult {
            share: level,
            damping_ratio: Some(damping_ratio),
            damping_ratio_interval: Some([first, last]),
            reason: None,
        })
    }

    /// Returns the fall through a level that may lie outside the range of φ.
    fn fall_within(&mut self, level: f64) -> Result<Fall, VibrationError> {
        if level > 1.0 {
            Ok(Fall::Below)
        } else if level <= 0.0 {
            Ok(Fall::Above)
        } else {
            self.fall(level)
        }
    }

    fn fall(&mut self, level: f64) -> Result<Fall, VibrationError> {
        let last_above = |points: &[Point]| points.iter().rposition(|point| point.share.mean >= level);
        if self.points.last().is_none_or(|point| point.share.mean >= level && point.damping < self.top) {
            self.add(self.top)?;
        }
        if last_above(&self.points).is_none() && self.points.first().is_none_or(|point| point.damping > 0.0) {
            self.add(0.0)?;
        }
        let Some(mut at) = last_above(&self.points) else { return Ok(Fall::Below) };
        if at + 1 == self.points.len() {
            return Ok(Fall::Above);
        }
        let mut halve = false;
        loop {
            let (low, high) = (self.points[at], self.points[at + 1]);
            let (width, drop) = (high.damping - low.damping, low.share.mean - high.share.mean);
            let resolved = RESOLVED * NORMAL_95 * low.share.se.max(high.share.se);
            if width <= TOLERANCE * high.damping + LEAST_TOLERANCE || drop <= resolved {
                return Ok(Fall::Between(low, high));
            }
            // Alternates regula falsi with bisection, away from the ends.
            let fraction = if halve { 0.5 } else { ((low.share.mean - level) / drop).clamp(0.1, 0.9) };
            let added = self.add(low.damping + fraction * width)?;
            at = if self.points[added].share.mean >= level { added } else { added - 1 };
            halve = self.points[at + 1].damping - self.points[at].damping > 0.5 * width;
        }
    }

    /// Evaluates φ and returns the index of its point.
    fn add(&mut self, damping: f64) -> Result<usize, VibrationError> {
        let share = (self.share)(damping)?;
        let index = self.points.partition_point(|point| point.damping < damping);
        self.points.insert(index, Point { damping, share });
        Ok(index)
    }
}

/// Simulates ensembles of one oscillator at several damping ratios, which must rise.
///
/// Trajectory i uses the same realisation at every damping ratio, so differences along the sweep have less noise than
/// counts. Fails like [`Ensemble::simulate`].
pub fn damping_sweep(
    oscillator: &Oscillator,
    damping_ratios: &[f64],
    process: &FrictionProcess,
    settings: &EnsembleSettings,
    monitor: &dyn Monitor,
) -> Result<DampingSweep, VibrationError> {
    if let Some(pair) = damping_ratios.windows(2).find(|pair| pair[0] >= pair[1]) {
        return Err(VibrationError::Parameter { parameter: "damping sweep", value: pair[1], wanted: "rising" });
    }
    let mut ensembles = Vec::with_capacity(damping_ratios.len());
    for (done, &damping) in damping_ratios.iter().enumerate() {
        monitor.progress("damping ratios", done, damping_ratios.len());
        ensembles.push(Ensemble::simulate(&oscillator.with_damping(damping)?, process, settings, monitor)?);
    }
    monitor.progress("damping ratios", damping_ratios.len(), damping_ratios.len());
    Ok(DampingSweep { damping_ratios: damping_ratios.to_vec(), ensembles })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Coulomb;
    use crate::tests::machine;
    use crate::{Forcing, VelocityLaw};
    use asperity_base::distribution::standard_normal_quantile;
    use asperity_base::monitor::Silent;
    use asperity_base::random;
    use asperity_process::ProcessModel;
    use asperity_testing::covered;

    const LEVELS: [f64; 3] = [0.95, 0.5, 0.05];

    /// Returns a function with the mean and standard error of φ over trajectories. Each trajectory vibrates all of the
    /// time below its threshold and never above; thresholds are normal about 0.2 with a standard deviation of 0.02.
    fn thresholds(count: usize, seed: u64) -> impl Fn(f64) -> Result<Count, VibrationError> {
        let normal = random::standard_normal(&mut random::stream(seed, "thresholds", 0), count);
        move |damping| {
            let n = normal.len() as f64;
            let mean = normal.iter().filter(|z| 0.2 + 0.02 * **z > damping).count() as f64 / n;
            let std = (mean * (1.0 - mean) * n / (n - 1.0)).sqrt();
            Ok(Count { mean, std, se: std / n.sqrt() })
        }
    }

    #[test]
    fn crossings_match_the_mean_within_the_tolerance_for_any_sweep() {
        // Without sampling error: φ = 1/(1 + e^{(ζ − .2)/.004}).
        let logistic =
            |damping: f64| Ok(Count { mean: (1.0 + ((damping - 0.2) / 0.004).exp()).recip(), std: 0.0, se: 0.0 });
        for known in [&[][..], &[0.1, 0.3], &[0.01, 0.02], &[0.3, 0.39], &[0.1, 0.15, 0.2, 0.25]] {
            let points = known.iter().map(|&damping| Point { damping, share: logistic(damping).unwrap() }).collect();
            let found = Search { points, top: 0.4, share: &logistic }.crossings(&LEVELS).unwrap();
            for crossing in found {
                let wanted = 0.2 + 0.004 * (1.0 / crossing.share - 1.0).ln();
                let error = (crossing.damping_ratio.unwrap() - wanted).abs();
                assert!(error < TOLERANCE * wanted, "{known:?}: {crossing:?} instead of {wanted}");
                let [low, high] = crossing.damping_ratio_interval.unwrap();
                assert!(low <= wanted && wanted <= high && high - low <= 1.1 * TOLERANCE * wanted, "{crossing:?}");
            }
        }
        let outside = Search { points: Vec::new(), top: 0.19, share: &logistic }.crossings(&LEVELS).unwrap();
        assert!(outside[0].damping_ratio.is_some() && outside[1].reason.as_ref().unwrap().contains("0.19"));
        let weak = |_: f64| Ok(Count { mean: 0.6, std: 0.0, se: 0.0 });
        let found = Search { points: Vec::new(), top: 0.4, share: &weak }.crossings(&LEVELS).unwrap();
        assert!(found[0].reason.as_ref().unwrap().contains("even without damping"));
        assert!(
            found.iter().all(|crossing| crossing.damping_ratio.is_none() && crossing.damping_ratio_interval.is_none())
        );
    }

    #[test]
    fn intervals_of_crossings_cover_quantiles_of_normal_thresholds() {
        let replicates = 1000;
        for paths in [400, 100, 16] {
            let mut held = [0; 3];
            for replicate in 0..replicates {
                let share = thresholds(paths, replicate);
                let found = Search { points: Vec::new(), top: 0.4, share: &share }.crossings(&LEVELS).unwrap();
                for (count, crossing) in held.iter_mut().zip(found) {
                    let wanted = 0.2 + 0.02 * standard_normal_quantile(1.0 - crossing.share);
                    let [low, high] = crossing.damping_ratio_interval.unwrap();
                    *count += usize::from(low <= wanted && wanted <= high);
                }
            }
            for (level, held) in LEVELS.into_iter().zip(held) {
                let case = format!("normal thresholds of {paths} trajectories, {:.0} %", 100.0 * level);
                let fraction = covered("damping ratio at a fraction of vibration", &case, held, replicates as usize);
                assert!(fraction >= 0.93, "{case}: {fraction}");
            }
        }
    }

    #[test]
    fn more_noise_widens_the_end_of_vibration() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
        let settings = EnsembleSettings::new(20, 200.0, 9);
        let width = |std| {
            let model = ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01);
            let process = FrictionProcess::new(model).unwrap();
            let sweep = damping_sweep(&oscillator, &[0.14, 0.22, 0.3], &process, &settings, &Silent).unwrap();
            let found = sweep.crossings(&oscillator, &process, &LEVELS, &settings, &Silent).unwrap();
            for crossing in &found {
                let ([a, b], damping_ratio) =
                    (crossing.damping_ratio_interval.unwrap(), crossing.damping_ratio.unwrap());
                assert!(a <= damping_ratio && damping_ratio <= b);
            }
            found[2].damping_ratio.unwrap() - found[0].damping_ratio.unwrap()
        };
        let (little, much) = (width(1e-6), width(1e-3));
        assert!(little < 1e-3 && much > 0.03, "{little} and {much}");
    }

    #[test]
    fn without_fluctuation_all_crossings_are_the_end_of_vibration() {
        let crossings = |oscillator: &Oscillator| {
            let found = crossings_without_fluctuation(oscillator, &LEVELS, 0.3, &Silent).unwrap();
            assert!(found.windows(2).all(|pair| pair[0].damping_ratio == pair[1].damping_ratio));
            found[1].clone()
        };
        let free = Oscillator::with_stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
        let found = crossings(&free);
        assert!((found.damping_ratio.unwrap() - 0.204_830_150_584_523_17).abs() < 1e-12);
        // Boundary of the 1:1 locked orbit.
        let forced = Oscillator::with_stribeck(0.2, 4.2, 0.1, 0.1).unwrap();
        let forced = forced.with_forcing(Some(Forcing { amplitude: 0.01, frequency: 0.98 })).unwrap();
        let found = crossings(&forced);
        assert!((found.damping_ratio.unwrap() - 0.270_299_774_5).abs() < 1.4e-4, "{found:?}");
        let law = VelocityLaw::Coulomb(Coulomb { kinetic: 0.3 });
        let found = crossings(&machine(0.3, law, 0.1, 0.1));
        assert!(found.damping_ratio.is_none() && found.reason.unwrap().contains("no vibration"));
    }

    #[test]
    fn a_sweep_that_does_not_rise_is_refused() {
        let oscillator = Oscillator::with_stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
        let process = FrictionProcess::new(ProcessModel::new("normal".parse().unwrap(), 1e-4, 0.01)).unwrap();
        let settings = EnsembleSettings::new(2, 10.0, 9);
        assert!(damping_sweep(&oscillator, &[0.2, 0.1], &process, &settings, &Silent).is_err());
    }
}

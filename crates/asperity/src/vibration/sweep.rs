//! Ensembles over damping: how noise smears the sharp end of the cycle.

use serde::{Deserialize, Serialize};

use super::{Ensemble, EnsembleSettings, Oscillator, VibrationError};
use crate::friction::process::FrictionProcess;
use crate::monitor::Monitor;
use crate::stats::NORMAL_95;

/// Ensembles at rising damping ratios under the same realisations of friction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DampingSweep {
    /// Damping ratios, rising.
    pub damping_ratios: Vec<f64>,
    /// One ensemble for each.
    pub ensembles: Vec<Ensemble>,
}

/// Where the cycle rate falls through a level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// Share of the rate at the least damping of the sweep.
    pub share: f64,
    /// Damping ratio, interpolated linearly.
    pub damping_ratio: f64,
    /// 95 % interval: where the mean count less and plus 1.96 standard errors falls through the level.
    pub interval: [f64; 2],
}

impl DampingSweep {
    /// Where the mean number of cycles falls through a share of its value at the least damping of the sweep.
    ///
    /// None if it, or a bound of its interval, does not fall so low within the sweep. The sampling error of the reference
    /// count itself is left aside: all ensembles share their realisations, so it is correlated with the others.
    pub fn falls_through(&self, share: f64) -> Option<Crossing> {
        let level = share * self.ensembles.first()?.cycles.mean;
        let crossing = |errors: f64| {
            let count = |i: usize| self.ensembles[i].cycles.mean + errors * self.ensembles[i].cycles.se;
            let after = (1..self.ensembles.len()).find(|&i| count(i) <= level && count(i - 1) > level)?;
            let fraction = (count(after - 1) - level) / (count(after - 1) - count(after));
            let (a, b) = (self.damping_ratios[after - 1], self.damping_ratios[after]);
            Some(a + fraction * (b - a))
        };
        let interval = [crossing(-NORMAL_95)?, crossing(NORMAL_95)?];
        Some(Crossing { share, damping_ratio: crossing(0.0)?, interval })
    }
}

/// Ensembles of one oscillator at several damping ratios, which must rise.
///
/// Trajectory i reads the same realisation at every damping, so differences along the sweep have less noise than counts.
/// Fails as [`Ensemble::simulate`] does.
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
    use crate::friction::process::ProcessModel;
    use crate::monitor::Silent;

    #[test]
    fn more_noise_smears_the_end_of_the_cycle_more() {
        let oscillator = Oscillator::stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
        let damping_ratios: Vec<f64> = (0..9).map(|i| 0.14 + 0.02 * f64::from(i)).collect();
        let settings = EnsembleSettings::new(20, 200.0, 9);
        let width = |std| {
            let model = ProcessModel::new("beta:2.1,5".parse().unwrap(), std, 0.01);
            let process = FrictionProcess::new(model).unwrap();
            let sweep = damping_sweep(&oscillator, &damping_ratios, &process, &settings, &Silent).unwrap();
            let (high, low) = (sweep.falls_through(0.9).unwrap(), sweep.falls_through(0.5).unwrap());
            for crossing in [high, low] {
                let [a, b] = crossing.interval;
                assert!(a <= crossing.damping_ratio && crossing.damping_ratio <= b);
            }
            let beginning = DampingSweep {
                damping_ratios: sweep.damping_ratios[..2].to_vec(),
                ensembles: sweep.ensembles[..2].to_vec(),
            };
            assert_eq!(beginning.falls_through(0.5), None);
            low.damping_ratio - high.damping_ratio
        };
        let (little, much) = (width(1e-5), width(1e-3));
        assert!(little > 0.0 && little < 0.02 && much > 0.03, "{little} and {much}");
    }

    #[test]
    fn a_sweep_that_does_not_rise_is_refused() {
        let oscillator = Oscillator::stribeck(0.1, 4.2, 0.1, 0.003).unwrap();
        let process = FrictionProcess::new(ProcessModel::new("normal".parse().unwrap(), 1e-4, 0.01)).unwrap();
        let settings = EnsembleSettings::new(2, 10.0, 9);
        assert!(damping_sweep(&oscillator, &[0.2, 0.1], &process, &settings, &Silent).is_err());
    }
}

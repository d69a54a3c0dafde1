//! Velocity of one trajectory as an audio signal.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use super::{
    Oscillator, PhasePoint, TrajectorySettings, VibrationError, cycle_portrait, limit_cycle, positive,
    trajectory_portrait,
};
use asperity_process::Fluctuation;

/// Peak of the limit cycle relative to full scale, −6 dB.
const PEAK_DB: f64 = -6.0;
/// Length of the fades in seconds, at most a quarter of the record each.
const FADE_S: f64 = 0.01;
/// Number of points of the limit cycle in the search for its largest velocity.
const CYCLE_POINTS: usize = 8193;
/// Longest record in seconds.
const LONGEST_S: f64 = 600.0;

/// Settings of an audio signal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveformSettings {
    /// Natural frequency f₀ = ω₀/2π in hertz, which sets the scale of τ = ω₀t.
    pub natural_frequency_hz: f64,
    /// Samples per second.
    pub sampling_rate_hz: f64,
    /// Length in seconds, at most 600.
    pub seconds: f64,
    /// Time τ before the first sample.
    pub from: f64,
    /// Settings of the trajectory; its duration is replaced by the length of the record.
    pub followed: TrajectorySettings,
}

/// Velocity X′ of a mass at equal times, as fractions of full scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Waveform {
    /// Samples per second.
    pub sampling_rate_hz: f64,
    /// Samples; values beyond ±1 exceed the range of an integer file.
    pub samples: Vec<f64>,
    /// Velocity X′ at −6 dB of full scale: the largest velocity of the limit cycle without fluctuation, or of the
    /// record if there is no cycle.
    pub reference_velocity: f64,
    /// Frequency of the limit cycle in hertz, if there is one.
    pub cycle_frequency_hz: Option<f64>,
}

impl Waveform {
    /// Records one trajectory.
    ///
    /// Every sample is a value of the motion itself at τ = `from` + 2πf₀k/rate, without interpolation and without
    /// filter. The velocity has kinks where stick ends and begins; their frequency components above half the sampling
    /// rate have a density that falls with the fourth power of the frequency. The first and the last 10 ms fade in and
    /// out.
    ///
    /// Fails if the natural frequency, the frequency of the force or of the cycle is not below half the sampling rate,
    /// if settings are out of range, and like [`super::Trajectory::simulate`].
    pub fn record(
        oscillator: &Oscillator,
        fluctuation: impl Fluctuation,
        settings: &WaveformSettings,
    ) -> Result<Self, VibrationError> {
        let WaveformSettings { natural_frequency_hz, sampling_rate_hz, seconds, from, followed } = *settings;
        positive("natural frequency", natural_frequency_hz)?;
        positive("sampling rate", sampling_rate_hz)?;
        let count = (seconds * sampling_rate_hz).round();
        if !(seconds <= LONGEST_S && count >= 2.0) {
            let wanted = "two samples at least and 600 s at most";
            return Err(VibrationError::Parameter { parameter: "seconds", value: seconds, wanted });
        }
        let cycle_frequency_hz =
            limit_cycle(oscillator)?.cycle().map(|cycle| natural_frequency_hz * TAU / cycle.period);
        let force = oscillator.forcing().map_or(0.0, |force| force.frequency * natural_frequency_hz);
        let highest = natural_frequency_hz.max(force).max(cycle_frequency_hz.unwrap_or(0.0));
        if highest >= 0.5 * sampling_rate_hz {
            let wanted = "below half the sampling rate, in hertz";
            return Err(VibrationError::Parameter { parameter: "frequency of the vibration", value: highest, wanted });
        }
        let step = TAU * natural_frequency_hz / sampling_rate_hz;
        let followed = TrajectorySettings { duration: from + step * (count - 1.0), ..followed };
        let record = trajectory_portrait(oscillator, fluctuation, &followed, from, count as usize)?;
        let cycle = cycle_portrait(oscillator, CYCLE_POINTS)?;
        let reference_velocity = largest(cycle.as_ref().unwrap_or(&record));
        let scale = if reference_velocity > 0.0 { 10_f64.powf(PEAK_DB / 20.0) / reference_velocity } else { 0.0 };
        let fade = (FADE_S * sampling_rate_hz).min(0.25 * count);
        let samples = record.iter().enumerate().map(|(k, point)| {
            let from_end = (k as f64).min(count - 1.0 - k as f64);
            let fraction = (from_end / fade).min(1.0);
            scale * point.velocity * 0.5 * (1.0 - (PI * fraction).cos())
        });
        Ok(Self { sampling_rate_hz, samples: samples.collect(), reference_velocity, cycle_frequency_hz })
    }
}

/// Returns the largest speed of a portrait.
fn largest(points: &[PhasePoint]) -> f64 {
    points.iter().fold(0.0, |most, point| point.velocity.abs().max(most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Drive, Forcing};
    use asperity_process::Steady;

    fn settings(natural_frequency_hz: f64, seconds: f64) -> WaveformSettings {
        let followed = TrajectorySettings { duration: 1.0, start: None, drive: Drive::Distance };
        WaveformSettings { natural_frequency_hz, sampling_rate_hz: 44_100.0, seconds, from: 60.0, followed }
    }

    fn machine(damping: f64) -> Oscillator {
        Oscillator::with_stribeck(0.1, 4.2, damping, 0.003).unwrap()
    }

    #[test]
    fn the_cycle_peaks_at_half_of_full_scale_and_fades_at_both_ends() {
        let wave = Waveform::record(&machine(0.17), Steady, &settings(440.0, 0.5)).unwrap();
        assert_eq!(wave.samples.len(), 22_050);
        let peak = wave.samples.iter().fold(0.0_f64, |most, sample| sample.abs().max(most));
        // Between samples, 0.063 of τ apart, the peak may be missed by half the curvature times the squared half
        // distance.
        assert!((peak / 10_f64.powf(-0.3) - 1.0).abs() < 1e-3, "{peak}");
        assert_eq!((wave.samples[0], wave.samples[22_049]), (0.0, 0.0));
        let slowest = limit_cycle(&machine(0.17)).unwrap().cycle().unwrap().velocity_min.abs();
        assert!((wave.reference_velocity / slowest - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_dominant_frequency_is_the_frequency_of_the_cycle() {
        let wave = Waveform::record(&machine(0.17), Steady, &settings(500.0, 0.2)).unwrap();
        let power = |bin: usize| {
            let turn = TAU * bin as f64 / wave.samples.len() as f64;
            let sum = |wave: &[f64], of: fn(f64) -> f64| -> f64 {
                wave.iter().enumerate().map(|(k, sample)| sample * of(turn * k as f64)).sum()
            };
            sum(&wave.samples, f64::cos).powi(2) + sum(&wave.samples, f64::sin).powi(2)
        };
        let loudest = (1..400).max_by(|a, b| power(*a).total_cmp(&power(*b))).unwrap();
        // T from a high-precision solver; a bin is 5 Hz wide.
        let wanted = 500.0 * TAU / 6.372_163_483_739_709;
        assert!((5.0 * loudest as f64 - wanted).abs() <= 2.5, "bin {loudest}, wanted {wanted} Hz");
        assert!((wave.cycle_frequency_hz.unwrap() / wanted - 1.0).abs() < 1e-10);
    }

    #[test]
    fn a_settled_machine_is_scaled_by_its_own_record() {
        let wave = Waveform::record(&machine(0.3), Steady, &WaveformSettings { from: 0.0, ..settings(440.0, 0.1) });
        let wave = wave.unwrap();
        assert_eq!(wave.cycle_frequency_hz, None);
        assert!(wave.samples.iter().all(|sample| sample.abs() <= 10_f64.powf(-0.3)));
    }

    #[test]
    #[ignore = "slow"]
    fn frequencies_above_half_the_sampling_rate_are_refused() {
        let refused = |oscillator: &Oscillator, settings| Waveform::record(oscillator, Steady, &settings).is_err();
        assert!(refused(&machine(0.17), settings(22_050.0, 0.1)));
        assert!(refused(&machine(0.17), settings(0.0, 0.1)));
        assert!(refused(&machine(0.17), settings(440.0, 1e-6)));
        assert!(refused(&machine(0.17), settings(440.0, 601.0)));
        let forced = machine(0.17).with_forcing(Some(Forcing { amplitude: 0.01, frequency: 60.0 })).unwrap();
        assert!(refused(&forced, settings(440.0, 0.1)));
    }
}

//! Velocity as a sound file.

use std::f64::consts::TAU;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use asperity::friction::process::FrictionProcess;
use asperity::quantity::AngularFrequency;
use asperity::vibration::{Oscillator, SoundSettings, Waveform, WaveformSettings};
use clap::Args;
use hound::{SampleFormat, WavSpec, WavWriter};

use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{check_target, replace_file, write_verb};

/// Samples per second.
const SAMPLING_RATE_HZ: u32 = 44_100;
/// Default length of a file in seconds.
const SECONDS: f64 = 5.0;

/// Flags of the sound file.
#[derive(Debug, Args)]
pub(super) struct Wav {
    /// Write the velocity of the first trajectory to this file: mono, 16 bits, 44,100 Hz, with the limit cycle's peak 6
    /// dB below full scale.
    #[arg(long, value_name = "FILE.wav", requires = "natural_frequency")]
    wav: Option<PathBuf>,
    /// Length of the sound file in seconds; 5 when left out.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, requires = "wav")]
    seconds: Option<f64>,
}

impl Wav {
    pub(super) fn is_requested(&self) -> bool {
        self.wav.is_some()
    }

    /// Fails if the file cannot be written.
    pub(super) fn check(&self, inputs: &[&Path]) -> Result<(), Failure> {
        self.wav.as_ref().map_or(Ok(()), |file| check_target("--wav", file, inputs))
    }

    /// Simulates the first trajectory for the duration of the file, if requested.
    pub(super) fn record(
        &self,
        oscillator: &Oscillator,
        process: &FrictionProcess,
        settings: &SoundSettings,
        natural_frequency: Option<AngularFrequency>,
        monitor: &Terminal,
    ) -> Result<Option<Waveform>, Failure> {
        let Some(natural_frequency) = natural_frequency.filter(|_| self.is_requested()) else { return Ok(None) };
        let waveform = WaveformSettings {
            natural_frequency_hz: natural_frequency.0 / TAU,
            sampling_rate_hz: f64::from(SAMPLING_RATE_HZ),
            seconds: self.seconds.unwrap_or(SECONDS),
            from: settings.from,
            followed: settings.followed,
        };
        let path = process.path(settings.seed, 0);
        let wave = monitor.killable(|| Waveform::record(oscillator, path, &waveform))??;
        Ok(Some(wave))
    }

    /// Writes the sound file.
    pub(super) fn write(&self, wave: Option<&Waveform>, monitor: &Terminal) -> Result<(), Failure> {
        let Some((file, wave)) = self.wav.as_ref().zip(wave) else { return Ok(()) };
        let loud = wave.samples.iter().filter(|sample| sample.abs() > 1.0).count();
        if loud > 0 {
            monitor.warn(&format!("{loud} of {} samples exceed full scale and are clipped", wave.samples.len()));
        }
        let verb = write_verb(file);
        replace_file(file, |file| written(BufWriter::new(file), &wave.samples).map_err(io_error))?;
        monitor.note(&format!("{verb} {}", file.display()));
        Ok(())
    }
}

fn written(file: impl io::Write + io::Seek, samples: &[f64]) -> Result<(), hound::Error> {
    let sample_format = SampleFormat::Int;
    let spec = WavSpec { channels: 1, sample_rate: SAMPLING_RATE_HZ, bits_per_sample: 16, sample_format };
    let mut writer = WavWriter::new(file, spec)?;
    for sample in samples {
        writer.write_sample((sample.clamp(-1.0, 1.0) * f64::from(i16::MAX)).round() as i16)?;
    }
    writer.finalize()
}

fn io_error(error: hound::Error) -> io::Error {
    match error {
        hound::Error::IoError(error) => error,
        other => io::Error::other(other),
    }
}

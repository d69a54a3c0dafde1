//! Sound of the vibration: level and spectrum.

use std::f64::consts::TAU;

use asperity::quantity::AngularFrequency;
use asperity::study::Table;
use asperity::study::result::SoundSpectrum;
use asperity::vibration::{self, Drive, Oscillator, SoundSettings, TrajectorySettings, limit_cycle};
use asperity_report::VibrationFigures;
use clap::Args;

use super::folder::Folder;
use super::machine::{Damping, Machine};
use super::random::{Source, note_time};
use super::wav::Wav;
use crate::args;
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::{Answer, columns, print};
use crate::resources::require_memory;

/// Memory for one point of a record, in bytes.
const POINT_BYTES: f64 = 48.0;

/// Records the velocity of several trajectories: its level relative to the limit cycle's, and its power spectrum.
#[derive(Debug, Args)]
pub(crate) struct Sound {
    #[command(flatten)]
    machine: Machine,
    #[command(flatten)]
    damping: Damping,
    #[command(flatten)]
    source: Source,
    /// Number of trajectories.
    #[arg(long, value_name = "N", default_value = "32", value_parser = args::count, allow_hyphen_values = true)]
    trajectories: usize,
    /// Duration τ of each trajectory.
    #[arg(long, value_name = "X", default_value = "640", value_parser = args::positive, allow_hyphen_values = true)]
    duration: f64,
    /// Time τ before the record begins.
    #[arg(long, value_name = "X", default_value = "60", value_parser = args::non_negative, allow_hyphen_values = true)]
    from: f64,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
    #[command(flatten)]
    wav: Wav,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl Sound {
    /// Returns whether the command writes a sound file, which has the natural frequency of the machine.
    pub(super) fn writes_wav(&self) -> bool {
        self.wav.is_requested()
    }

    pub(crate) fn run(&self, natural_frequency: Option<AngularFrequency>, monitor: &Terminal) -> Result<(), Failure> {
        let oscillator = self.machine.oscillator(self.damping.damping_ratio, monitor)?;
        let process = self.source.process(&oscillator, monitor)?;
        let settings = SoundSettings {
            trajectories: self.trajectories,
            points_per_period: 64,
            from: self.from,
            seed: self.seed,
            followed: TrajectorySettings { duration: self.duration, start: None, drive: Drive::Distance },
        };
        let inputs: Vec<_> = self.machine.friction.inputs().into_iter().chain(self.source.inputs()).collect();
        let has_folder = self.folder.is_requested(&inputs)?;
        self.wav.check(&inputs)?;
        note_time(&process, oscillator.belt_velocity() * self.duration, self.trajectories, monitor);
        // Includes the phase portraits and transforms of the velocities.
        let points = self.duration / TAU * settings.points_per_period as f64;
        require_memory(POINT_BYTES * points * self.trajectories as f64, "the record of the velocities")?;
        let wave = self.wav.record(&oscillator, &process, &settings, natural_frequency, monitor)?;
        let sound = vibration::Sound::record(&oscillator, &process, &settings, monitor)?;
        let period = cycle_period(&oscillator, monitor)?;
        let clipped = process.model().clipped_fraction();
        let answer = Answer::new(&sound)?.with("cycle_period", period).with("clipped_fraction", clipped);
        if has_folder {
            let &vibration::Sound { level_db, level_db_interval, .. } = &sound;
            let figures = VibrationFigures::Sound { level_db, level_db_interval, cycle_period: period };
            self.folder.write(
                "sound",
                &figures,
                &inputs,
                &answer,
                vec![("sound_spectrum", spectrum(&sound))],
                monitor,
            )?;
        }
        self.wav.write(wave.as_ref(), monitor)?;
        if self.json {
            return answer.print(true);
        }
        let spectrum = ["frequency", "density", "density_low", "density_high"];
        spectrum.iter().fold(answer, |answer, key| answer.without(key)).print(false)?;
        let mut rows = vec![["frequency/natural", "density", "95 % low", "95 % high"].map(str::to_owned)];
        for k in 0..sound.frequency.len() {
            let row = [sound.frequency[k], sound.density[k], sound.density_low[k], sound.density_high[k]];
            rows.push(row.map(|value| format!("{value:.4e}")));
        }
        print(&format!("\n{}", columns(&rows)))
    }
}

/// Returns the period of the limit cycle without fluctuation.
fn cycle_period(oscillator: &Oscillator, monitor: &Terminal) -> Result<Option<f64>, Failure> {
    let regime = monitor.killable(|| limit_cycle(oscillator))??;
    Ok(regime.cycle().map(|cycle| cycle.period))
}

fn spectrum(sound: &vibration::Sound) -> Table {
    Table::from(SoundSpectrum {
        frequency: (&sound.frequency).into(),
        density: (&sound.density).into(),
        density_low: (&sound.density_low).into(),
        density_high: (&sound.density_high).into(),
    })
}

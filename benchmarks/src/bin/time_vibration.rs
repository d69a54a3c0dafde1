//! Times the stick-slip solver, and prints seconds and results as JSON.
//!
//! `cargo run --release -p asperity-benchmarks --bin time_vibration -- CASE key=value …`; the mass on the belt has the friction law of the paper.
//!
//! | case | timed work |
//! |---|---|
//! | `cycle` | `cycles` deterministic cycles of one mass |
//! | `lockstep` | `cycles` deterministic cycles of each of `machines` masses in one batch, damping ratios evenly over ±10 % |
//! | `path` | `paths` trajectories of `duration` under stochastic friction, one after the other, the noise included |
//! | `ensemble` | the same in one batch, with the distributions of their counts |
//! | `sweep` | `paths` trajectories at each of `dampings` damping ratios from 0.14 to 0.30, in one batch |
//!
//! | key | default | meaning |
//! |---|---|---|
//! | `friction`, `decay`, `damping`, `velocity` | 0.1, 4.2, 0.17, 0.003 | μ_st, a, ζ, V |
//! | `cycles`, `machines`, `paths`, `dampings` | 1000, 256, 400, 12 | see above |
//! | `duration` | 637.2 | τ of a trajectory |
//! | `std`, `length` | 0.001, 0.01 | of the friction process: Beta(2.1, 5), 20 grid points per correlation length |
//! | `seed` | 1 | of the friction process |
//! | `repeats`, `warm_up` | 5, 1 | timed runs, and runs before them that are not timed |
//! | `threads` | 1 | of the pool; 0: all |
//! | `knots` | | file for the grid values of all paths, little-endian doubles, path by path (`path`) |
#![expect(clippy::print_stdout, reason = "prints times")]

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use asperity::friction::process::{FrictionProcess, ProcessModel, Steady};
use asperity::monitor::Silent;
use asperity::vibration::{
    Drive, Ensemble, EnsembleSettings, Event, EventKind, Oscillator, Trajectory, TrajectorySettings, damping_sweep,
    deterministic_slips, limit_cycle,
};
use asperity_benchmarks::Words;
use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Settings of the timed work.
struct Job {
    damping: f64,
    oscillator: Oscillator,
    process: FrictionProcess,
    cycles: usize,
    machines: usize,
    paths: usize,
    dampings: usize,
    duration: f64,
    seed: u64,
    knots: String,
    repeats: usize,
    warm_up: usize,
}

impl Job {
    /// Returns the seconds of the timed runs and the result of the last.
    fn timed<T>(&self, mut run: impl FnMut() -> Result<T>) -> Result<(Vec<f64>, T)> {
        for _ in 0..self.warm_up {
            run()?;
        }
        let mut seconds = Vec::new();
        loop {
            let start = Instant::now();
            let result = run()?;
            seconds.push(start.elapsed().as_secs_f64());
            if seconds.len() >= self.repeats {
                return Ok((seconds, result));
            }
        }
    }

    fn settings(&self, duration: f64) -> TrajectorySettings {
        TrajectorySettings { duration, start: None, drive: Drive::Distance }
    }

    /// Returns a duration in which a mass from the default start finishes at least `cycles` cycles.
    fn long_enough(&self, cycles: usize) -> Result<f64> {
        let regime = limit_cycle(&self.oscillator)?;
        let period = regime.cycle().ok_or("there is no cycle at this damping ratio")?.period;
        Ok(period * (cycles + 2) as f64)
    }

    fn cycle(&self) -> Result<Value> {
        let settings = self.settings(self.long_enough(self.cycles)?);
        let (seconds, found) =
            self.timed(|| Ok(Trajectory::simulate(black_box(&self.oscillator), Steady, &settings)?))?;
        let detached: Vec<f64> =
            found.events.iter().filter(|event| event.kind == EventKind::Detach).map(|event| event.tau).collect();
        let (first, last) = (detached.first().ok_or("no slip")?, detached.last().ok_or("no slip")?);
        let period = (last - first) / (detached.len() - 1) as f64;
        Ok(json!({ "seconds": seconds, "cycles": found.slips.cycles, "period": period }))
    }

    fn lockstep(&self) -> Result<Value> {
        let settings = self.settings(self.long_enough(self.cycles)?);
        let machines: Vec<Oscillator> = (0..self.machines)
            .map(|i| {
                let place = 2.0 * i as f64 / (self.machines - 1).max(1) as f64 - 1.0;
                Ok(self.oscillator.with_damping(self.damping * (1.0 + 0.1 * place))?)
            })
            .collect::<Result<_>>()?;
        let (seconds, cycles) = self.timed(|| {
            let mut cycles = 0;
            for slips in deterministic_slips(black_box(&machines), &settings) {
                cycles += slips?.cycles;
            }
            Ok(cycles)
        })?;
        // The batch returns counts alone, so the period follows from bisected ends of the first and a later cycle.
        let later = self.cycles.min(100);
        let (first, last) = (self.end_of_cycle(1)?, self.end_of_cycle(1 + later)?);
        Ok(json!({ "seconds": seconds, "cycles": cycles, "period": (last - first) / later as f64 }))
    }

    /// Returns the time at which the batch finishes cycle `number`: the shortest duration with this count.
    fn end_of_cycle(&self, number: usize) -> Result<f64> {
        let machines = vec![self.oscillator.clone(); 8];
        let (mut before, mut after) = (0.0, self.long_enough(number)?);
        loop {
            let middle = 0.5 * (before + after);
            if middle <= before || middle >= after {
                return Ok(after);
            }
            let slips = deterministic_slips(&machines, &self.settings(middle)).swap_remove(0)?;
            if slips.cycles >= number as u64 { after = middle } else { before = middle }
        }
    }

    fn path(&self) -> Result<Value> {
        let settings = self.settings(self.duration);
        let (seconds, found) = self.timed(|| {
            (0..self.paths)
                .map(|index| {
                    let path = self.process.path(self.seed, index as u64);
                    Ok(Trajectory::simulate(&self.oscillator, path, &settings)?)
                })
                .collect::<Result<Vec<Trajectory>>>()
        })?;
        let mut answer = json!({ "seconds": seconds, "cycles": found.iter().map(|t| t.slips.cycles).sum::<u64>() });
        if !self.knots.is_empty() {
            answer["step"] = json!(self.process.step());
            answer["cycles_by_path"] = json!(found.iter().map(|t| t.slips.cycles).collect::<Vec<u64>>());
            answer["ends"] = json!(found.iter().map(|t| ends(&t.events)).collect::<Vec<_>>());
            self.write_knots()?;
        }
        Ok(answer)
    }

    /// Writes the grid values that a mass passes if it never moves backwards, and a few more.
    fn write_knots(&self) -> Result<()> {
        let farthest = self.oscillator.belt_velocity() * self.duration + 2.0 * self.oscillator.static_friction();
        let count = (farthest / self.process.step()) as usize + 2;
        let mut bytes = Vec::with_capacity(8 * count * self.paths);
        for index in 0..self.paths {
            let mut path = self.process.path(self.seed, index as u64);
            for _ in 0..count {
                bytes.extend(path.next_value().to_le_bytes());
            }
        }
        Ok(std::fs::write(&self.knots, bytes)?)
    }

    fn ensemble(&self) -> Result<Value> {
        let settings = EnsembleSettings::new(self.paths, self.duration, self.seed);
        let (seconds, found) =
            self.timed(|| Ok(Ensemble::simulate(&self.oscillator, &self.process, &settings, &Silent)?))?;
        Ok(json!({ "seconds": seconds, "cycles": found.cycles.mean * self.paths as f64, "se": found.cycles.se }))
    }

    fn sweep(&self) -> Result<Value> {
        let fraction = |i: usize| i as f64 / (self.dampings - 1).max(1) as f64;
        let dampings: Vec<f64> = (0..self.dampings).map(|i| 0.14 + 0.16 * fraction(i)).collect();
        let settings = EnsembleSettings::new(self.paths, self.duration, self.seed);
        let (seconds, found) =
            self.timed(|| Ok(damping_sweep(&self.oscillator, &dampings, &self.process, &settings, &Silent)?))?;
        let means: Vec<f64> = found.ensembles.iter().map(|ensemble| ensemble.cycles.mean).collect();
        let half = found.crossings(&self.oscillator, &self.process, &[0.5], &settings, &Silent)?.swap_remove(0);
        Ok(json!({
            "seconds": seconds, "dampings": dampings, "mean_cycles": means,
            "half": half.damping_ratio, "half_interval": half.damping_ratio_interval,
        }))
    }
}

/// Returns the times at which the mass sticks again.
fn ends(events: &[Event]) -> Vec<f64> {
    events.iter().filter(|event| event.kind == EventKind::Restick).map(|event| event.tau).collect()
}

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let case = words.next().ok_or("usage: time_vibration CASE key=value …")?;
    let mut words = Words::parse(words)?;
    let damping = words.or("damping", 0.17)?;
    let (friction, decay, velocity) =
        (words.or("friction", 0.1)?, words.or("decay", 4.2)?, words.or("velocity", 0.003)?);
    let model = ProcessModel::new("beta:2.1,5".parse()?, words.or("std", 0.001)?, words.or("length", 0.01)?);
    let job = Job {
        damping,
        oscillator: Oscillator::with_stribeck(friction, decay, damping, velocity)?,
        process: FrictionProcess::new(model)?,
        cycles: words.or("cycles", 1000)?,
        machines: words.or("machines", 256)?,
        paths: words.or("paths", 400)?,
        dampings: words.or("dampings", 12)?,
        duration: words.or("duration", 637.2)?,
        seed: words.or("seed", 1)?,
        knots: words.or("knots", String::new())?,
        repeats: words.or("repeats", 5)?,
        warm_up: words.or("warm_up", 1)?,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(words.or("threads", 1)?).build()?;
    words.finish()?;
    let answer = pool.install(|| match case.as_str() {
        "cycle" => job.cycle(),
        "lockstep" => job.lockstep(),
        "path" => job.path(),
        "ensemble" => job.ensemble(),
        "sweep" => job.sweep(),
        _ => Err(format!("{case} is not a case").into()),
    })?;
    println!("{answer}");
    Ok(())
}

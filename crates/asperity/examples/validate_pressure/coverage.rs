//! How often 95 % intervals hold the truth, on small patches that are solved by the hundred thousand.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use asperity::contact::{Boundary, Control, HalfSpace};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::pressure::{Estimate, Method, PressureError, Problem, Study};
use asperity::surface::KarhunenLoeve;

use crate::Result;

/// Points along either side.
const POINTS: usize = 16;
/// Contact solutions of the truth, of which 256 cells each are pooled.
const TRUTH: usize = 60_000;
/// What is told of each estimate: P(contact), mean, quantiles of 10, 50 and 90 %, the simultaneous band.
const TOLD: usize = 6;
const QUANTILES: [f64; 3] = [0.1, 0.5, 0.9];

/// A small patch.
struct World {
    name: &'static str,
    plane_m: f64,
    hardness_pa: Option<f64>,
    fine_solves: usize,
}

const WORLDS: [World; 2] = [
    World { name: "elastic", plane_m: -0.6, hardness_pa: None, fine_solves: 200 },
    World { name: "capped", plane_m: -2.0, hardness_pa: Some(12.0), fine_solves: 300 },
];

/// Of one method over the replicates.
#[derive(Debug, Clone, Default)]
struct Count {
    estimates: u32,
    /// Intervals there were, and those that held the truth.
    told: [u32; TOLD],
    held: [u32; TOLD],
    /// Sums of errors of P(contact) and mean, of their squares, and of the widths of the intervals.
    errors: [f64; 2],
    squares: [f64; 2],
    widths: [f64; 2],
    z: [f64; 8],
    alt: [u32; 4],
    altw: f64,
}

impl Count {
    fn add(&mut self, found: &Estimate, truth: &Estimate) {
        self.estimates += 1;
        let mut tell = |place: usize, held: Option<bool>| {
            self.told[place] += u32::from(held.is_some());
            self.held[place] += u32::from(held == Some(true));
        };
        let probability = found.contact_probability_interval;
        tell(0, probability.map(|interval| interval.contains(truth.contact_probability)));
        let mean = found.mean_interval_pa();
        tell(1, mean.map(|mean| mean.contains(truth.mean_pa)));
        for (place, probability) in QUANTILES.into_iter().enumerate() {
            let wanted = truth.law.quantile(probability);
            tell(2 + place, found.quantile_interval_pa(probability).map(|interval| interval.contains(wanted)));
        }
        let band = found.band.as_ref();
        if let Some(band) = band {
            for (k, p) in [0.1, 0.5, 0.9].into_iter().enumerate() {
                let q = truth.law.quantile(p);
                let z = (found.law.cdf(q) - band.bias_at(q) - truth.law.cdf(q)) / band.standard_error_at(q);
                if z.is_finite() {
                    self.z[2 * k] += z;
                    self.z[2 * k + 1] += z * z;
                }
            }
            let (b, s) = (found.contact_probability_bias.unwrap_or(0.0), found.contact_probability_se);
            let e = (found.contact_probability - truth.contact_probability).abs();
            let half = (b * b + (1.96 * s).powi(2)).sqrt();
            self.alt[0] += u32::from(e <= half);
            self.altw += half;
            let (b, s) = (found.mean_bias_pa.unwrap_or(0.0), found.mean_se_pa);
            let e = (found.mean_pa - truth.mean_pa).abs();
            self.alt[1] += u32::from(e <= (b * b + (1.96 * s).powi(2)).sqrt());
            self.alt[2] += u32::from((found.mean_pa - b - truth.mean_pa).abs() <= band.pointwise_factor * s);
        }
        tell(
            5,
            band.map(|band| {
                band.values.iter().enumerate().all(|(i, value)| {
                    let ([low, high], cdf) = (band.simultaneous(i), truth.law.cdf(*value));
                    low <= cdf && cdf <= high
                })
            }),
        );
        let errors = [found.contact_probability - truth.contact_probability, found.mean_pa - truth.mean_pa];
        let widths = [probability.map_or(f64::NAN, |p| p.high - p.low), mean.map_or(f64::NAN, |mean| mean.high - mean.low)];
        for k in 0..2 {
            self.errors[k] += errors[k];
            self.squares[k] += errors[k].powi(2);
            self.widths[k] += widths[k];
        }
    }

    fn merge(&mut self, other: &Self) {
        self.estimates += other.estimates;
        for k in 0..8 { self.z[k] += other.z[k]; }
        for k in 0..4 { self.alt[k] += other.alt[k]; }
        self.altw += other.altw;
        for k in 0..TOLD {
            self.told[k] += other.told[k];
            self.held[k] += other.held[k];
        }
        for k in 0..2 {
            self.errors[k] += other.errors[k];
            self.squares[k] += other.squares[k];
            self.widths[k] += other.widths[k];
        }
    }

    fn row(&self, name: &str) {
        let share = |k: usize| match self.told[k] {
            0 => "–".to_owned(),
            told => format!("{:.1}", 100.0 * f64::from(self.held[k]) / f64::from(told)),
        };
        let n = f64::from(self.estimates.max(1));
        let errors = |k: usize| {
            format!("{:+.4} | {:.4} | {:.4}", self.errors[k] / n, (self.squares[k] / n).sqrt(), 0.5 * self.widths[k] / n)
        };
        let shares: Vec<String> = (0..TOLD).map(share).collect();
        eprintln!("{name}: z {:?} root-sum-square: {:?} width {:.4}", (0..3).map(|k| format!("{:.2} {:.2}", self.z[2*k]/n, (self.z[2*k+1]/n).sqrt())).collect::<Vec<_>>(), self.alt.map(|a| f64::from(a)/n), self.altw / n);
        println!("| {name} | {} | {} | {} |", shares.join(" | "), errors(0), errors(1));
    }
}

pub(crate) fn print(replicates: u64) -> Result<()> {
    for world in &WORLDS {
        let grid = Grid::covering(POINTS, POINTS, 1.0, 1.0)?;
        let covariance =
            Covariance::isotropic(CorrelationModel::SquaredExponential, 1.0, 0.15 * std::f64::consts::SQRT_2)?;
        let surface = KarhunenLoeve::periodic_without_constant(&covariance, grid, 8)?.rescaled();
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: std::f64::consts::FRAC_1_PI };
        let half_space = HalfSpace::new(grid, 1.0, boundary)?;
        let control = Control::Plane { height_m: world.plane_m };
        let problem = Problem::new(&surface, &half_space, control, world.hardness_pa)?;
        let start = Instant::now();
        let sizes = Study { fine_solves: 20, reference_samples: TRUTH, ..Study::new(1) };
        let truth = sizes.run(&problem, &Silent)?.reference.estimate;
        eprintln!("{}: truth in {:.0} s", world.name, start.elapsed().as_secs_f64());
        let atom = world.hardness_pa.map_or(0.0, |h| 1.0 - truth.law.cdf(h * (1.0 - 1e-6)));
        println!(
            "\n## World {}: P(contact) {:.4}, at the hardness {:.4}, mean {:.4} Pa, std {:.4} Pa, quantiles {:?}, {} fine\n",
            world.name,
            truth.contact_probability,
            atom,
            truth.mean_pa,
            truth.law.std(),
            QUANTILES.map(|p| truth.law.quantile(p)),
            world.fine_solves
        );
        let counts = Mutex::new(vec![Count::default(); Method::ALL.len()]);
        let next = AtomicU64::new(0);
        let failed: Mutex<Option<PressureError>> = Mutex::new(None);
        std::thread::scope(|scope| -> Result<()> {
            for _ in 0..2 {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
                let (counts, next, failed, problem, truth) = (&counts, &next, &failed, &problem, &truth);
                scope.spawn(move || {
                    let mut own = vec![Count::default(); Method::ALL.len()];
                    loop {
                        let seed = next.fetch_add(1, Ordering::Relaxed);
                        if seed >= replicates {
                            break;
                        }
                        if seed % 100 == 0 {
                            eprintln!("{}: {seed} of {replicates}, {:.0} s", world.name, start.elapsed().as_secs_f64());
                        }
                        let study = Study {
                            fine_solves: world.fine_solves,
                            reference_samples: 2,
                            variables: 3,
                            degree: 2,
                            surrogate_samples: 2000,
                            ..Study::new(seed)
                        };
                        match pool.install(|| study.run(problem, &Silent)) {
                            Ok(results) => {
                                for (count, method) in own.iter_mut().zip(Method::ALL) {
                                    if let Some((found, _)) = results.estimate(method) {
                                        count.add(found, truth);
                                    }
                                }
                            }
                            Err(error) => *failed.lock().unwrap() = Some(error),
                        }
                    }
                    let mut counts = counts.lock().unwrap();
                    counts.iter_mut().zip(&own).for_each(|(all, own)| all.merge(own));
                });
            }
            Ok(())
        })?;
        if let Some(error) = failed.into_inner().unwrap() {
            return Err(error.into());
        }
        println!("| method | P(contact) | mean | 10 % | 50 % | 90 % | band | bias P | rms P | half width P | bias mean | rms mean | half width mean |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
        for (count, method) in counts.into_inner().unwrap().iter().zip(Method::ALL) {
            count.row(&format!("{} ({})", method.name(), count.estimates));
        }
    }
    Ok(())
}

//! Two coupled modes of a mass on a belt.

mod answer;

use std::path::Path;

use asperity::friction::process::{FrictionProcess, Steady};
use asperity::study::{Table, implausible_damping, implausible_friction};
use asperity::vibration::VibrationError;
use asperity::vibration::mode_coupling::{
    Contact, Damping, EigenvalueScan, Ensemble, EnsembleSettings, GrowthRates, GrowthSettings, Mode, Model, Parameters,
    Point, Regime, Trajectory, TrajectorySettings, eigenvalue_scan, growth_rates, limit_cycle, modes,
};
use clap::Args;
use clap::builder::ArgPredicate;

use super::folder::Folder;
use super::random::{Fluctuation, Paths};
use super::{Friction, refused};
use crate::args::{self, Refusal};
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::resources::require_memory;

/// Points of a drawn cycle.
const CYCLE_POINTS: usize = 1200;
/// Memory for the modes at one friction coefficient, and in the answer.
const POINT_BYTES: f64 = 512.0;
/// How far the scan reaches beyond the largest coefficient that matters, unless told.
const BEYOND: f64 = 1.25;
/// Least share of valid realisations.
const LEAST_VALID: f64 = 0.95;
/// Share of the cycle's amplitude that counts as a vibration, unless told.
const THRESHOLD: f64 = 0.5;

/// Tells where two modes that friction couples lose their stability, and what the vibration is then; with the flags of a
/// fluctuation, how surely it comes.
///
/// Two inclined springs hold a mass, a third presses it on the belt (Hoffmann, Fischer, Allgaier & Gaul 2002). Forces are in
/// units of the static normal force, stiffnesses in mω₀². Left out, springs make the modes meet at μ = 0.75.
#[derive(Debug, Args)]
#[command(mut_arg("correlation_length", |length| length.required(false).requires("friction_std")))]
#[command(mut_arg("marginal", |law| law.required(false).requires("friction_std")))]
pub(crate) struct ModeCoupling {
    #[command(flatten)]
    friction: Friction,
    /// Dimensionless belt velocity V.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    belt_velocity: f64,
    /// Largest friction coefficient of the eigenvalues; a quarter beyond those that matter when left out.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    friction_to: Option<f64>,
    /// Number of friction coefficients.
    #[arg(long, value_name = "N", default_value = "401", value_parser = args::count, allow_hyphen_values = true)]
    points: usize,
    #[command(flatten)]
    folder: Folder,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    springs: Springs,
    #[command(flatten)]
    noise: Option<Noise>,
    #[command(flatten)]
    fluctuation: Option<Fluctuation>,
}

/// Springs and dampers.
#[derive(Debug, Args)]
#[command(next_help_heading = "Springs and dampers")]
struct Springs {
    /// Directions of the inclined springs in degrees, from the belt's velocity towards the belt; 150,30 when left out.
    #[arg(long, value_name = "A,B", value_parser = two, allow_hyphen_values = true)]
    angles: Option<[f64; 2]>,
    /// Their stiffnesses.
    #[arg(long, value_name = "K1,K2", value_parser = two, allow_hyphen_values = true)]
    springs: Option<[f64; 2]>,
    /// Stiffness of the contact spring.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    contact_stiffness: Option<f64>,
    /// Damping ratios of the modes without friction, the slow one first. Without any flag of damping there is none.
    #[arg(long, value_name = "Z1,Z2", value_parser = two, allow_hyphen_values = true, group = "damping")]
    modal_damping: Option<[f64; 2]>,
    /// Damping a + b·(stiffness).
    #[arg(long, value_name = "A,B", value_parser = two, allow_hyphen_values = true, group = "damping")]
    proportional_damping: Option<[f64; 2]>,
    /// Dampers along the belt and across it.
    #[arg(long, value_name = "X,Y", value_parser = two, allow_hyphen_values = true, group = "damping")]
    dampers: Option<[f64; 2]>,
}

/// A fluctuation of friction, and how many paths are followed under it.
#[derive(Debug, Args)]
#[command(next_help_heading = "Fluctuation of friction")]
struct Noise {
    /// Standard deviation of the friction coefficient.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, required = false,
          requires_ifs = [(ArgPredicate::IsPresent, "correlation_length"), (ArgPredicate::IsPresent, "marginal"),
                          (ArgPredicate::IsPresent, "trajectories"), (ArgPredicate::IsPresent, "duration"),
                          (ArgPredicate::IsPresent, "seed")])]
    friction_std: f64,
    /// Number of paths.
    #[arg(long, value_name = "N", value_parser = args::count, allow_hyphen_values = true, required = false,
          requires = "friction_std")]
    trajectories: usize,
    /// Time τ of each.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, required = false,
          requires = "friction_std")]
    duration: f64,
    /// Time τ before growth is measured.
    #[arg(long, value_name = "X", default_value = "60", value_parser = args::non_negative, allow_hyphen_values = true,
          requires = "friction_std")]
    settling: f64,
    /// Amplitude |x − x_s| about steady sliding that is a vibration; half the cycle's when left out.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, requires = "friction_std")]
    threshold: Option<f64>,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true, required = false,
          requires = "friction_std")]
    seed: u64,
}

fn two(text: &str) -> Result<[f64; 2], Refusal> {
    let wanted = || format!("found `{text}`, wanted two numbers, such as 0.01,0.02");
    let (first, second) = text.split_once(',').ok_or_else(wanted)?;
    Ok([args::number(first.trim()).map_err(|_| wanted())?, args::number(second.trim()).map_err(|_| wanted())?])
}

impl Springs {
    fn parameters(&self, friction: &Friction, belt_velocity: f64) -> Result<Parameters, Failure> {
        let usual = Parameters::default();
        let damping = match (self.modal_damping, self.proportional_damping, self.dampers) {
            (Some(ratios), _, _) => Damping::Modal { ratios },
            (_, Some([mass, stiffness]), _) => Damping::Proportional { mass, stiffness },
            (_, _, Some([tangential, normal])) => Damping::Axes { tangential, normal },
            (None, None, None) => usual.damping,
        };
        Ok(Parameters {
            angles_deg: self.angles.unwrap_or(usual.angles_deg),
            springs: self.springs.unwrap_or(usual.springs),
            contact_stiffness: self.contact_stiffness.unwrap_or(usual.contact_stiffness),
            damping,
            static_friction: friction.static_friction,
            law: friction.law()?,
            belt_velocity,
        })
    }
}

/// All that is found.
struct Found {
    model: Model,
    scan: EigenvalueScan,
    regime: Regime,
    growth: Option<GrowthRates>,
    ensemble: Option<(f64, Ensemble)>,
}

impl ModeCoupling {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let parameters = self.springs.parameters(&self.friction, self.belt_velocity)?;
        let ratios = if let Damping::Modal { ratios } = parameters.damping { ratios } else { [0.0; 2] };
        let model = Model::new(parameters).map_err(Failure::usage)?;
        let doubts =
            ratios.map(implausible_damping).into_iter().chain([implausible_friction(self.friction.static_friction)]);
        doubts.flatten().for_each(|doubt| monitor.warn(&doubt));
        let inputs: Vec<&Path> = self.friction.inputs();
        let wanted = self.folder.wanted(&inputs)?;
        require_memory(POINT_BYTES * self.points as f64, "the scan of the modes")?;
        let scan = self.scan(&model).map_err(|e| refused(&e))?;
        let told = answer::of_modes(&model, &scan);
        let regime = monitor
            .at_once(|| limit_cycle(&model, None))?
            .or_else(|e| Err(refused(&e).told(told.clone(), self.json)?))?;
        if model.damping() == [0.0; 3] && modes(&model, model.sliding_friction()).iter().all(|mode| mode.growth == 0.0)
        {
            monitor.warn(
                "nothing is damped and no mode grows: the motion keeps what it starts with and settles nowhere; state \
                 --dampers, --modal-damping or --proportional-damping",
            );
        } else if let Some(note) = answer::note(&regime) {
            monitor.note(note);
        }
        let mut found = Found { model, scan, regime, growth: None, ensemble: None };
        if let (Some(noise), Some(fluctuation)) = (&self.noise, &self.fluctuation) {
            noise.add(fluctuation, &mut found, monitor)?;
        }
        let answer = told.and(answer::of_motion(&found));
        let whole = answer.clone().with("scan", answer::scan(&found.scan));
        if wanted {
            self.folder.write(&inputs, &whole, tables(&found).map_err(|e| refused(&e))?, monitor)?;
        }
        if self.json { whole.print(true) } else { answer.print(false) }
    }

    fn scan(&self, model: &Model) -> Result<EigenvalueScan, VibrationError> {
        if let Some(most) = self.friction_to {
            return eigenvalue_scan(model, most, self.points);
        }
        let own = model.sliding_friction();
        let most = BEYOND * model.coalescence().map_or(own, |met| met.max(own));
        let scan = eigenvalue_scan(model, most, self.points)?;
        // Much damping moves the loss of stability far.
        match scan.critical {
            Some(critical) if critical.friction > most => {
                eigenvalue_scan(model, BEYOND * critical.friction, self.points)
            }
            _ => Ok(scan),
        }
    }
}

impl Noise {
    fn add(&self, fluctuation: &Fluctuation, found: &mut Found, monitor: &Terminal) -> Result<(), Failure> {
        let process = FrictionProcess::new(fluctuation.model(self.friction_std, 1.0)).map_err(Failure::usage)?;
        let (trajectories, duration, seed) = (self.trajectories, self.duration, self.seed);
        let model = &found.model;
        let threshold = match (self.threshold, found.regime.cycle()) {
            (Some(threshold), _) => threshold,
            (None, Some(cycle)) => 0.5 * THRESHOLD * (cycle.tangential[1] - cycle.tangential[0]),
            (None, None) => {
                return Err(Failure::usage("there is no cycle to take the amplitude from: state --threshold"));
            }
        };
        let settling = self.settling;
        let belt_velocity = model.belt_velocity();
        Paths { belt_velocity, duration: settling + 2.0 * duration, count: trajectories }.announce(&process, monitor);
        let settings = GrowthSettings { trajectories, duration, settling, seed, least_valid_share: LEAST_VALID };
        let growth =
            growth_rates(model, model.sliding_friction(), &process, &settings, monitor).map_err(|e| refused(&e))?;
        let least_valid_share = LEAST_VALID;
        let settings = EnsembleSettings { trajectories, duration, threshold, seed, start: None, least_valid_share };
        let ensemble = Ensemble::simulate(model, &process, &settings, monitor).map_err(|e| refused(&e))?;
        if let Some(first) = ensemble.failures.first() {
            let failed = ensemble.failures.len();
            monitor.warn(&format!("{failed} of {trajectories} paths are left out; the first: {}", first.reason));
        }
        found.growth = Some(growth);
        found.ensemble = Some((threshold, ensemble));
        Ok(())
    }
}

/// The modes over friction, and the cycle.
fn tables(found: &Found) -> Result<Vec<(&'static str, Table)>, VibrationError> {
    let scan = &found.scan;
    let of = |value: &dyn Fn(&[Mode; 2]) -> f64| scan.modes.iter().map(value).collect::<Vec<f64>>();
    let mut tables = vec![(
        "modes_over_friction",
        Table::new([
            ("friction", scan.friction.clone()),
            ("growth_1", of(&|modes| modes[0].growth)),
            ("frequency_1", of(&|modes| modes[0].frequency)),
            ("growth_2", of(&|modes| modes[1].growth)),
            ("frequency_2", of(&|modes| modes[1].frequency)),
        ]),
    )];
    if let Some(cycle) = found.regime.cycle() {
        let settings = TrajectorySettings { duration: cycle.period, start: Some(cycle.start) };
        let points = Trajectory::portrait(&found.model, Steady, &settings, 0.0, CYCLE_POINTS)?;
        tables.push(("mode_cycle", portrait(&points)));
    }
    Ok(tables)
}

fn portrait(points: &[Point]) -> Table {
    let column = |of: fn(&Point) -> f64| points.iter().map(of).collect::<Vec<f64>>();
    Table::new([
        ("tau", column(|p| p.tau)),
        ("tangential", column(|p| p.state.tangential)),
        ("tangential_velocity", column(|p| p.state.tangential_velocity)),
        ("normal", column(|p| p.state.normal)),
        ("normal_velocity", column(|p| p.state.normal_velocity)),
        (
            "contact",
            column(|p| match p.contact {
                Contact::Stick => 0.0,
                Contact::Slip => 1.0,
                Contact::OverSlip => 2.0,
                Contact::Flight => 3.0,
            }),
        ),
    ])
}

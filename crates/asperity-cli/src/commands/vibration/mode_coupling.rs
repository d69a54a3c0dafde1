//! Two coupled modes of a mass on a belt.

mod answer;

use std::path::Path;

use asperity::friction::process::{FrictionProcess, Steady};
use asperity::stats::VALID_FRACTION;
use asperity::study::result::CoupledPortrait;
use asperity::study::{Table, implausible_damping, implausible_friction, modes_table};
use asperity::vibration::VibrationError;
use asperity::vibration::mode_coupling::{
    Contact, CoupledEnsemble, CoupledEnsembleSettings, CoupledParameters, CoupledRegime, CoupledTrajectory,
    CoupledTrajectorySettings, Damping, EigenvalueScan, GrowthRates, GrowthSettings, Model, Point, SCAN_POINTS,
    eigenvalue_scan, growth_rates, limit_cycle, modes, scan_end,
};
use asperity_report::{CoupledModes, VibrationFigures};
use clap::Args;
use clap::builder::ArgPredicate;

use super::folder::Folder;
use super::machine::Belt;
use super::random::{Fluctuation, note_time};
use super::velocity_law::Friction;
use crate::args::{self, Refusal};
use crate::failure::Failure;
use crate::monitor::Terminal;
use crate::output::Answer;
use crate::resources::require_memory;

/// Points of a drawn cycle.
const CYCLE_POINTS: usize = 1200;
/// Memory for the modes at one friction coefficient, including the answer, in bytes.
const POINT_BYTES: f64 = 512.0;
/// Default amplitude that counts as a vibration, relative to the cycle's amplitude.
const THRESHOLD: f64 = 0.5;

/// Finds where two modes coupled by friction lose their stability, and the vibration that follows; with a fluctuation
/// of friction, its probability.
///
/// Two inclined springs hold a mass, a third presses it on the belt (Hoffmann, Fischer, Allgaier & Gaul 2002). Forces
/// are in units of the static normal force, stiffnesses in mω₀². With the default springs the modes meet at μ = 0.75.
#[derive(Debug, Args)]
#[command(mut_arg("correlation_length", |length| length.required(false).requires("friction_std")))]
#[command(mut_arg("marginal", |law| law.required(false).requires("friction_std")))]
pub(crate) struct ModeCoupling {
    #[command(flatten)]
    friction: Friction,
    #[command(flatten)]
    belt: Belt,
    /// Largest friction coefficient of the eigenvalues. When left out, 1.25 times the largest coefficient of interest.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    friction_to: Option<f64>,
    /// Number of friction coefficients.
    #[arg(long, value_name = "N", default_value_t = SCAN_POINTS, value_parser = args::count, allow_hyphen_values = true)]
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

/// Springs and dampers of the model.
#[derive(Debug, Args)]
#[command(next_help_heading = "Springs and dampers")]
struct Springs {
    /// Directions of the inclined springs in degrees, from the belt's velocity towards the belt; 150,30 when left out.
    #[arg(long, value_name = "A,B", value_parser = number_pair, allow_hyphen_values = true)]
    angles: Option<[f64; 2]>,
    /// Stiffnesses of the inclined springs.
    #[arg(long, value_name = "K1,K2", value_parser = number_pair, allow_hyphen_values = true)]
    springs: Option<[f64; 2]>,
    /// Stiffness of the contact spring.
    #[arg(long, value_name = "X", value_parser = args::of_input("vibration.contact_spring"), allow_hyphen_values = true)]
    contact_stiffness: Option<f64>,
    /// Damping ratios of the modes without friction, the slow mode first. Without any damping flag there is no damping.
    #[arg(long, value_name = "Z1,Z2", value_parser = number_pair, allow_hyphen_values = true, group = "damping")]
    modal_damping: Option<[f64; 2]>,
    /// Coefficients A,B of damping proportional to stiffness, A + B·(stiffness).
    #[arg(long, value_name = "A,B", value_parser = number_pair, allow_hyphen_values = true, group = "damping")]
    proportional_damping: Option<[f64; 2]>,
    /// Dampers along the belt and across it.
    #[arg(long, value_name = "X,Y", value_parser = number_pair, allow_hyphen_values = true, group = "damping")]
    dampers: Option<[f64; 2]>,
}

/// Fluctuation of friction, and the number of trajectories.
#[derive(Debug, Args)]
#[command(next_help_heading = "Fluctuation of friction")]
struct Noise {
    /// Standard deviation of the friction coefficient.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, required = false,
          requires_ifs = [(ArgPredicate::IsPresent, "correlation_length"), (ArgPredicate::IsPresent, "marginal"),
                          (ArgPredicate::IsPresent, "trajectories"), (ArgPredicate::IsPresent, "duration"),
                          (ArgPredicate::IsPresent, "seed")])]
    friction_std: f64,
    /// Number of trajectories.
    #[arg(long, value_name = "N", value_parser = args::count, allow_hyphen_values = true, required = false,
          requires = "friction_std")]
    trajectories: usize,
    /// Duration τ of each trajectory.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, required = false,
          requires = "friction_std")]
    duration: f64,
    /// Time τ before the growth is measured.
    #[arg(long, value_name = "X", default_value = "60", value_parser = args::non_negative, allow_hyphen_values = true,
          requires = "friction_std")]
    settling: f64,
    /// Amplitude |x − x_s| about steady sliding that counts as a vibration; half the cycle's amplitude when left out.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, requires = "friction_std")]
    threshold: Option<f64>,
    /// Seed of every random draw.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true, required = false,
          requires = "friction_std")]
    seed: u64,
}

fn number_pair(text: &str) -> Result<[f64; 2], Refusal> {
    let message = || format!("found `{text}`, expected two numbers, such as 0.01,0.02");
    let (first, second) = text.split_once(',').ok_or_else(message)?;
    Ok([args::number(first.trim()).map_err(|_| message())?, args::number(second.trim()).map_err(|_| message())?])
}

impl Springs {
    fn parameters(&self, friction: &Friction, belt_velocity: f64) -> Result<CoupledParameters, Failure> {
        let usual = CoupledParameters::default();
        let damping = match (self.modal_damping, self.proportional_damping, self.dampers) {
            (Some(ratios), _, _) => Damping::Modal { ratios },
            (_, Some([mass, stiffness]), _) => Damping::Proportional { mass, stiffness },
            (_, _, Some([tangential, normal])) => Damping::Axes { tangential, normal },
            (None, None, None) => usual.damping,
        };
        Ok(CoupledParameters {
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

impl ModeCoupling {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let parameters = self.springs.parameters(&self.friction, self.belt.belt_velocity)?;
        let ratios = if let Damping::Modal { ratios } = parameters.damping { ratios } else { [0.0; 2] };
        let model = Model::new(parameters).map_err(Failure::usage)?;
        let warnings =
            ratios.map(implausible_damping).into_iter().chain([implausible_friction(self.friction.static_friction)]);
        warnings.flatten().for_each(|warning| monitor.warn(&warning));
        let inputs: Vec<&Path> = self.friction.inputs();
        let has_folder = self.folder.is_requested(&inputs)?;
        require_memory(POINT_BYTES * self.points as f64, "the scan of the modes")?;
        let scan = self.scan(&model)?;
        let modes_answer = answer::modes_answer(&model, &scan);
        let regime = monitor
            .killable(|| limit_cycle(&model, None))?
            .or_else(|e| Err(Failure::from(e).print(modes_answer.clone(), self.json)?))?;
        if model.damping() == [0.0; 3] && modes(&model, model.sliding_friction()).iter().all(|mode| mode.growth == 0.0)
        {
            monitor.warn(
                "there is no damping and no mode grows, so the motion never settles; give \
                 --dampers, --modal-damping or --proportional-damping",
            );
        } else if let Some(note) = answer::note(&regime) {
            monitor.note(note);
        }
        let mut answer = modes_answer.and(answer::motion_answer(&regime));
        let mut mean_growth = None;
        if let (Some(noise), Some(fluctuation)) = (&self.noise, &self.fluctuation) {
            let (growth, fluctuating) = noise.answer(fluctuation, &model, &regime, monitor)?;
            mean_growth = Some(growth.mean);
            answer = answer.and(fluctuating);
        }
        let whole = answer.clone().with("scan", answer::scan(&scan));
        if has_folder {
            let figures = VibrationFigures::ModeCoupling(CoupledModes {
                coalescence: scan.coalescence,
                critical_friction: scan.critical.map(|critical| critical.friction),
                friction: model.sliding_friction(),
                belt_velocity: Some(model.belt_velocity()),
                mean_growth,
            });
            self.folder.write("mode-coupling", &figures, &inputs, &whole, tables(&model, &scan, &regime)?, monitor)?;
        }
        if self.json { whole.print(true) } else { answer.print(false) }
    }

    fn scan(&self, model: &Model) -> Result<EigenvalueScan, VibrationError> {
        if let Some(most) = self.friction_to {
            return eigenvalue_scan(model, most, self.points);
        }
        let most = scan_end(model, model.coalescence());
        let scan = eigenvalue_scan(model, most, self.points)?;
        // Strong damping moves the loss of stability to large coefficients.
        match scan.critical {
            Some(critical) if critical.friction > most => {
                eigenvalue_scan(model, scan_end(model, Some(critical.friction)), self.points)
            }
            _ => Ok(scan),
        }
    }
}

impl Noise {
    /// Simulates the motion with a fluctuation of friction. Returns its growth, and the answer on growth and vibration.
    fn answer(
        &self,
        fluctuation: &Fluctuation,
        model: &Model,
        regime: &CoupledRegime,
        monitor: &Terminal,
    ) -> Result<(GrowthRates, Answer), Failure> {
        let process = monitor.killable(|| FrictionProcess::new(fluctuation.model(self.friction_std, 1.0)))?;
        let process = process.map_err(Failure::usage)?;
        let (trajectories, duration, seed) = (self.trajectories, self.duration, self.seed);
        let threshold = match (self.threshold, regime.cycle()) {
            (Some(threshold), _) => threshold,
            (None, Some(cycle)) => 0.5 * THRESHOLD * (cycle.tangential[1] - cycle.tangential[0]),
            (None, None) => {
                return Err(Failure::usage("there is no cycle to derive the amplitude from; give --threshold"));
            }
        };
        let settling = self.settling;
        note_time(&process, model.belt_velocity() * (settling + 2.0 * duration), trajectories, monitor);
        let least_valid_share = VALID_FRACTION;
        let settings = GrowthSettings { trajectories, duration, settling, seed, least_valid_share };
        let growth = growth_rates(model, model.sliding_friction(), &process, &settings, monitor)?;
        let settings =
            CoupledEnsembleSettings { trajectories, duration, threshold, seed, start: None, least_valid_share };
        let ensemble = CoupledEnsemble::simulate(model, &process, &settings, monitor)?;
        if let Some(first) = ensemble.failures.first() {
            let failed = ensemble.failures.len();
            monitor.warn(&format!("{failed} of {trajectories} trajectories failed, the first: {}", first.reason));
        }
        let answer = answer::fluctuation_answer(&growth, threshold, &ensemble);
        Ok((growth, answer))
    }
}

/// Returns the tables: the modes over friction, and the cycle.
fn tables(
    model: &Model,
    scan: &EigenvalueScan,
    regime: &CoupledRegime,
) -> Result<Vec<(&'static str, Table)>, VibrationError> {
    let mut tables = vec![("modes_over_friction", modes_table(scan))];
    if let Some(cycle) = regime.cycle() {
        let settings = CoupledTrajectorySettings { duration: cycle.period, start: Some(cycle.start) };
        let points = CoupledTrajectory::portrait(model, Steady, &settings, 0.0, CYCLE_POINTS)?;
        tables.push(("mode_cycle", portrait(&points)));
    }
    Ok(tables)
}

fn portrait(points: &[Point]) -> Table {
    let column = |of: fn(&Point) -> f64| points.iter().map(of).collect();
    Table::from(CoupledPortrait {
        tau: column(|p| p.tau),
        tangential: column(|p| p.state.tangential),
        tangential_velocity: column(|p| p.state.tangential_velocity),
        normal: column(|p| p.state.normal),
        normal_velocity: column(|p| p.state.normal_velocity),
        contact: column(|p| match p.contact {
            Contact::Stick => 0.0,
            Contact::Slip => 1.0,
            Contact::OverSlip => 2.0,
            Contact::Flight => 3.0,
        }),
    })
}

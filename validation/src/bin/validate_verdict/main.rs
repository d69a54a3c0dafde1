//! Compares a verdict with machines whose whole chain is solved, and prints the result as Markdown.
//!
//! `cargo run --release -p asperity-validation --bin validate_verdict -- [MACHINES]` prints `docs/validation/verdict.md`; `just validate`
//! writes the file. This program combines the links to the chain of a machine without the verdict's expansion of friction: strips of other
//! random numbers, the friction coefficient, and the limit of damping.
#![expect(clippy::print_stdout, reason = "prints a table")]

use std::sync::Arc;

use asperity::contact::{Boundary, Control, HalfSpace, Solver, contact_modulus_pa};
use asperity::correlation::CorrelationFamily;
use asperity::friction::law::BowdenTabor;
use asperity::friction::replicates::MomentReplicates;
use asperity::friction::strip::StripProblem;
use asperity::friction::window::Window;
use asperity::map::{Grid, HeightMap};
use asperity::monitor::Silent;
use asperity::stats::{Moments, NORMAL_95};
use asperity::study::result::VerdictResult;
use asperity::study::{Stage, Study, VERDICT_SAMPLES};
use asperity::surface::level::Level;
use asperity::surface::model::{CompositeModel, CovarianceRequest, Measurable, SurfaceModel, SurfaceRequest, XiOrder};
use asperity::surface::preparation::Preparation;
use asperity::surface::scanned::ScannedSurface;
use asperity::translation::TranslationKind;
use asperity::vibration::{DampingMargins, Oscillator};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const STUDY: &str = include_str!("study.toml");
/// Seed of the strips, different from the seed of the study.
const SEED: u64 = 77;
/// Points and pitch of a strip. This and the following values are exact in the study.
const GRID: (usize, usize, f64) = (3072, 80, 2e-6);
const WINDOW_M: f64 = 600e-6;
const STRIPS: usize = 8;
const POISSON_RATIO: f64 = 0.25;
const AREA_M2: f64 = 5000e-6;
const MASS_KG: f64 = 15.0;
const FREQUENCY_RAD_PER_S: f64 = 200.0 * std::f64::consts::PI;
const VELOCITY_M_PER_S: f64 = 20e-3;

fn main() -> Result<()> {
    let machines: usize = std::env::args().nth(1).map_or(Ok(500), |word| word.parse())?;
    let folder = tempfile::tempdir()?;
    let bytes = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../studies/brake_disc.x3p"))?;
    std::fs::write(folder.path().join("brake_disc.x3p"), &bytes)?;
    let outcome = Study::parse(STUDY, "study.toml")?.run(folder.path(), Some(Stage::Verdict), &Silent)?;
    let verdict = outcome.results.verdict.ok_or("the study has no verdict")?;
    let samples = &outcome.tables[VERDICT_SAMPLES];
    let column = |name: &str| samples.column(name).ok_or_else(|| format!("no column {name}"));
    let [hardness_pa, strength_pa, modulus_pa] =
        [column("material.hardness")?, column("material.shear_strength")?, column("material.youngs_modulus")?];
    let [damping, force_n, stribeck_s_per_m] =
        [column("vibration.damping_ratio")?, column("vibration.normal_force")?, column("vibration.stribeck")?];
    let [learnt, margin] = [column("friction_coefficient")?, column("damping_margin")?];
    let surface = surface(&bytes)?;
    let mut errors = Vec::with_capacity(machines);
    let (mut solved, mut predicted, mut agree) = (0, 0, 0);
    for index in 0..machines {
        let law = BowdenTabor { shear_strength_pa: strength_pa[index] };
        let friction = friction(&surface, law, modulus_pa[index], hardness_pa[index], force_n[index] / AREA_M2)?;
        errors.push((learnt[index] / friction).ln());
        let velocity_m_per_s = force_n[index] / (MASS_KG * FREQUENCY_RAD_PER_S);
        let (decay, velocity) = (stribeck_s_per_m[index] * velocity_m_per_s, VELOCITY_M_PER_S / velocity_m_per_s);
        let oscillator = Oscillator::with_stribeck(friction, decay, damping[index], velocity)?;
        let vibrates = DampingMargins::new(&oscillator)?.from_stick < 0.0;
        solved += usize::from(vibrates);
        predicted += usize::from(margin[index] < 0.0);
        agree += usize::from(vibrates == (margin[index] < 0.0));
    }
    print(&verdict, &errors, [solved, predicted, agree]);
    Ok(())
}

/// Returns the model of the random surfaces that the study measures on the scan.
fn surface(bytes: &[u8]) -> Result<CompositeModel> {
    let map = HeightMap::try_from(asperity_formats::read_bytes(bytes)?)?;
    let preparation =
        Preparation { level: Level::Plane, outliers: Some(5.0), s_filter_m: None, l_filter_m: None, robust: false };
    let scan = ScannedSurface::new(preparation.apply(map)?)?;
    let request = SurfaceRequest::Translated {
        rms_height_m: Measurable::Measured,
        covariance: CovarianceRequest::Measured,
        families: CorrelationFamily::ALL.to_vec(),
        marginal: Measurable::Measured,
        shortest_wave_m: None,
        translation: TranslationKind::Plain,
        expansion: None,
    };
    Ok(CompositeModel { surface: SurfaceModel::new(request, Some(&scan))?.0, counterface: None })
}

/// Returns the friction coefficient of one machine's contact.
fn friction(
    model: &CompositeModel,
    law: BowdenTabor,
    youngs_modulus_pa: f64,
    hardness_pa: f64,
    pressure_pa: f64,
) -> Result<f64> {
    let (columns, rows, pitch_m) = GRID;
    let grid = Grid::new(columns, rows, pitch_m, pitch_m)?;
    let modulus_pa = contact_modulus_pa(youngs_modulus_pa, POISSON_RATIO);
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus_pa);
    let problem = StripProblem {
        valid_share: 0.95,
        half_space: HalfSpace::new(grid, modulus_pa, Boundary::Periodic { mean_compliance_m_per_pa })?,
        window: Window::rectangle(WINDOW_M, grid.height_m(), grid)?,
        law: Arc::new(law),
        hardness_pa: Some(hardness_pa),
        solver: Solver::default(),
    };
    let generated = model.strip(grid, true, XiOrder::Wavevector)?;
    let strips = problem.strips(generated.surface.as_ref(), STRIPS, SEED);
    let solved = strips.solve(&[Control::MeanPressure { pascal: pressure_pa }], &Silent)?;
    let solved = solved.into_iter().next().ok_or("no level was solved")??;
    Ok(MomentReplicates::from_mean_load(&solved, problem.window.step_m()).all.mean)
}

fn print(verdict: &VerdictResult, errors: &[f64], [solved, predicted, agree]: [usize; 3]) {
    let count = errors.len() as f64;
    let percent = |fraction: f64| format!("{:.2} %", 100.0 * fraction);
    let [low, high] = verdict.probability_interval;
    let probability = solved as f64 / count;
    let standard_error = (probability * (1.0 - probability) / count).sqrt().hypot(0.5 * (high - low) / NORMAL_95);
    let error = Moments::new(errors);
    println!(
        "# The verdict compared with machines whose whole chain is solved\n\n`just validate` writes this page. The study has the scan of the quickstart \
         and six uncertain values (modulus, hardness and shear strength of the pad, damping ratio, load, Stribeck coefficient). The verdict \
         learns friction from a few solved points. Here, {STRIPS} strips of other random numbers are solved for each of the first \
         {count} machines, and their limits of damping are computed from the solved friction.\n\n| | |\n|-|-|\n\
         | probability, verdict | {} [{}, {}] |\n| probability, {count} solved machines | {} |\n\
         | difference over its standard error | {:.2} |\n| the same machines, learnt friction | {} |\n\
         | machines with the same answer | {} |\n| friction, learnt over solved: mean of the logarithm | {} |\n\
         | standard deviation of the logarithm | {} |\n| standard error of the verdict | {} |\n\
         | solved points, and those near the limit | {}, {} |",
        percent(verdict.probability),
        percent(low),
        percent(high),
        percent(probability),
        (probability - verdict.probability) / standard_error,
        percent(predicted as f64 / count),
        percent(agree as f64 / count),
        percent(error.mean),
        percent(error.std),
        verdict.friction.as_ref().map_or_else(String::new, |friction| percent(friction.standard_error)),
        verdict.friction.as_ref().map_or(0, |friction| friction.points),
        verdict.friction.as_ref().map_or(0, |friction| friction.points_near_limit),
    );
}

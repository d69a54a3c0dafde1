//! Friction of surfaces whose parameters are uncertain.

use crate::chaos::{Observed, Propagated, Propagation, Resamples};
use crate::contact::Control;
use crate::friction::FrictionError;
use crate::friction::replicates::{LevelMoments, MomentReplicates};
use crate::monitor::Monitor;
use crate::study::file::FrictionSection;
use crate::study::friction_stage::{Setup, SolvedLevel, no_variance};
use crate::study::level_control::LevelControl;
use crate::study::output::StageOutput;
use crate::study::result::{
    FailedPoint, ParameterIndexResult, Prescribed, UncertainLevel, UncertainParameter, UncertainResponse,
    UncertaintyResult, law_result, pair,
};
use crate::study::surface_stage::SurfaceStage;
use crate::study::uncertain_surface::UncertainSurface;
use crate::study::{StudyError, Table, sentence};

/// Share of the variance that an expansion may leave unexplained, and that may be noise, before a level is warned about.
const UNEXPLAINED_SHARE: f64 = 0.2;
/// Name of the task in progress.
const TASK: &str = "friction uncertainty";

/// Passes on what is done of one part of a task as a part of all.
pub(super) struct PartOf<'a> {
    pub(super) monitor: &'a dyn Monitor,
    /// Name of the task.
    pub(super) task: &'static str,
    pub(super) before: usize,
    pub(super) total: usize,
}

impl Monitor for PartOf<'_> {
    fn progress(&self, _what: &str, done: usize, _total: usize) {
        self.monitor.progress(self.task, self.before + done, self.total);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled()
    }
}

/// What is found at each point and level.
struct Found {
    /// By level, and then by point.
    quotient: Vec<Vec<Option<MomentReplicates>>>,
    at_mean_load: Vec<Vec<Option<MomentReplicates>>>,
    failures: Vec<Vec<FailedPoint>>,
    /// What is to be wary of in the surfaces, one entry for each surface.
    warnings: Vec<String>,
}

/// Solves strips of surfaces with other parameters at the levels of the stage.
pub(super) fn run(
    section: &FrictionSection,
    setup: &Setup,
    surface: &SurfaceStage,
    levels: &[SolvedLevel],
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<(UncertaintyResult, StageOutput)>, StudyError> {
    let Some(stated) = &section.uncertainty else { return Ok(None) };
    let uncertain = UncertainSurface::new(stated, surface)?;
    let realisations = section.uncertainty_realisations();
    let propagation = Propagation::new(uncertain.parameters.clone(), stated.points, seed)?;
    let controls: Vec<LevelControl> = levels.iter().map(|level| level.control).collect();
    let found = solve(&propagation, &uncertain, setup, &controls, (realisations, seed), monitor)?;
    let mut output = StageOutput::default();
    if let Some(first) = found.warnings.first() {
        let (some, all) = (found.warnings.len(), propagation.points());
        output.warnings.push(format!("of {some} of the {all} surfaces of uncertain parameters: {first}"));
    }
    let mut results = Vec::with_capacity(levels.len());
    for (place, control) in controls.iter().enumerate() {
        if monitor.cancelled() {
            return Err(crate::monitor::Cancelled.into());
        }
        let of = |replicates: &[Option<MomentReplicates>]| responses(&propagation, replicates, section.tolerance, seed);
        let (mut quotient, at_mean_load) = (of(&found.quotient[place])?, of(&found.at_mean_load[place])?);
        if let Some(tail) = &levels[place].heavy_tail {
            let reason = Some(format!("F/N has no variance: {}", no_variance(tail)));
            quotient.iter_mut().filter(|response| response.name != "mean" || !tail.has_mean()).for_each(|response| {
                *response = UncertainResponse {
                    name: response.name.clone(),
                    reason: reason.clone(),
                    ..UncertainResponse::default()
                };
            });
        }
        let failures = found.failures[place].clone();
        output.warnings.extend(warnings(*control, &quotient, &failures));
        let prescribed = control.contact(&surface.model.marginal);
        results.push(UncertainLevel {
            control: control.key(),
            percentile: control.percentile(),
            mean_pressure_pa: if let Control::MeanPressure { pascal } = prescribed { Some(pascal) } else { None },
            penetration_m: if let Control::Penetration { metre } = prescribed { Some(metre) } else { None },
            responses: quotient,
            at_mean_load,
            failures,
        });
    }
    output.tables = vec![
        ("friction_uncertainty", moments_table(levels, &results)),
        ("friction_sensitivity", sensitivity_table(levels, &results, &propagation)),
    ];
    output.assumptions.push(words(&propagation, &uncertain, &controls, realisations));
    let parameters = propagation.parameters().iter().map(|parameter| UncertainParameter {
        name: parameter.name().to_owned(),
        mean: parameter.marginal().mean(),
        std: parameter.marginal().std(),
        law: law_result(parameter.marginal()),
    });
    let result = UncertaintyResult {
        points: propagation.points(),
        realisations,
        parameters: parameters.collect(),
        levels: results,
    };
    Ok(Some((result, output)))
}

fn solve(
    propagation: &Propagation,
    uncertain: &UncertainSurface<'_>,
    setup: &Setup,
    levels: &[LevelControl],
    (realisations, seed): (usize, u64),
    monitor: &dyn Monitor,
) -> Result<Found, StudyError> {
    let none = || levels.iter().map(|_| Vec::with_capacity(propagation.points())).collect();
    let failures = vec![Vec::new(); levels.len()];
    let mut found = Found { quotient: none(), at_mean_load: none(), failures, warnings: Vec::new() };
    let each = realisations * levels.len();
    for point in 0..propagation.points() {
        let model = uncertain.at(&propagation.point(point))?;
        let generated = model.comparable_strip(setup.grid, setup.periodic)?;
        found.warnings.extend(generated.warnings.into_iter().next());
        let strips = setup.strips(generated.surface.as_ref(), realisations, seed);
        let controls: Vec<Control> = levels.iter().map(|level| level.contact(&model.marginal)).collect();
        let part = PartOf { monitor, task: TASK, before: point * each, total: propagation.points() * each };
        for (place, level) in strips.solve(&controls, &part)?.into_iter().enumerate() {
            let step_m = setup.window.step_m();
            let level = level.map_err(|error: FrictionError| error.to_string());
            found.quotient[place].push(level.as_ref().ok().map(|level| MomentReplicates::of_quotient(level, step_m)));
            found.at_mean_load[place]
                .push(level.as_ref().ok().map(|level| MomentReplicates::at_mean_load(level, step_m)));
            found.failures[place].extend(level.err().map(|reason| FailedPoint { point, reason }));
        }
    }
    Ok(found)
}

/// Every moment of one level over the parameters. What differs by less than the tolerance of the contacts is equal.
fn responses(
    propagation: &Propagation,
    found: &[Option<MomentReplicates>],
    tolerance: f64,
    seed: u64,
) -> Result<Vec<UncertainResponse>, StudyError> {
    let strips = found.iter().flatten().map(|replicates| replicates.without.len()).max().unwrap_or(0);
    let all = |replicates: &Option<MomentReplicates>| replicates.as_ref().map_or(LevelMoments::NONE, |r| r.all);
    let without = |replicates: &Option<MomentReplicates>, strip: usize| {
        replicates.as_ref().and_then(|r| r.without.get(strip)).copied().unwrap_or(LevelMoments::NONE)
    };
    let friction = found.iter().flatten().map(|replicates| replicates.all.mean.abs()).fold(0.0, f64::max);
    let resolutions = [tolerance * friction, tolerance * friction, tolerance, 0.0];
    LevelMoments::NAMES
        .iter()
        .enumerate()
        .map(|(moment, &name)| {
            let values: Vec<f64> = found.iter().map(|replicates| all(replicates).values()[moment]).collect();
            let without: Vec<Vec<f64>> = (0..strips)
                .map(|strip| found.iter().map(|replicates| without(replicates, strip).values()[moment]).collect())
                .collect();
            let undefined = values.iter().filter(|value| !value.is_finite()).count();
            if undefined == values.len() {
                let reason = Some("it is undefined for every surface".to_owned());
                return Ok(UncertainResponse { name: name.into(), reason, ..UncertainResponse::default() });
            }
            let observed = Observed { values: &values, without: &without, resolution: resolutions[moment] };
            match propagation.respond(&observed, &Resamples::new(seed)) {
                Ok(propagated) => Ok(response(name, propagation, &propagated)),
                Err(error @ crate::chaos::PropagationError::TooFewValid { .. }) => Ok(UncertainResponse {
                    name: name.into(),
                    reason: Some(error.to_string()),
                    ..UncertainResponse::default()
                }),
                Err(error) => Err(error.into()),
            }
        })
        .collect()
}

fn response(name: &'static str, propagation: &Propagation, found: &Propagated) -> UncertainResponse {
    let sobol = found.indices.as_ref().map_or_else(
        |_| Vec::new(),
        |indices| {
            let parameters = propagation.parameters().iter().zip(indices.first_order.iter().zip(&indices.total));
            let index = parameters.map(|(parameter, (first, total))| ParameterIndexResult {
                parameter: parameter.name().to_owned(),
                first: first.value,
                first_interval: pair(first.interval),
                total: total.value,
                total_interval: pair(total.interval),
            });
            index.collect()
        },
    );
    UncertainResponse {
        name: name.into(),
        value: Some(found.mean.value),
        value_interval: Some(pair(found.mean.interval)),
        std: Some(found.std.value),
        std_interval: Some(pair(found.std.interval)),
        interval: Some(pair(found.band())),
        loo_error: Some(found.leave_one_out),
        noise_standard_error: Some(found.noise.standard_error),
        noise_share: Some(found.noise.variance_fraction.min(1.0)),
        sobol,
        reason: found.indices.as_ref().err().map(ToString::to_string),
    }
}

fn warnings(control: LevelControl, responses: &[UncertainResponse], failures: &[FailedPoint]) -> Vec<String> {
    let name = control.name();
    let mut warnings = Vec::new();
    if let Some(first) = failures.first() {
        let surfaces = sentence::count(failures.len(), "surface", "surfaces");
        let reason = &first.reason;
        warnings
            .push(format!("at {name}, {surfaces} of uncertain parameters had no answer; the first because {reason}"));
    }
    let above = |share: fn(&UncertainResponse) -> Option<f64>| -> Vec<String> {
        let of = |r: &UncertainResponse| {
            let share = share(r).filter(|share| *share > UNEXPLAINED_SHARE)?;
            Some(format!("{} {} %", words_of(&r.name), sentence::digits(100.0 * share.min(1.0))))
        };
        responses.iter().filter_map(of).collect()
    };
    let unexplained = above(|r| r.loo_error);
    if !unexplained.is_empty() {
        warnings.push(format!(
            "at {name}, the expansion in the uncertain parameters leaves this share of the variance unexplained: {}; indices \
             are as uncertain",
            unexplained.join(", ")
        ));
    }
    let noise = above(|r| r.noise_share);
    if !noise.is_empty() {
        warnings.push(format!(
            "at {name}, this share of the variance over surfaces is expected of the few strips and not of the parameters: {}; \
             raise realisations in [friction.uncertainty]",
            noise.join(", ")
        ));
    }
    warnings
}

fn words_of(name: &str) -> &str {
    match name {
        "coefficient_of_variation" => "coefficient of variation",
        "correlation_length_m" => "correlation length",
        name => name,
    }
}

fn words(
    propagation: &Propagation,
    uncertain: &UncertainSurface<'_>,
    controls: &[LevelControl],
    realisations: usize,
) -> String {
    let parameters: Vec<String> = propagation
        .parameters()
        .iter()
        .map(|parameter| {
            let (mean, std) = (parameter.marginal().mean(), parameter.marginal().std());
            match parameter.name() {
                "skewness" => format!("skewness {} ± {}", sentence::digits(mean), sentence::digits(std)),
                name => {
                    format!("{} {} ± {}", name.replace('_', " "), sentence::si(mean, "m"), sentence::si(std, "m"))
                }
            }
        })
        .collect();
    let mut held = Vec::new();
    let any = |key: Prescribed| controls.iter().any(|control| control.key() == key);
    if any(Prescribed::Percentile) {
        held.push("a percentile is of each surface's own heights, so that its plane moves with them");
    }
    if any(Prescribed::MeanPressure) {
        held.push("a mean pressure is the same for all surfaces");
    }
    if any(Prescribed::Penetration) {
        held.push("a penetration is the same for all surfaces");
    }
    let law = if uncertain.has_skewness() {
        " Their heights have Johnson's law, whose kurtosis stays as far above the least possible one, 1 + Ssk², as that of the \
         study's law is."
    } else {
        ""
    };
    format!(
        "Parameters of the surface are taken as independent: {} (standard deviations). {} surfaces with {realisations} strips \
         each of the same xi_samples were solved, and the moments of friction expanded in the parameters; {}.{law}",
        parameters.join(", "),
        propagation.points(),
        held.join("; "),
    )
}

/// Column of a number that may be missing.
fn numbers(levels: &[UncertainLevel], value: impl Fn(&UncertainLevel) -> Option<f64>) -> Vec<f64> {
    levels.iter().map(|level| value(level).unwrap_or(f64::NAN)).collect()
}

/// Where each level is on the load curve of the study's own surface.
fn places(solved: &[SolvedLevel]) -> Vec<(String, Vec<f64>)> {
    vec![
        ("percentile".into(), solved.iter().map(|l| l.control.percentile().unwrap_or(f64::NAN)).collect()),
        ("penetration_m".into(), solved.iter().map(|l| l.level.penetration_m).collect()),
        ("mean_pressure_pa".into(), solved.iter().map(|l| l.level.mean_pressure_pa).collect()),
    ]
}

/// Moments of the quotient with their bands over the parameters.
fn moments_table(solved: &[SolvedLevel], levels: &[UncertainLevel]) -> Table {
    let mut columns = places(solved);
    for (place, name) in LevelMoments::NAMES.iter().enumerate() {
        let of = |value: fn(&UncertainResponse) -> Option<f64>| numbers(levels, |level| value(&level.responses[place]));
        columns.push(((*name).into(), of(|r| r.value)));
        columns.push((format!("{name}_std"), of(|r| r.std)));
        columns.push((format!("{name}_low"), of(|r| r.interval.map(|i| i[0]))));
        columns.push((format!("{name}_high"), of(|r| r.interval.map(|i| i[1]))));
        columns.push((format!("{name}_noise_share"), of(|r| r.noise_share)));
    }
    Table::new(columns)
}

/// Sobol' indices of the moments at the mean load.
fn sensitivity_table(solved: &[SolvedLevel], levels: &[UncertainLevel], propagation: &Propagation) -> Table {
    let mut columns = places(solved);
    for (place, name) in LevelMoments::NAMES.iter().enumerate() {
        for (parameter, own) in propagation.parameters().iter().enumerate() {
            let of = |value: fn(&ParameterIndexResult) -> f64| {
                numbers(levels, |level| level.at_mean_load[place].sobol.get(parameter).map(value))
            };
            let own = own.name();
            columns.push((format!("{name}_first_{own}"), of(|index| index.first)));
            columns.push((format!("{name}_total_{own}"), of(|index| index.total)));
            columns.push((format!("{name}_total_{own}_low"), of(|index| index.total_interval[0])));
            columns.push((format!("{name}_total_{own}_high"), of(|index| index.total_interval[1])));
        }
    }
    Table::new(columns)
}

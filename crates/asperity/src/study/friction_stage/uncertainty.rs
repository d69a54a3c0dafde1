//! Friction of surfaces with uncertain parameters: results, tables and words.

use super::entries::prescribed;
use super::uncertain_surface::UncertainSurface;
use super::words::no_variance;
use crate::chaos::{Observed, Propagated, Propagation, Resamples};
use crate::contact::Control;
use crate::friction::replicates::{LevelMoments, MomentReplicates};
use crate::friction::strip::StripProblem;
use crate::friction::uncertain::{PointMoments, UncertainPlan};
use crate::friction::{LevelControl, RoughBody, SolvedLevel};
use crate::monitor::Monitor;
use crate::study::check::FrictionStudy;
use crate::study::output::StageOutput;
use crate::study::result::{
    FailedPoint, ParameterIndexResult, Prescribed, UncertainLevel, UncertainParameter, UncertainResponse,
    UncertaintyResult, distribution_result, pair,
};
use crate::study::surface_stage::SurfaceStage;
use crate::study::{StudyError, Table, sentence};
use crate::surface::model::XiOrder;

/// Fraction of unexplained variance, and of noise, above which there is a warning.
const UNEXPLAINED: f64 = 0.2;

/// Solves strips of surfaces with other parameters at the levels of the stage.
pub(super) fn run(
    study: &FrictionStudy,
    problem: &StripProblem,
    surface: &SurfaceStage,
    levels: &[SolvedLevel],
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<Option<(UncertaintyResult, StageOutput)>, StudyError> {
    let Some(stated) = &study.uncertainty else { return Ok(None) };
    let uncertain = UncertainSurface::new(stated, surface)?;
    let realisations = stated.realisations;
    let propagation = Propagation::new(uncertain.parameters.clone(), stated.points, seed)?;
    let controls: Vec<LevelControl> = levels.iter().map(|level| level.control).collect();
    let plan = UncertainPlan { problem, levels: &controls, points: propagation.points(), realisations, seed };
    let task = plan.task(monitor);
    let mut output = StageOutput::default();
    let (mut points, mut warned) = (Vec::new(), Vec::new());
    for index in 0..plan.points {
        let model = uncertain.at(&propagation.point(index))?;
        let generated = model.strip(problem.grid(), problem.is_periodic(), XiOrder::Wavevector)?;
        points.push(plan.solve(generated.surface.as_ref(), |p| model.height_quantile_m(p), &task)?);
        warned.extend(generated.warnings.into_iter().next());
    }
    if let Some(first) = warned.first() {
        let (some, all) = (warned.len(), propagation.points());
        output.warnings.push(format!("of {some} of the {all} surfaces of uncertain parameters: {first}"));
    }
    let mut results = Vec::with_capacity(levels.len());
    for (place, control) in controls.iter().enumerate() {
        if monitor.cancelled() {
            return Err(crate::monitor::Cancelled.into());
        }
        let of = |which: usize| {
            let replicates = points.iter().map(|point| point[place].as_ref().ok().map(|found| &found[which]));
            responses(&propagation, &replicates.collect::<Vec<_>>(), study.tolerance, seed)
        };
        let [quotient, at_mean_load] = defined([of(0)?, of(1)?], &levels[place], study.body);
        let failed = |(point, levels): (usize, &PointMoments)| {
            levels[place].as_ref().err().map(|reason| FailedPoint { point, reason: reason.clone() })
        };
        let failures: Vec<FailedPoint> = points.iter().enumerate().filter_map(failed).collect();
        output.warnings.extend(warnings(*control, &quotient, &failures));
        let contact = control.contact(|p| surface.model.height_quantile_m(p));
        results.push(UncertainLevel {
            control: prescribed(*control),
            percentile: control.percentile(),
            mean_pressure_pa: if let Control::MeanPressure { pascal } = contact { Some(pascal) } else { None },
            penetration_m: if let Control::Penetration { metre } = contact { Some(metre) } else { None },
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
        law: distribution_result(parameter.marginal()),
    });
    let result = UncertaintyResult {
        points: propagation.points(),
        realisations,
        parameters: parameters.collect(),
        levels: results,
    };
    Ok(Some((result, output)))
}

/// Returns the responses of F/N and of friction at the mean load without those that are undefined for a level.
fn defined(
    [mut quotient, mut at_mean_load]: [Vec<UncertainResponse>; 2],
    level: &SolvedLevel,
    body: RoughBody,
) -> [Vec<UncertainResponse>; 2] {
    if let Some(tail) = &level.heavy_tail {
        let reason = format!("F/N has no variance: {}", no_variance(tail));
        withdraw(&mut quotient, &reason, |name| name != "mean" || !tail.has_mean());
    }
    if body != RoughBody::Track {
        for responses in [&mut quotient, &mut at_mean_load] {
            let reason = "friction is a process along the path only if the track alone is rough";
            withdraw(responses, reason, |name| name == "correlation_length_m");
        }
    }
    [quotient, at_mean_load]
}

/// Replaces the responses of some names by the reason why they are undefined.
fn withdraw(responses: &mut [UncertainResponse], reason: &str, undefined: impl Fn(&str) -> bool) {
    responses.iter_mut().filter(|response| undefined(&response.name)).for_each(|response| {
        *response = UncertainResponse {
            name: std::mem::take(&mut response.name),
            reason: Some(reason.to_owned()),
            ..UncertainResponse::default()
        };
    });
}

/// Expands every moment of one level in the parameters. Moments that differ by less than the tolerance of the contacts count as
/// equal.
fn responses(
    propagation: &Propagation,
    found: &[Option<&MomentReplicates>],
    tolerance: f64,
    seed: u64,
) -> Result<Vec<UncertainResponse>, StudyError> {
    let strips = found.iter().flatten().map(|replicates| replicates.without.len()).max().unwrap_or(0);
    let all = |replicates: &Option<&MomentReplicates>| replicates.map_or(LevelMoments::NONE, |r| r.all);
    let without = |replicates: &Option<&MomentReplicates>, strip: usize| {
        replicates.and_then(|r| r.without.get(strip)).copied().unwrap_or(LevelMoments::NONE)
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
    let above = |value: fn(&UncertainResponse) -> Option<f64>| -> Vec<String> {
        let of = |r: &UncertainResponse| {
            let fraction = value(r).filter(|fraction| *fraction > UNEXPLAINED)?;
            Some(format!("{} {} %", words_of(&r.name), sentence::digits(100.0 * fraction.min(1.0))))
        };
        responses.iter().filter_map(of).collect()
    };
    let unexplained = above(|r| r.loo_error);
    if !unexplained.is_empty() {
        warnings.push(format!(
            "at {name}, the expansion in the uncertain parameters leaves a part of the variance unexplained: {}; indices are as \
             uncertain",
            unexplained.join(", ")
        ));
    }
    let noise = above(|r| r.noise_share);
    if !noise.is_empty() {
        warnings.push(format!(
            "at {name}, a part of the variance over surfaces is due to the few strips, not to the parameters: {}; raise \
             realisations in [friction.uncertainty]",
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
    let any = |key: Prescribed| controls.iter().any(|control| prescribed(*control) == key);
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
        " Their heights have Johnson's distribution. Its kurtosis exceeds the least possible one, 1 + Ssk², by as much as the \
         kurtosis of the study's distribution does."
    } else {
        ""
    };
    format!(
        "Parameters of the surface are taken as independent: {} (standard deviations). {} surfaces with {realisations} strips \
         each, drawn from the same random numbers, were solved, and the moments of friction expanded in the parameters; {}.{law}",
        parameters.join(", "),
        propagation.points(),
        held.join("; "),
    )
}

/// Returns a column of numbers; missing ones are NaN.
fn numbers(levels: &[UncertainLevel], value: impl Fn(&UncertainLevel) -> Option<f64>) -> Vec<f64> {
    levels.iter().map(|level| value(level).unwrap_or(f64::NAN)).collect()
}

/// Returns the columns that locate each level on the load curve of the surface of the study.
fn places(solved: &[SolvedLevel]) -> Vec<(String, Vec<f64>)> {
    vec![
        ("percentile".into(), solved.iter().map(|l| l.control.percentile().unwrap_or(f64::NAN)).collect()),
        ("penetration_m".into(), solved.iter().map(|l| l.strips.penetration_m).collect()),
        ("mean_pressure_pa".into(), solved.iter().map(|l| l.strips.mean_pressure_pa).collect()),
    ]
}

/// Returns the table of the moments of the quotient with their bands over the parameters.
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

/// Returns the table of Sobol' indices of the moments at the mean load.
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

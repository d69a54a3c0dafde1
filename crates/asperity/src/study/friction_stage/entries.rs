//! The levels of the friction stage in `results.json`.

use std::collections::BTreeMap;

use super::words::no_variance;
use crate::correlation::{LengthFit, Stationarity};
use crate::distribution::fit::{Fit, Ranking};
use crate::friction::statistics::{FrictionStatistics, ReturnLevel, Tail};
use crate::friction::window_study::WindowStudy;
use crate::friction::{LevelControl, RoughBody, SolvedLevel};
use crate::stats::ProcessEstimate;
use crate::study::result::{
    AreaUpscalingResult, AtMeanLoad, CorrelationCurveResult, CorrelationModelResult, CrossResult, GoodnessResult,
    LevelProcess, LevelResult, OperatingPoint, Pair, PaperUpscalingResult, Prescribed, RankedDistributionResult,
    ReturnLevelResult, StationarityResult, TailResult, UpscalingResult, distribution_result, finite, pair,
};

/// Returns the variability over the nominal area by both upscalings.
fn upscaling(solved: &SolvedLevel, nominal_area_m2: f64) -> UpscalingResult {
    let (std, variance_reduction) = (solved.process.moments.std, solved.variance_reduction(nominal_area_m2));
    UpscalingResult {
        paper: PaperUpscalingResult { std },
        area: AreaUpscalingResult {
            nominal_area_m2,
            windows: nominal_area_m2 / solved.window.area_m2(),
            variance_reduction,
            std: std * variance_reduction.sqrt(),
        },
    }
}

/// Returns the kind of a level in results.
pub(super) fn prescribed(level: LevelControl) -> Prescribed {
    match level {
        LevelControl::Percentile(_) => Prescribed::Percentile,
        LevelControl::MeanPressure(_) | LevelControl::Nominal(_) => Prescribed::MeanPressure,
        LevelControl::Penetration(_) => Prescribed::Penetration,
    }
}

/// Returns the entry of a level; without the track as the only rough body, friction has no known course along the path.
pub(super) fn level_result(solved: &SolvedLevel, body: RoughBody, nominal_area_m2: f64) -> LevelResult {
    let process = &solved.process;
    let (between_parts_std, between_parts_std_interval) = match (body, &solved.two_bodies) {
        (RoughBody::Track, _) | (RoughBody::Both, None) => (None, None),
        (RoughBody::Slider, _) => (Some(process.moments.std), interval(process.estimates.std)),
        (RoughBody::Both, Some(found)) => (Some(found.between_parts_std), found.between_parts_interval.map(pair)),
    };
    let process = level_process(solved, nominal_area_m2);
    let process = LevelProcess { between_parts_std, between_parts_std_interval, ..process };
    let level = any_level_result(solved, process);
    match body {
        RoughBody::Track => level,
        RoughBody::Slider | RoughBody::Both => without_path(level),
    }
}

/// Returns the level without the numbers that describe friction along a path.
fn without_path(level: LevelResult) -> LevelResult {
    LevelResult {
        correlation_length_m: None,
        correlation_length_m_interval: None,
        return_levels: Vec::new(),
        process: LevelProcess {
            correlation_length_without_window_m: None,
            correlation_length_without_window_m_interval: None,
            correlation_without_window_model: None,
            correlation_families_told_apart: None,
            correlation_without_window_fit_p: None,
            correlation_without_window_agreement_p: None,
            window_only: None,
            stationarity: None,
            at_mean_load: AtMeanLoad {
                correlation_length_m: None,
                correlation_length_m_interval: None,
                correlation_curves: Vec::new(),
                correlation_models: Vec::new(),
                ..level.process.at_mean_load
            },
            ..level.process
        },
        ..level
    }
}

fn any_level_result(solved: &SolvedLevel, process: LevelProcess) -> LevelResult {
    let (strips, statistics) = (&solved.strips, &solved.statistics);
    let correlation = statistics.correlation.as_ref().ok();
    // Without a variance no moment above the first exists, and no interval of a moment.
    let exists = solved.heavy_tail.is_none();
    let moment = |value: f64| finite(value).filter(|_| exists);
    let interval = |estimate| interval(estimate).filter(|_| exists);
    let correlation = correlation.filter(|_| exists);
    LevelResult {
        leading: false,
        control: prescribed(solved.control),
        percentile: solved.control.percentile(),
        penetration_m: strips.penetration_m,
        mean_pressure_pa: strips.mean_pressure_pa,
        contact_fraction: strips.contact_fraction,
        plastic_share: strips.plastic_fraction(),
        mean: solved.quotient_mean(),
        mean_interval: interval(statistics.estimates.mean),
        std: moment(statistics.moments.std),
        std_interval: interval(statistics.estimates.std),
        coefficient_of_variation: moment(statistics.moments.coefficient_of_variation()),
        coefficient_of_variation_interval: interval(statistics.estimates.coefficient_of_variation),
        skewness: moment(statistics.moments.skewness),
        skewness_interval: interval(statistics.estimates.skewness),
        excess_kurtosis: moment(statistics.moments.excess_kurtosis),
        excess_kurtosis_interval: interval(statistics.estimates.excess_kurtosis),
        correlation_length_m: correlation.map(|c| c.exponential.length_m),
        correlation_length_m_interval: correlation.and_then(|c| c.length_interval).map(pair),
        marginal: statistics.marginal().filter(|_| exists).map(|fit| distribution_result(&fit.marginal)),
        marginal_parameter_intervals: if exists { parameter_intervals(statistics) } else { BTreeMap::new() },
        gof: goodness(statistics).filter(|_| exists),
        return_levels: statistics
            .tail
            .as_ref()
            .filter(|_| exists)
            .map_or_else(Vec::new, |tail| tail.return_levels.iter().map(return_level).collect()),
        tail: statistics.tail.as_ref().map(tail),
        beta: statistics.beta.as_ref().filter(|_| exists).map(|fit| distribution_result(&fit.marginal)),
        no_variance: solved.heavy_tail.as_ref().map(no_variance),
        process,
        empty_windows: statistics.empty_windows,
        contact_cells_per_window: statistics.contact_cells,
        sparse_window_share: statistics.sparse_fraction,
        effective_windows: statistics.effective_windows,
        failed_samples: strips.failures.len(),
    }
}

fn level_process(solved: &SolvedLevel, nominal_area_m2: f64) -> LevelProcess {
    let study = solved.window_study.as_ref();
    LevelProcess {
        correlation_length_without_window_m: study.map(|s| s.length_m),
        correlation_length_without_window_m_interval: study.map(|s| pair(s.interval)),
        correlation_without_window_model: study.map(|s| s.model.name().into()),
        correlation_families_told_apart: study.map(|s| s.families.told_apart()),
        correlation_without_window_fit_p: study.and_then(|s| s.lack_of_fit).map(|test| test.p_value),
        correlation_without_window_agreement_p: study.and_then(|s| s.one_length_p),
        window_only: study.map(WindowStudy::window_only),
        between_parts_std: None,
        between_parts_std_interval: None,
        at_mean_load: at_mean_load(solved),
        stationarity: solved.analysis.stationarity.as_ref().ok().map(stationarity),
        area_and_load: solved
            .analysis
            .area_and_load
            .as_ref()
            .ok()
            .map(|found| CrossResult { correlation: found.coefficient, interval: pair(found.interval) }),
        upscaling: upscaling(solved, nominal_area_m2),
    }
}

/// Returns the moments, marginal and correlation of friction at the mean load.
fn at_mean_load(solved: &SolvedLevel) -> AtMeanLoad {
    let process = &solved.process;
    AtMeanLoad {
        mean: solved.mean,
        mean_interval: interval(process.estimates.mean),
        std: process.moments.std,
        std_interval: interval(process.estimates.std),
        skewness: finite(process.moments.skewness),
        excess_kurtosis: finite(process.moments.excess_kurtosis),
        correlation_length_m: process.correlation.as_ref().ok().map(|c| c.exponential.length_m),
        correlation_length_m_interval: process.correlation.as_ref().ok().and_then(|c| c.length_interval).map(pair),
        correlation_curves: correlation_curves(process),
        correlation_models: solved.window_study.as_ref().map_or_else(Vec::new, correlation_models),
        marginal: process.marginal().map(|fit| distribution_result(&fit.marginal)),
        marginal_parameter_intervals: parameter_intervals(process),
        gof: goodness(process),
        laws: ranked(&process.marginals),
        effective_windows: process.effective_windows,
    }
}

/// The friction coefficient of the level that drives the vibration.
pub(super) fn operating_point(solved: &SolvedLevel, nominal_area_m2: f64) -> OperatingPoint {
    let process = &solved.process;
    let (contact_fraction, contact_interval) = solved.contact_fraction;
    let stiffness = solved.strips.stiffness_pa_per_m();
    OperatingPoint {
        level: solved.control.name(),
        percentile: solved.control.percentile(),
        penetration_m: solved.strips.penetration_m,
        mean_pressure_pa: solved.strips.mean_pressure_pa,
        contact_fraction,
        contact_fraction_interval: contact_interval.map(pair),
        contact_stiffness_pa_per_m: stiffness.map(|(mean, _)| mean),
        contact_stiffness_pa_per_m_se: stiffness.and_then(|(_, standard_error)| finite(standard_error)),
        mean: solved.mean,
        mean_interval: interval(process.estimates.mean),
        mean_computational_interval: None,
        mean_sampling_interval: None,
        mean_of_scan: None,
        grid_error: None,
        saturation: None,
        resolved: true,
        std: process.moments.std,
        std_interval: interval(process.estimates.std),
        std_nominal_area: upscaling(solved, nominal_area_m2).area.std,
    }
}

fn interval(estimate: Option<ProcessEstimate>) -> Option<Pair> {
    estimate.map(|estimate| pair(estimate.interval))
}

/// Returns the intervals of the parameters of the marginal distribution; `None` where there is none.
fn parameter_intervals(statistics: &FrictionStatistics) -> BTreeMap<String, Option<Pair>> {
    let parameters = statistics.marginals.place().map_or(&[][..], |place| &statistics.parameters[place]);
    parameters.iter().map(|p| (p.name.to_owned(), interval(p.estimate))).collect()
}

fn goodness(statistics: &FrictionStatistics) -> Option<GoodnessResult> {
    distance(&statistics.marginals, statistics.marginals.place()?)
}

fn distance(ranking: &Ranking, place: usize) -> Option<GoodnessResult> {
    let found = ranking.distance(place)?;
    Some(GoodnessResult {
        kolmogorov_smirnov: found.kolmogorov_smirnov.statistic,
        kolmogorov_smirnov_p: found.kolmogorov_smirnov.p_value,
        anderson_darling: found.anderson_darling.map(|distance| distance.statistic),
        anderson_darling_p: found.anderson_darling.map(|distance| distance.p_value),
    })
}

/// Returns all fitted distributions in the order of Akaike’s criterion.
fn ranked(ranking: &Ranking) -> Vec<RankedDistributionResult> {
    let criterion = |fit: &Fit| fit.aic_correlated(ranking.effective_size);
    let least = ranking.fits.first().map_or(f64::NAN, criterion);
    let of = |(place, fit): (usize, &Fit)| RankedDistributionResult {
        name: fit.family.key().into(),
        aic_difference: criterion(fit) - least,
        gof: distance(ranking, place),
    };
    ranking.fits.iter().enumerate().map(of).collect()
}

fn tail(tail: &Tail) -> TailResult {
    TailResult {
        largest: tail.largest,
        threshold: tail.threshold,
        peaks: tail.clusters,
        shape: tail.shape,
        shape_interval: pair(tail.shape_interval),
    }
}

fn return_level(level: &ReturnLevel) -> ReturnLevelResult {
    ReturnLevelResult { distance_m: level.distance_m, mu: level.mu, interval: level.interval.map(pair) }
}

fn correlation_curves(process: &FrictionStatistics) -> Vec<CorrelationCurveResult> {
    let curves = process.correlation.iter().flat_map(|found| &found.models);
    curves
        .map(|fit| CorrelationCurveResult {
            model: fit.model.name().into(),
            length_m: fit.length_m,
            misfit: fit.misfit,
        })
        .collect()
}

fn correlation_models(study: &WindowStudy) -> Vec<CorrelationModelResult> {
    let families = &study.families;
    let result = |fit: &LengthFit| {
        let best = fit.model == families.fits[0].model;
        CorrelationModelResult {
            model: fit.model.name().into(),
            length_m: fit.length_m,
            length_interval: pair(fit.interval),
            aic_difference: if best { 0.0 } else { families.evidence() },
            worse_beyond_chance: !best && families.told_apart(),
        }
    };
    families.fits.iter().map(result).collect()
}

fn stationarity(found: &Stationarity) -> StationarityResult {
    StationarityResult {
        trend_per_m: finite(found.trend.estimate),
        trend_p: finite(found.trend.p_value),
        mean_change_p: finite(found.mean_change.p_value),
        ends_p: finite(found.ends.p_value),
        variance_change_p: finite(found.variance_change.p_value),
        wander_p: found.wander.and_then(|wander| finite(wander.p_value)),
    }
}

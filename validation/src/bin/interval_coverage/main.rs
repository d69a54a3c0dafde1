//! Counts how often the 95 % intervals of the statistics of a map contain the values of its surface.
//!
//! `cargo run --release -p asperity-validation --bin interval_coverage -- [MAPS [ONLY [POINTS]]]`
//!
//! draws MAPS maps (default 1000) of each case, with 30 correlation lengths a side and POINTS points (default 4) per length. ONLY is a part
//! of the names of the cases to run. For each statistic, the program prints the true value, the mean of the estimates, their standard
//! deviation, the mean standard error over it, the mean number of blocks, the fraction of maps with an interval, the fraction of these
//! intervals that contain the true value, and the fractions above and below it; then the coverage of the correlation at some lags along x.
//! The last table is the table of `docs/validation/statistics.md`.

#![expect(clippy::print_stdout, reason = "prints tables")]

use asperity::correlation::{Autocorrelation, CorrelationModel, Covariance, StationaryCovariance};
use asperity::distribution::Marginal;
use asperity::distribution::translation::Translation;
use asperity::map::{Grid, HeightMap};
use asperity::random;
use asperity::stats::{Interval, Moments};
use asperity::surface::areal::{EquivalentLine, MaterialRatio, parameters};
use asperity::surface::level::{Level, remove_form};
use asperity::surface::uncertainty::{Estimate, Estimates, Uncertainty, Values, removed_terms};
use asperity::surface::{RandomSurface, SpectralField, Translated};
use ndarray::{Array2, s};
use rand::RngExt;
use rayon::prelude::*;

/// Number of correlation lengths a side; the length is the geometric mean of those along x and y.
const LENGTHS: f64 = 30.0;
/// Seed of heights and of holes.
const SEED: u64 = 1;

type Failure = Box<dyn std::error::Error + Send + Sync>;

type Found = (Estimates, Vec<Option<Interval>>);

struct Case {
    /// Points per correlation length along y.
    points: f64,
    distribution: &'static str,
    model: CorrelationModel,
    /// Correlation length along x over that along y.
    stretch: f64,
    /// Fraction of missing points.
    missing: f64,
    level: Level,
}

const fn case(distribution: &'static str, model: CorrelationModel, level: Level) -> Case {
    Case { points: 4.0, distribution, model, stretch: 1.0, missing: 0.0, level }
}

/// Lags along x of the tested correlations, in quarters of the correlation length along y.
const QUARTERS: [usize; 5] = [1, 4, 8, 16, 40];

const LOGNORMAL: &str = "lognormal:0,0.5";
const BETA: &str = "beta:2.1,5";

const CASES: [Case; 14] = {
    use CorrelationModel::{Exponential, SquaredExponential};
    use Level::{Mean, Plane};
    [
        case("normal", SquaredExponential, Mean),
        case("normal", SquaredExponential, Plane),
        case("normal", Exponential, Mean),
        case("normal", Exponential, Plane),
        case(LOGNORMAL, SquaredExponential, Mean),
        case(LOGNORMAL, SquaredExponential, Plane),
        case(LOGNORMAL, Exponential, Mean),
        case("lognormal:0,0.2", SquaredExponential, Mean),
        case("lognormal:0,0.3", SquaredExponential, Mean),
        case(BETA, SquaredExponential, Mean),
        case(BETA, Exponential, Mean),
        case(BETA, Exponential, Plane),
        Case { missing: 0.2, ..case("normal", Exponential, Mean) },
        Case { stretch: 3.0, ..case("normal", SquaredExponential, Mean) },
    ]
};

/// Covariance that is stretched along x.
struct Lay {
    covariance: Covariance,
    stretch: f64,
}

impl StationaryCovariance for Lay {
    fn std_m(&self) -> f64 {
        1.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.covariance.correlation(dx_m / self.stretch, dy_m)
    }
}

impl Case {
    fn name(&self) -> String {
        let lay = if self.stretch == 1.0 { String::new() } else { format!(", l_x = {} l_y", self.stretch) };
        let holes = if self.missing > 0.0 { format!(", {} % missing", 100.0 * self.missing) } else { String::new() };
        format!("{} {}, {} removed{lay}{holes}", self.distribution, self.model.name(), self.level)
    }

    fn distribution(&self) -> Result<Marginal, Failure> {
        Ok(self.distribution.parse::<Marginal>()?.standardised(0.0, 1.0)?)
    }

    fn covariance(&self) -> Result<Lay, Failure> {
        Ok(Lay { covariance: Covariance::new(self.model, 1.0, self.points, self.points)?, stretch: self.stretch })
    }

    fn side(&self) -> usize {
        (LENGTHS * self.points * self.stretch.sqrt()).round() as usize
    }

    /// Returns the estimates, and the intervals of the correlation at the lags, of `count` maps.
    fn estimates(&self, count: u64) -> Result<Vec<Found>, Failure> {
        // Fifteen lengths beyond the map, so that opposite edges are uncorrelated in the periodic field.
        let side = self.side();
        let domain = side + (15.0 * self.points * self.stretch) as usize;
        let field = SpectralField::periodic(&self.covariance()?, Grid::new(domain, domain, 1.0, 1.0)?);
        let field = Translated::new(field, self.distribution()?)?;
        let grid = Grid::new(side, side, 1.0, 1.0)?;
        let uncertainty = Uncertainty { removed_terms: removed_terms(self.level), ..Uncertainty::default() };
        let of_map = |index: u64| -> Result<Found, Failure> {
            let xi = random::standard_normal(&mut random::stream(SEED, "coverage", index), field.xi_len());
            let mut heights: Array2<f64> = field.generate(&xi).heights_m().slice(s![..side, ..side]).to_owned();
            let mut holes = random::stream(SEED, "holes", index);
            heights.iter_mut().filter(|_| holes.random::<f64>() < self.missing).for_each(|z| *z = f64::NAN);
            let map = remove_form(&HeightMap::new(grid, heights)?, self.level)?.map;
            let values = Values::new(&parameters(&map)?, &Autocorrelation::estimate(&map)?);
            let [correlation, _] = uncertainty.correlation(&map, &values, [&self.lags(), &[]])?;
            Ok((uncertainty.of(&map, &values)?, correlation))
        };
        (0..count).into_par_iter().map(of_map).collect()
    }

    fn lags(&self) -> [usize; 5] {
        QUARTERS.map(|quarters| (0.25 * self.points * quarters as f64).round() as usize)
    }

    /// Returns the correlation of the surface at the lags.
    fn correlations(&self) -> Result<[f64; 5], Failure> {
        let (translation, covariance) = (Translation::new(&self.distribution()?)?, self.covariance()?);
        Ok(self.lags().map(|lag| translation.correlation(covariance.correlation(lag as f64, 0.0))))
    }

    /// Returns the statistics of the surface, in the order of [`Estimates::named`].
    fn truths(&self) -> Result<[f64; 11], Failure> {
        let (distribution, covariance) = (self.distribution()?, self.covariance()?);
        let count = 2_000_000;
        let quantile = |i: i32| distribution.quantile((f64::from(i) + 0.5) / f64::from(count));
        let heights: Vec<f64> = (0..count).map(quantile).collect();
        let moments = Moments::new(&heights);
        let sa = heights.iter().map(|z| (z - moments.mean).abs()).sum::<f64>() / f64::from(count);
        let core = MaterialRatio::of(&heights).core(EquivalentLine::LeastSquares);
        let translation = Translation::new(&distribution)?;
        let rho = |x: f64, y: f64| translation.correlation(covariance.correlation(x, y));
        let falls_to = |level: f64, turn: f64| {
            let (mut near, mut far) = (0.0, 1e3 * self.points);
            for _ in 0..60 {
                let middle = 0.5 * (near + far);
                if rho(middle * turn.cos(), middle * turn.sin()) > level { near = middle } else { far = middle }
            }
            near
        };
        let inverse_e = (-1.0_f64).exp();
        let across = std::f64::consts::FRAC_PI_2;
        let (length_x, length_y) = (falls_to(inverse_e, 0.0), falls_to(inverse_e, across));
        let (skew, kurtosis) = (distribution.skewness(), distribution.excess_kurtosis() + 3.0);
        let sdq = (4.0 - 2.0 * rho(1.0, 0.0) - 2.0 * rho(0.0, 1.0)).sqrt();
        Ok([sa, 1.0, skew, kurtosis, sdq, falls_to(0.2, across), core.sk_m, core.spk_m, core.svk_m, length_x, length_y])
    }
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let count: u64 = arguments.first().map_or(Ok(1000), |count| count.parse())?;
    let only = arguments.get(1).map_or("", String::as_str);
    let mut table = String::new();
    let points: f64 = arguments.get(2).map_or(Ok(4.0), |points| points.parse())?;
    for case in CASES.into_iter().filter(|case| case.name().contains(only)) {
        let case = Case { points, ..case };
        println!("{}: {count} maps of {} points a side", case.name(), case.side());
        let (truths, maps) = (case.truths()?, case.estimates(count)?);
        table += &format!("| {} |", case.name());
        for (k, truth) in truths.into_iter().enumerate() {
            let name = maps[0].0.named()[k].0;
            let found: Vec<Estimate> = maps.iter().filter_map(|(m, _)| m.named()[k].1).collect();
            let fraction =
                |of: &dyn Fn(&Estimate) -> bool| found.iter().filter(|e| of(e)).count() as f64 / found.len() as f64;
            let spread = Moments::new(&found.iter().map(|e| e.surface).collect::<Vec<f64>>());
            let mean = |of: &dyn Fn(&Estimate) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
            let covered = fraction(&|e| e.interval.contains(truth));
            println!(
                "  {name:22} truth {truth:8.4} mean {:8.4} sd {:.4} se/sd {:.3} blocks {:5.1} with interval {:.3} covered \
                 {covered:.3} (above {:.3}, below {:.3})",
                spread.mean,
                spread.std,
                mean(&|e| e.standard_error) / spread.std,
                mean(&|e| e.blocks),
                found.len() as f64 / count as f64,
                fraction(&|e| e.interval.low > truth),
                fraction(&|e| e.interval.high < truth),
            );
            // No entry if fewer than half of the maps have an interval.
            table += &if 2 * found.len() < maps.len() { " – |".into() } else { format!(" {:.1} |", 100.0 * covered) };
        }
        for (k, truth) in case.correlations()?.into_iter().enumerate() {
            let found: Vec<Interval> = maps.iter().filter_map(|(_, correlation)| correlation[k]).collect();
            let covered = found.iter().filter(|interval| interval.contains(truth)).count() as f64 / found.len() as f64;
            let half = found.iter().map(|i| 0.5 * (i.high - i.low)).sum::<f64>() / found.len() as f64;
            println!("  correlation at lag {:2}: truth {truth:7.4}, ± {half:.4}, covered {covered:.3}", case.lags()[k]);
            table += &format!(" {:.1} |", 100.0 * covered);
        }
        table += "\n";
    }
    println!(
        "\n| case | Sa | Sq | Ssk | Sku | Sdq | Sal | Sk | Spk | Svk | l_x | l_y | ρ(l/4) | ρ(l) | ρ(2l) | ρ(4l) | ρ(10l) |"
    );
    println!("|---|{}\n{table}", "---:|".repeat(16));
    Ok(())
}

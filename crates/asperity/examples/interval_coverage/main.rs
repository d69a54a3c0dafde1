//! How often the 95 % intervals of a map's statistics hold those of its surface.
//!
//! `cargo run --release -p asperity --example interval_coverage -- [MAPS] [LENGTHS] [MISSING] [LEVEL] [CASE …]`
//!
//! draws MAPS maps (1000) of LENGTHS correlation lengths (30) a side with ten points to a length, takes a share MISSING of
//! the points out (0) and the form LEVEL (mean), and counts for each case, such as `normal/exponential` or
//! `beta:2.1,5/squared_exponential`, or `normal/exponential*4` of a lay along x, four times as long. Columns: the truth,
//! the mean of the estimates, their spread, the mean standard error over it, the mean number of blocks, the share of maps with
//! an interval, the share of these intervals that hold the truth, and the shares that lie above and below it.

use asperity::correlation::{Autocorrelation, CorrelationModel, Covariance, StationaryCovariance};
use asperity::law::Marginal;
use asperity::law::translation::Translation;
use asperity::map::{Grid, HeightMap};
use asperity::random;
use asperity::stats::Moments;
use asperity::surface::areal::{EquivalentLine, MaterialRatio, parameters};
use asperity::surface::level::{Level, remove_form};
use asperity::surface::uncertainty::{Estimates, Uncertainty, Values, removed_terms};
use asperity::surface::{RandomSurface, SpectralField, Translated};
use ndarray::{Array2, s};
use rand::RngExt;

/// Points to a correlation length.
const POINTS: usize = 10;

type Failure = Box<dyn std::error::Error>;

/// A covariance stretched along x.
struct Lay {
    covariance: Covariance,
    stretch: f64,
}

impl Lay {
    fn parse(text: &str) -> Result<Self, Failure> {
        let (model, stretch) = text.split_once('*').unwrap_or((text, "1"));
        let model = match model {
            "squared_exponential" => CorrelationModel::SquaredExponential,
            "exponential" => CorrelationModel::Exponential,
            other => return Err(format!("no model {other}").into()),
        };
        let length = POINTS as f64;
        let covariance = Covariance::new(model, 1.0, length, length)?;
        Ok(Self { covariance, stretch: stretch.parse()? })
    }
}

impl StationaryCovariance for Lay {
    fn std_m(&self) -> f64 {
        1.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        self.covariance.correlation(dx_m / self.stretch, dy_m)
    }
}

struct Case {
    law: Marginal,
    covariance: Lay,
    side: usize,
    missing: f64,
    level: Level,
}

impl Case {
    fn parse(text: &str, lengths: usize, missing: f64, level: Level) -> Result<Self, Failure> {
        let (law, model) = text.split_once('/').ok_or("a case is LAW/MODEL")?;
        let law: Marginal = law.parse()?;
        let law = law.standardised(0.0, 1.0)?;
        Ok(Self { law, covariance: Lay::parse(model)?, side: lengths * POINTS, missing, level })
    }

    fn maps(&self, count: usize) -> Result<Vec<Estimates>, Failure> {
        // Fifteen lengths beyond the map, opposite edges of the periodic field no longer know of each other.
        let domain = self.side + 15 * (POINTS as f64 * self.covariance.stretch) as usize;
        let field = SpectralField::periodic(&self.covariance, Grid::new(domain, domain, 1.0, 1.0)?);
        let field = Translated::new(field, self.law.clone())?;
        let grid = Grid::new(self.side, self.side, 1.0, 1.0)?;
        let uncertainty = Uncertainty { removed_terms: removed_terms(self.level), ..Uncertainty::default() };
        let mut all = vec![];
        for index in 0..count {
            let germ = random::standard_normal(&mut random::stream(1, "coverage", index as u64), field.germ_len());
            let mut heights: Array2<f64> =
                field.generate(&germ).heights_m().slice(s![..self.side, ..self.side]).to_owned();
            let mut holes = random::stream(1, "holes", index as u64);
            heights.iter_mut().filter(|_| holes.random::<f64>() < self.missing).for_each(|z| *z = f64::NAN);
            let map = remove_form(&HeightMap::new(grid, heights)?, self.level)?.map;
            let (parameters, correlation) = (parameters(&map)?, Autocorrelation::estimate(&map)?);
            all.push(uncertainty.of(&map, &Values::new(&parameters, &correlation))?);
        }
        Ok(all)
    }

    /// The surface's own statistics, in the order of [`Estimates::named`].
    fn truths(&self) -> Result<[f64; 11], Failure> {
        let count = 2_000_000;
        let quantile = |i: usize| self.law.quantile((i as f64 + 0.5) / f64::from(count));
        let heights: Vec<f64> = (0..count as usize).map(quantile).collect();
        let moments = Moments::of(&heights);
        let sa = heights.iter().map(|z| (z - moments.mean).abs()).sum::<f64>() / f64::from(count);
        let core = MaterialRatio::of(&heights).core(EquivalentLine::LeastSquares);
        let translation = Translation::new(&self.law)?;
        let rho = |x: f64, y: f64| translation.correlation(self.covariance.correlation(x, y));
        let falls_to = |level: f64, turn: f64| {
            let (mut near, mut far) = (0.0, 10.0 * self.side as f64);
            for _ in 0..60 {
                let middle = 0.5 * (near + far);
                if rho(middle * turn.cos(), middle * turn.sin()) > level { near = middle } else { far = middle }
            }
            near
        };
        let inverse_e = (-1.0_f64).exp();
        let across = std::f64::consts::FRAC_PI_2;
        let (length_x, length_y) = (falls_to(inverse_e, 0.0), falls_to(inverse_e, across));
        let (skew, kurtosis) = (self.law.skewness(), self.law.excess_kurtosis() + 3.0);
        let sdq = (4.0 - 2.0 * rho(1.0, 0.0) - 2.0 * rho(0.0, 1.0)).sqrt();
        Ok([sa, 1.0, skew, kurtosis, sdq, falls_to(0.2, across), core.sk_m, core.spk_m, core.svk_m, length_x, length_y])
    }
}

#[expect(clippy::print_stdout, reason = "a table for people")]
fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let of = |place: usize, default: &'static str| arguments.get(place).map_or(default, String::as_str);
    let count: usize = of(0, "1000").parse()?;
    let lengths: usize = of(1, "30").parse()?;
    let missing: f64 = of(2, "0").parse()?;
    let level: Level = of(3, "mean").parse()?;
    let mut cases: Vec<&str> = arguments.iter().skip(4).map(String::as_str).collect();
    if cases.is_empty() {
        cases = vec![
            "normal/squared_exponential",
            "normal/exponential",
            "beta:2.1,5/squared_exponential",
            "beta:2.1,5/exponential",
        ];
    }
    for text in cases {
        let case = Case::parse(text, lengths, missing, level)?;
        println!("{text}: {count} maps of {lengths} lengths, {missing} missing, {level} removed");
        let (truths, maps) = (case.truths()?, case.maps(count)?);
        for (k, truth) in truths.into_iter().enumerate() {
            let name = maps[0].named()[k].0;
            let found: Vec<_> = maps.iter().filter_map(|m| m.named()[k].1).collect();
            let share = |of: &dyn Fn(&asperity::surface::uncertainty::Estimate) -> bool| {
                found.iter().filter(|e| of(e)).count() as f64 / found.len() as f64
            };
            let values: Vec<f64> = found.iter().map(|e| e.surface).collect();
            let spread = Moments::of(&values);
            let mean = |of: &dyn Fn(&asperity::surface::uncertainty::Estimate) -> f64| {
                found.iter().map(of).sum::<f64>() / found.len() as f64
            };
            println!(
                "  {name:22} truth {truth:8.4} mean {:8.4} spread {:.4} se/spread {:.3} blocks {:5.1} given {:.3} covered {:.3} \
                 (above {:.3}, below {:.3})",
                spread.mean,
                spread.std,
                mean(&|e| e.standard_error) / spread.std,
                mean(&|e| e.blocks),
                found.len() as f64 / count as f64,
                share(&|e| e.interval.contains(truth)),
                share(&|e| e.interval.low > truth),
                share(&|e| e.interval.high < truth),
            );
        }
    }
    Ok(())
}

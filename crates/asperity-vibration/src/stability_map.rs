//! Stability map: probability of sustained vibration over two parameters of a machine.

mod contour;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::contour::grid_contour;
use self::contour::{Place, Square, boundary, contour};
use super::{
    Ensemble, EnsembleSettings, Estimate, Oscillator, Parameters, VibrationError, clipped_to_positive, limit_cycle,
    limit_damping,
};
use asperity_base::blocks::Task;
use asperity_base::choice;
use asperity_base::monitor::{Monitor, Quiet};
use asperity_process::{FrictionProcess, ProcessModel};

/// Fraction of the trajectories after which a point is decided if all of them agree.
const FIRST_FRACTION: f64 = 0.25;
/// Least number of trajectories that may decide a point.
const FIRST_COUNT: usize = 64;
/// Standard deviation of friction below which it is constant.
pub const CONSTANT_STD: f64 = 1e-12;
/// Largest number of halvings of a cell.
const MAX_DEPTH: u32 = 8;

choice! {
    /// Parameters of a stability map.
    pub enum MapOver: "pair of parameters" {
        /// Damping ratio and dimensionless belt velocity.
        DampingVelocity = "damping_velocity",
        /// Damping ratio and standard deviation of friction.
        DampingStd = "damping_scatter",
        /// Dimensionless belt velocity and load over the stated normal force; the law and all lengths hold in SI.
        VelocityLoad = "velocity_load",
    }
}

impl MapOver {
    /// Returns the names of the axes.
    pub fn axes(self) -> [&'static str; 2] {
        match self {
            Self::DampingVelocity => ["damping_ratio", "belt_velocity"],
            Self::DampingStd => ["damping_ratio", "friction_std"],
            Self::VelocityLoad => ["belt_velocity", "load_ratio"],
        }
    }

    /// Returns the oscillator at a point and the model of its friction, clipped to stay positive; `None` below [`CONSTANT_STD`]. Both arguments are of the stated load; lengths at the point are in units of its own load.
    ///
    /// # Errors
    /// A parameter is out of range.
    pub fn machine(
        self,
        stated: &Oscillator,
        friction: &ProcessModel,
        [x, y]: [f64; 2],
    ) -> Result<(Oscillator, Option<ProcessModel>), VibrationError> {
        let ([damping_ratio, belt_velocity], std, load) = match self {
            Self::DampingVelocity => ([x, y], friction.std, 1.0),
            Self::DampingStd => ([x, stated.belt_velocity()], y, 1.0),
            Self::VelocityLoad => ([stated.damping_ratio(), x], friction.std, y),
        };
        let at = Parameters { damping_ratio, belt_velocity, ..stated.parameters().clone() };
        let oscillator = Oscillator::new(at)?.under_load(load)?;
        let (shape, correlation_length) = (friction.shape.in_unit(load), friction.correlation_length / load);
        let model = ProcessModel { std, shape, correlation_length, ..friction.clone() };
        let model = (std >= CONSTANT_STD).then(|| clipped_to_positive(&oscillator, model, 1.0));
        Ok((oscillator, model))
    }
}

/// Axis of the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapAxis {
    /// Least value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
    /// Number of cells of the first grid.
    pub cells: usize,
}

impl MapAxis {
    /// Returns the axis if it is valid, otherwise the reason.
    ///
    /// # Errors
    /// Fails if the axis does not rise, if an end is not finite, or if the number of cells is not 1 to 1000.
    pub fn check(self) -> Result<Self, &'static str> {
        if !(self.from.is_finite() && self.to.is_finite() && self.from < self.to) {
            return Err("the last value of an axis must be above the first");
        }
        if self.cells == 0 || self.cells > 1000 {
            return Err("an axis has 1 to 1000 cells");
        }
        Ok(self)
    }

    /// Returns the value at index i of n + 1 equally spaced values.
    fn at(&self, i: usize, n: usize) -> f64 {
        if i == n { self.to } else { self.from + (self.to - self.from) * (i as f64 / n as f64) }
    }
}

/// Settings of a map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapSettings {
    /// First axis.
    pub x: MapAxis,
    /// Second axis.
    pub y: MapAxis,
    /// Largest number of halvings of a cell through which a level passes, 0 … 8.
    pub depth: u32,
    /// Settings of the ensemble at every point; all points use the same realisations.
    pub ensemble: EnsembleSettings,
}

impl MapSettings {
    /// Returns the largest fraction of the friction values that is clipped at a point of the first grid, of machines by
    /// [`MapOver::machine`].
    ///
    /// # Errors
    /// A parameter is out of range.
    pub fn clipped_fraction(
        &self,
        over: MapOver,
        stated: &Oscillator,
        friction: &ProcessModel,
    ) -> Result<f64, VibrationError> {
        let values = |axis: MapAxis| (0..=axis.cells).map(move |i| axis.at(i, axis.cells));
        let points = values(self.x).flat_map(|x| values(self.y).map(move |y| [x, y]));
        points
            .map(|point| over.machine(stated, friction, point))
            .try_fold(0.0_f64, |largest, found| Ok(largest.max(found?.1.map_or(0.0, |model| model.clipped_fraction()))))
    }
}

/// Machine: an oscillator and its friction fluctuation, if any.
pub type FluctuatingOscillator = (Oscillator, Option<FrictionProcess>);

/// Point of the map.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapPoint {
    /// First parameter.
    pub x: f64,
    /// Second parameter.
    pub y: f64,
    /// Fraction of the trajectories that sustain vibration.
    pub sustained: Estimate,
    /// Number of trajectories of this fraction; 1 without fluctuation.
    pub trajectories: usize,
    /// Largest damping ratio at which the machine vibrates without fluctuation, if there is one.
    pub limit_damping_ratio: Option<f64>,
    /// Damping ratio ζ of the machine.
    pub damping_ratio: f64,
}

/// Cell of the map, whose corners are points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapCell {
    /// Lower and upper end along x.
    pub x: [f64; 2],
    /// Lower and upper end along y.
    pub y: [f64; 2],
    /// Mean probability at the corners.
    pub probability: f64,
}

/// Resolution of the transition of the probability.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapResolution {
    /// Width of the smallest cells along x.
    pub x: f64,
    /// Width of the smallest cells along y.
    pub y: f64,
    /// Fraction of the cells on the contour of 50 % in which the probability falls from 95 % to 5 %. The width of the
    /// transition is then less than a cell and unknown.
    pub unresolved_share: f64,
}

/// Contour of the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapContour {
    /// Probability.
    pub level: f64,
    /// Lines (x, y).
    pub lines: Vec<Vec<[f64; 2]>>,
}

/// Probability of sustained vibration over two parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StabilityMap {
    /// All points, by y and then by x.
    pub points: Vec<MapPoint>,
    /// Cells that were not halved.
    pub cells: Vec<MapCell>,
    /// Contours at 5, 50 and 95 %. The contours of 5 and 95 % omit the cells that do not resolve the transition.
    pub contours: Vec<MapContour>,
    /// Lines (x, y) at which vibration without fluctuation ends.
    pub limit: Vec<Vec<[f64; 2]>>,
    /// Widths of the smallest cells, and how many of them do not resolve the transition.
    pub resolution: MapResolution,
}

impl StabilityMap {
    /// Levels of the contours.
    pub const LEVELS: [f64; 3] = [0.05, 0.5, 0.95];
}

/// Computes the map of the machines `machine(x, y)`.
///
/// A first grid is refined where a level of [`StabilityMap::LEVELS`], or the end of vibration without fluctuation, lies
/// between the corners of a cell. A smallest cell that contains both 5 and 95 % does not resolve the transition: only
/// the contour of 50 % is drawn in it, and it counts in [`MapResolution::unresolved_share`]. All points use the same
/// realisations of friction, so the differences between points have less noise than the points. A point is finished
/// early if the first quarter of its trajectories agree.
///
/// Fails like [`Ensemble::simulate`] at the first point that fails, if an axis is empty, or when cancelled.
pub fn stability_map(
    machine: &(dyn Fn(f64, f64) -> Result<FluctuatingOscillator, VibrationError> + Sync),
    settings: &MapSettings,
    monitor: &dyn Monitor,
) -> Result<StabilityMap, VibrationError> {
    for (parameter, axis) in [("end of the x axis", settings.x), ("end of the y axis", settings.y)] {
        axis.check().map_err(|wanted| VibrationError::Parameter { parameter, value: axis.to, wanted })?;
    }
    if settings.depth > MAX_DEPTH {
        let value = f64::from(settings.depth);
        return Err(VibrationError::Parameter { parameter: "map depth", value, wanted: "at most 8" });
    }
    let finest = 1_usize << settings.depth;
    let (nx, ny) = (settings.x.cells * finest, settings.y.cells * finest);
    let mut squares: Vec<Square> = (0..settings.y.cells)
        .flat_map(|j| (0..settings.x.cells).map(move |i| Square { corner: (i * finest, j * finest), side: finest }))
        .collect();
    let mut points: BTreeMap<Place, MapPoint> = BTreeMap::new();
    let mut leaves: Vec<Square> = Vec::new();
    while !squares.is_empty() {
        let mut wanted: Vec<Place> = squares.iter().flat_map(Square::corners).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.retain(|place| !points.contains_key(place));
        let task = Task::new(monitor, "points of the map", wanted.len());
        let found: Vec<MapPoint> = task.map(wanted.len(), |index| {
            let (x, y) = (settings.x.at(wanted[index].0, nx), settings.y.at(wanted[index].1, ny));
            point(machine, x, y, &settings.ensemble, monitor)
        })?;
        points.extend(wanted.into_iter().zip(found));
        // Each square is checked with all points on its sides, including points that neighbours added later.
        leaves.append(&mut squares);
        let (halved, kept): (Vec<Square>, Vec<Square>) =
            leaves.into_iter().partition(|square| square.side > 1 && is_crossed(square, &points));
        leaves = kept;
        squares = halved.iter().flat_map(Square::quarters).collect();
    }
    let place = |(i, j): Place| [settings.x.at(i, nx), settings.y.at(j, ny)];
    let probability = |point: &MapPoint| point.sustained.value;
    let [low, middle, high] = StabilityMap::LEVELS;
    let holds = |square: &Square, [below, above]: [f64; 2]| {
        let sides: Vec<f64> = boundary(square, &points).iter().map(|place| probability(&points[place])).collect();
        sides.iter().any(|p| *p < below) && sides.iter().any(|p| *p >= above)
    };
    let resolved: Vec<Square> = leaves.iter().filter(|square| !holds(square, [low, high])).copied().collect();
    let front = leaves.iter().filter(|square| holds(square, [middle, middle])).count();
    let resolution = MapResolution {
        x: (settings.x.to - settings.x.from) / nx as f64,
        y: (settings.y.to - settings.y.from) / ny as f64,
        unresolved_share: (leaves.len() - resolved.len()) as f64 / front.max(1) as f64,
    };
    let contours = StabilityMap::LEVELS.map(|level| {
        let squares = if level == middle { &leaves } else { &resolved };
        MapContour { level, lines: contour(squares, &points, &|p| Some(probability(p) - level), &place) }
    });
    let limit = contour(&leaves, &points, &|p| p.limit_damping_ratio.map(|c| c - p.damping_ratio), &place);
    let cells = leaves
        .iter()
        .map(|square| {
            let [low, _, high, _] = square.corners().map(place);
            let probability = square.corners().iter().map(|c| points[c].sustained.value).sum::<f64>() / 4.0;
            MapCell { x: [low[0], high[0]], y: [low[1], high[1]], probability }
        })
        .collect();
    let mut points: Vec<(Place, MapPoint)> = points.into_iter().collect();
    points.sort_by_key(|((i, j), _)| (*j, *i));
    let points = points.into_iter().map(|(_, point)| point).collect();
    Ok(StabilityMap { points, cells, contours: contours.into(), limit, resolution })
}

/// Returns whether a level or the deterministic limit passes between points on the sides.
fn is_crossed(square: &Square, points: &BTreeMap<Place, MapPoint>) -> bool {
    let sides: Vec<MapPoint> = boundary(square, points).iter().map(|place| points[place]).collect();
    let between = |value: &dyn Fn(&MapPoint) -> f64, level: f64| {
        sides.iter().any(|p| value(p) < level) && sides.iter().any(|p| value(p) >= level)
    };
    StabilityMap::LEVELS.iter().any(|level| between(&|p| p.sustained.value, *level))
        || between(&|p| p.limit_damping_ratio.map_or(f64::NAN, |c| c - p.damping_ratio), 0.0)
}

fn point(
    machine: &(dyn Fn(f64, f64) -> Result<FluctuatingOscillator, VibrationError> + Sync),
    x: f64,
    y: f64,
    settings: &EnsembleSettings,
    monitor: &dyn Monitor,
) -> Result<MapPoint, VibrationError> {
    let (oscillator, process) = machine(x, y)?;
    let limit_damping_ratio = limit_damping(&oscillator).ok().filter(|limit| *limit > 0.0);
    let damping_ratio = oscillator.damping_ratio();
    let at = |sustained, trajectories| MapPoint { x, y, sustained, trajectories, limit_damping_ratio, damping_ratio };
    let Some(process) = process else {
        let value = if limit_cycle(&oscillator)?.kind().is_vibration() { 1.0 } else { 0.0 };
        return Ok(at(Estimate { value, interval: [value, value] }, 1));
    };
    let of = |trajectories| -> Result<Estimate, VibrationError> {
        let settings = EnsembleSettings { trajectories, sample_capacity: 0, ..*settings };
        Ok(Ensemble::simulate(&oscillator, &process, &settings, &Quiet(monitor))?.passages.sustained)
    };
    let first = ((FIRST_FRACTION * settings.trajectories as f64) as usize).max(FIRST_COUNT);
    if first < settings.trajectories {
        let sustained = of(first)?;
        if sustained.value == 0.0 || sustained.value == 1.0 {
            return Ok(at(sustained, first));
        }
    }
    Ok(at(of(settings.trajectories)?, settings.trajectories))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::critical_damping;
    use asperity_base::monitor::Silent;
    use asperity_process::CorrelationShape;

    fn settings(depth: u32, trajectories: usize, duration: f64) -> MapSettings {
        MapSettings {
            x: MapAxis { from: 0.1, to: 0.3, cells: 4 },
            y: MapAxis { from: 0.002, to: 0.2, cells: 3 },
            depth,
            ensemble: EnsembleSettings::new(trajectories, duration, 7),
        }
    }

    #[test]
    fn without_fluctuation_the_contour_is_the_end_of_the_cycle_and_the_transition_has_no_width() {
        let machine = |x: f64, y: f64| Ok((Oscillator::with_stribeck(0.1, 4.2, x, y)?, None));
        let map = stability_map(&machine, &settings(5, 0, 1.0), &Silent).unwrap();
        let spacing = 0.2 / 4.0 / 32.0;
        assert_eq!(map.limit.len(), 1);
        for [damping, velocity] in &map.limit[0] {
            let wanted = critical_damping(&Oscillator::with_stribeck(0.1, 4.2, 0.1, *velocity).unwrap()).unwrap();
            // Error of linear interpolation over a cell of ζ_c, whose second derivative in V is below 3·μ_st·a³/2 = 11
            // (Hopf's formula).
            let cell: f64 = 0.198 / 3.0 / 32.0;
            assert!(
                (damping - wanted.critical_damping_ratio).abs() < 0.5 * 11.2 * cell.powi(2),
                "{damping} at {velocity}"
            );
        }
        // A jump has no width that a cell could resolve: 5 and 95 % are not drawn one cell apart.
        assert_eq!(map.resolution.unresolved_share, 1.0);
        assert!((map.resolution.x / spacing - 1.0).abs() < 1e-12, "{:?}", map.resolution);
        for contour in &map.contours {
            assert_eq!(contour.lines.len(), usize::from(contour.level == 0.5), "{}", contour.level);
            let Some(line) = contour.lines.first() else { continue };
            assert!((line[0][1] - 0.002).abs() < 1e-12 || (line[line.len() - 1][1] - 0.002).abs() < 1e-12);
            for [damping, velocity] in line {
                let wanted = critical_damping(&Oscillator::with_stribeck(0.1, 4.2, 0.1, *velocity).unwrap()).unwrap();
                // Within the cell that the contour crosses, along ζ and along V (slope of ζ_c below 1.8).
                let cell = spacing + 1.8 * 0.198 / 96.0;
                assert!((damping - wanted.critical_damping_ratio).abs() < cell, "{damping} at {velocity}");
            }
        }
        // The cells tile the map.
        let area: f64 = map.cells.iter().map(|c| (c.x[1] - c.x[0]) * (c.y[1] - c.y[0])).sum();
        assert!((area / (0.2 * 0.198) - 1.0).abs() < 1e-12);
        let full = (4 * 32 + 1) * (3 * 32 + 1);
        assert!(map.points.len() < full / 6, "{} of {full} points", map.points.len());
    }

    #[test]
    fn axes_replace_the_stated_values_and_load_shortens_lengths() {
        let stated = Oscillator::with_stribeck(0.1, 4.2, 0.15, 0.004).unwrap();
        let shape = CorrelationShape::WindowedExponential { window: 0.2 };
        let friction = ProcessModel { shape, ..ProcessModel::new("beta:2.1,5".parse().unwrap(), 0.001, 0.01) };
        let of = |map: MapOver, at| {
            let (oscillator, model) = map.machine(&stated, &friction, at).unwrap();
            let model = model.unwrap();
            // At least a tenth of the kinetic coefficient remains.
            let clipped = -model.least.unwrap() / oscillator.law().coefficient(oscillator.static_friction());
            assert!((0.5..0.9).contains(&clipped), "{clipped}");
            (oscillator.damping_ratio(), oscillator.belt_velocity(), model.std, model.shape, model.correlation_length)
        };
        assert_eq!(of(MapOver::DampingVelocity, [0.2, 0.01]), (0.2, 0.01, 0.001, shape, 0.01));
        assert_eq!(of(MapOver::DampingStd, [0.2, 0.002]), (0.2, 0.004, 0.002, shape, 0.01));
        let shorter = CorrelationShape::WindowedExponential { window: 0.1 };
        assert_eq!(of(MapOver::VelocityLoad, [0.01, 2.0]), (0.15, 0.005, 0.001, shorter, 0.005));
        let (_, constant) = MapOver::DampingStd.machine(&stated, &friction, [0.2, 0.0]).unwrap();
        assert_eq!(constant, None);
    }

    #[test]
    fn a_share_of_all_or_none_needs_the_first_trajectories_only() {
        let machine = |x: f64, y: f64| {
            let model = ProcessModel::new("beta:2.1,5".parse()?, 0.001, 0.01);
            Ok((Oscillator::with_stribeck(0.1, 4.2, x, y)?, Some(FrictionProcess::new(model)?)))
        };
        let settings = EnsembleSettings::new(200, 60.0, 7);
        let found = point(&machine, 0.02, 0.003, &settings, &Silent).unwrap();
        let (oscillator, process) = machine(0.02, 0.003).unwrap();
        let first = EnsembleSettings { trajectories: FIRST_COUNT, ..settings };
        let wanted = Ensemble::simulate(&oscillator, &process.unwrap(), &first, &Silent).unwrap().passages.sustained;
        assert_eq!((found.trajectories, found.sustained), (FIRST_COUNT, wanted));
    }

    #[test]
    fn noise_separates_the_contours_and_a_point_equals_its_ensemble() {
        let machine = |x: f64, y: f64| {
            let model = ProcessModel::new("beta:2.1,5".parse()?, 0.001, 0.01);
            Ok((Oscillator::with_stribeck(0.1, 4.2, x, 0.003 + 0.001 * y)?, Some(FrictionProcess::new(model)?)))
        };
        let settings = MapSettings {
            x: MapAxis { from: 0.12, to: 0.3, cells: 6 },
            y: MapAxis { from: 0.0, to: 1.0, cells: 1 },
            depth: 1,
            ensemble: EnsembleSettings::new(100, 200.0, 7),
        };
        let map = stability_map(&machine, &settings, &Silent).unwrap();
        let place = |level: f64| {
            let contour = map.contours.iter().find(|c| c.level == level).unwrap();
            let places: Vec<f64> = contour.lines.iter().flatten().map(|p| p[0]).collect();
            places.iter().sum::<f64>() / places.len() as f64
        };
        assert!(place(0.95) < place(0.5) - 0.01 && place(0.5) < place(0.05) - 0.01, "{:?}", map.contours);
        assert_eq!(map.resolution.unresolved_share, 0.0);
        // With very little noise the transition lies within a cell, and the map reports it.
        let quiet = |x: f64, y: f64| {
            let model = ProcessModel::new("beta:2.1,5".parse()?, 1e-7, 0.01);
            Ok((machine(x, y)?.0, Some(FrictionProcess::new(model)?)))
        };
        let sharp = stability_map(&quiet, &settings, &Silent).unwrap();
        assert_eq!(sharp.resolution.unresolved_share, 1.0);
        assert_eq!(sharp.contours.iter().map(|c| c.lines.len()).collect::<Vec<_>>(), [0, 1, 0]);
        let at = map.points.iter().find(|p| p.trajectories == 100).unwrap();
        let (oscillator, process) = machine(at.x, at.y).unwrap();
        let alone = Ensemble::simulate(&oscillator, &process.unwrap(), &settings.ensemble, &Silent).unwrap();
        assert_eq!(alone.passages.sustained, at.sustained);
    }

    #[test]
    fn an_empty_axis_is_refused() {
        let machine = |x: f64, y: f64| Ok((Oscillator::with_stribeck(0.1, 4.2, x, y)?, None));
        let mut wrong = settings(0, 0, 1.0);
        wrong.x.to = wrong.x.from;
        assert!(stability_map(&machine, &wrong, &Silent).is_err());
        assert!(stability_map(&machine, &MapSettings { depth: 9, ..settings(0, 0, 1.0) }, &Silent).is_err());
    }
}

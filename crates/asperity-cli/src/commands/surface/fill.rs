//! Filling of missing heights and extension of maps.

use std::path::PathBuf;

use asperity::map::HeightMap;
use asperity::monitor::Monitor;
use asperity::quantity::Length;
use asperity::random;
use asperity::study::filling_warnings;
use asperity::surface::level::Level;
use asperity::surface::{
    ConditionalError, FILLED_AT_ONCE, FillCovariance, FillError, FillMarginal, FillOptions, Filling, RandomSurface,
    filling_memory_bytes,
};
use clap::Args;

use super::maps::MapsOut;
use crate::args::{self, OneOrTwo};
use crate::failure::{Failure, Kind, chain};
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::resources::require_memory;

/// Fills missing heights with random ones that continue the map, conditional on the heights present, with their
/// covariance and distribution. Heights that are present stay unchanged, bit for bit. The result is one possible
/// surface out of many.
#[derive(Debug, Args)]
pub(crate) struct Fill {
    /// File to read, in any format that `asperity formats` lists; the content decides the format.
    input: PathBuf,
    #[command(flatten)]
    options: ScanOptions,
    #[command(flatten)]
    target: MapsOut,
    /// Seed of the random heights.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Number of maps, all with the same measured heights.
    #[arg(long, value_name = "K", default_value = "1", value_parser = args::count, allow_hyphen_values = true)]
    count: usize,
    /// Length by which to extend the map beyond each of its edges, along x and y.
    #[arg(long, value_name = "Q[,Q]", value_parser = extension, allow_hyphen_values = true)]
    extend: Option<OneOrTwo<Length>>,
    /// Form to remove before and to add back afterwards: none, mean, plane, quadratic, polynomial:N, cylinder or
    /// sphere. Beyond the map the form continues with its value at the edge.
    #[arg(long, value_name = "FORM", default_value = "plane")]
    level: Level,
    /// Covariance of the random heights: the map's own, or the model that fits it best.
    #[arg(long, value_parser = args::named::<FillCovariance>(), default_value = "measured")]
    covariance: FillCovariance,
    /// Distribution of the random heights: measured on the heights present, or normal.
    #[arg(long, value_parser = args::named::<FillMarginal>(), default_value = "measured")]
    marginal: FillMarginal,
    /// Variance of the measurement noise over the variance of the heights; the command raises it to the noise that the
    /// heights show. The random heights are those of the surface beneath the noise.
    #[arg(long, value_name = "X", default_value = "0", value_parser = args::non_negative, allow_hyphen_values = true)]
    nugget: f64,
}

impl Fill {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        // Refuse now instead of after the work: during part of it Ctrl-C leaves no time to remove the folder.
        let probe = self.target.open(self.count, &[&self.input])?;
        let map = input::map(&self.input, &self.options, monitor)?;
        let options = self.fill_options(&map);
        let side = |n: usize, extend: usize| n as f64 + 2.0 * extend as f64;
        let points = side(map.grid().nx(), options.extend_x) * side(map.grid().ny(), options.extend_y);
        require_memory(filling_memory_bytes(points), "filling a map of this size")?;
        probe.require_disk(self.count, points)?;
        drop(probe);
        let filling = monitor.killable(|| Filling::new(&map, options, monitor))?.map_err(|e| self.fill_failure(&e))?;
        let (filled, points) = (filling.filled_points(), filling.grid().points());
        if filled == 0 {
            monitor.warn(&format!("{}: no height is missing; the map is written as it is", self.input.display()));
        }
        filling_warnings(&filling, self.nugget).iter().for_each(|warning| monitor.warn(warning));
        let maps = self.target.open(self.count, &[&self.input])?;
        let xi = |index: usize| {
            let mut stream = random::stream(self.seed, "fill", index as u64);
            random::standard_normal(&mut stream, filling.xi_len())
        };
        for first in (0..self.count).step_by(FILLED_AT_ONCE) {
            let some = first..(first + FILLED_AT_ONCE).min(self.count);
            let drawn = filling.draw(some.clone().map(xi), monitor)?;
            for (index, map) in some.zip(&drawn) {
                monitor.check()?;
                maps.write(index, map)?;
                monitor.progress("maps", index + 1, self.count);
            }
        }
        monitor.check()?;
        let written = maps.commit()?;
        let percent = 100.0 * filled as f64 / points as f64;
        monitor.note(&format!(
            "{written}: {filled} of {points} heights ({percent:.1} %) are filled in, {} are measured",
            points - filled
        ));
        Ok(())
    }

    fn fill_options(&self, map: &HeightMap) -> FillOptions {
        let (x, y) = self.extend.map_or((0.0, 0.0), |pair| (pair.both().0.0, pair.both().1.0));
        FillOptions {
            level: self.level,
            extend_x: (x / map.grid().dx_m()).ceil() as usize,
            extend_y: (y / map.grid().dy_m()).ceil() as usize,
            covariance: self.covariance,
            marginal: self.marginal,
            nugget: self.nugget,
        }
    }

    fn fill_failure(&self, error: &FillError) -> Failure {
        let kind = match error {
            FillError::Conditional(ConditionalError::Parameter { .. }) => Kind::Usage,
            _ => Kind::Data,
        };
        Failure::new(kind, format!("{}: {}", self.input.display(), chain(error)))
    }
}

fn extension(text: &str) -> Result<OneOrTwo<Length>, args::Refusal> {
    args::pair(text, args::non_negative_quantity)
}

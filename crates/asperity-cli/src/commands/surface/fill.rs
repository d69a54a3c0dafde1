//! Voids filled and edges extended.

use std::path::PathBuf;

use asperity::map::HeightMap;
use asperity::monitor::Monitor;
use asperity::quantity::Length;
use asperity::random;
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

/// Share of the variance that goes unsaid, as noise and as change of the covariance.
const DOUBTFUL_NOISE: f64 = 1e-4;
const DOUBTFUL_CLIPPING: f64 = 0.02;

/// Fills missing heights with random ones that continue the map: given the heights present, with their covariance and
/// law. Heights that are present stay as they are, bit by bit. What is filled in is one possible surface out of many.
#[derive(Debug, Args)]
pub(crate) struct Fill {
    /// File to read, in any format that `asperity formats` lists; known by its content.
    input: PathBuf,
    #[command(flatten)]
    options: ScanOptions,
    #[command(flatten)]
    target: MapsOut,
    /// Seed of what is filled in.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Number of maps, all with the same measured heights.
    #[arg(long, value_name = "K", default_value = "1", value_parser = args::count, allow_hyphen_values = true)]
    count: usize,
    /// Length by which the map is continued beyond each of its edges, along x and y.
    #[arg(long, value_name = "Q[,Q]", value_parser = extension, allow_hyphen_values = true)]
    extend: Option<OneOrTwo<Length>>,
    /// Form that is taken out before and put back afterwards: none, mean, plane, quadratic, polynomial:N, cylinder or
    /// sphere. Beyond the map it goes on as it is at the edge.
    #[arg(long, value_name = "FORM", default_value = "plane")]
    level: Level,
    /// Covariance of what is filled in: the map's own, or the model that fits it best.
    #[arg(long, value_parser = args::named::<FillCovariance>(), default_value = "measured")]
    covariance: FillCovariance,
    /// Law of what is filled in: that of the heights present, or the normal one.
    #[arg(long, value_parser = args::named::<FillMarginal>(), default_value = "measured")]
    marginal: FillMarginal,
    /// Variance of the measurement noise over that of the heights; at least what the heights show. What is filled in is the
    /// surface beneath the noise.
    #[arg(long, value_name = "X", default_value = "0", value_parser = args::non_negative, allow_hyphen_values = true)]
    nugget: f64,
}

impl Fill {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        // Refused now rather than after the work, during some of which Ctrl-C leaves no time to clear a folder away.
        let probe = self.target.open(self.count, &[&self.input])?;
        let map = input::map(&self.input, &self.options, monitor)?;
        let options = self.fill_options(&map);
        let sides = [map.grid().nx() + 2 * options.extend_x, map.grid().ny() + 2 * options.extend_y];
        let points: f64 = sides.iter().map(|n| *n as f64).product();
        require_memory(filling_memory_bytes(points), "filling a map of this size")?;
        probe.require_disk(self.count, points)?;
        drop(probe);
        let filling = monitor.at_once(|| Filling::new(&map, options, monitor))?.map_err(|e| self.unfilled(&e))?;
        let (filled, points) = (filling.filled_points(), filling.grid().points());
        if filled == 0 {
            monitor.warn(&format!("{}: no height is missing; the map is written as it is", self.input.display()));
        }
        self.doubt(&filling, monitor);
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
                maps.keep(index, map)?;
                monitor.progress("maps", index + 1, self.count);
            }
        }
        monitor.check()?;
        let written = maps.commit()?;
        let share = 100.0 * filled as f64 / points as f64;
        monitor.note(&format!(
            "{written}: {filled} of {points} heights ({share:.1} %) are filled in, {} are measured",
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

    /// Tells where what is filled in differs from the map.
    fn doubt(&self, filling: &Filling, monitor: &Terminal) {
        let (noise, clipped) = (filling.surface().noise(), filling.surface().clipped_variance());
        if noise > self.nugget.max(DOUBTFUL_NOISE) {
            monitor.warn(&format!(
                "in places, neighbouring heights differ more than the covariance says, as by noise of {noise:.0e} of the variance; \
                 what is filled in is that much smoother"
            ));
        }
        if clipped > DOUBTFUL_CLIPPING {
            monitor.warn(&format!(
                "the correlation reaches too far for a map of this size: {:.1} % of the variance was changed to draw it",
                100.0 * clipped
            ));
        }
    }

    fn unfilled(&self, error: &FillError) -> Failure {
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

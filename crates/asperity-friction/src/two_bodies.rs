//! Friction of two rough bodies: differences between parts, and the fluctuation along the path.
//!
//! A part of the slider carries its heights c(x) along, while the track t(x) passes under it. After the sliding distance s the gap
//! depends on t(x + s) + c(x). The friction F(x, s) of the window at x therefore has the covariance β + φ ρ(h) over sliding
//! distances h apart. β is the variance between parts, which is constant along the path, and φ ρ(h) is the covariance of the
//! fluctuation, with ρ(∞) = 0.
//!
//! The strips of a level are solved again with the track moved under the slider, and [`split()`] estimates β, φ and ρ.

mod distances;
pub(super) mod split;

use asperity_base::blocks::{Loop, Task};
use asperity_base::correlation::{Axis, axis_correlation_length_m};
use asperity_base::map::HeightMap;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_contact::{ContactWorkspace, Control};
use ndarray::{Array2, s};

pub use self::distances::DISTANCES;
use self::distances::Distances;
use self::split::{TwoBodyFriction, split};
use crate::FrictionError;
use crate::solved_level::SolvedLevel;
use crate::strip::{FailedStrip, Record, Strips};
use crate::window::Window;
use crate::window_contact::window_contacts;

impl TwoBodyFriction {
    /// Solves the strips of a level again, under the same control, with the track moved under the slider by up to [`DISTANCES`]
    /// distances; `None` unless both bodies are rough and the strips periodic.
    ///
    /// The surface is the track, the counterface the slider. Strips of ten windows are short: with a fixed mean pressure the
    /// covariance far apart may be negative by up to a tenth of φ, which then adds to φ and is missing in β.
    ///
    /// # Errors
    /// Fewer than 95 % of the strips converged at all distances, or the monitor cancelled.
    pub fn solve(
        strips: &Strips<'_>,
        level: &SolvedLevel,
        control: Control,
        monitor: &dyn Monitor,
    ) -> Result<Option<Self>, FrictionError> {
        let (grid, window) = (strips.problem.grid(), &level.window);
        let Some([track, _]) = bodies(strips, 0).filter(|_| strips.problem.is_periodic()) else { return Ok(None) };
        let track_length_m = axis_correlation_length_m(&track, Axis::X).ok().flatten();
        let distances = Distances::new(grid, window.length_m(), track_length_m);
        let failed = |index: &usize| level.strips.failures.iter().any(|failure| failure.index == *index);
        let solved: Vec<usize> = (0..strips.realisations).filter(|index| !failed(index)).collect();
        let task = Task::new(monitor, "friction of two bodies", solved.len() * distances.moved().len());
        let workspace = || strips.problem.half_space.workspace();
        let blocks = Loop {
            count: solved.len(),
            block_bytes: size_of::<Vec<Record>>() * distances.moved().len(),
            steps: distances.moved().len(),
            failure: |moved: &Result<Vec<Vec<Record>>, String>| moved.as_ref().err().cloned(),
        };
        let solve = |workspace: &mut ContactWorkspace, place: usize| -> Result<Result<Vec<_>, _>, Cancelled> {
            let records = distances
                .moved()
                .iter()
                .map(|cells| task.step(|| records_after(strips, solved[place], *cells, window, control, workspace)));
            records.collect()
        };
        let mut moved = Vec::with_capacity(solved.len());
        task.reduce(&blocks, workspace, solve, |_, records| moved.push(records))?;
        let mut failures = level.strips.failures.clone();
        let mut records = Vec::new();
        let resting = level.strips.records.chunks(level.strips.tracks);
        for ((index, moved), resting) in solved.into_iter().zip(moved).zip(resting) {
            match moved {
                Ok(moved) => records.push([vec![resting.to_vec()], moved].concat()),
                Err(reason) => failures.push(FailedStrip { index, reason }),
            }
        }
        strips.check_valid(&failures)?;
        Ok(Some(split(&deviations(&records), &distances, level.process.moments.std, window.length_m())))
    }
}

/// Returns the maps of the track and of the slider, as seen from outside; `None` unless both bodies are rough.
fn bodies(strips: &Strips<'_>, index: usize) -> Option<[HeightMap; 2]> {
    strips.surface.bodies(&strips.normal_variables(index))
}

/// Solves a strip after a sliding distance of a number of cells; returns the records of its tracks.
fn records_after(
    strips: &Strips<'_>,
    index: usize,
    cells: usize,
    window: &Window,
    control: Control,
    workspace: &mut ContactWorkspace,
) -> Result<Vec<Record>, String> {
    let [track, slider] = bodies(strips, index).ok_or("one body is smooth")?;
    let (track, slider) = (track.heights_m(), slider.heights_m().slice(s![.., ..;-1]));
    let heights_m = Array2::from_shape_fn(track.dim(), |(row, column)| {
        track[[row, (column + cells) % track.ncols()]] + slider[[row, column]]
    });
    let solution = strips.solution(&heights_m, control, None, workspace)?;
    let law = strips.problem.law.as_ref();
    let tracks = window_contacts(&solution, &[window], law.ploughs().then_some(&heights_m));
    Ok(tracks.concat().iter().map(|windows| Record::from_contacts(windows, law)).collect())
}

/// Returns the deviations (F − μ̄N)/N̄ of all windows by strip and distance, from their records by strip, distance and track.
fn deviations(records: &[Vec<Vec<Record>>]) -> Vec<Vec<Vec<f64>>> {
    let all: Vec<Record> = records.iter().flatten().flatten().cloned().collect();
    let (mean, linear) = Record::at_mean_load(&all);
    let mut linear = linear.into_iter();
    let mut of_tracks = |count: usize| -> Vec<f64> {
        linear.by_ref().take(count).flat_map(|record| record.friction).map(|friction| friction - mean).collect()
    };
    records.iter().map(|strip| strip.iter().map(|tracks| of_tracks(tracks.len())).collect()).collect()
}

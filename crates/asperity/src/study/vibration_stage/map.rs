//! Stability map of a study.

use super::clipping::clipping_warning;
use super::ensembles::Ensembles;
use crate::friction::process::FrictionProcess;
use crate::monitor::Monitor;
use crate::study::file::MapSection;
use crate::study::result::{MapResolutionResult, MapResult};
use crate::study::series::lines_table;
use crate::study::{StudyError, Table};
use crate::vibration::{
    EnsembleSettings, MapAxis, MapCell, MapPoint, MapResolution, MapSettings, StabilityMap, stability_map,
};

impl Ensembles<'_> {
    /// Returns the settings of a map.
    pub(super) fn map_settings(&self, section: &MapSection) -> MapSettings {
        let axis = |(from, to, cells)| MapAxis { from, to, cells };
        let ensemble = EnsembleSettings { trajectories: section.trajectories, sample_capacity: 0, ..self.settings() };
        MapSettings { x: axis(section.x), y: axis(section.y), depth: section.depth, ensemble }
    }

    /// Returns a warning about the points of a stability map at which friction is clipped.
    ///
    /// # Errors
    /// At a point of the first grid more friction is clipped than the study allows.
    pub(super) fn map_clipping(&self, map: &MapSection) -> Result<Option<String>, StudyError> {
        let upscaling = self.study.machine.upscaling;
        let found = self.map_settings(map).clipped_fraction(map.over, &self.oscillator, &self.model(upscaling))?;
        let largest = self.accepted(found, upscaling)?;
        Ok(clipping_warning(largest).map(|warning| format!("stability map: at the worst point, {warning}")))
    }

    /// Computes the map over the parameters of the study, with its main upscaling.
    pub(super) fn map(&self, section: &MapSection, monitor: &dyn Monitor) -> Result<StabilityMap, StudyError> {
        let friction = self.model(self.study.machine.upscaling);
        let machine = |x: f64, y: f64| {
            let (oscillator, model) = section.over.machine(&self.oscillator, &friction, [x, y])?;
            Ok((oscillator, model.map(FrictionProcess::new).transpose()?))
        };
        Ok(stability_map(&machine, &self.map_settings(section), monitor)?)
    }
}

/// Returns the named parameters and the resolution of a stability map.
pub fn map_result(map: &StabilityMap, [x, y]: [&str; 2]) -> MapResult {
    let MapResolution { x: width, y: height, unresolved_share } = map.resolution;
    MapResult { x: x.into(), y: y.into(), resolution: MapResolutionResult { x: width, y: height, unresolved_share } }
}

/// Returns the tables of a stability map over the named parameters: `map_points`, `map_cells`, `map_contours`, and the
/// end of vibration without fluctuation, `map_limit`.
pub fn stability_map_tables(map: &StabilityMap, [x, y]: [&str; 2]) -> Vec<(&'static str, Table)> {
    let of_points = |of: fn(&MapPoint) -> f64| map.points.iter().map(of).collect::<Vec<f64>>();
    let of_cells = |of: fn(&MapCell) -> f64| map.cells.iter().map(of).collect::<Vec<f64>>();
    let points = Table::new([
        (x, of_points(|p| p.x)),
        (y, of_points(|p| p.y)),
        ("sustained_share", of_points(|p| p.sustained.value)),
        ("sustained_share_low", of_points(|p| p.sustained.interval[0])),
        ("sustained_share_high", of_points(|p| p.sustained.interval[1])),
        ("trajectories", of_points(|p| p.trajectories as f64)),
        ("limit_damping_ratio", of_points(|p| p.limit_damping_ratio.unwrap_or(f64::NAN))),
    ]);
    let cells = Table::new([
        (format!("{x}_low"), of_cells(|c| c.x[0])),
        (format!("{x}_high"), of_cells(|c| c.x[1])),
        (format!("{y}_low"), of_cells(|c| c.y[0])),
        (format!("{y}_high"), of_cells(|c| c.y[1])),
        ("probability".to_owned(), of_cells(|c| c.probability)),
    ]);
    let contours = map.contours.iter().flat_map(|contour| contour.lines.iter().map(|line| (contour.level, line)));
    let limit = map.limit.iter().map(|line| (f64::NAN, line));
    vec![
        ("map_points", points),
        ("map_cells", cells),
        ("map_contours", lines_table([x, y], contours, true)),
        ("map_limit", lines_table([x, y], limit, false)),
    ]
}

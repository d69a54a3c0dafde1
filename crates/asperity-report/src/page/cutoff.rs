//! The table of friction over the shortest wavelength.

use asperity_results::{CutoffResult, ScanCutoff, ScanFriction};

use crate::cells::{DASH, percent, plain, shown};
use crate::format::Dimension;
use crate::page::data_table::DataTable;
use crate::run::RESULTS;

/// Returns one row per cut-off of the scan itself.
pub(super) fn of_scan(scan: &ScanFriction) -> DataTable {
    let length = |metre: f64| Dimension::Length.show(metre);
    let row = |of: &ScanCutoff| {
        let mean = shown(Dimension::None, of.mean, Some(of.mean_interval));
        let grid_error = of.grid_error.map_or_else(|| DASH.to_owned(), |error| plain(error, 2));
        vec![length(of.cutoff_m), mean, grid_error, plain(of.rms_slope, 3), percent(of.plastic_fraction, 3)]
    };
    let [x_m, y_m] = scan.size_m;
    let pitches: Vec<String> = scan.pitches_m.iter().map(|pitch_m| length(*pitch_m)).collect();
    let caption = format!(
        "Friction of the scan itself, {} × {}, pressed at the operating point on pitches of {}; brackets are the 95 % interval for the surface \
         of which it is a sample{}",
        length(x_m),
        length(y_m),
        pitches.join(", "),
        scan.slope_ratio
            .map_or_else(String::new, |ratio| format!("; a strip has {} times its rms slope", plain(ratio, 3))),
    );
    let headers = ["Shortest wave", "μ", "Error of the pitch", "Rms slope", "Contact at the hardness"];
    DataTable::new(&caption, &headers, scan.cut_offs.iter().map(row).collect(), RESULTS)
}

/// Returns one row per cut-off and one per smaller pitch; `None` without a cut-off.
pub(super) fn table(cutoff: &CutoffResult) -> Option<DataTable> {
    let length = |metre: f64| Dimension::Length.show(metre);
    let row = |cutoff_m: String, mean: f64, interval, [slope, plastic]: [String; 2]| {
        vec![cutoff_m, shown(Dimension::None, mean, interval), slope, plastic]
    };
    let points = cutoff.points.iter().map(|point| {
        let others = [plain(point.rms_slope, 3), percent(point.plastic_fraction, 3)];
        row(length(point.cutoff_m), point.mean, point.mean_interval, others)
    });
    let finer = cutoff.finer_pitches.iter().map(|finer| {
        let name = format!("{}, pitch of {}", length(cutoff.cutoff_m), length(finer.pitch_m));
        row(name, finer.mean, finer.mean_interval, [DASH; 2].map(str::to_owned))
    });
    if cutoff.points.is_empty() {
        return None;
    }
    let caption = format!(
        "Mean friction without the waves below a cut-off, at the mean pressure {} on strips of the pitch {}; brackets are 95 % \
         intervals",
        Dimension::Pressure.show(cutoff.mean_pressure_pa),
        length(cutoff.pitch_m)
    );
    let headers = ["Cut-off", "Mean μ", "Rms slope", "Contact at the hardness"];
    Some(DataTable::new(&caption, &headers, points.chain(finer).collect(), "tables/friction_cutoff.csv"))
}

//! The tables of friction over the shortest wavelength.

use asperity_results::{CutoffResult, ScanFriction};

use crate::page::answer_table::all;
use crate::page::data_table::DataTable;

/// Returns how the scan was pressed, and a row for each cut-off.
pub(super) fn of_scan(scan: &ScanFriction) -> [DataTable; 2] {
    [
        DataTable::of("The scan itself, pressed at the operating point", scan, all),
        DataTable::listed(
            "Friction of the scan itself without shorter waves; brackets are 95 % intervals",
            &scan.cut_offs,
            all,
        ),
    ]
}

/// Returns how the strips were solved, and a row for each cut-off and for each smaller pitch.
pub(super) fn tables(cutoff: &CutoffResult) -> [DataTable; 3] {
    [
        DataTable::of("Strips that are solved without their shortest waves", cutoff, |key| key != "known"),
        DataTable::listed("Mean friction without shorter waves; brackets are 95 % intervals", &cutoff.points, all),
        DataTable::listed("The same surface on smaller cells; brackets are 95 % intervals", &cutoff.finer_pitches, all),
    ]
}

//! Measured friction records in columns of text.

#![no_main]

use asperity::friction::measured::{Abscissa, ColumnTable, MeasuredRecord, RecordColumns, RecordPreparation};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    asperity_fuzz::bounded(16 * bytes.len(), || {
        let Ok(table) = ColumnTable::read(bytes) else { return };
        let columns = |abscissa| RecordColumns {
            column: "1".into(),
            unit: None,
            abscissa,
            velocity_m_per_s: Some(0.01),
            normal_force: None,
        };
        for abscissa in [
            Abscissa::Distance { column: "2".into(), unit: None },
            Abscissa::Time { column: "2".into(), unit: None },
        ] {
            let Ok(record) = MeasuredRecord::new(&table, &columns(abscissa)) else { continue };
            if let Ok(prepared) = RecordPreparation::default().apply(&record) {
                let step_m = prepared.record.step_m;
                assert!(step_m > 0.0 && step_m.is_finite());
            }
        }
    });
});

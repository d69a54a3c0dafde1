//! Stored blocks, their headers with the right checksum and with that of the file, and the records of runs.

#![no_main]

use asperity::study::{Computation, RunRecord, fuzzing};
use libfuzzer_sys::fuzz_target;
use sha2::{Digest, Sha256};

fuzz_target!(|bytes: &[u8]| {
    asperity_fuzz::bounded(8 * bytes.len(), || {
        fuzzing::read_blocks(bytes);
        // Changes of a header are seen by its checksum, but for one that fits.
        let mut file = b"asperity blocks1".to_vec();
        file.extend((bytes.len() as u64).to_le_bytes());
        file.extend(Sha256::digest(bytes));
        file.extend(bytes);
        fuzzing::read_blocks(&file);
    });
    if let Ok(record) = serde_json::from_slice::<RunRecord>(bytes) {
        let _ = Computation::of_record(&record);
    }
});

//! Large files that are as large as they declare, made to take time or memory.
//!
//! `ASPERITY_CRAFTED_MIB` sets their size (default 4).
#![expect(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

mod archives;
mod binary;
#[path = "../memory/mod.rs"]
mod memory;
mod texts;

use std::time::Instant;

use asperity_formats::read_bytes;

use memory::{TIME_LIMIT, peak_bytes_of_all_threads};

/// A file and its name.
type Crafted = (&'static str, Vec<u8>);

/// The most memory that a file may take beyond multiples of its size and of the number of its heights.
const FREE_BYTES: usize = 24 << 20;

#[test]
#[ignore = "slow"]
fn crafted_files_take_no_more_than_their_size_and_their_heights_justify() {
    let mib = std::env::var("ASPERITY_CRAFTED_MIB").map_or(4, |mib| mib.parse().unwrap());
    let size = mib << 20;
    for make in [texts::crafted, archives::crafted, binary::crafted] {
        for (name, bytes) in make(size) {
            let start = Instant::now();
            let (result, peak) = peak_bytes_of_all_threads(|| read_bytes(&bytes));
            let took = start.elapsed();
            let points = result.as_ref().map_or(0, |scan| scan.heights_m.len());
            // Texts are read in pieces, which are then joined: twice the heights, and room to grow.
            let limit = FREE_BYTES + 3 * bytes.len() + 24 * points;
            assert!(peak <= limit, "{name}: {peak} bytes for {} of input and {points} heights", bytes.len());
            assert!(took < TIME_LIMIT, "{name}: {took:?}");
            let longest = match &result {
                Ok(scan) => scan.warnings.iter().map(|warning| warning.chars().count()).max().unwrap_or(0),
                Err(error) => error.to_string().chars().count(),
            };
            assert!(longest <= 2000, "{name}: a message of {longest} characters");
        }
    }
}

//! Files of surfaces. The content decides the format; each format has seeds of its own.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // The scan or the error is the answer.
    let _ = asperity_fuzz::read_scan(bytes);
});

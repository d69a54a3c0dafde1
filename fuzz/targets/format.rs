//! Files of surfaces of one format, [`asperity_fuzz::is_wanted`].

#![no_main]

use libfuzzer_sys::{Corpus, fuzz_target};

fuzz_target!(|bytes: &[u8]| -> Corpus {
    if !asperity_fuzz::is_wanted(bytes) {
        return Corpus::Reject;
    }
    // The scan or the error is the answer.
    let _ = asperity_fuzz::read_scan(bytes);
    Corpus::Keep
});

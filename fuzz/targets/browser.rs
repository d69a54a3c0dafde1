//! Settings that the pages pass to the core as JSON texts: parts `machine`, `cycle`, `limits`, `surface`, or `settings` and `scan`.

#![no_main]

use asperity_wasm::fuzzing;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|input: &[u8]| {
    let parts = asperity_fuzz::parts(input);
    let scan = parts.iter().find(|(name, _)| name == "scan").map(|(_, part)| *part);
    for (name, part) in &parts {
        if let Ok(text) = std::str::from_utf8(part) {
            asperity_fuzz::bounded(input.len(), || fuzzing::answer(name, text, scan));
        }
    }
});

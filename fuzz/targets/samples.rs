//! Files of samples of uncertain values: numbers, and quantities of several dimensions.

#![no_main]

use asperity::study::fuzzing;
use libfuzzer_sys::fuzz_target;

/// Keys of a study file, with and without bounds and units.
const KEYS: [(&str, &str); 6] = [
    ("vibration", "spring_angles"),
    ("surface", "hurst"),
    ("surface", "rms_height"),
    ("material", "youngs_modulus"),
    ("vibration", "natural_frequency"),
    ("vibration", "stribeck"),
];

fuzz_target!(|text: &str| {
    for (section, name) in KEYS {
        let Some(input) = asperity_fuzz::bounded(text.len(), || fuzzing::read_samples(section, name, text)) else {
            continue;
        };
        let values = [-40.0, -1.0, 0.0, 1.0, 40.0].map(|g| input.value(g));
        assert!(values.is_sorted() && values.iter().all(|value| value.is_finite()), "{name}: {values:?}");
    }
});

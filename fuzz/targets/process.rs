//! Files of friction processes, which are read, written again, and simulated.

#![no_main]

use asperity::friction::process::{FittedProcess, FrictionProcess, Generator};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let Ok(process) = asperity_fuzz::bounded(text.len(), || FittedProcess::from_json(text)) else { return };
    let written = process.to_json().expect("a valid process can be written");
    assert_eq!(FittedProcess::from_json(&written).as_ref(), Ok(&process), "{written}");
    if process.generator == Some(Generator::Jacobi) {
        // Its table takes up to 13 seconds.
        return;
    }
    asperity_fuzz::bounded(text.len(), || {
        // With a step of its own, as for a machine, and with a fixed one.
        let model = process.model(1e-3).and_then(FrictionProcess::new);
        if let Ok(model) = model {
            let mut path = model.path(1, 0);
            assert!((0..3).all(|_| !path.next_value().is_nan()), "{process:?}");
        }
        if let Ok(values) = process.simulate(3e-5, 1e-5, 1, 0) {
            assert!(values.len() == 4 && values.iter().all(|mu| !mu.is_nan()), "{process:?}");
        }
    });
});

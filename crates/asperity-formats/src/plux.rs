//! PLUX.

use crate::format::{Codec, Description, Tested};
use crate::input::Input;
use crate::{Format, FormatError, ReadOptions, Scan};

pub(crate) const CODEC: Codec = Codec {
    description: Description {
        format: Format::Plux,
        name: "PLUX",
        extensions: &["plux"],
        vendor: "Sensofar",
        known_by: "",
        reads: "",
        writes: "",
        stores_pitch: true,
        missing_points: "",
        orientation: "",
        tested: Tested::Specification,
    },
    detect,
    read,
    write: None,
};

fn detect(_bytes: &[u8]) -> bool {
    false
}

fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Scan, FormatError> {
    Err(Input::new(Format::Plux, bytes).unsupported("a file", "another format"))
}

//! The files inside archives, whose checksums would hide every change from the readers behind them.

#![no_main]

use std::io::{Cursor, Write};

use libfuzzer_sys::fuzz_target;
use zip::CompressionMethod::Stored;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fuzz_target!(|input: &[u8]| {
    let parts = asperity_fuzz::parts(input);
    let bytes = match parts.as_slice() {
        [(name, content)] if name == "gzip" => gzip(content),
        parts => zip(parts),
    };
    if let Some(bytes) = bytes {
        let _ = asperity_fuzz::read_scan(&bytes);
    }
});

fn gzip(content: &[u8]) -> Option<Vec<u8>> {
    let mut stream = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::none());
    stream.write_all(content).ok()?;
    stream.finish().ok()
}

/// Returns an archive; `None` if it cannot hold files of these names.
fn zip(files: &[(String, &[u8])]) -> Option<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(name.as_str(), SimpleFileOptions::default().compression_method(Stored)).ok()?;
        archive.write_all(content).ok()?;
    }
    Some(archive.finish().ok()?.into_inner())
}

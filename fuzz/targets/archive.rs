//! The files inside archives of one format, [`asperity_fuzz::is_wanted`]. The checksums of archives would hide every change from the
//! readers behind them.

#![no_main]

use std::io::{Cursor, Write};

use libfuzzer_sys::{Corpus, fuzz_target};
use zip::CompressionMethod::Stored;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

fuzz_target!(|input: &[u8]| -> Corpus {
    let parts = asperity_fuzz::parts(input);
    let (bytes, content) = match parts.as_slice() {
        [(name, content)] if name == "gzip" => (gzip(content), Some(*content)),
        parts => (zip(parts), None),
    };
    let Some(bytes) = bytes.filter(|bytes| asperity_fuzz::is_wanted(content.unwrap_or(bytes))) else {
        return Corpus::Reject;
    };
    let _ = asperity_fuzz::read_scan(&bytes);
    Corpus::Keep
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

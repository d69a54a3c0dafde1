//! gzip streams around other formats.

use crate::check::assert_error;
use crate::fixture::{Content, Fixture, read_bytes};
use crate::fixtures::{Sur, TEXT, gzip};

pub(crate) fn fixtures() -> Vec<Fixture> {
    let sur = Content::Gzip(Sur::default().bytes());
    let needed = sur.bytes().len();
    vec![Fixture { name: "gzip of SUR", content: sur, needed }]
}

#[test]
fn a_gzip_stream_is_read_like_its_content() {
    let plain = read_bytes(TEXT).unwrap();
    let packed = read_bytes(&gzip(TEXT)).unwrap();
    assert_eq!(crate::bits(&plain), crate::bits(&packed));
    assert_eq!(plain.metadata, packed.metadata);
}

#[test]
fn the_content_of_a_gzip_stream_decides_and_not_its_names() {
    let folder = tempfile::tempdir().unwrap();
    let sur = Sur::default().bytes();
    // The name in the stream, that of its file, and the content.
    for (inner, name, content) in [
        ("map.xyz", "map.txt.gz", &sur[..]),
        ("map.txt", "map.xyz.gz", &sur),
        ("map.sur", "map.sur.gz", TEXT),
        ("map.npy", "map.csv", TEXT),
    ] {
        let mut stream = flate2::GzBuilder::new().filename(inner).write(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut stream, content).unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, stream.finish().unwrap()).unwrap();
        let (packed, plain) = (asperity_formats::read(&path).unwrap(), read_bytes(content).unwrap());
        assert_eq!((packed.format, crate::bits(&packed)), (plain.format, crate::bits(&plain)), "{name}");
    }
}

#[test]
fn a_gzip_stream_in_another_is_read_and_a_third_refused() {
    assert_eq!(crate::bits(&read_bytes(&gzip(&gzip(TEXT))).unwrap()), crate::bits(&read_bytes(TEXT).unwrap()));
    assert_error(read_bytes(&gzip(&gzip(&gzip(TEXT)))), "unknown format");
}

#[test]
fn a_damaged_gzip_stream_is_reported() {
    let mut bytes = gzip(TEXT);
    let end = bytes.len();
    // The checksum is eight bytes before the end (RFC 1952).
    bytes[end - 8] ^= 1;
    assert!(read_bytes(&bytes).unwrap_err().to_string().starts_with("gzip: stream: "));
}

#[test]
fn a_gzip_stream_that_is_cut_off_is_described() {
    let bytes = gzip(TEXT);
    assert_error(
        read_bytes(&bytes[..bytes.len() / 2]),
        "gzip: stream: the compressed stream ends early; the file is cut off",
    );
}

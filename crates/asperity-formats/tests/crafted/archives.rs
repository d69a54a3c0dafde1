//! Archives and compressed streams.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;

use crate::Crafted;
use crate::binary::npy;

/// An archive of files as they are.
fn stored(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in files {
        zip.start_file(name.as_str(), options).unwrap();
        zip.write_all(content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// An X3P file of `layers` of one height, with `more` in its description and the text `list` in place of a link.
fn x3p(more: &str, (columns, layers): (usize, usize), list: Option<&str>) -> Vec<(String, Vec<u8>)> {
    let axis = |name: &str, kind: &str| {
        format!("<{name}><AxisType>{kind}</AxisType><DataType>D</DataType><Increment>1e-6</Increment></{name}>")
    };
    let link = list.map_or("<DataLink><PointDataLink>data.bin</PointDataLink></DataLink>".into(), |list| {
        format!("<DataList>{list}</DataList>")
    });
    let main = format!(
        "<a><Record1><FeatureType>SUR</FeatureType><Axes>{}{}{}</Axes></Record1>{more}<Record3><MatrixDimension>\
         <SizeX>{columns}</SizeX><SizeY>1</SizeY><SizeZ>{layers}</SizeZ></MatrixDimension>{link}</Record3></a>",
        axis("CX", "I"),
        axis("CY", "I"),
        axis("CZ", "A")
    );
    vec![("main.xml".into(), main.into_bytes()), ("data.bin".into(), vec![0; 8 * layers])]
}

/// The same with a description in other bytes.
fn recoded(more: &str, code: impl Fn(&str) -> Vec<u8>) -> Vec<u8> {
    let mut files = x3p(more, (1, 1), None);
    files[0].1 = code(std::str::from_utf8(&files[0].1).unwrap());
    stored(&files)
}

pub(crate) fn crafted(size: usize) -> Vec<Crafted> {
    let described = |more: &str| stored(&x3p(more, (1, 1), None));
    let gzip = |content: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    };
    // Paths that agree in their first thousand bytes are compared in full.
    let names = ["n".repeat(40), "m".repeat(40)];
    let deep = |inner: &str| {
        let open: String = names.iter().cycle().take(20).map(|name| format!("<{name}>")).collect();
        let close: String = names.iter().rev().cycle().take(20).map(|name| format!("</{name}>")).collect();
        format!("{open}{inner}{close}")
    };
    let paths: String = (0..16_000).map(|number| format!("<b{number}>x</b{number}>")).collect();
    let layer = "<LAYER_0><FILENAME_Z>a.raw</FILENAME_Z></LAYER_0>";
    let plux = (0..16_000).map(|number| layer.replace('0', &number.to_string())).collect::<String>();
    let general = "<GENERAL><IMAGE_SIZE_X>1</IMAGE_SIZE_X><IMAGE_SIZE_Y>1</IMAGE_SIZE_Y></GENERAL>";
    let plux = format!("<xml>{general}{plux}</xml>").into_bytes();
    let array = npy("<f8", false, (1, 1), &[0; 8]);
    let long_names =
        (0..size / 15_000).take(1000).map(|n| (format!("{n:04}{}.npy", "n".repeat(14_000)), array.clone()));
    vec![
        ("X3P with a long text", described(&format!("<a>{}</a>", "x".repeat(size)))),
        (
            "X3P with a text in Latin-1",
            recoded(&format!("<a>{}</a>", "é".repeat(size)), |text| {
                text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect()
            }),
        ),
        (
            "X3P with a text in UTF-16",
            recoded(&format!("<a>{}</a>", "€".repeat(size / 2)), |text| {
                [vec![0xff, 0xfe], text.encode_utf16().flat_map(u16::to_le_bytes).collect()].concat()
            }),
        ),
        ("X3P of empty elements", described(&"<a/>".repeat(size / 4))),
        ("X3P of equal elements", described(&"<a>x</a>".repeat(size / 8))),
        ("X3P of entities", described(&format!("<a>{}</a>", "&lt;".repeat(size / 4)))),
        ("X3P of deep elements", described(&deep(&(paths + &"<b8000>x</b8000>".repeat(size / 16))))),
        ("X3P of a list without numbers", stored(&x3p("", (size / 8, 1), Some(&"<Datum/>".repeat(size / 8))))),
        ("X3P with 4096 layers", stored(&x3p("", (1, 4096), None))),
        ("PLUX with 16000 layers", stored(&[("index.xml".into(), plux), ("a.raw".into(), vec![0; 4])])),
        (
            "a zip archive of many files",
            stored(&(0..size / 128).map(|n| (n.to_string(), Vec::new())).collect::<Vec<_>>()),
        ),
        ("NPZ with long names", stored(&long_names.collect::<Vec<_>>())),
        ("gzip of text", gzip(&b"1.25 -0.5 7\n".repeat(size / 12))),
        ("gzip streams", gzip(b"1 ").repeat(size / 22)),
        ("gzip streams of nothing", gzip(b"").repeat(size / 20)),
    ]
}

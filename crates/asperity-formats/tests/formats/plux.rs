use asperity_formats::{Format, FormatError};

use crate::check::{assert_error, assert_no_warning, assert_pitch, assert_refused, assert_scan, assert_warns, bytes};
use crate::fixture::{Content, Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata};

/// Variable parts of a PLUX file. The rest is as written by the program SensoSCAN.
struct Plux {
    size: (u32, u32),
    pitch: &'static str,
    layers: &'static str,
    folder: &'static str,
}

impl Default for Plux {
    fn default() -> Self {
        Self {
            size: (3, 2),
            pitch: "<FOV_X>5</FOV_X><FOV_Y>2.5</FOV_Y>",
            layers: "<LAYER_0><FILENAME_STACK>LAYER_0.stack.raw</FILENAME_STACK><FILENAME_Z>LAYER_0.raw</FILENAME_Z>\
                     <POSITION_X>12.5</POSITION_X></LAYER_0>",
            folder: "",
        }
    }
}

const OF_TWO_LAYERS: &str = "<LAYER_10><FILENAME_Z>LAYER_10.raw</FILENAME_Z></LAYER_10>\
                             <LAYER_1><FILENAME_STACK>LAYER_1.stack.raw</FILENAME_STACK></LAYER_1>\
                             <LAYER_2><FILENAME_Z>LAYER_2.raw</FILENAME_Z></LAYER_2>";

impl Plux {
    fn index(&self) -> String {
        format!(
            r#"<?xml version="1.0" encoding="utf-8"?>
<xml>
  <GENERAL>
    <AUTHOR>A. Operator</AUTHOR>
    <DATE>2024-01-02 03:04:05</DATE>
    {}
    <IMAGE_SIZE_X>{}</IMAGE_SIZE_X>
    <IMAGE_SIZE_Y>{}</IMAGE_SIZE_Y>
  </GENERAL>
  <INFO>
    <SIZE>2</SIZE>
    <ITEM_0><NAME>Device</NAME><VALUE>S neox</VALUE></ITEM_0>
    <ITEM_1><NAME>Technique</NAME><VALUE>Confocal</VALUE></ITEM_1>
  </INFO>
  {}
</xml>
"#,
            self.pitch, self.size.0, self.size.1, self.layers
        )
    }

    fn content(&self) -> Content {
        let heights = bytes![[1.5_f32, f32::NAN, -3.0, 1_000_001.0, f32::INFINITY, 0.0]];
        let file = |name: &str, bytes: Vec<u8>| (format!("{}{name}", self.folder), bytes);
        Content::Zip(vec![
            file("LAYER_0.raw", heights.clone()),
            file("LAYER_0.stack.raw", vec![9; 18]),
            file("LAYER_2.raw", bytes![[2.0_f32; 6]]),
            file("LAYER_10.raw", bytes![[10.0_f32; 6]]),
            file("index.xml", self.index().into_bytes()),
            file("./recipe.txt", b"<xml/>".to_vec()),
        ])
    }

    fn bytes(&self) -> Vec<u8> {
        self.content().bytes()
    }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let fixture = |name, plux: &Plux| {
        let content = plux.content();
        Fixture { name, needed: content.bytes().len(), content }
    };
    vec![
        fixture("PLUX of one layer", &Plux::default()),
        fixture("PLUX of two layers in a folder", &Plux { layers: OF_TWO_LAYERS, folder: "a/", ..Plux::default() }),
    ]
}

#[test]
fn heights_are_micrometres_in_rows_of_x() {
    let heights = [1.5e-6, NAN, -3e-6, NAN, NAN, 0.0];
    let scan = assert_scan(&Plux::default().bytes(), Format::Plux, (2, 3), (5e-6, 2.5e-6), &heights);
    assert_no_warning(&scan);
    let wanted = [
        ("Device", "S neox"),
        ("Technique", "Confocal"),
        ("GENERAL/AUTHOR", "A. Operator"),
        ("GENERAL/DATE", "2024-01-02 03:04:05"),
        ("LAYER_0/POSITION_X", "12.5"),
    ];
    assert_metadata(&scan, &wanted);
    assert!(!scan.metadata.contains_key("INFO/ITEM_0/NAME") && !scan.metadata.contains_key("INFO/ITEM_0/VALUE"));
}

#[test]
fn the_field_of_view_by_name_is_the_side_of_a_pixel_in_micrometres() {
    for (pitch, pitch_m, words) in [
        ("<FOV_X>0.138</FOV_X><FOV_Y>0.138</FOV_Y>", Some((0.138e-6, 0.138e-6)), ""),
        // Like the numbers of points.
        ("<FOV_X>300</FOV_X><FOV_Y>200</FOV_Y>", Some((3e-4, 2e-4)), "sides of the field"),
        ("<FOV_X>0.5</FOV_X>", None, "no pixel size"),
    ] {
        let scan = read_bytes(&Plux { pitch, ..Plux::default() }.bytes()).unwrap();
        assert_pitch(&scan, pitch_m);
        if !words.is_empty() {
            assert_warns(&scan, words);
        }
    }
}

#[test]
fn layers_with_heights_are_channels_in_the_order_of_their_numbers() {
    let bytes = Plux { layers: OF_TWO_LAYERS, ..Plux::default() }.bytes();
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!(scan.channels, ["LAYER_2", "LAYER_10"]);
    assert_heights(&scan, &[2e-6; 6]);
    for channel in ["2", "layer_10"] {
        let scan = read_channel(&bytes, channel).unwrap();
        assert_heights(&scan, &[10e-6; 6]);
        assert_eq!(scan.channel, 1);
    }
    assert_error(read_channel(&bytes, "LAYER_1"), "PLUX: no height map");
}

#[test]
fn dimensions_and_layers_that_are_not_there_are_refused() {
    let of_size = |size| Plux { size, ..Plux::default() }.bytes();
    let of_layers = |layers| Plux { layers, ..Plux::default() }.bytes();
    assert_refused([
        (of_size((3, 3)), "PLUX: the numbers (LAYER_0.raw, byte 0) stop after 24 bytes; wanted 36"),
        (of_size((0, 2)), "PLUX: GENERAL/IMAGE_SIZE_X ("),
        (of_size((u32::MAX, 2)), "the limit is"),
        (of_layers("<LAYER_0><FILENAME_Z>gone.raw</FILENAME_Z></LAYER_0>"), "gone.raw: no such file"),
        (of_layers("<LAYER_0><FILENAME_STACK>LAYER_0.stack.raw</FILENAME_STACK></LAYER_0>"), "FILENAME_Z"),
    ]);
}

#[test]
fn an_index_without_a_layer_is_refused_as_plux_and_other_indexes_are_not_plux() {
    let archive = |index: String| Content::Zip(vec![("index.xml".into(), index.into_bytes())]).bytes();
    let plux = archive(Plux { layers: "", ..Plux::default() }.index());
    assert_eq!(Format::detect(&plux), Some(Format::Plux));
    assert_refused([(plux, "PLUX: no layer of index.xml has heights (LAYER_n/FILENAME_Z)")]);
    assert_ne!(Format::detect(&archive("<xml><GENERAL/></xml>".into())), Some(Format::Plux));
}

#[test]
fn long_paths_cannot_fill_the_memory() {
    // Every element costs its path again: these 2 MiB would take 17 GiB.
    let name = "n".repeat(1 << 17);
    let leaves: String = (0..1 << 17).map(|leaf| format!("<a{leaf}>1</a{leaf}>")).collect();
    let layers = format!("<{name}>{leaves}</{name}>");
    let index = Plux::default().index().replace("</xml>", &format!("{layers}</xml>"));
    let files = vec![("index.xml".to_owned(), index.into_bytes()), ("LAYER_0.raw".to_owned(), vec![0; 24])];
    let bytes = Content::Zip(files).bytes();
    let (error, peak) = crate::memory::peak_bytes(|| read_bytes(&bytes).unwrap_err());
    assert!(matches!(error, FormatError::Xml { .. }), "{error}");
    assert!(peak < (64 << 20) + 2 * bytes.len(), "{peak}");
}

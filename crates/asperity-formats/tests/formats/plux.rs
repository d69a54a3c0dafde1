use asperity_formats::{Channel, Format, FormatError, ReadOptions};

use crate::check::assert_error;
use crate::fixture::{Content, Fixture, read_bytes, read_bytes_with, read_channel};
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

fn raw(heights_um: &[f32]) -> Vec<u8> {
    heights_um.iter().flat_map(|z| z.to_le_bytes()).collect()
}

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
        let heights = raw(&[1.5, f32::NAN, -3.0, 1_000_001.0, f32::INFINITY, 0.0]);
        let file = |name: &str, bytes: Vec<u8>| (format!("{}{name}", self.folder), bytes);
        Content::Zip(vec![
            file("LAYER_0.raw", heights.clone()),
            file("LAYER_0.stack.raw", vec![9; 18]),
            file("LAYER_2.raw", raw(&[2.0; 6])),
            file("LAYER_10.raw", raw(&[10.0; 6])),
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
    let scan = read_bytes(&Plux::default().bytes()).unwrap();
    assert_eq!(Format::detect(&Plux::default().bytes()), Some(Format::Plux));
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[1.5e-6, NAN, -3e-6, NAN, NAN, 0.0]);
    assert_eq!(scan.warnings, [] as [String; 0]);
}

#[test]
fn the_field_of_view_by_name_is_the_side_of_a_pixel_in_micrometres() {
    let scan = read_bytes(&Plux::default().bytes()).unwrap();
    assert_eq!(scan.pitch_m, Some((5e-6, 2.5e-6)));
    let pitch = "<FOV_X>0.138</FOV_X><FOV_Y>0.138</FOV_Y>";
    let (dx_m, dy_m) = read_bytes(&Plux { pitch, ..Plux::default() }.bytes()).unwrap().pitch_m.unwrap();
    assert_eq!(dx_m, dy_m);
    assert!((dx_m / 0.138e-6 - 1.0).abs() < 1e-15);
}

#[test]
fn sides_like_the_numbers_of_points_give_a_warning() {
    let pitch = "<FOV_X>300</FOV_X><FOV_Y>200</FOV_Y>";
    let scan = read_bytes(&Plux { pitch, ..Plux::default() }.bytes()).unwrap();
    assert_eq!(scan.pitch_m, Some((3e-4, 2e-4)));
    assert!(scan.warnings.iter().any(|warning| warning.contains("sides of the field")), "{:?}", scan.warnings);
}

#[test]
fn a_pixel_size_that_is_not_there_is_left_out_with_a_warning() {
    let scan = read_bytes(&Plux { pitch: "<FOV_X>0.5</FOV_X>", ..Plux::default() }.bytes()).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings.iter().any(|warning| warning.contains("no pixel size")), "{:?}", scan.warnings);
}

#[test]
fn layers_with_heights_are_channels_in_the_order_of_their_numbers() {
    let bytes = Plux { layers: OF_TWO_LAYERS, ..Plux::default() }.bytes();
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!(scan.channels, ["LAYER_2", "LAYER_10"]);
    assert_heights(&scan, &[2e-6; 6]);
    for channel in [Channel::Number(2), Channel::Name("layer_10".into())] {
        let scan = read_bytes_with(&bytes, &ReadOptions { channel: Some(channel), ..ReadOptions::default() }).unwrap();
        assert_heights(&scan, &[10e-6; 6]);
        assert_eq!(scan.channel, 1);
    }
    assert_error(read_channel(&bytes, "LAYER_1"), "no height map");
}

#[test]
fn items_are_kept_by_their_names_and_the_rest_by_their_paths() {
    let scan = read_bytes(&Plux::default().bytes()).unwrap();
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
fn layers_without_heights_are_refused_with_a_reason() {
    let layers = "<LAYER_0><FILENAME_STACK>LAYER_0.stack.raw</FILENAME_STACK></LAYER_0>";
    let error = read_bytes(&Plux { layers, ..Plux::default() }.bytes()).unwrap_err();
    assert!(matches!(error, FormatError::Unsupported { format: Format::Plux, .. }), "{error}");
    assert!(error.to_string().contains("FILENAME_Z"), "{error}");
}

#[test]
fn dimensions_that_exceed_the_file_are_errors() {
    let of_size = |size| read_bytes(&Plux { size, ..Plux::default() }.bytes());
    assert_error(of_size((3, 3)), "PLUX: the numbers (LAYER_0.raw, byte 0) stop after 24 bytes; wanted 36");
    assert!(matches!(of_size((0, 2)), Err(FormatError::Field { field, .. }) if field == "GENERAL/IMAGE_SIZE_X"));
    assert!(matches!(of_size((u32::MAX, 2)), Err(FormatError::TooLarge { .. })));
    let layers = "<LAYER_0><FILENAME_Z>gone.raw</FILENAME_Z></LAYER_0>";
    assert_error(read_bytes(&Plux { layers, ..Plux::default() }.bytes()), "gone.raw: no such file");
}

#[test]
fn an_index_without_a_layer_is_refused_as_plux_and_other_indexes_are_not_plux() {
    let archive = |index: String| Content::Zip(vec![("index.xml".into(), index.into_bytes())]).bytes();
    let plux = archive(Plux { layers: "", ..Plux::default() }.index());
    assert_eq!(Format::detect(&plux), Some(Format::Plux));
    assert_error(read_bytes(&plux), "PLUX: no layer of index.xml has heights (LAYER_n/FILENAME_Z)");
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

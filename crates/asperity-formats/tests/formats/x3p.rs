use asperity_formats::{Format, FormatError, MAX_POINTS, Scan, write_x3p};
use ndarray::array;

use crate::fixture::{Content, Fixture, read_bytes, read_channel, unsupported};
use crate::fixtures::{X3p, md5, zip};
use crate::memory::peak_bytes;
use crate::{NAN, assert_heights, assert_metadata};

fn le<const N: usize>(numbers: impl IntoIterator<Item = [u8; N]>) -> Vec<u8> {
    numbers.into_iter().flatten().collect()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let masked = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>I</DataType><Increment>1e-9</Increment>",
        data: vec![1; 8],
        valid: Some(vec![0b1101]),
        folder: "a/",
        ..X3p::default()
    };
    let fixture = |name, x3p: &X3p| {
        let content = Content::Zip(x3p.files(x3p.main_xml().as_bytes()));
        Fixture { name, needed: content.bytes().len(), content }
    };
    let packed = write_x3p(&Scan::new(array![[1e-6, f64::NAN]], Some((1e-6, 1e-6)))).unwrap();
    vec![
        fixture("X3P of float64", &X3p::default()),
        fixture("X3P of int16 with a mask in a folder", &masked),
        fixture("X3P of three layers of int32", &layered()),
        Fixture::whole("X3P with deflated files", packed),
    ]
}

#[test]
fn doubles_without_increment_are_metres_in_rows_of_x() {
    let scan = read_bytes(
        &X3p {
            size: (3, 2, 1),
            data: le([1., 2., 3., 4., 5., 6.].map(|z: f64| (z * 1e-6).to_le_bytes())),
            ..X3p::default()
        }
        .bytes(),
    )
    .unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_eq!(scan.heights_m[[1, 0]], 4.0 * 1e-6);
    assert_eq!(scan.pitch_m, Some((2.5e-6, 5e-6)));
    assert_eq!(scan.warnings, [] as [String; 0]);
}

#[test]
fn int16_is_signed_scaled_shifted_and_masked_from_the_lowest_bit() {
    let file = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>I</DataType><Increment>1e-9</Increment><Offset>5e-9</Offset>",
        size: (5, 2, 1),
        data: le([-32768_i16, -1, 0, 1, 32767, 10, 20, 30, 40, 50].map(i16::to_le_bytes)),
        // Points 3 and 8 are not valid.
        valid: Some(vec![0b1111_0111, 0b0000_0010]),
        ..X3p::default()
    };
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_heights(&scan, &[-32763e-9, 4e-9, 5e-9, NAN, 32772e-9, 15e-9, 25e-9, 35e-9, NAN, 55e-9]);
    assert!(scan.warnings.iter().all(|warning| warning.contains("field of view")), "{:?}", scan.warnings);
}

#[test]
fn int32_is_signed_and_scaled() {
    let file = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>L</DataType><Increment>1e-15</Increment>",
        data: le([i32::MIN, -1, 0, i32::MAX].map(i32::to_le_bytes)),
        ..X3p::default()
    };
    let scan = read_bytes(&file.bytes()).unwrap();
    assert_heights(&scan, &[-2147483648e-15, -1e-15, 0.0, 2147483647e-15]);
}

#[test]
fn integers_of_a_program_that_writes_unsigned_ones_are_unsigned() {
    let file = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>I</DataType><Increment>1e-12</Increment>",
        size: (2, 1, 1),
        data: le([0_u16, 65535].map(u16::to_le_bytes)),
        ..X3p::default()
    };
    let main = file.main_xml().replace("Meyer &amp; S&#246;hne", "SurfaceTopography");
    let scan = read_bytes(&file.with_main(main.as_bytes())).unwrap();
    assert_heights(&scan, &[0.0, 65535e-12]);
    assert!(scan.warnings.iter().any(|warning| warning.contains("unsigned")), "{:?}", scan.warnings);
    assert_heights(&read_bytes(&file.bytes()).unwrap(), &[0.0, -1e-12]);
}

#[test]
fn nan_and_infinities_of_floats_are_missing_and_increments_apply() {
    let file = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>F</DataType><Increment>1E-6</Increment><Offset>1e-6</Offset>",
        size: (3, 2, 1),
        data: le([0.5_f32, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -2.0, 4.0].map(f32::to_le_bytes)),
        ..X3p::default()
    };
    assert_heights(&read_bytes(&file.bytes()).unwrap(), &[1.5e-6, NAN, NAN, NAN, -1e-6, 5e-6]);
}

#[test]
fn a_validity_file_masks_floats_too() {
    let scan = read_bytes(&X3p { valid: Some(vec![0b1101]), ..X3p::default() }.bytes()).unwrap();
    assert_heights(&scan, &[1e-6, NAN, 3e-6, 4e-6]);
}

#[test]
fn prefixes_do_not_matter() {
    let file = X3p::default();
    let plain = file.main_xml().replace("p:ISO5436_2", "ISO5436").replace("xmlns:p=", "xmlns=");
    let prefixed = file.main_xml().replace("</p:", "</").replace("<p:", "<");
    let prefixed = prefixed.replace("</", "<|").replace('<', "<q:").replace("<q:|", "</q:");
    let prefixed = prefixed.replace("<q:?", "<?").replace("<q:!", "<!").replace("<q: ", "< ");
    for main in [plain, prefixed] {
        let scan = read_bytes(&file.with_main(main.as_bytes())).unwrap();
        assert_heights(&scan, &[1e-6, 2e-6, 3e-6, 4e-6]);
        assert_eq!(scan.warnings, [] as [String; 0], "{main}");
        assert_eq!(scan.metadata["Record2/Comment"], "a < b");
    }
}

#[test]
fn main_xml_may_be_utf16_or_latin1() {
    let file = X3p::default();
    let main = file.main_xml().replace("UTF-8", "UTF-16");
    let utf16: Vec<u8> = [0xfeff].into_iter().chain(main.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let latin1: Vec<u8> = file.main_xml().chars().map(|c| u8::try_from(c).unwrap()).collect();
    for main in [utf16, latin1] {
        let scan = read_bytes(&file.with_main(&main)).unwrap();
        assert_heights(&scan, &[1e-6, 2e-6, 3e-6, 4e-6]);
        assert_eq!(scan.metadata["Record2/Instrument/Model"], "µSurf");
    }
}

#[test]
fn files_may_be_in_a_folder_beside_files_of_desktops() {
    let file = X3p { folder: "land 1/", ..X3p::default() };
    let main = file.main_xml();
    let checksum = format!("{} *main.xml", md5(main.as_bytes()));
    let bytes = zip(&[
        ("__MACOSX/main.xml", b"\x00\x05\x16\x07"),
        ("land 1/", b""),
        ("land 1/bindata\\data.bin", &file.data),
        ("land 1/md5checksum.hex", checksum.as_bytes()),
        ("land 1/main.xml", main.as_bytes()),
        ("land 1/old/main.xml", b"<not this/>"),
    ]);
    for bytes in [file.bytes(), bytes] {
        let scan = read_bytes(&bytes).unwrap();
        assert_heights(&scan, &[1e-6, 2e-6, 3e-6, 4e-6]);
        assert_eq!(scan.warnings, [] as [String; 0]);
    }
}

#[test]
fn links_may_start_with_a_dot_or_a_slash() {
    let file = X3p::default();
    for link in ["./bindata/data.bin", "/bindata/data.bin", "bindata\\data.bin", "BinData/Data.BIN"] {
        let main = file.main_xml().replace("bindata/data.bin", link);
        assert_heights(&read_bytes(&file.with_main(main.as_bytes())).unwrap(), &[1e-6, 2e-6, 3e-6, 4e-6]);
    }
}

#[test]
fn a_wrong_checksum_is_a_warning() {
    let file = X3p { valid: Some(vec![0b1111]), ..X3p::default() };
    let main = file.main_xml();
    for (part, stated) in [("bindata/data.bin", md5(&file.data)), ("bindata/valid.bin", md5(&[0b1111]))] {
        let main = main.replace(&stated.to_uppercase(), "00112233445566778899AABBCCDDEEFF");
        let scan = read_bytes(&file.with_main(main.as_bytes())).unwrap();
        assert!(matches!(scan.warnings.as_slice(), [one] if one.starts_with(part)), "{:?}", scan.warnings);
        assert_heights(&scan, &[1e-6, 2e-6, 3e-6, 4e-6]);
    }
    let changed = main.replace("2007", "2017");
    let bytes = zip(&[
        ("main.xml", changed.as_bytes()),
        ("bindata/data.bin", &file.data),
        ("bindata/valid.bin", &[0b1111]),
        ("md5checksum.hex", format!("{} *main.xml", md5(main.as_bytes())).as_bytes()),
    ]);
    let scan = read_bytes(&bytes).unwrap();
    assert!(matches!(scan.warnings.as_slice(), [one] if one.starts_with("main.xml")), "{:?}", scan.warnings);
}

#[test]
fn a_missing_checksum_file_is_a_warning() {
    let file = X3p::default();
    let bytes = zip(&[("main.xml", file.main_xml().as_bytes()), ("bindata/data.bin", &file.data)]);
    let scan = read_bytes(&bytes).unwrap();
    assert!(matches!(scan.warnings.as_slice(), [one] if one.contains("could not be verified")), "{:?}", scan.warnings);
}

#[test]
fn the_checksum_file_may_hold_the_sum_alone_or_sums_of_other_files() {
    let file = X3p::default();
    let main = file.main_xml();
    let sum = md5(main.as_bytes());
    let warnings = |checksum: String| {
        let files =
            [("main.xml", main.as_bytes()), ("bindata/data.bin", &file.data), ("md5checksum.hex", checksum.as_bytes())];
        read_bytes(&zip(&files)).unwrap().warnings
    };
    for fits in
        [sum.clone(), format!("{}\r\n", sum.to_uppercase()), format!("00 *bindata/data.bin\n{sum}  ./main.xml\n")]
    {
        assert_eq!(warnings(fits), [] as [String; 0]);
    }
    for absent in [String::new(), format!("{} *bindata/data.bin\n", md5(&file.data))] {
        let found = warnings(absent);
        assert!(found.iter().any(|one| one.contains("main.xml")), "{found:?}");
    }
}

/// Returns three layers of 2 × 3 numbers in nanometre: the hundreds are the layer, the tens the line, the ones the
/// column. Point (1, 0) of the second layer is not valid: bit 6 + 3, across a border of bytes.
fn layered() -> X3p {
    let numbers = [11, 12, 13, 21, 22, 23].map(|point| [100, 200, 300].map(|layer| layer + point));
    X3p {
        z_axis: "<AxisType>A</AxisType><DataType>L</DataType><Increment>1e-9</Increment>",
        size: (3, 2, 3),
        data: le((0..18).map(|n| i32::to_le_bytes(numbers[n % 6][n / 6]))),
        valid: Some(vec![0xff, 0b1111_1101, 0b11]),
        ..X3p::default()
    }
}

#[test]
fn layers_are_channels_each_with_its_own_numbers_and_validity() {
    let bytes = layered().bytes();
    let read = |text: &str| read_channel(&bytes, text).unwrap();
    assert_heights(&read("layer 1"), &[111e-9, 112e-9, 113e-9, 121e-9, 122e-9, 123e-9]);
    assert_heights(&read("2"), &[211e-9, 212e-9, 213e-9, NAN, 222e-9, 223e-9]);
    assert_heights(&read("Layer 3"), &[311e-9, 312e-9, 313e-9, 321e-9, 322e-9, 323e-9]);
    for text in ["1", "2", "3"] {
        let scan = read(text);
        assert_eq!(scan.channels, ["layer 1", "layer 2", "layer 3"]);
        assert_eq!((scan.channel + 1).to_string(), text);
        assert_eq!(scan.warnings, [] as [String; 0]);
    }
    let first = read_bytes(&bytes).unwrap();
    assert_eq!(first.heights_m, read("1").heights_m);
    assert!(matches!(first.warnings.as_slice(), [one] if one.contains("3 height maps")), "{:?}", first.warnings);
    for absent in ["0", "4", "height"] {
        let error = read_channel(&bytes, absent).unwrap_err();
        assert!(matches!(error, FormatError::NoSuchChannel { .. }), "{error}");
    }
}

#[test]
fn layers_that_the_data_do_not_reach_are_errors_when_asked_for() {
    let mut file = layered();
    file.data.truncate(4 * 14);
    let bytes = file.bytes();
    let scan = read_channel(&bytes, "2").unwrap();
    assert!(
        matches!(scan.warnings.as_slice(), [one] if one.contains("shorter than the stated 3")),
        "{:?}",
        scan.warnings
    );
    match read_channel(&bytes, "3") {
        Err(FormatError::Truncated { part, found: 8, wanted: 24, .. }) => assert_eq!(part, "the numbers"),
        other => panic!("{other:?}"),
    }
    let cut_mask = X3p { valid: Some(vec![0xff]), ..layered() }.bytes();
    assert!(read_channel(&cut_mask, "1").is_ok());
    match read_channel(&cut_mask, "2") {
        Err(FormatError::Truncated { part, found: 1, wanted: 2, .. }) => assert_eq!(part, "the validity bits"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn more_layers_than_any_instrument_stacks_are_refused() {
    let error = read_bytes(&X3p { size: (2, 2, 1 << 40), ..X3p::default() }.bytes()).unwrap_err();
    assert!(matches!(error, FormatError::TooLarge { field, .. } if field.ends_with("SizeZ")));
}

#[test]
fn a_single_point_is_read() {
    let scan =
        read_bytes(&X3p { size: (1, 1, 1), data: 7e-6_f64.to_le_bytes().into(), ..X3p::default() }.bytes()).unwrap();
    assert_eq!(scan.heights_m.dim(), (1, 1));
    assert_heights(&scan, &[7e-6]);
}

#[test]
fn profiles_point_clouds_and_absolute_axes_are_refused_with_a_reason() {
    let cases = [
        (X3p { feature: "PRF", ..X3p::default() }, "profile"),
        (X3p { feature: "PCL", ..X3p::default() }, "point cloud"),
        (X3p { x_axis_type: "A", ..X3p::default() }, "CX is absolute"),
    ];
    for (file, reason) in cases {
        let found = unsupported(&file.bytes());
        assert!(found.contains(reason), "{found}");
    }
}

#[test]
fn lists_of_points_are_refused_by_name_also_where_the_description_holds_them() {
    // Points of three coordinates in the description, as the schema has them; the third case lists the heights of profiles.
    let list = "<ListDimension>2</ListDimension><DataList><Datum>0;0;1e-6</Datum><Datum>1e-6;0;2e-6</Datum></DataList>";
    for (feature, x_axis_type, reason) in [
        ("PCL", "A", "a point cloud (PCL)"),
        ("SUR", "A", "CX is absolute"),
        ("SUR", "I", "a list of points (ListDimension)"),
    ] {
        let file = X3p { feature, x_axis_type, ..X3p::default() };
        let main = file.main_xml();
        let (head, rest) = main.split_once("<MatrixDimension>").unwrap();
        let (_, tail) = rest.split_once("</DataLink>").unwrap();
        let order = if reason.contains("absolute") {
            format!("{head}<MatrixDimension>{}", rest.split_once("<DataLink>").unwrap().0)
        } else {
            head.into()
        };
        let main = format!("{order}{list}{tail}");
        let files = file.files(main.as_bytes());
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
        let message = read_bytes(&crate::fixtures::zip(&files)).unwrap_err().to_string();
        assert!(message.starts_with("X3P: the ") && message.contains(reason), "{message}");
    }
}

#[test]
fn a_data_list_in_the_description_is_read() {
    let file = X3p {
        z_axis: "<AxisType>A</AxisType><DataType>I</DataType><Increment>0.001</Increment><Offset>-0.5</Offset>",
        ..X3p::default()
    };
    let main = file.main_xml();
    let (head, rest) = main.split_once("<DataLink>").unwrap();
    let (_, tail) = rest.split_once("</DataLink>").unwrap();
    let with_list = |list: &str| file.with_main(format!("{head}<DataList>{list}</DataList>{tail}").as_bytes());
    let list = "<Datum>986</Datum>\n<Datum> -308 </Datum><Datum/><!-- none --><Datum>1548</Datum>";
    assert_heights(&read_bytes(&with_list(list)).unwrap(), &[0.486, -0.808, NAN, 1.048]);
    let layered = file.main_xml().replace("<SizeX>2<", "<SizeX>1<").replace("<SizeZ>1<", "<SizeZ>2<");
    let (head, rest) = layered.split_once("<DataLink>").unwrap();
    let (_, tail) = rest.split_once("</DataLink>").unwrap();
    let bytes = file.with_main(format!("{head}<DataList>{list}</DataList>{tail}").as_bytes());
    assert_heights(&read_channel(&bytes, "1").unwrap(), &[0.486, -0.808]);
    assert_heights(&read_channel(&bytes, "2").unwrap(), &[NAN, 1.048]);
    assert!(matches!(
        read_bytes(&with_list("<Datum>986</Datum>")),
        Err(FormatError::Field { field, found, wanted, .. })
            if field.ends_with("Datum") && found == "1 values" && wanted == "4 values"
    ));
    assert!(matches!(
        read_bytes(&with_list("<Datum>986;1;2</Datum>")),
        Err(FormatError::Field { found, .. }) if found == "986;1;2"
    ));
}

#[test]
fn data_that_end_early_are_an_error_and_data_that_go_on_a_warning() {
    match read_bytes(&X3p { size: (3, 2, 1), ..X3p::default() }.bytes()) {
        Err(FormatError::Truncated { part, found: 32, wanted: 48, .. }) => assert_eq!(part, "the numbers"),
        other => panic!("{other:?}"),
    }
    let scan = read_bytes(&X3p { size: (3, 1, 1), ..X3p::default() }.bytes()).unwrap();
    assert_heights(&scan, &[1e-6, 2e-6, 3e-6]);
    assert!(matches!(scan.warnings.as_slice(), [one] if one.contains("longer than")), "{:?}", scan.warnings);
    assert!(matches!(
        read_bytes(&X3p { valid: Some(Vec::new()), ..X3p::default() }.bytes()),
        Err(FormatError::Truncated { part, found: 0, wanted: 1, .. }) if part == "the validity bits"
    ));
}

#[test]
fn declared_sizes_are_not_believed() {
    for size in [(1 << 28, 2, 1), (u64::MAX >> 1, u64::MAX >> 1, 1)] {
        assert!(matches!(
            read_bytes(&X3p { size, ..X3p::default() }.bytes()),
            Err(FormatError::TooLarge { limit: MAX_POINTS, .. })
        ));
    }
    assert!(matches!(
        read_bytes(&X3p { size: (1 << 14, 1 << 14, 1), ..X3p::default() }.bytes()),
        Err(FormatError::Truncated { found: 32, .. })
    ));
    for size in [(0, 2, 1), (u64::MAX, 1, 1), (2, 2, 0)] {
        assert!(matches!(
            read_bytes(&X3p { size, ..X3p::default() }.bytes()),
            Err(FormatError::Field { field, .. }) if field.contains("MatrixDimension/Size")
        ));
    }
}

#[test]
fn damaged_descriptions_are_errors_that_name_their_place() {
    let file = X3p::default();
    let main = file.main_xml();
    let damaged = [
        main.replace("</Record1>", "</Record9>"),
        main.replace("&amp;", "&lol;"),
        main[..main.len() / 2].to_owned(),
        "<a>".repeat(100_000),
    ];
    for main in damaged {
        assert!(matches!(
            read_bytes(&file.with_main(main.as_bytes())),
            Err(FormatError::Xml { format: Format::X3p, .. })
        ));
    }
    let error = read_bytes(&file.with_main(main.replace("<SizeX>2<", "<SizeX>two<").as_bytes())).unwrap_err();
    assert!(error.to_string().starts_with("X3P: Record3/MatrixDimension/SizeX (main.xml, byte "), "{error}");
    assert!(error.to_string().ends_with("is `two`; wanted a whole number"), "{error}");
    let error = read_bytes(&file.with_main(main.replace("DataType>D", "DataType>X").as_bytes())).unwrap_err();
    assert!(error.to_string().contains("Record1/Axes/CZ/DataType") && error.to_string().contains("`X`"), "{error}");
    let error = read_bytes(&file.with_main(main.replace("bindata/data.bin", "a/b.bin").as_bytes())).unwrap_err();
    assert!(error.to_string().contains("a/b.bin: no such file"), "{error}");
}

#[test]
fn a_zip_archive_is_known_by_main_xml() {
    for other in ["a.npy", "domain.xml", "main.xm"] {
        let bytes = zip(&[(other, b"\x93NUMPY")]);
        assert_ne!(Format::detect(&bytes), Some(Format::X3p), "{other}");
    }
    for folder in ["", "a/", "a b\\"] {
        let bytes = X3p { folder, ..X3p::default() }.bytes();
        assert_eq!(Format::detect(&bytes), Some(Format::X3p));
        // An archive that was cut off is still named.
        assert_eq!(Format::detect(&bytes[..100]), Some(Format::X3p));
        let error = read_bytes(&bytes[..100]).unwrap_err();
        assert!(matches!(&error, FormatError::Archive { .. }), "{error}");
    }
}

#[test]
fn increments_of_zero_give_a_warning() {
    let file = |z_axis, data: Vec<u8>| X3p { z_axis, size: (2, 1, 1), data, ..X3p::default() }.bytes();
    let read = |bytes: &[u8], expected: &str| {
        let scan = read_bytes(bytes).unwrap();
        assert!(scan.warnings.iter().any(|warning| warning.contains(expected)), "{expected}: {:?}", scan.warnings);
        scan
    };
    let integers = le([-3_i16, 5].map(i16::to_le_bytes));
    let floats = le([1e-6_f32, 2e-6].map(f32::to_le_bytes));
    let whole = read(&file("<AxisType>A</AxisType><DataType>I</DataType>", integers.clone()), "no increment");
    assert_heights(&whole, &[-3.0, 5.0]);
    let none = "<AxisType>A</AxisType><DataType>F</DataType><Increment>0</Increment>";
    assert_heights(&read(&file(none, floats.clone()), "is 0"), &[f64::from(1e-6_f32), f64::from(2e-6_f32)]);
    let incremental = "<AxisType>I</AxisType><DataType>F</DataType>";
    assert_heights(&read(&file(incremental, floats), "incremental"), &[f64::from(1e-6_f32), f64::from(2e-6_f32)]);
    let none = "<AxisType>A</AxisType><DataType>I</DataType><Increment>0</Increment>";
    let error = read_bytes(&file(none, integers)).unwrap_err();
    assert!(matches!(&error, FormatError::Field { field, .. } if field.ends_with("CZ/Increment")), "{error}");
}

#[test]
fn the_first_line_is_the_top_one_and_another_origin_gives_a_warning() {
    let file = X3p { size: (1, 4, 1), ..X3p::default() };
    let with_origin = |origin: &str| {
        let main = file.main_xml().replace("</Axes>", &format!("<Origin>{origin}</Origin></Axes>"));
        read_bytes(&file.with_main(main.as_bytes())).unwrap()
    };
    assert_heights(&with_origin("NW"), &[1e-6, 2e-6, 3e-6, 4e-6]);
    assert_eq!(with_origin("NW").warnings, read_bytes(&file.bytes()).unwrap().warnings);
    assert_heights(&with_origin("SW"), &[1e-6, 2e-6, 3e-6, 4e-6]);
    assert!(with_origin("SW").warnings.iter().any(|warning| warning.contains("origin `SW`")));
}

#[test]
fn metadata_are_kept_by_their_path() {
    let scan = read_bytes(&X3p::default().bytes()).unwrap();
    let wanted = [
        ("Record1/Axes/CX/Offset", "1e-3"),
        ("Record1/Revision", "ISO5436 - 2000"),
        ("Record2/Date", "2007-04-30T13:58:02.6+02:00"),
        ("Record2/Instrument/Manufacturer", "Meyer & Söhne"),
        ("Record2/Comment", "a < b"),
    ];
    assert_metadata(&scan, &wanted);
    assert!(!scan.metadata.contains_key("Record1/Axes/CY/Offset"));
}

#[test]
fn an_axis_without_increment_leaves_the_pitch_out() {
    let file = X3p::default();
    let scan =
        read_bytes(&file.with_main(file.main_xml().replace("<Increment> 5e-6 </Increment>", "").as_bytes())).unwrap();
    assert_eq!(scan.pitch_m, None);
    assert_eq!(scan.warnings.len(), 1);
}

#[test]
fn descriptions_that_would_take_more_memory_than_they_are_long_are_refused() {
    let many = (0..100_000).map(|n| format!("<e{n}>1</e{n}>")).collect::<String>();
    let long = "x".repeat(100_000);
    let mains = [
        (format!("<a>{many}</a>"), "different elements"),
        (format!("<a><{long}>{many}</{long}></a>"), "names of more than"),
    ];
    for (main, reason) in mains {
        let bytes = X3p::default().with_main(main.as_bytes());
        let (error, peak) = peak_bytes(|| read_bytes(&bytes).unwrap_err());
        assert!(error.to_string().contains(reason), "{error}");
        assert!(peak < 4 * bytes.len(), "{peak} bytes for {}", bytes.len());
    }
}

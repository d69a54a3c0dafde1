use asperity_formats::{Format, FormatError, Scan, write_x3p};
use ndarray::array;

use crate::check::{
    Raw, assert_error, assert_no_warning, assert_one_warning, assert_refused, assert_scan, assert_warns, bytes,
};
use crate::fixture::{Content, Fixture, read_bytes, read_channel};
use crate::fixtures::{X3p, md5, zip};
use crate::memory::peak_bytes;
use crate::{NAN, assert_heights, assert_metadata};

/// The description of an absolute axis with heights of a type, and more elements.
macro_rules! z_axis {
    ($data_type:literal $($more:literal)?) => {
        concat!("<AxisType>A</AxisType><DataType>", $data_type, "</DataType>" $(, $more)?)
    };
}

const HEIGHTS: [f64; 4] = [1e-6, 2e-6, 3e-6, 4e-6];

fn x3p(z_axis: &'static str, (columns, rows): (u64, u64), numbers: impl Raw) -> X3p {
    X3p { z_axis, size: (columns, rows, 1), data: bytes![numbers], ..X3p::default() }
}

/// The file of the default heights with another description.
fn described(change: impl FnOnce(String) -> String) -> Vec<u8> {
    let file = X3p::default();
    file.with_main(change(file.main_xml()).as_bytes())
}

/// A text in which another stands from `start` on and before `end`.
fn between(text: &str, start: &str, end: &str, new: &str) -> String {
    let (head, rest) = text.split_once(start).unwrap();
    format!("{head}{new}{}", rest.split_once(end).unwrap().1)
}

fn read(bytes: &[u8]) -> Scan {
    read_bytes(bytes).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let scaled = x3p(z_axis!("I" "<Increment>1e-9</Increment>"), (2, 2), [1_u8; 8]);
    let masked = X3p { valid: Some(vec![0b1101]), folder: "a/", ..scaled };
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
    let heights = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].map(|z: f64| z * 1e-6);
    let bytes = X3p { size: (3, 2, 1), data: bytes![heights], ..X3p::default() }.bytes();
    let scan = assert_scan(&bytes, Format::X3p, (2, 3), (2.5e-6, 5e-6), &heights);
    assert_no_warning(&scan);
    let wanted = [
        ("Record1/Axes/CX/Offset", "1e-3"),
        ("Record1/Revision", "ISO5436 - 2000"),
        ("Record2/Date", "2007-04-30T13:58:02.6+02:00"),
        ("Record2/Instrument/Manufacturer", "Meyer & Söhne"),
        ("Record2/Comment", "a < b"),
    ];
    assert_metadata(&scan, &wanted);
    assert!(!scan.metadata.contains_key("Record1/Axes/CY/Offset"));
    let point = X3p { size: (1, 1, 1), data: bytes![7e-6], ..X3p::default() };
    assert_scan(&point.bytes(), Format::X3p, (1, 1), (2.5e-6, 5e-6), &[7e-6]);
    // An axis without an increment.
    let scan = read(&described(|main| main.replace("<Increment> 5e-6 </Increment>", "")));
    assert_eq!((scan.pitch_m, scan.warnings.len()), (None, 1));
}

#[test]
fn numbers_are_scaled_and_shifted_and_masked_from_the_lowest_bit() {
    let offset = z_axis!("I" "<Increment>1e-9</Increment><Offset>5e-9</Offset>");
    let file = x3p(offset, (5, 2), [-32768_i16, -1, 0, 1, 32767, 10, 20, 30, 40, 50]);
    // Points 3 and 8 are not valid.
    let scan = read(&X3p { valid: Some(vec![0b1111_0111, 0b0000_0010]), ..file }.bytes());
    assert_heights(&scan, &[-32763e-9, 4e-9, 5e-9, NAN, 32772e-9, 15e-9, 25e-9, 35e-9, NAN, 55e-9]);
    assert!(scan.warnings.iter().all(|warning| warning.contains("field of view")), "{:?}", scan.warnings);
    let long = x3p(z_axis!("L" "<Increment>1e-15</Increment>"), (2, 2), [i32::MIN, -1, 0, i32::MAX]);
    assert_heights(&read(&long.bytes()), &[-2147483648e-15, -1e-15, 0.0, 2147483647e-15]);
    // NaN and infinities of floats are missing, and a validity file masks floats too.
    let numbers = [0.5, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -2.0, 4.0];
    let float = x3p(z_axis!("F" "<Increment>1E-6</Increment><Offset>1e-6</Offset>"), (3, 2), numbers);
    assert_heights(&read(&float.bytes()), &[1.5e-6, NAN, NAN, NAN, -1e-6, 5e-6]);
    let masked = X3p { valid: Some(vec![0b1101]), ..X3p::default() };
    assert_heights(&read(&masked.bytes()), &[1e-6, NAN, 3e-6, 4e-6]);
}

#[test]
fn integers_of_a_program_that_writes_unsigned_ones_are_unsigned() {
    let file = x3p(z_axis!("I" "<Increment>1e-12</Increment>"), (2, 1), [0_u16, 65535]);
    let main = file.main_xml().replace("Meyer &amp; S&#246;hne", "SurfaceTopography");
    let scan = read(&file.with_main(main.as_bytes()));
    assert_heights(&scan, &[0.0, 65535e-12]);
    assert_warns(&scan, "unsigned");
    assert_heights(&read(&file.bytes()), &[0.0, -1e-12]);
}

#[test]
fn descriptions_may_have_any_prefix_encoding_and_spelling_of_links() {
    let main = X3p::default().main_xml();
    let plain = main.replace("p:ISO5436_2", "ISO5436").replace("xmlns:p=", "xmlns=");
    let prefixed = main.replace("</p:", "</").replace("<p:", "<");
    let prefixed = prefixed.replace("</", "<|").replace('<', "<q:").replace("<q:|", "</q:");
    let prefixed = prefixed.replace("<q:?", "<?").replace("<q:!", "<!").replace("<q: ", "< ");
    let utf16 = main.replace("UTF-8", "UTF-16");
    let utf16 = [0xfeff].into_iter().chain(utf16.encode_utf16());
    let latin1 = main.chars().map(|c| u8::try_from(c).unwrap());
    let links = ["./bindata/data.bin", "/bindata/data.bin", "bindata\\data.bin", "BinData/Data.BIN"];
    let mut mains = vec![plain.into(), prefixed.into(), utf16.flat_map(u16::to_le_bytes).collect(), latin1.collect()];
    mains.extend(links.map(|link| main.replace("bindata/data.bin", link).into_bytes()));
    for main in mains {
        let scan = read(&X3p::default().with_main(&main));
        assert_heights(&scan, &HEIGHTS);
        assert_no_warning(&scan);
        assert_metadata(&scan, &[("Record2/Comment", "a < b"), ("Record2/Instrument/Model", "µSurf")]);
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
        assert_no_warning(&assert_scan(&bytes, Format::X3p, (2, 2), (2.5e-6, 5e-6), &HEIGHTS));
    }
}

#[test]
fn wrong_and_missing_checksums_are_warnings() {
    let file = X3p { valid: Some(vec![0b1111]), ..X3p::default() };
    let main = file.main_xml();
    for (part, stated) in [("bindata/data.bin", md5(&file.data)), ("bindata/valid.bin", md5(&[0b1111]))] {
        let main = main.replace(&stated.to_uppercase(), "00112233445566778899AABBCCDDEEFF");
        let scan = read(&file.with_main(main.as_bytes()));
        assert_one_warning(&scan, part);
        assert_heights(&scan, &HEIGHTS);
    }
    let main = X3p::default().main_xml();
    let files = [("main.xml", main.as_bytes()), ("bindata/data.bin", file.data.as_slice())];
    assert_one_warning(&read(&zip(&files)), "could not be verified");
    let (sum, other) = (md5(main.as_bytes()), md5(&file.data));
    for (checksum, words) in [
        (sum.clone(), ""),
        (format!("{}\r\n", sum.to_uppercase()), ""),
        (format!("00 *bindata/data.bin\n{sum}  ./main.xml\n"), ""),
        (format!("{other} *main.xml"), "main.xml"),
        (String::new(), "main.xml"),
        (format!("{other} *bindata/data.bin\n"), "main.xml"),
    ] {
        let files = [files[0], files[1], ("md5checksum.hex", checksum.as_bytes())];
        let scan = read(&zip(&files));
        if words.is_empty() { assert_no_warning(&scan) } else { assert_one_warning(&scan, words) }
    }
}

/// Returns three layers of 2 × 3 numbers in nanometre: the hundreds are the layer, the tens the line, the ones the
/// column. Point (1, 0) of the second layer is not valid: bit 6 + 3, across a border of bytes.
fn layered() -> X3p {
    let numbers = [100, 200, 300].map(|layer| [11, 12, 13, 21, 22, 23].map(|point| layer + point));
    let file = x3p(z_axis!("L" "<Increment>1e-9</Increment>"), (3, 2), numbers);
    X3p { size: (3, 2, 3), valid: Some(vec![0xff, 0b1111_1101, 0b11]), ..file }
}

#[test]
fn layers_are_channels_each_with_its_own_numbers_and_validity() {
    let bytes = layered().bytes();
    for (names, heights_nm) in [
        (["layer 1", "1"], [111.0, 112.0, 113.0, 121.0, 122.0, 123.0]),
        (["Layer 2", "2"], [211.0, 212.0, 213.0, NAN, 222.0, 223.0]),
        (["Layer 3", "3"], [311.0, 312.0, 313.0, 321.0, 322.0, 323.0]),
    ] {
        for name in names {
            let scan = read_channel(&bytes, name).unwrap();
            assert_heights(&scan, &heights_nm.map(|z| z * 1e-9));
            assert_eq!(scan.channels, ["layer 1", "layer 2", "layer 3"]);
            assert_eq!((scan.channel + 1).to_string(), names[1]);
            assert_no_warning(&scan);
        }
    }
    let first = read(&bytes);
    assert_eq!(first.heights_m, read_channel(&bytes, "1").unwrap().heights_m);
    assert_one_warning(&first, "3 height maps");
    for absent in ["0", "4", "height"] {
        assert_error(read_channel(&bytes, absent), "no height map");
    }
    // Layers that the data do not reach are errors when asked for.
    let mut file = layered();
    file.data.truncate(4 * 14);
    assert_one_warning(&read_channel(&file.bytes(), "2").unwrap(), "shorter than the stated 3");
    assert_error(
        read_channel(&file.bytes(), "3"),
        "the numbers (bindata/data.bin, byte 48) stop after 8 bytes; wanted 24",
    );
    let cut = X3p { valid: Some(vec![0xff]), ..layered() }.bytes();
    assert!(read_channel(&cut, "1").is_ok());
    assert_error(read_channel(&cut, "2"), "the validity bits (bindata/valid.bin, byte 0) stop after 1 bytes; wanted 2");
}

#[test]
fn a_profile_of_one_line_is_a_single_row() {
    let profile = X3p { feature: "PRF", size: (4, 1, 1), ..X3p::default() };
    let scan = read(&profile.bytes());
    assert_heights(&scan, &HEIGHTS);
    assert!(scan.is_profile());
    let main =
        between(&profile.main_xml(), "<CY>", "</CY>", "<CY><AxisType>I</AxisType></CY>").replace("</CY></CY>", "</CY>");
    let scan = read(&profile.with_main(main.as_bytes()));
    assert_eq!(scan.pitch_m.map(|(step_m, across_m)| step_m == across_m), Some(true));
}

#[test]
fn profiles_points_and_absolute_axes_are_refused_with_a_reason() {
    let cases = [
        ("PRF", "I", "a profile (PRF) of several lines"),
        ("PCL", "I", "a point cloud (PCL)"),
        ("SUR", "A", "CX is absolute"),
    ];
    for (feature, x_axis_type, reason) in cases {
        assert_refused([(X3p { feature, x_axis_type, ..X3p::default() }.bytes(), reason)]);
    }
    // Points of three coordinates in the description, as the schema has them; the third case lists the heights of profiles.
    let list = "<ListDimension>2</ListDimension><DataList><Datum>0;0;1e-6</Datum><Datum>1e-6;0;2e-6</Datum></DataList>";
    for (feature, x_axis_type, start, reason) in [
        ("PCL", "A", "<MatrixDimension>", "a point cloud (PCL)"),
        ("SUR", "A", "<DataLink>", "CX is absolute"),
        ("SUR", "I", "<MatrixDimension>", "a list of points (ListDimension)"),
    ] {
        let file = X3p { feature, x_axis_type, ..X3p::default() };
        let files = file.files(between(&file.main_xml(), start, "</DataLink>", list).as_bytes());
        let files: Vec<(&str, &[u8])> = files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
        assert_refused([(zip(&files), reason)]);
    }
}

#[test]
fn a_data_list_in_the_description_is_read() {
    let file = x3p(z_axis!("I" "<Increment>0.001</Increment><Offset>-0.5</Offset>"), (2, 2), [] as [u8; 0]);
    let with_list = |main: &str, list: &str| {
        let list = format!("<DataList>{list}</DataList>");
        file.with_main(between(main, "<DataLink>", "</DataLink>", &list).as_bytes())
    };
    let (main, list) =
        (file.main_xml(), "<Datum>986</Datum>\n<Datum> -308 </Datum><Datum/><!-- none --><Datum>1548</Datum>");
    assert_heights(&read(&with_list(&main, list)), &[0.486, -0.808, NAN, 1.048]);
    let layered = with_list(&main.replace("<SizeX>2<", "<SizeX>1<").replace("<SizeZ>1<", "<SizeZ>2<"), list);
    assert_heights(&read_channel(&layered, "1").unwrap(), &[0.486, -0.808]);
    assert_heights(&read_channel(&layered, "2").unwrap(), &[NAN, 1.048]);
    assert_refused([
        (with_list(&main, "<Datum>986</Datum>"), "is `1 values`; wanted 4 values"),
        (with_list(&main, "<Datum>986;1;2</Datum>"), "is `986;1;2`"),
    ]);
}

#[test]
fn sizes_and_data_that_do_not_fit_each_other_are_refused() {
    let sized = |columns, rows, layers| X3p { size: (columns, rows, layers), ..X3p::default() }.bytes();
    assert_refused([
        (sized(3, 2, 1), "the numbers (bindata/data.bin, byte 0) stop after 32 bytes; wanted 48"),
        (sized(1 << 14, 1 << 14, 1), "stop after 32 bytes"),
        (
            X3p { valid: Some(vec![]), ..X3p::default() }.bytes(),
            "the validity bits (bindata/valid.bin, byte 0) stop after 0",
        ),
        (sized(1 << 28, 2, 1), "the limit is 268435456"),
        (sized(u64::MAX >> 1, u64::MAX >> 1, 1), "the limit is 268435456"),
        (sized(2, 2, 1 << 40), "is 1099511627776; the limit is"),
        (sized(0, 2, 1), "MatrixDimension/Size"),
        (sized(u64::MAX, 1, 1), "MatrixDimension/Size"),
        (sized(2, 2, 0), "MatrixDimension/Size"),
    ]);
    let scan = read(&sized(3, 1, 1));
    assert_heights(&scan, &[1e-6, 2e-6, 3e-6]);
    assert_one_warning(&scan, "longer than");
}

#[test]
fn damaged_descriptions_are_errors_that_name_their_place() {
    let (file, main) = (X3p::default(), X3p::default().main_xml());
    let damaged = [
        main.replace("</Record1>", "</Record9>"),
        main.replace("&amp;", "&lol;"),
        main[..main.len() / 2].to_owned(),
        "<a>".repeat(100_000),
    ];
    for main in damaged {
        let error = read_bytes(&file.with_main(main.as_bytes())).unwrap_err();
        assert!(matches!(error, FormatError::Xml { format: Format::X3p, .. }), "{error}");
    }
    for (from, to, start, end) in [
        (
            "<SizeX>2<",
            "<SizeX>two<",
            "Record3/MatrixDimension/SizeX (main.xml, byte ",
            "is `two`; wanted a whole number",
        ),
        ("DataType>D", "DataType>X", "Record1/Axes/CZ/DataType", "is `X`"),
        ("bindata/data.bin", "a/b.bin", "a/b.bin: ", "no such file"),
    ] {
        let bytes = described(|main| main.replace(from, to));
        assert_refused([(&bytes, start), (&bytes, end)]);
    }
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
        assert!(matches!(read_bytes(&bytes[..100]), Err(FormatError::Archive { .. })));
    }
}

#[test]
fn doubtful_axes_give_a_warning() {
    let (integers, floats) = (bytes![[-3_i16, 5]], bytes![[1e-6_f32, 2e-6]]);
    let single = [1e-6_f32, 2e-6].map(f64::from);
    for (z_axis, data, words, heights) in [
        (z_axis!("I"), &integers, "no increment", [-3.0, 5.0]),
        (z_axis!("F" "<Increment>0</Increment>"), &floats, "is 0", single),
        ("<AxisType>I</AxisType><DataType>F</DataType>", &floats, "incremental", single),
    ] {
        let scan = read(&x3p(z_axis, (2, 1), data).bytes());
        assert_warns(&scan, words);
        assert_heights(&scan, &heights);
    }
    assert_refused([(x3p(z_axis!("I" "<Increment>0</Increment>"), (2, 1), integers).bytes(), "CZ/Increment (")]);
    // The first line is the top one, whichever origin is stated.
    let file = X3p { size: (1, 4, 1), ..X3p::default() };
    let usual = read(&file.bytes()).warnings;
    for (origin, is_reported) in [("NW", false), ("SW", true)] {
        let main = file.main_xml().replace("</Axes>", &format!("<Origin>{origin}</Origin></Axes>"));
        let scan = read(&file.with_main(main.as_bytes()));
        assert_heights(&scan, &HEIGHTS);
        assert_eq!(scan.warnings == usual, !is_reported);
        assert_eq!(crate::check::warns(&scan, "origin `SW`"), is_reported);
    }
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
        let (result, peak) = peak_bytes(|| read_bytes(&bytes));
        assert_error(result, reason);
        assert!(peak < 4 * bytes.len(), "{peak} bytes for {}", bytes.len());
    }
}

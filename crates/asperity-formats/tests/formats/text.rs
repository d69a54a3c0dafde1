use asperity_formats::{Format, FormatError, ReadOptions, Scan};

use crate::check::{
    assert_error, assert_no_warning, assert_one_warning, assert_pitch, assert_refused, assert_scan, assert_warns,
};
use crate::fixture::{Fixture, read_bytes, read_bytes_with, read_channel, read_in_metre};
use crate::fixtures::TEXT;
use crate::{NAN, assert_heights, assert_metadata};

/// As Gwyddion exports data fields with a header.
const GWYDDION: &str = "# Channel: Topography\n# Width: 3.0 µm\n# Height: 1.00 µm\n# Value units: m\n\
    1e-09\t2e-09\t3e-09\n4e-09\t5e-09\t6e-09\n";
/// Export of SPIP: lengths in nanometre; after the heights a map with 1 for missing points.
const SPIP: &str = "# File Format = ASCII\r\n# Created by SPIP 4.6.5.0\r\n# x-pixels = 3\r\n# y-pixels = 2\r\n\
    # x-length = 30\r\n# y-length = 10\r\n# x-offset = 0\r\n# Bit2nm = 0.5\r\n# voidpixels = 1\r\n\
    # Start of Data:\r\n1\t2\t3\r\n4\t5\t6\r\n0\t0\t0\r\n0\t1\t0\r\n";
/// An ESRI grid.
const ESRI: &str = "ncols 3\nnrows 2\nxllcorner 0.0\nyllcorner 0.0\ncellsize 0.5e-6\nNODATA_value -9999\n\
    1e-9 2e-9 3e-9\n4e-9 -9999 6e-9\n";
const DECIMAL_COMMAS: &str = "# unit: nm\n1,5;-2,5;3\n4,25E0;;6\n";

/// Returns two of Gwyddion's channels in one file, and one that is not a height.
fn two_channels() -> String {
    let phase = GWYDDION.replace("Topography", "Phase").replace("Value units: m", "Value units: deg");
    let zoom = "# Channel: Zoom\n# Width: 4 nm\n# Height: 2 nm\n# Value units: nm\n1 2\n";
    format!("{GWYDDION}\n{phase}\n{zoom}")
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::open_ended("text", TEXT.to_vec()),
        Fixture::open_ended("text of Gwyddion", GWYDDION.into()),
        Fixture::open_ended("text of two channels", two_channels().into_bytes()),
        Fixture::open_ended("text of SPIP", SPIP.into()),
        Fixture::open_ended("text of ESRI", ESRI.into()),
        Fixture::open_ended("text with decimal commas", DECIMAL_COMMAS.into()),
    ]
}

fn read(text: &str) -> Scan {
    read_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{text:?}: {error}"))
}

const MATRIX: &str = "1 2 3\n4 5 6\n";
const NUMBERS: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

/// The usual numbers below a header.
fn headed(header: &str) -> Scan {
    read(&format!("{header}\n{MATRIX}"))
}

#[test]
fn separators_are_found_out() {
    for text in [
        "1 2 3\n4 5 6\n",
        "  1   2 3\r\n4 5 6",
        "1,2,3\n4,5,6\n",
        "1, 2, 3\n\n4 ,5 ,6\n",
        "1;2;3\n4;5;6",
        "1\t2\t3\n4\t5\t6\n",
        "\u{feff}1 2 3\n4 5 6\n",
        "1 2 3\r4 5 6\r",
        "1 2 3 # first\n% between\n4 5 6\n#",
        "1e0 +2 3.\n.4e1 5.0 0006\n",
    ] {
        assert_scan(text.as_bytes(), Format::Text, (2, 3), None, &NUMBERS);
    }
    assert_heights(&read("-2.5e-6"), &[-2.5e-6]);
    // A separator at the end of every row opens no column.
    let scan = assert_scan(b"1,2,\n3,,\n", Format::Text, (2, 2), None, &[1.0, 2.0, 3.0, NAN]);
    assert_eq!(scan.warnings.len(), 1);
    assert_scan(b"1,2,\n3,,4\n", Format::Text, (2, 3), None, &[1.0, 2.0, NAN, 3.0, NAN, 4.0]);
}

#[test]
fn marks_of_missing_heights_are_understood() {
    for (text, heights) in [
        ("1,,nan\n,2,-inf", [1.0, NAN, NAN, NAN, 2.0, NAN]),
        ("1;;NaN\n;2;Infinity", [1.0, NAN, NAN, NAN, 2.0, NAN]),
        ("1\t\tNAN\n\t2\tinf", [1.0, NAN, NAN, NAN, 2.0, NAN]),
        ("1 nan nan\ninf 2 -INF", [1.0, NAN, NAN, NAN, 2.0, NAN]),
        // Of other programs.
        ("1 BAD bad\nNo Data 2 no data\n", [1.0, NAN, NAN, NAN, 2.0, NAN]),
        ("1,BAD,\nNo Data,2,3\n", [1.0, NAN, NAN, NAN, 2.0, 3.0]),
        ("# NODATA_value: -1\n-1 2 3\n4 5 6\n", [NAN, 2.0, 3.0, 4.0, 5.0, 6.0]),
        // Errors of spreadsheets, which are no comments.
        ("1,#N/A,3\n#DIV/0!,5,6 # both\n", [1.0, NAN, 3.0, NAN, 5.0, 6.0]),
        ("1\t#NV\t3\r\n#VALUE!\t5\t6\r\n", [1.0, NAN, 3.0, NAN, 5.0, 6.0]),
        ("1 #NUM! 3\n#REF! 5 6", [1.0, NAN, 3.0, NAN, 5.0, 6.0]),
    ] {
        assert_heights(&read(text), &heights);
    }
    let scan = read("#N/A,1\n2,3\n");
    assert_heights(&scan, &[NAN, 1.0, 2.0, 3.0]);
    assert!(scan.metadata.is_empty());
    assert_metadata(&read("#N/Applicable\n2,3\n"), &[("comment", "N/Applicable")]);
}

#[test]
fn text_in_utf16_is_read_as_spreadsheets_write_it() {
    let text = "\u{feff}# unit: µm\r\n1,5\t2,5\r\n3,5\t4,5\r\n";
    let [little, big] =
        [u16::to_le_bytes, u16::to_be_bytes].map(|order| text.encode_utf16().flat_map(order).collect::<Vec<u8>>());
    for bytes in [little, big] {
        assert_scan(&bytes, Format::Text, (2, 2), None, &[1.5e-6, 2.5e-6, 3.5e-6, 4.5e-6]);
    }
    // Bytes that only start like it.
    assert_eq!(Format::detect(b"\xff\xfe\x00\x00\x01\x00"), None);
}

#[test]
fn labels_of_rows_and_columns_are_left_out() {
    // As pandas writes a frame, and a spreadsheet with coordinates.
    for text in [",0,1\n0,1e-6,2e-6\n1,3e-6,4e-6\n", ";1;2\n1;1e-6;2e-6\n2;3e-6;4e-6\n"] {
        let scan = assert_scan(text.as_bytes(), Format::Text, (2, 2), None, &[1e-6, 2e-6, 3e-6, 4e-6]);
        assert_one_warning(&scan, "labels");
    }
    let scan = read("\t0.0\t0.33\t0.67\n5\t1\t2\t3\n5.5\t4\t5\t6\n6\t7\t8\t9\n");
    assert_eq!(scan.heights_m.dim(), (4, 4), "0.33 is not half of 0.67");
    let scan = read("\t0.0\t0.333\t0.666\n5\t1\t2\t3\n5.5\t4\t5\t6\n6\t7\t8\t9\n");
    assert_heights(&scan, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
    // A plane without its first point, as numbers; two columns; a corner that is there.
    for (text, shape) in
        [("nan,1,2\n1,2,3\n2,3,4\n", (3, 3)), (",1\n1,2\n2,3\n", (3, 2)), ("0,0,1\n0,5,6\n1,7,8\n", (3, 3))]
    {
        let scan = read(text);
        assert_eq!((scan.heights_m.dim(), scan.warnings.len()), (shape, 0), "{text:?}");
    }
}

#[test]
fn labels_along_the_sides_are_left_out_and_heights_are_not() {
    let row = |row: usize, first: &str| {
        let values: Vec<String> = (0..9).map(|column| format!("{}.5", (row * 5 + column * 7) % 11)).collect();
        format!("{first}{}\n", values.join(" "))
    };
    let rows = |first: &dyn Fn(usize) -> String| (0..9).map(|k| row(k, &first(k))).collect::<String>();
    let heights = read(&rows(&|_| String::new())).heights_m;
    let indexed = rows(&|k| format!("{k} "));
    let named = format!("1 2 3 4 5 6 7 8 9\n{}", rows(&|_| String::new()));
    let both = format!("0 0 .5 1 1.5 2 2.5 3 3.5 4\n{}", rows(&|k| format!("{} ", 10 * k)));
    for text in [&indexed, &named, &both, &named.replacen('\n', "\n\n", 1)] {
        let scan = read(text);
        assert_eq!(scan.heights_m, heights);
        assert_one_warning(&scan, "labels, which were left out");
    }
    // Beside an empty corner they are labels whatever the header states.
    let frame = "# pixel size: 1 um\n,0,1\n0,1e-7,2e-7\n1,3e-7,4e-7\n";
    assert_eq!(read(frame).heights_m.dim(), (2, 2));
    // The numbers of a plane step evenly everywhere, also beside a void, and the size of a map belongs to heights.
    let plane: String = (0..8).map(|y| (0..9).map(|x| format!("{} ", x + 3 * y)).collect::<String>() + "\n").collect();
    assert_eq!(read(&plane).heights_m.dim(), (8, 9));
    assert_eq!(read(&plane.replacen(" 1 ", " nan ", 1)).heights_m.dim(), (8, 9));
    for size in ["pixel size: 1 um", "dx: 1 um", "Width: 10 um\n# Height: 9 um"] {
        assert_eq!(read(&format!("# {size}\n# z unit: um\n{indexed}")).heights_m.dim(), (9, 10), "{size}");
    }
}

#[test]
fn heights_along_a_line_are_a_profile() {
    let um = |text: &str| {
        let options = ReadOptions { height_unit: Some("um".parse().unwrap()), ..ReadOptions::default() };
        read_bytes_with(text.as_bytes(), &options).unwrap()
    };
    for (text, heights, words) in [
        (
            "0 0.10\n0.5 0.20\n1 0.15\n1.5 0.30\n",
            [0.1, 0.2, 0.15, 0.3],
            "two columns, of which the first rises or falls over 4 rows",
        ),
        ("3,1\n2.1,5\n1,2\n0,4\n", [4.0, 2.0, 5.0, 1.0], "two columns"),
        ("0 0.5 1 1.5\n0.10 0.20 0.15 0.30\n", [0.1, 0.2, 0.15, 0.3], "two rows"),
        ("1\n5\n3\n4\n", [1.0, 5.0, 3.0, 4.0], "a single column of 4 numbers"),
        ("1 5 3 4\n", [1.0, 5.0, 3.0, 4.0], "a single row of 4 numbers"),
    ] {
        let scan = um(text);
        assert!(scan.is_profile() && scan.pitch_m.is_none(), "{text:?}");
        assert_heights(&scan, &heights.map(|z| z * 1e-6));
        assert_warns(&scan, words);
    }
    // Units and names of columns, among them those of a stylus with empty cells at the end of lines.
    let dektak = "Meta Data\nSavedAs,C:\\a.OPDx\nScanLength,2000\n\nData\nLateral(µm),Total Profile(Å),,\n\
                  0,-5528.24,,\n0.5,-5547.78,,\n1,12,,\n1.5,7,,\n";
    for (text, heights_nm) in [
        (dektak, [-552.824, -554.778, 1.2, 0.7]),
        ("# x [mm]  z [nm]\n0 1\n0.0005 2\n0.001 3\n0.0015 5\n", [1.0, 2.0, 3.0, 5.0]),
        ("# x unit: um\n# z unit: nm\n0 1\n.5 2\n1 3\n1.5 5\n", [1.0, 2.0, 3.0, 5.0]),
        ("# unit: nm\n# dx: 0.5 um\n1\n2\n3\n5\n", [1.0, 2.0, 3.0, 5.0]),
    ] {
        let scan = read_bytes(text.as_bytes()).unwrap();
        assert_eq!(scan.heights_m.dim(), (1, 4), "{text}");
        let (step_m, _) = scan.pitch_m.unwrap_or_else(|| panic!("{text}"));
        assert!((step_m / 5e-7 - 1.0).abs() < 1e-12, "{text}: {step_m}");
        assert!(scan.heights_m.iter().zip(heights_nm).all(|(z, nm)| (z / nm * 1e9 - 1.0).abs() < 1e-12), "{text}");
    }
    // HFM: units below the names, and a mark of missing heights.
    let hfm = "X;Y;valid\r\n[mm];[um];[1/0]\r\n8.6722;-1.5;1\r\n8.6727;0;0\r\n8.6732;2.5;1\r\n8.6737;3;1\r\n";
    let scan = read_bytes(hfm.as_bytes()).unwrap();
    assert_heights(&scan, &[-1.5e-6, f64::NAN, 2.5e-6, 3e-6]);
    assert!(scan.channels == ["Y"] && (scan.pitch_m.unwrap().0 / 5e-7 - 1.0).abs() < 1e-9, "{scan:?}");
    let two = "Lateral(µm),Raw(nm),Level(nm)\n0,1,11\n1,2,12\n2,3,13\n3,5,15\n";
    let scan = read_channel(two.as_bytes(), "level").unwrap();
    assert_eq!(scan.channels, ["Raw", "Level"]);
    assert_heights(&scan, &[11e-9, 12e-9, 13e-9, 15e-9]);
    assert_refused([
        ("0 1\n1 2\n5 3\n6 2\n", "whose positions step by 1 to 4; wanted positions in equal steps"),
        ("Lateral(µm),Force(mN)\n0,1\n1,2\n2,3\n3,5\n", "numbers in `mN`; wanted a unit of length"),
    ]);
    // A header with the size of a map describes heights, unless many step like positions.
    assert_eq!(read("# dx: 1 um\n# z unit: um\n1 2\n3 4\n5 6\n7 8\n").heights_m.dim(), (4, 2));
}

#[test]
fn profiles_as_programs_export_them_are_read_or_refused_by_name() {
    let beside: String = (0..8).map(|k| format!("{} {}\n", 0.5 * f64::from(k), k % 3)).collect();
    assert_refused([
        (format!("# dx: 0.5 um\n{beside}").as_str(), "beside a header with the size of a map: positions or heights"),
        ("1\n2\n1\n\n5\n2\n5\n\n2\n1\n2\n", "3 blocks of numbers, divided by blank lines"),
        ("1,25\n1,31\n1,22\n1,47\n", "rows such as `1,25`, one number with a decimal comma or two; wanted points"),
    ]);
    let in_um = |text: &str, pitch_m: Option<(f64, f64)>| {
        let height_unit = Some("um".parse().unwrap());
        read_bytes_with(text.as_bytes(), &ReadOptions { pitch_m, height_unit, ..ReadOptions::default() })
    };
    // Empty cells at the end of lines, comments with lengths, other units in the header, several heights.
    for (text, pitch_um) in [
        ("0,0;0,12;\n0,5;0,31;\n1,0;0,25;\n1,5;0,02;\n", None),
        ("# x [um], z [um]\n# Lt 2 mm, tip 2 um\n0.0 0.12\n0.5 0.31\n1.0 0.25\n1.5 0.02\n", Some(0.5)),
        ("# z unit: nm\n# x unit: mm\n# x [um] z [um]\n0.0 0.12\n0.5 0.31\n1.0 0.25\n1.5 0.02\n", Some(0.5)),
        ("x (um),raw (um),level (um)\n0.0,0.12,1\n0.5,0.31,2\n1.0,0.25,3\n1.5,0.02,1\n", Some(0.5)),
        // Units in the line below the names, and an index of the rows.
        ("Surface tester\nPosition;Height\nmm;µm\n0,0;0,12\n0,0005;0,31\n0,0010;0,25\n0,0015;0,02\n", Some(0.5)),
        (",x [um],z [um]\n0,0.0,0.12\n1,0.5,0.31\n2,1.0,0.25\n3,1.5,0.02\n", Some(0.5)),
        ("\"\",\"x [um]\",\"z [um]\"\n1,0.0,0.12\n2,0.5,0.31\n3,1.0,0.25\n4,1.5,0.02\n", Some(0.5)),
    ] {
        let scan = in_um(text, None).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(scan.heights_m.dim(), (1, 4), "{text}");
        assert!((scan.heights_m[[0, 1]] / 0.31e-6 - 1.0).abs() < 1e-12, "{text}: {scan:?}");
        assert_eq!(scan.pitch_m.map(|(step_m, _)| (step_m * 1e8).round() / 100.0), pitch_um, "{text}");
    }
    // Roles of columns follow from their names and units, in any order; indices of any kind and other columns have none.
    for text in [
        "Height;Position\nµm;mm\n0,12;0,0\n0,31;0,0005\n0,25;0,0010\n0,02;0,0015\n",
        "z [um],x [um]\n0.12,0\n0.31,0.5\n0.25,1\n0.02,1.5\n",
        "x [um],valid,z [um]\n0,1,0.12\n0.5,1,0.31\n1,1,0.25\n1.5,1,0.02\n",
        "valid,x [um],z [um]\n1,0,0.12\n1,0.5,0.31\n1,1,0.25\n1,1.5,0.02\n",
        "flag,x [um],z [um]\n1,0,0.12\n1,0.5,0.31\n0,1,0.25\n1,1.5,0.02\n",
        ",x [um],z [um]\n0,0,0.12\n2,0.5,0.31\n4,1,0.25\n6,1.5,0.02\n",
        "Unnamed: 0,x [um],z [um]\n7,0,0.12\n3,0.5,0.31\n4,1,0.25\n4,1.5,0.02\n",
        "x [um],z [um]\n1,0,0.12\n2,0.5,0.31\n4,1,0.25\n5,1.5,0.02\n",
        "t [s],x [um],z [um]\n0,0,0.12\n1,0.5,0.31\n2,1,0.25\n3,1.5,0.02\n",
        "Index,x [um],z\n1,0,0.12\n2,0.5,0.31\n3,1,0.25\n4,1.5,0.02\n",
    ] {
        let scan = in_um(text, None).unwrap_or_else(|error| panic!("{text}: {error}"));
        let heights_um: Vec<f64> = scan.heights_m.iter().map(|z| (z * 1e8).round() / 100.0).collect();
        assert_eq!(heights_um, [0.12, 0.31, 0.25, 0.02], "{text}");
        assert!((scan.pitch_m.unwrap().0 / 5e-7 - 1.0).abs() < 1e-9, "{text}");
        assert!(
            !text.starts_with("flag") || scan.warnings.iter().any(|w| w.contains("`flag` was left out")),
            "{scan:?}"
        );
    }
    // Names without units leave the distance between points open.
    let plain = in_um("x,z\n0,0.12\n0.5,0.31\n1,0.25\n1.5,0.02\n", None).unwrap();
    assert!(plain.is_profile() && plain.pitch_m.is_none());
    assert_error(in_um("Time [s],z [um]\n0,0.12\n1,0.31\n2,0.25\n3,0.02\n", None), "`Time [s]`; wanted a number");
    // Names of columns that the rows do not have.
    for text in ["Lateral(µm),Raw(nm)\n0,", "Lateral(µm),Raw(nm)\n0,\n1,\n", "Raw(nm),x(um)\n0,\n1,\n"] {
        assert_error(in_um(text, None), "a profile whose last column is empty");
    }
    // Missing marks of a column `valid`.
    let marked = in_um("x [um],z [um],valid\n0,0.12,1\n0.5,0.31,0\n1,0.25,\n1.5,0.02,1\n", None).unwrap();
    assert_eq!(marked.heights_m.iter().filter(|z| z.is_nan()).count(), 2);
    // Rounded positions need the distance between points.
    let rounded: String = (0..12).map(|k| format!("{:.3} {}\n", 0.0005 * f64::from(k), k * k % 7)).collect();
    assert!(in_um(&rounded, Some((5e-7, 5e-7))).unwrap().is_profile());
    assert_error(in_um(&rounded, None), "positions step by 0 to 0.001; wanted positions in equal steps");
}

#[test]
fn blocks_and_doubtful_labels_are_refused() {
    let line: String = (0..9).map(|k| format!("{k} {} {}\n", k * k % 7, k * k % 5)).collect();
    let cone: String = (0..12)
        .map(|y| (0..12).map(|x| format!("{} ", f64::from(x * x + y * y).sqrt())).collect::<String>() + "\n")
        .collect();
    let ramp: String = (0..12).map(|y| format!("{} {} 1 {}\n", 2 * y, y * y % 7, y * y % 5)).collect();
    let open = "evenly: labels, coordinates or heights";
    assert_refused([
        ("1 2\n3 4\n\n5 6\n7 8\n\n9 0\n1 2\n", "3 blocks of numbers, divided by blank lines"),
        ("1 2 3\n4 5 7\n\n7 8 1\n2 3 4\n", "2 blocks of numbers, divided by blank lines"),
        (&line, open),
        (&cone, open),
        (&ramp, open),
        ("0 1 2 3\n1 3 2 0\n2 0 1 3\n3 2 1 0\n", open),
    ]);
    // A blank line after each row divides nothing, nor does a comment.
    assert_eq!(read("1 2 3\n\n4 5 6\n# a\n\n7 8 1\n\n").heights_m.dim(), (3, 3));
    assert_eq!(read("1 5 2\n\n4 5 7\n7 8 1\n2 3 4\n").heights_m.dim(), (4, 3));
    // However many pieces a long text is read in.
    let long: String =
        (0..12000).map(|row| format!("{}\n\n", vec![((row * 7) % 13).to_string(); 300].join(" "))).collect();
    assert!(long.len() > 6 << 20);
    assert_eq!(read(&long).heights_m.dim(), (12000, 300));
}

#[test]
fn comments_become_metadata() {
    let scan = read("# instrument: stylus\n## a note\n% Ra = 0.4 µm\n1 2\n# another\n");
    assert_metadata(&scan, &[("instrument", "stylus"), ("Ra", "0.4 µm"), ("comment", "a note\nanother")]);
    assert_metadata(&read_bytes(b"# \xb5m\n1 2\n").unwrap(), &[("comment", "µm")]);
    assert_metadata(&read_bytes(TEXT).unwrap(), &[("comment", "two missing")]);
    // Without comment signs a header must be keys with values.
    let scan = read("Instrument: stylus\nDate = 2016-12-01\n\n1 2\n");
    assert_metadata(&scan, &[("Instrument", "stylus"), ("Date", "2016-12-01")]);
    assert_heights(&scan, &[1.0, 2.0]);
}

#[test]
fn lines_that_are_not_rows_of_numbers_are_named() {
    let error = read_bytes(b"# heights\n1 2 3\n\n4 5\n").unwrap_err();
    assert!(matches!(error, FormatError::Ragged { line: 4, found: 2, wanted: 3 }), "{error}");
    assert_refused([
        ("# heights\n1 2 3\n\n4 5\n", "text: line 4 has 2 values; the first row has 3"),
        ("1 2\n3 x4\n", "text: value 2 (line 2) is `x4`; wanted a number"),
        ("1;2\n3;4,5,6\n", "text: value 2 (line 2) is `4,5,6`; wanted a number"),
        // In one column a comma could be a separator.
        ("1\n2,5\n", "is `2,5`; wanted a number with a decimal point"),
        ("a,b,c\n1,2,3\n", "text: value 1 (line 1) is `a`"),
        // Beyond f64 is not the same as infinite.
        ("1 1e999\n", "`1e999`"),
        ("12:30 1 2\n", "text: value 1 (line 1) is `12:30`"),
        ("a: b\nsome words\n1 2\n", "text: value 1 (line 2) is `some`"),
        ("1 2\na: b\n3 4\n", "text: value 1 (line 2) is `a:`"),
        ("\n\n", "is missing"),
        ("# only a comment\n", "is missing"),
        (" ", "is missing"),
        // One decimal sign.
        ("1,5;2\n1.5;2\n", "a decimal sign (line 2) is `.`; wanted a comma"),
        ("1.5;2 # 1,5\n3;2,5\n", "a decimal sign (line 1) is `.`; wanted a comma"),
        ("1.234,5;2\n", ""),
    ]);
}

#[test]
fn a_list_of_points_gives_a_warning() {
    let list: String = (0..20).map(|i| format!("{i} {i} 0.5\n")).collect();
    assert_one_warning(&read(&list), "points x y z");
}

const HEIGHTS_M: [f64; 6] = [1e-9, 2e-9, 3e-9, 4e-9, 5e-9, 6e-9];

#[test]
fn gwyddion_states_the_size_of_all_points() {
    let german = GWYDDION.replace("Channel", "Kanal").replace("Width", "Breite").replace("Height", "Höhe");
    let commas = GWYDDION.replace("3.0", "3,0").replace("1.00", "1,00");
    for text in [GWYDDION, &german, &commas] {
        // 3 µm are three points of 1 µm, 1 µm is two of 0.5 µm.
        let scan = assert_scan(text.as_bytes(), Format::Text, (2, 3), (1e-6, 0.5e-6), &HEIGHTS_M);
        assert_no_warning(&scan);
    }
    assert_metadata(&read(GWYDDION), &[("Channel", "Topography")]);
}

#[test]
fn channels_of_one_file_are_distinguished() {
    let text = two_channels();
    let scan = read(&text);
    assert_heights(&scan, &HEIGHTS_M);
    assert_eq!(scan.channels, ["Topography", "Zoom"]);
    assert_warns(&scan, "2 height maps");
    let scan = read_channel(text.as_bytes(), "zoom").unwrap();
    assert_eq!((scan.heights_m.dim(), scan.channel, scan.pitch_m), ((1, 2), 1, Some((2e-9, 2e-9))));
    assert_heights(&scan, &[1e-9, 2e-9]);
    let phase = read_channel(text.as_bytes(), "Phase");
    assert_error(phase, "text: no height map `Phase`; the file holds `Topography`, `Zoom`");
    let broken = text.replace("\n1 2\n", "\n1 x\n");
    assert_error(read_channel(broken.as_bytes(), "2"), "text: value 2 (line 19) is `x`");
    let phases = text.replace("units: m", "units: V").replace("units: nm", "units: V");
    assert_refused([(phases, "text: the unit of no channel is a length")]);
    let same = "# Channel: Z\n1 2\n# Channel: Z\n3 4\n";
    assert_eq!(read(same).channels, ["Z", "Z 2"]);
    assert_heights(&read_channel(same.as_bytes(), "z 2").unwrap(), &[3.0, 4.0]);
}

#[test]
fn spip_uses_nanometre_and_marks_voids_after_the_heights() {
    let heights = [0.5e-9, 1e-9, 1.5e-9, 2e-9, NAN, 3e-9];
    assert_no_warning(&assert_scan(SPIP.as_bytes(), Format::Text, (2, 3), (1e-8, 5e-9), &heights));
    let micrometre = SPIP.replace("Bit2nm = 0.5", "z-unit = um");
    assert_heights(&read(&micrometre), &[1e-6, 2e-6, 3e-6, 4e-6, NAN, 6e-6]);
}

#[test]
fn an_esri_grid_is_read_with_any_line_breaks() {
    let wanted = [1e-9, 2e-9, 3e-9, 4e-9, NAN, 6e-9];
    for text in [
        ESRI.to_owned(),
        ESRI.replace("3e-9\n", "3e-9 "),
        ESRI.replace("NODATA_value -9999\n", ""),
        ESRI.to_uppercase(),
    ] {
        assert_scan(text.as_bytes(), Format::Text, (2, 3), (0.5e-6, 0.5e-6), &wanted);
    }
    assert_refused([(ESRI.replace("nrows 2", "nrows 3"), "ncols × nrows (line 1) is `3 × 3`; wanted 6")]);
}

#[test]
fn headers_of_other_programs_are_understood() {
    let attocube = "# Daisy frame view snapshot\n# x-pixels: 3\n# y-pixels: 2\n# x-length: 30\n# y-length: 10\n\
        # x-unit: um\n# y-unit: um\n# z-unit: nm\n# Start of Data:";
    let nova = "File Format = ASCII\nCreated by = Nova\nNX = 3\nNY = 2\nScale X = 10\nScale Y = 5\nUnit X = um\n\
        Unit Data = nm";
    for header in [attocube, nova] {
        let scan = headed(header);
        assert_heights(&scan, &HEIGHTS_M);
        assert_eq!(scan.pitch_m, Some((1e-5, 5e-6)), "{header}");
        assert_no_warning(&scan);
    }
}

#[test]
fn a_pixel_size_is_stated_in_many_ways() {
    let in_metre = |header: &str| read_in_metre(format!("{header}\n{MATRIX}").as_bytes()).unwrap();
    for (header, pitch_m) in [
        ("# pixel size: 0.5 um x 0.25 um", (0.5e-6, 0.25e-6)),
        ("# pixel size = 0.5 um", (0.5e-6, 0.5e-6)),
        ("# pixel_size: 0.5 x 0.25 µm", (0.5e-6, 0.25e-6)),
        ("# pixel size: 500nm, 250nm", (5e-7, 2.5e-7)),
        ("# pixel size [um]: 0.5 0.25", (0.5e-6, 0.25e-6)),
        ("# pixel size (mm) = (0.5, 0.25)", (0.5e-3, 0.25e-3)),
        ("% dx = 0.5 um\n% dy = 0.25 um", (0.5e-6, 0.25e-6)),
        ("# unit: um\n# dx: 0.5", (0.5e-6, 0.5e-6)),
        ("# dx: 0.5\n# dy: 0.25\n# xy unit: mm", (0.5e-3, 0.25e-3)),
        ("dx: 0.5 um\ndy: 0.25 um", (0.5e-6, 0.25e-6)),
        ("pitch = 0.5 um", (0.5e-6, 0.5e-6)),
        ("# size: 3 mm 1 mm", (1e-3, 0.5e-3)),
        ("# size: 3x1 mm", (1e-3, 0.5e-3)),
        ("# scan size: 3 um", (1e-6, 1.5e-6)),
        ("# physical sizes: (3, 1) um", (1e-6, 0.5e-6)),
        ("# x length: 3 um\n# y length: 1 um", (1e-6, 0.5e-6)),
        ("# Width: 3\n# Height: 1\n# unit: um", (1e-6, 0.5e-6)),
        // A size with a unit is always a length.
        ("# Width: 3.0 µm\n# Height: 2.0 µm", (1e-6, 1e-6)),
        ("# Width [um]: 3\n# Height [um]: 2", (1e-6, 1e-6)),
        ("# Width: 3\n# Height: 2\n# xy unit: um", (1e-6, 1e-6)),
        ("# size: 3 um x 2 um", (1e-6, 1e-6)),
        ("# size: 3 x 2 um", (1e-6, 1e-6)),
    ] {
        assert_pitch(&in_metre(header), pitch_m);
    }
    for (header, key) in [("# pixel size: 0.5 µ", "pixel size"), ("# x unit: µ\n# dx: 0.5", "x unit")] {
        assert_refused([(format!("{header}\n{MATRIX}"), format!("text: {key} (line 1) is `"))]);
    }
    // The unit of the heights does not turn numbers of points into lengths.
    for header in [
        "# size: 3 x 2",
        "# unit: um\n# size: 3 x 2",
        "# Width: 3\n# Height: 2",
        "# size: 3 MB",
        "# pixel size: small",
        "# Width: 3\n# Height: 2\n# unit: um",
    ] {
        assert_eq!(headed(header).pitch_m, None, "{header}");
    }
    assert_one_warning(&headed("# Width: 10 um"), "a width but no height");
    assert_warns(&in_metre("# dx = 0.5"), "without a unit");
    assert_one_warning(&headed("# nx = 4\n# ny = 2"), "the header states 4 × 2 points; there are 3 × 2");
}

/// The header that Koala (Lyncée Tec) writes above phases.
const KOALA: &str = "h=2 w=3\npixel size=2.84871e-07 m\ndata unit=rad\nheight conversion factor (-> m)=6.3e-8";

#[test]
fn heights_in_another_unit_are_converted() {
    for (header, z) in [
        ("# unit: um", 1e-6),
        ("# Value units: nm", 1e-9),
        ("# z-unit = [nm]", 1e-9),
        ("# unit: um\n# height unit: nm", 1e-9),
        ("unit: µm", 1e-6),
        // Conversion factors.
        (KOALA, 6.3e-8),
        ("# height conversion factor (-> um) = 2", 2e-6),
        ("data unit=rad\nheight conversion factor (-> m)=6,3e-8", 6.3e-8),
        ("data unit=rad\nheight conversion factor (-> m): 6.3E-8 m/rad", 6.3e-8),
        ("# data unit: rad\n# height conversion factor: 63 nm/rad", 63e-9),
        ("# z-unit = V\n# conversion factor (V -> nm) = 25", 25e-9),
        ("# z-unit = V\n# z conversion factor [nm/V] = 25", 25e-9),
        ("# conversion factor (V → nm) = +25", 25e-9),
        ("# unit: nm\n# conversion factor (nm -> m) = 1e-9", 1e-9),
        ("# height conversion factor (-> um) = 1,234e-1", 0.1234e-6),
        ("# height conversion factor (-> um) = 0,125", 0.125e-6),
    ] {
        let scan = headed(header);
        for (z_m, number) in scan.heights_m.iter().zip(NUMBERS) {
            assert!((z_m / (number * z) - 1.0).abs() < 1e-14, "{header}: {z_m:e}");
        }
        assert_no_warning(&scan);
        if !header.contains("factor") {
            assert!(scan.metadata["converted"].starts_with("heights from"), "{header}");
        }
    }
    assert!(!headed("# unit: m").metadata.contains_key("converted"));
    // In a file of decimal commas a comma separates no thousands.
    assert_heights(&read("# height conversion factor (-> um) = 1,250\n0,5 2\n"), &[0.625e-6, 2.5e-6]);
    let koala = headed(KOALA);
    assert_eq!((koala.pitch_m, koala.height_unit.as_deref()), (Some((2.84871e-7, 2.84871e-7)), Some("m")));
}

#[test]
fn doubtful_units_and_conversion_factors_give_a_warning() {
    let without_unit = "the header states `conversion factor: 6.3e-8` without a unit; metre was assumed";
    for (header, z, words) in [
        // A factor of its own beside another unit.
        (&*KOALA.replace("data unit=rad", "data unit=nm"), 6.3e-8, "the factor was used"),
        ("# unit: rad\n# conversion factor = 6.3e-8", 6.3e-8, without_unit),
        ("data unit=rad\nheight conversion factor (-> m)=-1e-8", -1e-8, "upside down"),
        ("# signal unit: deg", 1.0, "`signal unit: deg`"),
    ] {
        let scan = headed(header);
        assert_heights(&scan, &NUMBERS.map(|number| number * z));
        assert_one_warning(&scan, words);
    }
    for (header, quoted, z) in [
        ("# unit: nm\n# conversion factor (V -> um) = 25", "conversion factor (V -> um): 25", 1e-9),
        ("# unit: nm\n# conversion factor = 2", "conversion factor: 2", 1e-9),
        ("# unit: nm\n# height conversion factor (-> m) = abc", "height conversion factor (-> m): abc", 1e-9),
        ("# height conversion factor (-> V) = 63", "height conversion factor (-> V): 63", 1.0),
        ("# height conversion factor (-> m) = 2 nm/rad", "height conversion factor (-> m): 2 nm/rad", 1.0),
        ("# lateral conversion factor = 2", "lateral conversion factor: 2", 1.0),
        ("# the conversion factor is 6.3e-8 m", "the conversion factor is 6.3e-8 m", 1.0),
        ("# height conversion factor = 2\n# z conversion factor = 3", "z conversion factor: 3", 1.0),
    ] {
        let scan = headed(header);
        assert_heights(&scan, &NUMBERS.map(|number| number * z));
        assert_warns(&scan, &format!("the header states `{quoted}`, which was not used"));
    }
    // Koala states the factor of phases also above heights.
    assert_heights(&headed(&KOALA.replace("data unit=rad", "data unit=m")), &NUMBERS);
    assert_no_warning(&headed("data unit=m\nheight conversion factor (-> m)=0"));
    for value in ["abc", "0", "nan", "inf", "-0.0", "1,250", "1,2,3"] {
        let text = format!("# data unit: rad\n\n# height conversion factor (-> m) = {value}\n{MATRIX}");
        let wanted = format!("height conversion factor (-> m) (line 3) is `{value}`; wanted a number other than 0");
        assert_refused([(text, wanted)]);
    }
}

#[test]
fn numbers_in_a_unit_that_is_no_length_are_refused_unless_the_user_states_one() {
    // A current, and no Ångström.
    for unit in ["V", "A", "deg", "N m", "counts"] {
        let text = format!("# Value units: {unit}\n{MATRIX}");
        assert_refused([(
            text.clone(),
            format!("numbers in `{unit}`; wanted a unit of length; state it, as by --height-unit"),
        )]);
        let stated = ReadOptions { height_unit: Some("nm".parse().unwrap()), ..ReadOptions::default() };
        assert_heights(&read_bytes_with(text.as_bytes(), &stated).unwrap(), &NUMBERS.map(|number| 1e-9 * number));
    }
}

#[test]
fn decimal_commas_are_read_if_commas_are_no_separators() {
    for text in [
        "1,5;2,25;-3\n0;1e-3;7,0E1",
        "1,5\t2,25\t-3\n0\t1e-3\t7,0E1",
        "1,5 2,25 -3\n0 1e-3 7,0E1",
        "-0,5 1 2\n1,5 2,5 3",
    ] {
        let scan = read(text);
        assert_eq!(scan.heights_m.dim(), (2, 3), "{text}");
        assert_metadata(&scan, &[("decimal sign", "comma")]);
    }
    assert_heights(&read(DECIMAL_COMMAS), &[1.5e-9, -2.5e-9, 3e-9, 4.25e-9, NAN, 6e-9]);
    // Commas followed by spaces are separators.
    assert_heights(&read("1, 2, 3"), &[1.0, 2.0, 3.0]);
    assert_heights(&read("1,5"), &[1.0, 5.0]);
}

#[test]
fn special_numbers_of_c_libraries_are_missing_heights() {
    for text in ["1.#QNAN 2 -1.#IND\n4 1.#INF00 -nan(ind)\n", "1.#SNAN;2;1.#qnan0\n4;-1.#INF;nan(snan) # 1.#IND\n"] {
        assert_heights(&read(text), &[NAN, 2.0, NAN, 4.0, NAN, NAN]);
    }
    // With a decimal comma.
    assert_heights(&read("0,5;1,#QNAN\n-1,#IND;2,5\n"), &[0.5, NAN, NAN, 2.5]);
    // At the end of a line.
    assert_heights(&read("2 1.#IND"), &[2.0, NAN]);
    // Comments that touch a number stay comments.
    assert_heights(&read("2 1.#a comment\n3 1.#INFO\n4 1#IND\n"), &[2.0, 1.0, 3.0, 1.0, 4.0, 1.0]);
    assert_heights(&read("2,1,#IND\n"), &[2.0, 1.0]);
}

#[test]
fn a_long_text_is_the_same_in_pieces() {
    // Beyond a few MiB a text is read in pieces; comments and voids fall anywhere.
    let (rows, columns) = (3001, 257);
    let value = |row: usize, column: usize| ((row * 31 + column * 17) % 1009) as f64 * 1.25e-9 - 3e-7;
    let mut text = String::from("# unit: m\n");
    for row in 0..rows {
        let fields: Vec<String> = (0..columns)
            .map(|column| match (row + column) % 997 {
                0 => "nan".into(),
                _ => format!("{:e}", value(row, column)),
            })
            .collect();
        text += &fields.join(" ");
        text += if row % 100 == 7 { " # a comment\n" } else { "\n" };
    }
    assert!(text.len() > 6 << 20);
    let scan = read(&text);
    assert_eq!(scan.heights_m.dim(), (rows, columns));
    for ((row, column), z) in scan.heights_m.indexed_iter() {
        assert!(
            (row + column) % 997 == 0 && z.is_nan() || z.to_bits() == value(row, column).to_bits(),
            "{row} {column}"
        );
    }
    assert_eq!(scan.metadata["comment"].lines().count(), 30);
    // Row 2900 follows the unit and 2900 rows.
    let start = text.lines().take(2901).map(|line| line.len() + 1).sum::<usize>();
    text.replace_range(start..start + 1, "x");
    assert_error(read_bytes(text.as_bytes()), "text: value 1 (line 2902)");
}

#[test]
fn a_length_in_the_header_is_read_whole_or_refused() {
    let text = |size: &str| format!("# pixel size: {size}\n1e-7 2e-7\n3e-7 5e-7\n");
    assert_pitch(&read_bytes(text("1,234.5 um").as_bytes()).unwrap(), (1234.5e-6, 1234.5e-6));
    assert_refused([
        (text("12.34.5 um"), "text: pixel size (line 1) is `12.34.5 um`; wanted a length"),
        (text("1,234 um"), "text: pixel size (line 1) is `1,234 um`; wanted a length without a comma or space"),
        (text("1 234.5 um"), "text: pixel size (line 1) is `1 234.5 um`; wanted a length without a comma or space"),
        ("# width: 1,234 um\n# height: 2 mm\n1 2\n3 4\n".into(), "text: width (line 1) is `1,234 um`"),
        ("# width: 2 mm\n# height: 1.2.3 mm\n1 2\n3 4\n".into(), "text: height (line 2) is `1.2.3 mm`"),
    ]);
    // A stated pixel size replaces it.
    let options = ReadOptions { pitch_m: Some((2e-6, 2e-6)), ..ReadOptions::default() };
    assert_eq!(read_bytes_with(text("1,234 um").as_bytes(), &options).unwrap().pitch_m, options.pitch_m);
}

#[test]
fn the_mark_at_the_end_of_a_text_of_dos_is_no_height() {
    for end in ["\x1a", "\r\n\x1a", "\x1a\x1a", "\x1a\r\n"] {
        let text = format!("# unit: nm\r\n1 2\r\n3 4{end}");
        assert_scan(text.as_bytes(), Format::Text, (2, 2), None, &[1e-9, 2e-9, 3e-9, 4e-9]);
    }
    assert_eq!(Format::detect(b"1 2\n3 \x1a4\n"), None);
}

use asperity_formats::{FormatError, read_bytes};

use crate::assert_heights;
use crate::fixture::Fixture;
use crate::fixtures::TEXT;

const NAN: f64 = f64::NAN;

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![Fixture::open_ended("text", TEXT.to_vec())]
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
        let scan = read_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        assert_eq!(scan.heights_m.dim(), (2, 3), "{text:?}");
        assert_heights(&scan, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(scan.pitch_m, None);
    }
}

#[test]
fn empty_fields_nan_and_inf_are_missing() {
    for text in ["1,,nan\n,2,-inf", "1;;NaN\n;2;Infinity", "1\t\tNAN\n\t2\tinf", "1 nan nan\ninf 2 -INF"] {
        assert_heights(&read_bytes(text.as_bytes()).unwrap(), &[1.0, NAN, NAN, NAN, 2.0, NAN]);
    }
}

#[test]
fn comments_become_metadata() {
    let scan = read_bytes("# instrument: stylus\n## a note\n% Ra = 0.4 µm\n1 2\n# another\n".as_bytes()).unwrap();
    assert_eq!(scan.metadata["instrument"], "stylus");
    assert_eq!(scan.metadata["Ra"], "0.4 µm");
    assert_eq!(scan.metadata["comment"], "a note\nanother");
    assert_eq!(read_bytes(b"# \xb5m\n1 2\n").unwrap().metadata["comment"], "µm");
    assert_eq!(read_bytes(TEXT).unwrap().metadata["comment"], "two missing");
}

#[test]
fn ragged_rows_name_their_line() {
    let error = read_bytes(b"# heights\n1 2 3\n\n4 5\n").unwrap_err();
    assert!(matches!(error, FormatError::Ragged { line: 4, found: 2, wanted: 3 }), "{error}");
    assert_eq!(error.to_string(), "text: line 4 has 2 values; the first row has 3");
}

#[test]
fn what_is_no_number_names_its_line_and_column() {
    let error = read_bytes(b"1 2\n3 x4\n").unwrap_err();
    assert!(error.to_string().starts_with("text: value 2 (line 2) is `x4`; wanted a number"), "{error}");
    let error = read_bytes(b"1,5;2,5\n").unwrap_err();
    assert!(error.to_string().ends_with("is `1,5`; wanted a number with a decimal point"), "{error}");
    let error = read_bytes(b"x,y,z\n1,2,3\n").unwrap_err();
    assert!(error.to_string().starts_with("text: value 1 (line 1) is `x`"), "{error}");
    // Beyond f64 is not the same as infinite.
    assert!(read_bytes(b"1 1e999\n").unwrap_err().to_string().contains("`1e999`"));
}

#[test]
fn a_separator_at_the_end_of_every_row_opens_no_column() {
    let scan = read_bytes(b"1,2,\n3,,\n").unwrap();
    assert_heights(&scan, &[1.0, 2.0, 3.0, NAN]);
    assert_eq!(scan.heights_m.dim(), (2, 2));
    assert_eq!(scan.warnings.len(), 1);
    let scan = read_bytes(b"1,2,\n3,,4\n").unwrap();
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_heights(&scan, &[1.0, 2.0, NAN, 3.0, NAN, 4.0]);
}

#[test]
fn text_without_numbers_is_an_error() {
    for text in ["\n\n", "# only a comment\n", " "] {
        assert!(matches!(read_bytes(text.as_bytes()), Err(FormatError::MissingField { .. })), "{text:?}");
    }
}

#[test]
fn a_list_of_points_is_doubted() {
    let list: String = (0..20).map(|i| format!("{i} {i} 0.5\n")).collect();
    let scan = read_bytes(list.as_bytes()).unwrap();
    assert!(matches!(scan.warnings.as_slice(), [one] if one.contains("points x y z")), "{:?}", scan.warnings);
}

#[test]
fn a_comment_with_another_unit_than_metre_is_doubted() {
    assert_eq!(read_bytes(b"# Width: 10 um\n# Value units: m\n1 2\n").unwrap().warnings, [] as [String; 0]);
    let scan = read_bytes(b"# Value units: nm\n1 2\n").unwrap();
    assert_heights(&scan, &[1.0, 2.0]);
    assert!(matches!(scan.warnings.as_slice(), [one] if one.contains("`Value units: nm`")), "{:?}", scan.warnings);
}

#[test]
fn a_single_number_is_a_map() {
    assert_heights(&read_bytes(b"-2.5e-6").unwrap(), &[-2.5e-6]);
}

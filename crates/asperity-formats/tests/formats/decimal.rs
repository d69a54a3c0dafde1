//! Commas that are decimal signs or separate thousands.

use asperity_formats::{Decimal, Format, FormatError, ReadOptions, Scan};

use crate::assert_heights;
use crate::check::{assert_error, assert_pitch};
use crate::fixture::{read_bytes, read_bytes_with};

fn read_as(text: &str, decimal: Decimal) -> Result<Scan, FormatError> {
    read_bytes_with(text.as_bytes(), &ReadOptions { decimal: Some(decimal), ..ReadOptions::default() })
}

#[test]
fn commas_that_may_separate_thousands_need_a_stated_decimal_sign() {
    for separator in ["\t", " ", ";"] {
        let text = "# a map\n500X1,234X-12,345\n1,000X+7,500X999,999\n".replace('X', separator);
        let error = read_bytes(text.as_bytes()).unwrap_err();
        assert!(error.asks_for_option());
        assert_eq!(
            error.to_string(),
            "text: `1,234` (line 2) may be 1.234 or 1234, as all numbers of the file with a comma; state the decimal sign by \
             `--decimal comma` or `--decimal point`, in a study by `decimal`"
        );
        let scan = read_as(&text, Decimal::Comma).unwrap();
        assert_heights(&scan, &[500.0, 1.234, -12.345, 1.0, 7.5, 999.999]);
        let scan = read_as(&text, Decimal::Point).unwrap();
        assert_heights(&scan, &[500.0, 1234.0, -12345.0, 1000.0, 7500.0, 999_999.0]);
        assert!(!scan.metadata.contains_key("decimal sign"));
    }
}

#[test]
fn one_comma_that_separates_no_thousands_decides() {
    for (number, value) in [
        ("0,5", 0.5),
        ("12,34", 12.34),
        ("0,123", 0.123),
        ("1,2345", 1.2345),
        ("1234,567", 1234.567),
        ("1,234e0", 1.234),
    ] {
        for text in [format!("{number} 1,234\n2,345 3,456\n"), format!("3,456 1,234\n2,345 {number}\n")] {
            let scan = read_bytes(text.as_bytes()).unwrap();
            let first =
                if text.starts_with("3,456") { [3.456, 1.234, 2.345, value] } else { [value, 1.234, 2.345, 3.456] };
            assert_heights(&scan, &first);
            assert_eq!(scan.metadata["decimal sign"], "comma");
        }
        // It is no number with a decimal point.
        let error = read_as(&format!("{number} 1,234\n2,345 3,456\n"), Decimal::Point);
        assert!(number.contains('e') || error.is_err(), "{number}");
    }
    // A comma as separator is none of a number.
    assert_heights(&read_bytes(b"1,234,5\n2,345,6\n").unwrap(), &[1.0, 234.0, 5.0, 2.0, 345.0, 6.0]);
}

#[test]
fn the_certain_comma_may_be_far_from_the_first_line() {
    let rows = "1,234 2,345\n".repeat(200_000);
    assert_error(read_bytes(rows.as_bytes()), "`1,234` (line 1) may be 1.234 or 1234");
    let scan = read_bytes(format!("{rows}0,5 1,234\n").as_bytes()).unwrap();
    assert_eq!((scan.heights_m[[0, 0]], scan.heights_m[[200_000, 0]]), (1.234, 0.5));
}

#[test]
fn a_stated_sign_holds_for_all_numbers() {
    assert_heights(&read_as("1,234.5 1,234,567\n2 3\n", Decimal::Point).unwrap(), &[1234.5, 1_234_567.0, 2.0, 3.0]);
    assert_error(read_as("1.5 2\n3 4\n", Decimal::Comma), "a decimal sign (line 1) is `.`; wanted a comma");
    assert_error(
        read_as("0,5;2\n3;4\n", Decimal::Point),
        "value 1 (line 1) is `0,5`; wanted a number with a decimal point",
    );
    // A stated decimal comma separates no columns.
    let scan = read_as("1,234\n2,5\n1,5\n3,25\n", Decimal::Comma).unwrap();
    assert!(scan.is_profile());
    assert_heights(&scan, &[1.234, 2.5, 1.5, 3.25]);
    // The header may state it.
    let scan = read_bytes(b"# decimal sign: comma\n1,234 2,345\n3,456 4,567\n").unwrap();
    assert_heights(&scan, &[1.234, 2.345, 3.456, 4.567]);
    let scan = read_bytes(b"# decimal sign: point\n1,234 2,345\n3,456 4,567\n").unwrap();
    assert_heights(&scan, &[1234.0, 2345.0, 3456.0, 4567.0]);
}

#[test]
fn points_obey_a_stated_decimal_sign() {
    let list: String = (0..12).map(|n| format!("{},000\t{},500\t1,{:03}\n", 1 + n % 4, 2 + n / 4, n)).collect();
    let error = read_bytes(list.as_bytes()).unwrap_err();
    assert!(matches!(error, FormatError::AmbiguousDecimal { format: Format::Xyz, .. }), "{error}");
    let heights: Vec<f64> = (0..12).map(|n| 1.0 + f64::from(n) / 1000.0).collect();
    let scan = read_as(&list, Decimal::Comma).unwrap();
    assert_heights(&scan, &heights);
    assert_pitch(&scan, (1.0, 1.0));
    // In whole numbers, two heights do not exceed the field of 4 km.
    let scan = read_as(&list, Decimal::Point).unwrap();
    assert_eq!((scan.heights_m[[0, 0]], scan.heights_m[[2, 3]]), (1000.0, 1011.0));
    assert_pitch(&scan, (1000.0, 1000.0));
}

#[test]
fn lengths_of_a_header_obey_a_stated_decimal_sign() {
    let text = "# unit: nm\n# pixel size: 1,234 um\n1 2\n3 4\n";
    assert_error(read_bytes(text.as_bytes()), "pixel size (line 2) is `1,234 um`; wanted a length without a comma");
    assert_error(read_bytes(text.as_bytes()), "`--decimal`");
    assert_pitch(&read_as(text, Decimal::Comma).unwrap(), (1.234e-6, 1.234e-6));
    assert_pitch(&read_as(text, Decimal::Point).unwrap(), (1234e-6, 1234e-6));
    // So do factors.
    let text = "# height conversion factor (-> nm) = 1,250\n1 2\n3 4\n";
    assert_error(read_bytes(text.as_bytes()), "`1,250`; wanted a number other than 0");
    assert_heights(&read_as(text, Decimal::Comma).unwrap(), &[1.25e-9, 2.5e-9, 3.75e-9, 5e-9]);
    assert_heights(&read_as(text, Decimal::Point).unwrap(), &[1250e-9, 2500e-9, 3750e-9, 5000e-9]);
}

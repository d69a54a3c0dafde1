use asperity_formats::{Decimal, Format, ReadOptions, Scan};

use crate::assert_heights;
use crate::check::{assert_error, assert_pitch, assert_refused, assert_warns};
use crate::fixture::{Content, Fixture, read_bytes, read_bytes_with, read_channel};

/// Styles of cells: 2 and 3 are dates.
const STYLES: &str = r#"<styleSheet><numFmts><numFmt numFmtId="164" formatCode="[$-407]dd\-mmm;@"/><numFmt numFmtId="165"
formatCode="0.0\m&quot; mm&quot;_d[Red]"/></numFmts><cellStyleXfs><xf numFmtId="14"/></cellStyleXfs><cellXfs><xf numFmtId="0"/><xf
numFmtId="165"/><xf numFmtId="14"/><xf numFmtId="164"/></cellXfs></styleSheet>"#;

/// A workbook of sheets, each with its name and its cells.
fn workbook(sheets: &[(&str, String)]) -> Content {
    let mut files = vec![("[Content_Types].xml".to_owned(), "<Types/>".to_owned())];
    let (mut list, mut links) = (String::new(), String::new());
    for (place, (name, cells)) in sheets.iter().enumerate() {
        let number = place + 1;
        list += &format!(r#"<sheet name="{name}" sheetId="{number}" r:id="rId{number}"/>"#);
        links += &format!(
            r#"<Relationship Id="rId{number}" Type="http://a/relationships/worksheet" Target="worksheets/sheet{number}.xml"/>"#
        );
        let xml = format!("<worksheet><sheetData>{cells}</sheetData></worksheet>");
        files.push((format!("xl/worksheets/sheet{number}.xml"), xml));
    }
    let shared = ["x [mm]", "z [&#181;m]", "Cut-Off", "0.08mm", "Ra     0.018  µm  ", "CUT 0.08mm"];
    let shared: String = shared.iter().map(|text| format!("<si><t>{text}</t><rPh><t>ラ</t></rPh></si>")).collect();
    files.extend([
        ("xl/workbook.xml".to_owned(), format!(r#"<workbook xmlns:r="a"><sheets>{list}</sheets></workbook>"#)),
        ("xl/_rels/workbook.xml.rels".to_owned(), format!("<Relationships>{links}</Relationships>")),
        ("xl/sharedStrings.xml".to_owned(), format!("<sst>{shared}</sst>")),
        ("xl/styles.xml".to_owned(), STYLES.to_owned()),
    ]);
    Content::Zip(files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect())
}

/// Cells of numbers from a place on.
fn numbers(letters: &[&str], first_row: usize, rows: &[&[f64]]) -> String {
    let row = |(place, values): (usize, &&[f64])| {
        let number = first_row + place;
        let cell = |(letter, value): (&&str, &f64)| format!(r#"<c r="{letter}{number}" s="1"><v>{value}</v></c>"#);
        let cells: String = letters.iter().zip(*values).map(cell).collect();
        format!(r#"<row r="{number}">{cells}</row>"#)
    };
    rows.iter().enumerate().map(row).collect()
}

/// Cells of rows from the first on, written as text with bars between them: numbers, `'texts`, `?1` truth values, `@3;5` numbers of a style.
fn rows(text: &str) -> String {
    let cell = |(place, cell): (usize, &str)| {
        let number = |number: &str, kind: &str| format!("<c {kind} r=\"{}\"><v>{number}</v></c>", letters(place));
        match cell.trim().split_at_checked(1) {
            None => String::new(),
            Some(("'", text)) => {
                format!(r#"<c t="inlineStr" r="{}"><is><t>{text}</t></is></c>"#, letters(place))
            }
            Some(("?", truth)) => number(truth, r#"t="b""#),
            Some(("@", styled)) => {
                let (style, value) = styled.split_once(';').unwrap();
                number(value, &format!(r#"s="{style}""#))
            }
            Some(_) => number(cell.trim(), ""),
        }
    };
    let lines = text.trim_end().lines().enumerate();
    let row = |(place, line): (usize, &str)| {
        let cells: String = line.split('|').enumerate().map(cell).collect();
        if cells.is_empty() { cells } else { format!(r#"<row r="{}">{cells}</row>"#, place + 1) }
    };
    lines.map(row).collect()
}

/// Letters of a column below 52.
fn letters(place: usize) -> String {
    let letter = char::from(b'A' + (place % 26) as u8);
    if place < 26 { letter.into() } else { format!("A{letter}") }
}

fn sheet(text: &str) -> Vec<u8> {
    workbook(&[("a", rows(text))]).bytes()
}

fn heights(text: &str) -> Scan {
    read_bytes(&sheet(text)).unwrap()
}

/// A profile in the columns B and C under the names of the columns.
fn profile() -> String {
    let names = r#"<row r="2"><c r="B2" t="s"><v>0</v></c><c r="C2" t="s"><v>1</v></c></row>"#;
    names.to_owned() + &numbers(&["B", "C"], 3, &[&[0.0, 1.0], &[0.5, 2.0], &[1.0, -1.0], &[1.5, 0.0]])
}

/// A matrix with the text of an error and an empty cell at the end of a row, without names of cells.
fn matrix() -> String {
    let cell = |value: &str| format!("<c><v>{value}</v></c>");
    let row = |cells: &[String]| format!("<row>{}</row>", cells.concat());
    let missing = r#"<c t="e"><v>#N/A</v></c>"#.to_owned();
    [
        row(&[cell("1e-6"), cell("2E-6"), cell("3e-6")]),
        row(&[cell("4e-6"), missing, cell("6e-6")]),
        row(&[cell("7e-6"), cell("8e-6")]),
    ]
    .concat()
}

/// A workbook of a roughness tester: the certificate, parameters, a curve of material and a profile in E and F.
fn mitutoyo() -> Content {
    let certificate = r#"<row r="48"><c r="D48" t="s"><v>2</v></c><c r="E48" t="s"><v>3</v></c></row>"#.to_owned();
    let mut data = String::new();
    for (row, height) in [0.25, -0.5, 0.125, 1.0, 0.5, 0.0].into_iter().enumerate() {
        let number = row + 1;
        let parameters =
            [format!(r#"<c r="A{number}" t="s"><v>4</v></c><c r="B{number}" t="s"><v>5</v></c>"#), String::new()];
        let curve = format!(r#"<c r="C{number}"><v>0.{number}</v></c>"#);
        data += &format!(
            r#"<row r="{number}">{}{}<c r="E{number}"><v>{}</v></c><c r="F{number}"><v>{height}</v></c></row>"#,
            parameters[row.min(1)],
            if row < 2 { curve } else { String::new() },
            0.0005 * number as f64,
        );
    }
    workbook(&[("Certificate", certificate), ("DATA", data)])
}

fn fixture(name: &'static str, content: Content) -> Fixture {
    Fixture { name, needed: content.bytes().len(), content }
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        fixture("XLSX of a profile", workbook(&[("profile", profile())])),
        fixture("XLSX of two sheets", workbook(&[("profile", profile()), ("a &amp; b", matrix())])),
        fixture("XLSX of a roughness tester", mitutoyo()),
    ]
}

#[test]
fn a_sheet_is_read_as_the_text_of_its_cells() {
    let scan = read_bytes(&workbook(&[("profile", profile())]).bytes()).unwrap();
    assert_eq!(scan.format, Some(Format::Xlsx));
    assert_heights(&scan, &[1e-6, 2e-6, -1e-6, 0.0]);
    assert_pitch(&scan, (5e-4, 5e-4));
    assert_eq!(scan.channels, ["z"]);
}

#[test]
fn the_sheet_with_the_most_numbers_is_the_main_one_and_others_are_chosen_by_name_or_number() {
    let bytes = workbook(&[("profile", profile()), ("a &amp; b", matrix()), ("note", String::new())]).bytes();
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["profile".to_owned(), "a & b".to_owned()][..], 0));
    for channel in ["2", "A & B"] {
        let scan = read_channel(&bytes, channel).unwrap();
        let nan = f64::NAN;
        assert_heights(&scan, &[1e-6, 2e-6, 3e-6, 4e-6, nan, 6e-6, 7e-6, 8e-6, nan]);
    }
    assert_error(read_channel(&bytes, "3"), "XLSX: no height map number 3; the file holds `profile`, `a & b`");
}

#[test]
fn a_workbook_of_a_roughness_tester_holds_positions_in_the_unit_of_the_cut_off() {
    let scan = read_bytes(&mitutoyo().bytes()).unwrap();
    assert_heights(&scan, &[0.25e-6, -0.5e-6, 0.125e-6, 1e-6, 0.5e-6, 0.0]);
    assert_pitch(&scan, (0.5e-6, 0.5e-6));
    assert_eq!(scan.height_unit.as_deref(), Some("µm"));
    assert_warns(&scan, "this is a profile");
}

#[test]
fn several_tables_in_a_sheet_and_damaged_cells_are_refused() {
    let of = |cells: String| workbook(&[("a", cells)]).bytes();
    let two = numbers(&["A", "B"], 1, &[&[1.0, 2.0], &[3.0], &[4.0], &[5.0], &[6.0]]);
    assert_refused([
        (of(two), "XLSX: columns A and B of 5 and 1 numbers in the sheet `a`; wanted one table per sheet"),
        (of(String::new()), "XLSX: no sheet holds numbers"),
        (of(numbers(&["B", "A"], 1, &[&[1.0, 2.0]])), "is `A1`; wanted cells in the order of their columns"),
        (of(numbers(&["ZZZZ"], 1, &[&[1.0]])), "is `ZZZZ1`"),
        (of(numbers(&["A"], 1 << 21, &[&[1.0]])), "is `2097152`; wanted rows in their order"),
        (of(numbers(&["A"], 5, &[&[1.0]]) + &numbers(&["A"], 5, &[&[1.0]])), "is `5`; wanted rows"),
        (of(r#"<c t="s"><v>99</v></c>"#.into()), "is `99`; wanted the number of a shared text"),
        (of("<row>".into()), "`</sheetData>` closes `<row>`"),
        (of("&a;".into()), "the entity &a; is unknown"),
    ]);
}

#[test]
fn truth_values_mark_valid_heights_and_are_no_heights() {
    let profile = |valid: [&str; 4]| {
        let [a, b, c, d] = valid;
        format!("'x [mm]|'z [um]|'Valid\n0|1|{a}\n0.5|2|{b}\n1|3|{c}\n1.5|4|{d}")
    };
    for valid in [["1", "0", "1", "1"], ["?1", "?0", "?1", "?1"], ["'True", "'FALSE", "'TRUE", "'true"]] {
        assert_heights(&heights(&profile(valid)), &[1e-6, f64::NAN, 3e-6, 4e-6]);
    }
    assert_refused([
        (sheet("1|2|3\n4|?1|6\n7|8|9"), "text: value 2 (line 2) is `TRUE`"),
        (sheet("1|2|3\n4|@2;45352|6\n7|8|9"), "text: value 2 (line 2) is `date 45352`"),
        (sheet("1|2|3\n4|@3;45352|6\n7|8|9"), "text: value 2 (line 2) is `date 45352`"),
    ]);
    assert_heights(&heights("1|2.5|3\n4|@1;5|6"), &[1.0, 2.5, 3.0, 4.0, 5.0, 6.0]);
    // A column of dates is no part of the table.
    assert_heights(&heights("'t|'x [mm]|'z [um]\n@2;1|0|1\n@2;2|1|2\n@2;3|2|3\n@2;4|3|9"), &[1e-6, 2e-6, 3e-6, 9e-6]);
}

#[test]
fn an_empty_row_or_column_between_equal_blocks_is_missing_and_other_gaps_are_refused() {
    let nan = f64::NAN;
    let scan = heights("1|2|4\n4|5|7\n\n7|8|8\n3|2|1");
    assert_heights(&scan, &[1.0, 2.0, 4.0, 4.0, 5.0, 7.0, nan, nan, nan, 7.0, 8.0, 8.0, 3.0, 2.0, 1.0]);
    assert_warns(&scan, "1 empty row inside the table");
    let scan = heights("1|2||4|9\n4|5||7|8\n3|2||1|1");
    assert_heights(&scan, &[1.0, 2.0, nan, 4.0, 9.0, 4.0, 5.0, nan, 7.0, 8.0, 3.0, 2.0, nan, 1.0, 1.0]);
    assert_warns(&scan, "1 empty column inside the table");
    let scan = heights("1\n2\n4\n\n8\n3");
    assert_heights(&scan, &[1.0, 2.0, 4.0, nan, 8.0, 3.0]);
    // An error or NaN fills a row.
    assert_heights(&heights("1|2\n4|5\n'NaN\n7|9"), &[1.0, 2.0, 4.0, 5.0, nan, nan, 7.0, 9.0]);
    let far = numbers(&["A", "B"], 1, &[&[1.0, 2.0]]) + &numbers(&["A", "B"], 1 << 20, &[&[1.0, 2.0]]);
    assert_refused([
        (
            workbook(&[("a", far)]).bytes(),
            "XLSX: blocks of numbers A1:B1 and A1048576:B1048576, divided by empty rows, in the sheet `a`",
        ),
        (sheet("1|2|4\n4|5|7\n\n\n7|8|8\n3|2|1"), "XLSX: blocks of numbers A1:C2 and A5:C6, divided by empty rows"),
        (sheet("1|2|4\n4|5|7\n\n7|8\n3|2"), "XLSX: blocks of numbers A1:C2 and A4:B5"),
        (sheet("1|2|4\n4|5|7\n\n3.5"), "XLSX: blocks of numbers A1:C2 and A4:A4"),
        (sheet("1|2|4\n4|5|7\n\n2.5|3.5|5.5"), "XLSX: blocks of numbers A1:C2 and A4:C4"),
        (sheet("1|2|4\n4|5|7\n3.5"), "XLSX: rows 2 and 3 of 3 and 1 numbers"),
        (sheet("1|2|4\n4|5|7\n'mean|5|7"), "text: value 1 (line 3) is `mean`"),
        (sheet("1|2||4\n4|5||8"), "XLSX: blocks of numbers A1:B2 and D1:D2, divided by empty columns"),
        (sheet("'x|'z||'x|'z\n1|2||1|9\n2|5||2|8\n3|2||3|1"), "XLSX: blocks of numbers A2:B4 and D2:E4"),
    ]);
}

#[test]
fn a_table_may_have_holes_of_any_form() {
    let nan = f64::NAN;
    let side = 40;
    let inside = |x: usize, y: usize| (2.0 * x as f64 - 39.0).powi(2) + (2.0 * y as f64 - 39.0).powi(2) < 1600.0;
    let height = |place: usize| {
        let (x, y) = (place % side, place / side);
        if inside(x, y) { (7 * x * x + 3 * x * y * y) as f64 % 11.0 } else { nan }
    };
    let wanted: Vec<f64> = (0..side * side).map(height).collect();
    let cell = |z: &f64| if z.is_nan() { String::new() } else { z.to_string() };
    let lines: Vec<String> =
        wanted.chunks(side).map(|row| row.iter().map(cell).collect::<Vec<_>>().join("|")).collect();
    assert_heights(&heights(&lines.join("\n")), &wanted);
    // The same with labels in text before the rows.
    let labelled: Vec<String> = lines.iter().map(|line| format!("'row|{line}")).collect();
    assert_heights(&heights(&labelled.join("\n")), &wanted);
    // Columns with one number.
    assert_heights(&heights("1|2||\n3|5|7|6\n4|1||"), &[1.0, 2.0, nan, nan, 3.0, 5.0, 7.0, 6.0, 4.0, 1.0, nan, nan]);
    // A row with a label alone.
    let scan = heights("|0|1|2|3\n0|5|7|6|2\n1\n2|8|1|1|4");
    assert_heights(&scan, &[5.0, 7.0, 6.0, 2.0, nan, nan, nan, nan, 8.0, 1.0, 1.0, 4.0]);
}

#[test]
fn texts_that_are_numbers_count_and_share_their_decimal_sign() {
    let read = |text: &str, decimal| read_bytes_with(&sheet(text), &ReadOptions { decimal, ..ReadOptions::default() });
    let wanted = [0.25, 1.5, -3.5, 4.0];
    for text in ["'0,25|'1,5\n'-3,5|'4", "'0,25|1.5\n-3.5|4", "0.25|'1,5\n-3.5|4", "'0.25|'1.5\n'-3.5|'4"] {
        assert_heights(&read(text, None).unwrap(), &wanted);
    }
    let one = "'1,234\n'2,345\n3.5\n4";
    assert_heights(&read(one, Some(Decimal::Comma)).unwrap(), &[1.234, 2.345, 3.5, 4.0]);
    assert_heights(&read(one, Some(Decimal::Point)).unwrap(), &[1234.0, 2345.0, 3.5, 4.0]);
    assert_error(read(one, None), "XLSX: `1,234` (line 1) may be 1.234 or 1234");
    assert_error(read("'0,5|'0.5\n1|2", None), "text: a decimal sign (line 1) is `.`; wanted a comma");
    assert_heights(&heights("'x [mm]|'z [um]\n0|'0,25\n0.5|'1,5\n1|'2,5\n1.5|4"), &[0.25e-6, 1.5e-6, 2.5e-6, 4e-6]);
}

#[test]
fn texts_above_a_table_state_units_and_names() {
    let nm = [1e-9, 2.5e-9, 4e-9, 3e-9, 5e-9, 7e-9];
    let table = "1|2.5|4\n3|5|7\n";
    for head in [
        "'Height [nm]\n",
        "'Unit|'nm\n",
        "'Unit:|'nm\n'Ra|0.8|'um\n\n",
        "'unit: nm\n'c0|'c1|'c2\n",
        "'Max. height (nm)\n\n",
    ] {
        assert_heights(&heights(&format!("{head}{table}")), &nm);
    }
    let scan = heights(&format!("'unit|'nm\n'pixel size|0.5|'um\n'at|@2;45352\n{table}'end\n"));
    assert_heights(&scan, &nm);
    assert_pitch(&scan, (0.5e-6, 0.5e-6));
    assert_error(read_bytes(&sheet(&format!("'Height [V]\n{table}"))), "text: numbers in `V`");
    assert_heights(&heights("'z [nm]\n1\n2.5\n4\n3\n5\n7"), &nm);
    // Numbers above a profile, and names with units.
    let profile = heights("'Ra|0.81|'um\n'x [mm]|'z [nm]\n0|1\n0.5|2.5\n1|4\n1.5|3\n2|5\n2.5|7");
    assert_heights(&profile, &nm);
    assert_pitch(&profile, (5e-4, 5e-4));
    let profile = heights("'Position|'1. Height\n'mm|'nm\n0|1\n0.5|2.5\n1|4\n1.5|3\n2|5\n2.5|7");
    assert_heights(&profile, &nm);
    let scan = heights(&format!("'unit|'nm\n'pixel size|'0.5 um\n{table}"));
    assert_pitch(&scan, (0.5e-6, 0.5e-6));
    // Labels around a text, and numbers behind a text that are none.
    let around = |labels: &str| format!("'y \\ x|{labels}\n0|5|7|6.5\n1|8|1|1\n2|8|2|1");
    let scan = heights(&around("0|0.5|1"));
    assert_heights(&scan, &[5.0, 7.0, 6.5, 8.0, 1.0, 1.0, 8.0, 2.0, 1.0]);
    assert_warns(&scan, "labels, which were left out");
    assert_refused([
        (sheet(&around("0|0.5|2")), "XLSX: a text at the start of row 1 before numbers that do not step evenly"),
        (sheet("'a|3|4|5\n1|2|4|5|6\n3|5|7|8|8"), "XLSX: row 1 with a text before 3 numbers"),
    ]);
}

#[test]
fn sections_of_cdata_are_text_and_visible_sheets_come_first() {
    let cells = r#"<row><c><v><![CDATA[5]]></v></c><c><v>1</v></c></row><row><c><v>2</v></c><c><v>4</v></c></row>"#;
    assert_heights(&read_bytes(&workbook(&[("a", cells.into())]).bytes()).unwrap(), &[5.0, 1.0, 2.0, 4.0]);
    // The state is written into the name.
    for (state, read) in [("hidden", 1), ("veryHidden", 1), ("visible", 0)] {
        let first = format!(r#"a" state="{state}"#);
        let scan = read_bytes(&workbook(&[(&first, rows("1|2|4\n4|5|7")), ("b", rows("1|2\n4|6"))]).bytes()).unwrap();
        assert_eq!(scan.channel, read, "{state}");
    }
    let wide = format!("<row>{}</row>", "<c><v>1</v></c>".repeat(1 << 17));
    assert_refused([
        (
            workbook(&[("a", numbers(&["A"], 5, &[&[1.0]]) + &numbers(&["A"], 4, &[&[1.0]]))]).bytes(),
            "sheet1.xml, byte 78) is `4`; wanted rows",
        ),
        (workbook(&[("a", wide)]).bytes(), "is `16385`; wanted 16384 columns at most"),
    ]);
}

#[test]
fn shared_texts_and_distant_cells_cannot_fill_the_memory() {
    let names: String =
        (1..200_000).map(|row| format!(r#"<row r="{row}"><c r="XFD{row}"><v>1</v></c><c/></row>"#)).collect();
    let bytes = workbook(&[("a", names)]).bytes();
    let (read, peak) = crate::memory::peak_bytes(|| read_bytes(&bytes));
    assert!(read.is_ok_and(|scan| scan.heights_m.len() == 199_999));
    assert!(peak < (64 << 20) + 2 * bytes.len(), "{peak}");
}

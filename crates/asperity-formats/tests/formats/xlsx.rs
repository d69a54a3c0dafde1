use asperity_formats::Format;

use crate::assert_heights;
use crate::check::{assert_error, assert_pitch, assert_refused, assert_warns};
use crate::fixture::{Content, Fixture, read_bytes, read_channel};

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
        (of(two), "XLSX: the columns of the sheet `a` hold from few to 5 numbers; wanted one table per sheet"),
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
fn shared_texts_and_distant_cells_cannot_fill_the_memory() {
    let names: String =
        (1..200_000).map(|row| format!(r#"<row r="{row}"><c r="XFD{row}"><v>1</v></c><c/></row>"#)).collect();
    let bytes = workbook(&[("a", names)]).bytes();
    let (read, peak) = crate::memory::peak_bytes(|| read_bytes(&bytes));
    assert!(read.is_ok_and(|scan| scan.heights_m.len() == 199_999));
    assert!(peak < (64 << 20) + 2 * bytes.len(), "{peak}");
}

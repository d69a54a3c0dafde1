//! Readers of the documents of a report.

use asperity_report::{Figure, Run, render};
use quick_xml::Reader;
use quick_xml::events::Event;

/// Reads the whole document and returns the number of elements; panics if it is not well-formed.
pub(crate) fn elements(xml: &str) -> usize {
    let mut reader = Reader::from_str(xml);
    reader.config_mut().check_end_names = true;
    let (mut depth, mut count) = (0i64, 0);
    loop {
        match reader.read_event().expect("well-formed XML") {
            Event::Start(tag) => {
                depth += 1;
                count += 1;
                tag.attributes().for_each(|attribute| drop(attribute.expect("well-formed attribute")));
            }
            Event::Empty(tag) => {
                count += 1;
                tag.attributes().for_each(|attribute| drop(attribute.expect("well-formed attribute")));
            }
            Event::End(_) => depth -= 1,
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(depth, 0, "every element is closed");
    count
}

/// Returns the document without its embedded images and with plain spaces, for searching.
pub(crate) fn text(document: &str) -> String {
    let mut parts = document.split("data:image/png;base64,");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once('"').unwrap().1).replace('\u{a0}', " ")
}

/// Returns a page without its scripts and the data of its figures, after a check that no tag begins in the data.
pub(crate) fn without_scripts(html: &str) -> String {
    let mut parts = html.split("<script");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| {
        let (script, rest) = part.split_once("</script>").expect("a closed script");
        let is_data = script.starts_with(" type=\"application/json\">") && !script.contains('<');
        assert!(script.starts_with('>') || script.starts_with(" type=\"text/plain\"") || is_data);
        all + rest
    })
}

/// Returns the values of `src` and `href` attributes.
pub(crate) fn resources(html: &str) -> Vec<&str> {
    let after = |marker: &'static str| html.split(marker).skip(1).map(|rest| rest.split('"').next().unwrap());
    after("src=\"").chain(after("href=\"")).collect()
}

/// Returns the texts of a figure.
pub(crate) fn words(run: &Run, name: &str) -> Vec<String> {
    let svg = render(run).unwrap().figures.into_iter().find(|figure| figure.name == name).unwrap().svg;
    let pieces =
        svg.split('<').filter_map(|piece| piece.split_once('>')).map(|(_, text)| text.trim().replace('\u{a0}', " "));
    pieces.filter(|text| !text.is_empty()).collect()
}

/// Asserts that a figure is a well-formed document of legible text that loads nothing.
pub(crate) fn check_figure(figure: &Figure) {
    assert!(elements(&figure.svg) > 10, "{}", figure.name);
    let inside = |resource: &&str| resource.starts_with('#') || resource.starts_with("data:image/png;base64,");
    assert!(resources(&figure.svg).iter().all(inside), "{} loads nothing", figure.name);
    // Nothing is smaller than 12 px at 640 px.
    for size in figure.svg.split("font-size=\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
        assert!(size.parse::<f64>().unwrap() >= 12.0, "{}: font size {size}", figure.name);
    }
    // The letters of an image are no text.
    let drawn = figure.svg.split("base64,").map(|part| part.split_once('"').map_or("", |(_, rest)| rest));
    assert!(drawn.clone().all(|part| !part.contains("NaN")) && !text(&figure.svg).contains("inf"), "{}", figure.name);
}

/// Asserts that a page loads nothing from elsewhere.
pub(crate) fn check_page(html: &str) {
    for resource in resources(html) {
        assert!(resource.starts_with('#') || resource.starts_with("data:image/png;base64,"), "{resource:.60}");
    }
    for forbidden in ["<script", "<link", "@import", "url("] {
        assert!(!without_scripts(html).contains(forbidden), "{forbidden}");
    }
}

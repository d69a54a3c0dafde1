//! Reading the documents that a report consists of.

use quick_xml::Reader;
use quick_xml::events::Event;

/// Reads the whole document and returns the number of elements; panics where it is not well-formed.
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

/// The document without its embedded images, with its slashes unescaped, for searching.
pub(crate) fn text(document: &str) -> String {
    let mut parts = document.split("data:image/png;base64,");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once('"').unwrap().1).replace("&#x2f;", "/").replace('\u{a0}', " ")
}

/// Values of `src` and `href` attributes.
pub(crate) fn resources(html: &str) -> Vec<&str> {
    let after = |marker: &'static str| html.split(marker).skip(1).map(|rest| rest.split('"').next().unwrap());
    after("src=\"").chain(after("href=\"")).collect()
}

//! HTML in which every text is escaped.

use std::fmt::{self, Display};

/// Characters that have a meaning in HTML and SVG; `&` is the last to be unescaped.
const ESCAPES: [(char, &str); 5] = [('<', "&lt;"), ('>', "&gt;"), ('"', "&quot;"), ('\'', "&#39;"), ('&', "&amp;")];

/// Replaces the characters that have a meaning in HTML and SVG.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match ESCAPES.iter().find(|(special, _)| *special == character) {
            Some((_, escape)) => escaped += escape,
            None => escaped.push(character),
        }
    }
    escaped
}

/// A piece of HTML. A string becomes HTML by being escaped; only literals of this crate and its drawings are taken as they are.
#[derive(Debug, Clone, Default)]
pub(crate) struct Html(String);

impl Html {
    /// Takes a literal of this crate or a drawing of [`crate::plot::draw`], in which texts are escaped already.
    pub(crate) fn from_markup(markup: String) -> Self {
        Self(markup)
    }

    pub(crate) fn into_string(self) -> String {
        self.0
    }

    /// Returns the text without tags.
    pub(crate) fn text(&self) -> String {
        let mut pieces = self.0.split('<');
        let first = pieces.next().unwrap_or_default().to_owned();
        let text = pieces.fold(first, |text, piece| text + piece.split_once('>').map_or(piece, |(_, after)| after));
        ESCAPES.iter().fold(text, |text, (character, escape)| text.replace(escape, &character.to_string()))
    }
}

impl<T: AsRef<str>> From<T> for Html {
    fn from(text: T) -> Self {
        Self(escape(text.as_ref()))
    }
}

impl From<&Html> for Html {
    fn from(html: &Html) -> Self {
        html.clone()
    }
}

impl FromIterator<Html> for Html {
    fn from_iter<I: IntoIterator<Item = Html>>(pieces: I) -> Self {
        Self(pieces.into_iter().map(|piece| piece.0).collect())
    }
}

impl Display for Html {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Fills a literal template with HTML and with texts, which are escaped: `html!("<li>{}</li>", text)`.
///
/// `concat!` keeps the template from capturing variables, whose text would not be escaped.
macro_rules! html {
    ($template:expr, $($name:ident = $value:expr),+ $(,)?) => {
        $crate::markup::Html::from_markup(format!(concat!($template), $($name = $crate::markup::Html::from($value)),+))
    };
    ($template:expr $(, $value:expr)* $(,)?) => {
        $crate::markup::Html::from_markup(format!(concat!($template) $(, $crate::markup::Html::from($value))*))
    };
}
pub(crate) use html;

/// Returns a text with the names between backticks as code.
pub(crate) fn with_code(text: &str) -> Html {
    let part = |(place, part): (usize, &str)| match place % 2 {
        0 => Html::from(part.to_owned()),
        _ => html!("<code>{}</code>", part),
    };
    text.split('`').enumerate().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_of_html_has_no_tags_and_no_escapes() {
        assert_eq!(html!("a <strong class=\"b\">{}</strong>.", "&lt; < c & d").text(), "a &lt; < c & d.");
    }

    #[test]
    fn texts_are_escaped_and_html_is_not() {
        let evil = "\"><b>&'".to_owned();
        let item = html!("<li title=\"{title}\">{text}</li>", title = &evil, text = &evil);
        let escaped = "&quot;&gt;&lt;b&gt;&amp;&#39;";
        let wanted = format!("<li title=\"{escaped}\">{escaped}</li>");
        assert_eq!(item.to_string(), wanted);
        let list = html!("<ul>{}</ul>", [item, html!("<li/>")].into_iter().collect::<Html>());
        assert_eq!(list.into_string(), format!("<ul>{wanted}<li/></ul>"));
    }
}

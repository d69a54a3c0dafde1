//! A drawing surface in pixels that writes SVG.

use std::fmt::{self, Display};
use std::mem;

use crate::markup::escape;

const FONT_FAMILY: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";
/// Size of tick labels and legends in pixels.
pub(crate) const TEXT: f64 = 13.0;
/// Size of axis labels in pixels.
pub(crate) const LABEL: f64 = 14.0;
/// Colour of axes and text.
pub(crate) const INK: Colour = Colour(34, 34, 34);
/// Colour of the background.
pub(crate) const WHITE: Colour = Colour(255, 255, 255);
/// Pen of frames and ticks.
pub(crate) const THIN: Pen = Pen::new(INK, 1.0, Dash::Solid);
/// Pen of grid lines.
pub(crate) const GRID: Pen = Pen::new(Colour(226, 226, 226), 0.8, Dash::Solid);

/// A colour in sRGB: red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Colour(pub(crate) u8, pub(crate) u8, pub(crate) u8);

impl Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(red, green, blue) = self;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

/// A point in pixels, y downward.
pub(crate) type Point = (f64, f64);

/// A rectangle in pixels, y downward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Rect {
    pub(crate) fn new(left: f64, top: f64, width: f64, height: f64) -> Self {
        Self { left, top, right: left + width, bottom: top + height }
    }

    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub(crate) fn centre(&self) -> Point {
        (0.5 * (self.left + self.right), 0.5 * (self.top + self.bottom))
    }

    /// Reports whether a point lies in the rectangle, with half a pixel to spare.
    pub(crate) fn contains(&self, (x, y): Point) -> bool {
        x >= self.left - 0.5 && x <= self.right + 0.5 && y >= self.top - 0.5 && y <= self.bottom + 0.5
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }
}

/// Dash pattern of a line, so that curves differ without colour too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Dash {
    Solid,
    Dashed,
    Dotted,
    Alternating,
    Long,
    Short,
    DoubleDotted,
    LongShort,
    Sparse,
}

impl Dash {
    /// Returns the lengths drawn and left out in turn, in pixels.
    fn lengths(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[8.0, 4.0],
            Self::Dotted => &[2.0, 3.0],
            Self::Alternating => &[10.0, 3.5, 2.0, 3.5],
            Self::Long => &[16.0, 5.0],
            Self::Short => &[4.0, 2.5],
            Self::DoubleDotted => &[9.0, 3.0, 2.0, 3.0, 2.0, 3.0],
            Self::LongShort => &[14.0, 4.0, 5.0, 4.0],
            Self::Sparse => &[2.0, 6.0],
        }
    }

    /// Returns the SVG attribute of the lengths.
    fn attribute(self) -> String {
        match self.lengths() {
            [] => String::new(),
            lengths => {
                let lengths: Vec<String> = lengths.iter().map(f64::to_string).collect();
                format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
            }
        }
    }
}

/// Colour, width in pixels, dash and opacity of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pen {
    pub(crate) colour: Colour,
    pub(crate) width: f64,
    pub(crate) dash: Dash,
    pub(crate) opacity: f64,
}

impl Pen {
    pub(crate) const fn new(colour: Colour, width: f64, dash: Dash) -> Self {
        Self { colour, width, dash, opacity: 1.0 }
    }
}

/// Position of a text relative to its point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Align {
    Start,
    Middle,
    End,
    /// Turned by 90° anticlockwise, centred.
    Upward,
}

/// A figure under construction.
#[derive(Default)]
pub(crate) struct Canvas {
    body: String,
}

/// Rounds a coordinate to a tenth of a pixel.
pub(crate) fn px(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

fn path(points: &[Point]) -> String {
    points.iter().map(|(x, y)| format!("{},{}", px(*x), px(*y))).collect::<Vec<_>>().join(" ")
}

fn opaque(opacity: f64) -> String {
    if opacity == 1.0 { String::new() } else { format!(" opacity=\"{opacity}\"") }
}

/// Draws an SVG document of `width` × `height` pixels, `mm` millimetres wide in print, with an accessible title and description.
pub(crate) fn draw(
    (width, height): (f64, f64),
    mm: f64,
    title: &str,
    description: &str,
    content: impl FnOnce(&mut Canvas),
) -> String {
    let mut canvas = Canvas::default();
    content(&mut canvas);
    let (width, height, title, description) = (px(width), px(height), escape(title), escape(description));
    let tall = px(mm * height / width);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{mm}mm\" height=\"{tall}mm\" viewBox=\"0 0 {width} {height}\" \
         role=\"img\" aria-label=\"{title}\" stroke-linejoin=\"round\" font-family=\"{FONT_FAMILY}\">\n\
         <title>{title}</title>\n<desc>{description}</desc>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"{WHITE}\"/>\n{}</svg>\n",
        canvas.body
    )
}

impl Canvas {
    /// Draws a group with attributes; an empty one is left out.
    pub(crate) fn group(&mut self, attributes: &[(&str, &str)], content: impl FnOnce(&mut Self)) {
        let before = mem::take(&mut self.body);
        content(self);
        let inner = mem::replace(&mut self.body, before);
        if !inner.is_empty() {
            let attributes = attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", escape(value)));
            self.body += &format!("<g{}>\n{inner}</g>\n", attributes.collect::<String>());
        }
    }

    /// Draws around a point, which is the origin of the content. The page's script moves the content as a whole when it zooms.
    pub(crate) fn at(&mut self, (x, y): Point, content: impl FnOnce(&mut Self)) {
        self.group(&[("transform", &format!("translate({},{})", px(x), px(y)))], content);
    }

    /// Draws a line through points.
    pub(crate) fn line(&mut self, points: &[Point], pen: Pen) {
        self.body += &format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{}{}/>\n",
            path(points),
            pen.colour,
            px(pen.width),
            pen.dash.attribute(),
            opaque(pen.opacity)
        );
    }

    /// Draws a filled polygon.
    pub(crate) fn polygon(&mut self, points: &[Point], colour: Colour, opacity: f64) {
        self.body += &format!("<polygon points=\"{}\" fill=\"{colour}\"{}/>\n", path(points), opaque(opacity));
    }

    /// Draws a filled rectangle.
    pub(crate) fn fill(&mut self, rect: Rect, colour: Colour, opacity: f64) {
        let Rect { left, top, right, bottom } = rect;
        self.polygon(&[(left, top), (right, top), (right, bottom), (left, bottom)], colour, opacity);
    }

    /// Draws the outline of a rectangle.
    pub(crate) fn frame(&mut self, rect: Rect, pen: Pen) {
        let Rect { left, top, right, bottom } = rect;
        self.line(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top), (right, top)], pen);
    }

    /// Draws a filled disc with a white rim, so that it stands out on curves.
    pub(crate) fn disc(&mut self, centre: Point, radius: f64, colour: Colour) {
        self.dot(centre, radius + 1.0, WHITE, 1.0);
        self.dot(centre, radius, colour, 1.0);
    }

    /// Draws a filled disc without a rim.
    pub(crate) fn dot(&mut self, (x, y): Point, radius: f64, colour: Colour, opacity: f64) {
        let (x, y, radius, opacity) = (px(x), px(y), px(radius), opaque(opacity));
        self.body += &format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{colour}\"{opacity}/>\n");
    }

    /// Writes a text whose vertical middle lies at the point; an empty text is left out.
    pub(crate) fn text(&mut self, (x, y): Point, text: &str, size: f64, align: Align) {
        if text.is_empty() {
            return;
        }
        let (x, y, text) = (px(x), px(y), escape(text));
        let (anchor, turn) = match align {
            Align::Start => ("start", String::new()),
            Align::Middle => ("middle", String::new()),
            Align::End => ("end", String::new()),
            Align::Upward => ("middle", format!(" transform=\"rotate(-90,{x},{y})\"")),
        };
        self.body += &format!(
            "<text x=\"{x}\" y=\"{y}\" dy=\"0.5ex\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"{INK}\"{turn}>{text}</text>\n"
        );
    }

    /// Places a PNG image over a rectangle, its pixels kept sharp.
    pub(crate) fn image(&mut self, rect: Rect, data_uri: &str) {
        let (x, y, width, height) = (px(rect.left), px(rect.top), px(rect.width()), px(rect.height()));
        self.body += &format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
             image-rendering=\"pixelated\" href=\"{data_uri}\"/>\n"
        );
    }
}

/// Returns the width of a text in pixels from typical widths of sans-serif letters; only the viewer knows its fonts.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let width = |c: char| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | ' ' | '.' | ',' | ':' | '(' | ')' | '’' | '“' | '”' => 0.34,
        'm' | 'w' | 'M' | 'W' | '%' => 0.88,
        c if c.is_uppercase() => 0.70,
        _ => 0.58,
    };
    size * text.chars().map(width).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_written_in_tenths_of_a_pixel_with_their_dashes() {
        let mut canvas = Canvas::default();
        let pen = Pen { opacity: 0.5, ..Pen::new(Colour(0, 114, 178), 1.8, Dash::Dashed) };
        canvas.line(&[(0.0, 1.04), (30.06, 2.0)], pen);
        let wanted = "<polyline points=\"0,1 30.1,2\" fill=\"none\" stroke=\"#0072b2\" stroke-width=\"1.8\" \
                      stroke-dasharray=\"8 4\" opacity=\"0.5\"/>\n";
        assert_eq!(canvas.body, wanted);
    }

    #[test]
    fn the_header_states_pixels_and_the_text_is_escaped() {
        let svg = draw((640.0, 300.0), 170.0, "a < b & \"c\"", "d", |canvas| {
            canvas.text((10.0, 10.0), "<script>", TEXT, Align::Start);
        });
        assert!(svg.contains("width=\"170mm\" height=\"79.7mm\""));
        assert!(svg.contains("viewBox=\"0 0 640 300\""));
        assert!(svg.contains("a &lt; b &amp; &quot;c&quot;"));
        assert!(svg.contains("&lt;script&gt;") && !svg.contains("<script>"));
        assert!(svg.contains("font-size=\"13\""));
    }
}

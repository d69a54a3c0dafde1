//! A drawing surface in pixels with a tenth of a pixel as resolution, over the SVG backend of plotters.
//!
//! The backend places everything at whole units, which would show as steps in a curve. The canvas therefore draws on
//! ten units per pixel and states the true size in the header, so that a figure is 640 px wide and smooth.

use plotters::prelude::{Color, DrawingBackend, FontFamily, IntoFont, RGBColor, SVGBackend, ShapeStyle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontTransform, TextStyle};

use crate::ReportError;

/// Units of the drawing per pixel.
const UNITS: f64 = 10.0;
/// plotters divides a font size by this factor when it writes SVG.
const FONT_SCALE: f64 = 1.24;
const FONT_FAMILY: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";
/// Size of tick labels and legends in pixels.
pub(crate) const TEXT: f64 = 13.0;
/// Size of axis labels in pixels.
pub(crate) const LABEL: f64 = 14.0;
/// Colour of axes and text.
pub(crate) const INK: RGBColor = RGBColor(34, 34, 34);
/// Colour of grid lines.
pub(crate) const GRID: RGBColor = RGBColor(226, 226, 226);

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

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }
}

/// How a line is broken, so that curves differ without colour too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Dash {
    Solid,
    Dashed,
    Dotted,
    Alternating,
    Long,
}

impl Dash {
    /// Lengths drawn and left out in turn, in pixels.
    fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[8.0, 4.0],
            Self::Dotted => &[2.0, 3.0],
            Self::Alternating => &[10.0, 3.5, 2.0, 3.5],
            Self::Long => &[16.0, 5.0],
        }
    }
}

/// Colour, width in pixels, dash and opacity of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pen {
    pub(crate) colour: RGBColor,
    pub(crate) width: f64,
    pub(crate) dash: Dash,
    pub(crate) opacity: f64,
}

impl Pen {
    pub(crate) fn new(colour: RGBColor, width: f64, dash: Dash) -> Self {
        Self { colour, width, dash, opacity: 1.0 }
    }

    fn style(&self) -> ShapeStyle {
        let width = (self.width * UNITS).round().max(1.0) as u32;
        self.colour.mix(self.opacity).stroke_width(width)
    }
}

/// Where a text lies relative to its point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Align {
    Start,
    Middle,
    End,
    /// Turned by 90° anticlockwise, centred.
    Upward,
}

/// The figure while it is drawn.
pub(crate) struct Canvas<'a> {
    backend: SVGBackend<'a>,
    images: String,
}

fn units((x, y): (f64, f64)) -> (i32, i32) {
    ((x * UNITS).round() as i32, (y * UNITS).round() as i32)
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// An SVG document of `width` × `height` pixels with an accessible title and description.
///
/// # Errors
/// Whatever `content` reports.
pub(crate) fn draw(
    (width, height): (f64, f64),
    title: &str,
    description: &str,
    content: impl FnOnce(&mut Canvas<'_>) -> Result<(), ReportError>,
) -> Result<String, ReportError> {
    let mut raw = String::new();
    let size = ((width * UNITS) as u32, (height * UNITS) as u32);
    let images = {
        let mut canvas = Canvas { backend: SVGBackend::with_string(&mut raw, size), images: String::new() };
        content(&mut canvas)?;
        canvas.backend.present().map_err(|error| ReportError::Drawing { message: error.to_string() })?;
        std::mem::take(&mut canvas.images)
    };
    // The first tag is the backend's header; maps lie below everything that it drew.
    let body = raw.split_once('>').map_or("", |(_, body)| body);
    let (title, description) = (escape(title), escape(description));
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {w} {h}\" role=\"img\" aria-label=\"{title}\" stroke-linejoin=\"round\">\n\
         <title>{title}</title>\n<desc>{description}</desc>\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{images}{body}",
        w = size.0,
        h = size.1,
    ))
}

impl Canvas<'_> {
    fn check<E: std::fmt::Display>(result: Result<(), E>) -> Result<(), ReportError> {
        result.map_err(|error| ReportError::Drawing { message: error.to_string() })
    }

    /// A line through points, broken as the pen says.
    pub(crate) fn line(&mut self, points: &[(f64, f64)], pen: Pen) -> Result<(), ReportError> {
        let style = pen.style();
        for piece in dashes(points, pen.dash.pattern()) {
            let mut path: Vec<(i32, i32)> = piece.into_iter().map(units).collect();
            path.dedup();
            if path.len() > 1 {
                Self::check(self.backend.draw_path(path, &style))?;
            }
        }
        Ok(())
    }

    /// A filled polygon.
    pub(crate) fn polygon(&mut self, points: &[(f64, f64)], colour: RGBColor, opacity: f64) -> Result<(), ReportError> {
        let style = colour.mix(opacity).filled();
        Self::check(self.backend.fill_polygon(points.iter().copied().map(units), &style))
    }

    /// A filled rectangle.
    pub(crate) fn fill(&mut self, rect: Rect, colour: RGBColor) -> Result<(), ReportError> {
        let (from, to) = (units((rect.left, rect.top)), units((rect.right, rect.bottom)));
        Self::check(self.backend.draw_rect(from, to, &colour.filled(), true))
    }

    /// The outline of a rectangle.
    pub(crate) fn frame(&mut self, rect: Rect, pen: Pen) -> Result<(), ReportError> {
        let Rect { left, top, right, bottom } = rect;
        self.line(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top), (right, top)], pen)
    }

    /// A filled disc with a white rim, so that it stands out on curves.
    pub(crate) fn disc(&mut self, centre: (f64, f64), radius: f64, colour: RGBColor) -> Result<(), ReportError> {
        for (radius, colour) in [(radius + 1.0, RGBColor(255, 255, 255)), (radius, colour)] {
            let radius = (radius * UNITS).round() as u32;
            Self::check(self.backend.draw_circle(units(centre), radius, &colour.filled(), true))?;
        }
        Ok(())
    }

    /// A small filled disc without a rim.
    pub(crate) fn dot(
        &mut self,
        centre: (f64, f64),
        radius: f64,
        colour: RGBColor,
        opacity: f64,
    ) -> Result<(), ReportError> {
        let radius = (radius * UNITS).round() as u32;
        Self::check(self.backend.draw_circle(units(centre), radius, &colour.mix(opacity).filled(), true))
    }

    /// A text whose vertical middle lies at the point.
    pub(crate) fn text(&mut self, at: (f64, f64), text: &str, size: f64, align: Align) -> Result<(), ReportError> {
        let mut font = (FontFamily::Name(FONT_FAMILY), size * UNITS * FONT_SCALE).into_font();
        if align == Align::Upward {
            font = font.transform(FontTransform::Rotate270);
        }
        let horizontal = match align {
            Align::Start => HPos::Left,
            Align::Middle | Align::Upward => HPos::Center,
            Align::End => HPos::Right,
        };
        let style = TextStyle::from(font).color(&INK).pos(Pos::new(horizontal, VPos::Center));
        Self::check(self.backend.draw_text(text, &style, units(at)))
    }

    /// A PNG image stretched over a rectangle, its pixels kept sharp, below all that is drawn.
    pub(crate) fn image(&mut self, rect: Rect, data_uri: &str) {
        let ((x, y), (right, bottom)) = (units((rect.left, rect.top)), units((rect.right, rect.bottom)));
        self.images.push_str(&format!(
            "<image x=\"{x}\" y=\"{y}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"{data_uri}\"/>\n",
            right - x,
            bottom - y,
        ));
    }
}

/// The drawn pieces of a broken line.
fn dashes(points: &[(f64, f64)], pattern: &[f64]) -> Vec<Vec<(f64, f64)>> {
    if pattern.is_empty() {
        return vec![points.to_vec()];
    }
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
    let (mut index, mut left) = (0, pattern[0]);
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let at = (from.0 + (to.0 - from.0) * done / length, from.1 + (to.1 - from.1) * done / length);
            if index % 2 == 0 {
                piece.push(at);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![at];
            }
            index = (index + 1) % pattern.len();
            left = pattern[index];
        }
        left -= length - done;
        if index % 2 == 0 {
            piece.push(to);
        }
    }
    if index % 2 == 0 && piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

/// Width of a text in pixels from typical widths of sans-serif letters; fonts are known to the viewer only.
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
    fn dashes_cover_the_drawn_share_of_the_path_and_follow_its_corners() {
        let path = [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0)];
        let pieces = dashes(&path, &[8.0, 4.0]);
        let length = |points: &Vec<(f64, f64)>| -> f64 {
            points.windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum()
        };
        // 60 px hold exactly five periods of 12 px, each with 8 px drawn.
        assert_eq!(pieces.len(), 5);
        assert!((pieces.iter().map(length).sum::<f64>() - 40.0).abs() < 1e-9);
        assert!(pieces.iter().any(|piece| piece.contains(&(30.0, 0.0))));
        assert_eq!(dashes(&path, &[]), vec![path.to_vec()]);
    }

    #[test]
    fn the_header_states_pixels_and_the_text_is_escaped() {
        let svg = draw((640.0, 300.0), "a < b & \"c\"", "d", |canvas| {
            canvas.text((10.0, 10.0), "<script>", TEXT, Align::Start)
        })
        .unwrap();
        assert!(svg.contains("width=\"640\" height=\"300\""));
        assert!(svg.contains("viewBox=\"0 0 6400 3000\""));
        assert!(svg.contains("a &lt; b &amp; &quot;c&quot;"));
        assert!(svg.contains("&lt;script&gt;") && !svg.contains("<script>"));
        assert!(svg.contains("font-size=\"130\""));
    }
}

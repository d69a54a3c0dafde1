//! Indexed images: the colours of values, and the bar that explains them.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use crate::ReportError;
use crate::plot::axis::Axis;
use crate::plot::canvas::{Align, Canvas, Colour, LABEL, Rect, TEXT, THIN, WHITE, text_width};
use crate::plot::palette::{HARDNESS, MISSING, NO_CONTACT, colour_scale};

/// Palette entry of missing points.
pub(crate) const MISSING_ENTRY: u8 = 0;
/// Palette entry of pressures of exactly zero.
pub(crate) const NO_CONTACT_ENTRY: u8 = 1;
/// Palette entry of pressures at the hardness.
pub(crate) const HARDNESS_ENTRY: u8 = 2;
/// Number of palette entries below the colour scale.
const RESERVED: u8 = 3;
const COLOURS: usize = 253;

/// Returns the palette of values: missing, no contact, at the hardness, then the colour scale.
pub(crate) fn scale_palette() -> Vec<Colour> {
    let scale = (0..COLOURS).map(|i| colour_scale(i as f64 / (COLOURS - 1) as f64));
    [MISSING, NO_CONTACT, HARDNESS].into_iter().chain(scale).collect()
}

/// Returns the entry of [`scale_palette`] for a value in [0, 1]; values beyond saturate.
pub(crate) fn shade(t: f64) -> u8 {
    RESERVED + (t.clamp(0.0, 1.0) * (COLOURS - 1) as f64).round() as u8
}

/// Encodes `nx` × `ny` entries of a palette, row by row from the top, as the data URI of a PNG image. White is transparent, so that maps
/// have the background of the page.
///
/// # Errors
/// The PNG encoder failed.
pub(crate) fn indexed(nx: usize, ny: usize, indices: &[u8], palette: Vec<Colour>) -> Result<String, ReportError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, nx as u32, ny as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.iter().flat_map(|colour| [colour.0, colour.1, colour.2]).collect::<Vec<u8>>());
    if let Some(last) = palette.iter().rposition(|colour| *colour == WHITE) {
        let opacities = palette[..=last].iter().map(|colour| if *colour == WHITE { 0 } else { 255 });
        encoder.set_trns(opacities.collect::<Vec<u8>>());
    }
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(indices))
        .map_err(|error| ReportError::Image { message: error.to_string() })?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

/// A colour scale that is ready to be drawn.
#[derive(Debug, Clone)]
pub(crate) struct ColourBar {
    pub(crate) axis: Axis,
    data_uri: String,
}

impl ColourBar {
    /// Prepares the colour scale of an axis.
    ///
    /// # Errors
    /// The PNG encoder failed.
    pub(crate) fn new(axis: Axis) -> Result<Self, ReportError> {
        let scale: Vec<u8> = (0..COLOURS).rev().map(|i| RESERVED + i as u8).collect();
        Ok(Self { axis, data_uri: indexed(1, COLOURS, &scale, scale_palette())? })
    }

    /// Draws the scale into `bar`, with the ticks and the label of its axis at the right.
    pub(crate) fn draw(&self, canvas: &mut Canvas, bar: Rect) {
        canvas.image(bar, &self.data_uri);
        canvas.frame(bar, THIN);
        let mut widest: f64 = 0.0;
        for tick in self.axis.ticks((bar.height() / 110.0).max(2.0) as usize) {
            let at = bar.bottom - tick.position * bar.height();
            canvas.line(&[(bar.right, at), (bar.right + 4.0, at)], THIN);
            canvas.text((bar.right + 8.0, at), &tick.label, TEXT, Align::Start);
            widest = widest.max(text_width(&tick.label, TEXT));
        }
        let place = (bar.right + 8.0 + widest + 14.0, bar.centre().1);
        canvas.text(place, &self.axis.label(), LABEL, Align::Upward);
    }
}

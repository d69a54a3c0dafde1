//! Indexed images: colours of values, and the bar that explains them.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use plotters::prelude::RGBColor;

use crate::ReportError;
use crate::axis::Axis;
use crate::canvas::{Align, Canvas, Dash, INK, LABEL, Pen, Rect, TEXT, text_width};
use crate::palette::{MISSING, NO_CONTACT, colour_scale};

/// Palette entries below the colour scale: missing points, then points at exactly zero.
const RESERVED: u8 = 2;
const COLOURS: usize = 254;

/// The palette of values: missing, no contact, then the colour scale.
pub(crate) fn scale_palette() -> Vec<RGBColor> {
    let scale = (0..COLOURS).map(|i| colour_scale(i as f64 / (COLOURS - 1) as f64));
    [MISSING, NO_CONTACT].into_iter().chain(scale).collect()
}

/// The entry of [`scale_palette`] for a value in [0, 1]; values beyond saturate.
pub(crate) fn shade(t: f64) -> u8 {
    RESERVED + (t.clamp(0.0, 1.0) * (COLOURS - 1) as f64).round() as u8
}

/// An image of `nx` × `ny` entries of a palette, row by row from the top, as a data URI.
///
/// # Errors
/// The PNG encoder's.
pub(crate) fn indexed(nx: usize, ny: usize, indices: &[u8], palette: Vec<RGBColor>) -> Result<String, ReportError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, nx as u32, ny as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.iter().flat_map(|colour| [colour.0, colour.1, colour.2]).collect::<Vec<u8>>());
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(indices))
        .map_err(|error| ReportError::Image { message: error.to_string() })?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}

/// Draws the colour scale into `bar`, with the ticks and the label of an axis at the right.
///
/// # Errors
/// The drawing backend's and the PNG encoder's.
pub(crate) fn colour_bar(canvas: &mut Canvas<'_>, bar: Rect, axis: &Axis) -> Result<(), ReportError> {
    let scale: Vec<u8> = (0..COLOURS).rev().map(|i| RESERVED + i as u8).collect();
    canvas.image(bar, &indexed(1, COLOURS, &scale, scale_palette())?);
    let pen = Pen::new(INK, 1.0, Dash::Solid);
    canvas.frame(bar, pen)?;
    let mut widest: f64 = 0.0;
    for tick in axis.ticks((bar.height() / 110.0).max(2.0) as usize) {
        let at = bar.bottom - tick.position * bar.height();
        canvas.line(&[(bar.right, at), (bar.right + 4.0, at)], pen)?;
        canvas.text((bar.right + 8.0, at), &tick.label, TEXT, Align::Start)?;
        widest = widest.max(text_width(&tick.label, TEXT));
    }
    let middle = 0.5 * (bar.top + bar.bottom);
    canvas.text((bar.right + 8.0 + widest + 14.0, middle), &axis.label(), LABEL, Align::Upward)
}

//! Maps as images: fields become indexed PNGs with a colour bar.

use crate::axis::Axis;
use crate::canvas::{Align, Canvas, Dash, INK, LABEL, Pen, Rect, TEXT, text_width};
use crate::chart::fitting_ticks;
use crate::format::{Dimension, Unit};
use crate::image;
use crate::palette::{MISSING, NO_CONTACT};
use crate::{Field, ReportError};

/// Larger fields are averaged over blocks before they are embedded.
const MOST_POINTS: usize = 640 * 640;
const MOST_ALONG: usize = 2600;

/// What a field holds, and so how it is coloured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// Heights: relative to their mean.
    Height,
    /// Pressures: from zero; points at exactly zero carry no contact.
    Pressure,
    /// Contact probabilities, between the least and the largest.
    Probability,
    /// Relative errors, from zero.
    Error,
}

/// A field ready to be embedded.
#[derive(Debug, Clone)]
pub(crate) struct Raster {
    data_uri: String,
    kind: Kind,
    width_m: f64,
    height_m: f64,
    /// Ends of the colour scale in SI units.
    low: f64,
    high: f64,
    /// Points along an edge that were averaged into one pixel.
    pub(crate) block: usize,
    pub(crate) missing: usize,
}

/// The mean over present points of blocks of k × k points; a block mostly missing is missing.
fn averaged(field: &Field, block: usize) -> (usize, usize, Vec<f64>) {
    if block == 1 {
        return (field.nx, field.ny, field.values.clone());
    }
    let (nx, ny) = (field.nx.div_ceil(block), field.ny.div_ceil(block));
    let mut means = Vec::with_capacity(nx * ny);
    for row in 0..ny {
        for column in 0..nx {
            let (mut sum, mut present, mut all) = (0.0, 0usize, 0usize);
            for y in row * block..((row + 1) * block).min(field.ny) {
                for x in column * block..((column + 1) * block).min(field.nx) {
                    let value = field.values[y * field.nx + x];
                    all += 1;
                    if value.is_finite() {
                        sum += value;
                        present += 1;
                    }
                }
            }
            means.push(if 2 * present > all { sum / present as f64 } else { f64::NAN });
        }
    }
    (nx, ny, means)
}

/// A field reduced to what an image shows.
struct Shown {
    nx: usize,
    ny: usize,
    /// Heights relative to their mean, pressures as they are.
    values: Vec<f64>,
    block: usize,
    /// Ends of the field's own colour scale.
    scale: (f64, f64),
}

impl Shown {
    /// `None` when no value is present.
    fn of(field: &Field, kind: Kind) -> Option<Self> {
        let mut block = 1;
        while field.nx.div_ceil(block) * field.ny.div_ceil(block) > MOST_POINTS
            || field.nx.max(field.ny).div_ceil(block) > MOST_ALONG
        {
            block += 1;
        }
        let (nx, ny, mut values) = averaged(field, block);
        let mut present: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        if present.is_empty() {
            return None;
        }
        if kind == Kind::Height {
            let mean = present.iter().sum::<f64>() / present.len() as f64;
            present.iter_mut().for_each(|v| *v -= mean);
            values.iter_mut().for_each(|v| *v -= mean);
        }
        present.sort_by(f64::total_cmp);
        let quantile = |q: f64| present[((present.len() - 1) as f64 * q).round() as usize];
        // A few outliers must not take the whole scale; they saturate.
        let (low, high) = match kind {
            Kind::Height => (quantile(0.001), quantile(0.999)),
            Kind::Pressure => (0.0, quantile(0.999).max(0.5 * present[present.len() - 1])),
            Kind::Probability => (present[0], present[present.len() - 1]),
            Kind::Error => (0.0, present[present.len() - 1]),
        };
        // A flat field has no scale of its own; it lies in the middle of a small one.
        let magnitude = field.values.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
        let scale = match kind {
            Kind::Height if high - low <= 1e-12 * magnitude => (-1e-9, 1e-9),
            Kind::Pressure | Kind::Error if high <= 0.0 => (0.0, 1.0),
            Kind::Probability if high <= low => (0.0, 1.0),
            _ => (low, high),
        };
        Some(Self { nx, ny, values, block, scale })
    }

    fn coloured(&self, field: &Field, kind: Kind, (low, high): (f64, f64)) -> Result<Raster, ReportError> {
        let span = high - low;
        let indices: Vec<u8> = self
            .values
            .iter()
            .map(|&v| {
                if !v.is_finite() {
                    0
                } else if kind == Kind::Pressure && v <= 0.0 {
                    1
                } else {
                    image::shade((v - low) / span)
                }
            })
            .collect();
        Ok(Raster {
            data_uri: image::indexed(self.nx, self.ny, &indices, image::scale_palette())?,
            kind,
            width_m: field.nx as f64 * field.dx_m,
            height_m: field.ny as f64 * field.dy_m,
            low,
            high,
            block: self.block,
            missing: field.values.iter().filter(|v| !v.is_finite()).count(),
        })
    }
}

impl Raster {
    /// The image of a field; `None` when no value is present.
    ///
    /// # Errors
    /// The PNG encoder's.
    pub(crate) fn new(field: &Field, kind: Kind) -> Result<Option<Self>, ReportError> {
        Shown::of(field, kind).map(|shown| shown.coloured(field, kind, shown.scale)).transpose()
    }

    /// The images of several fields on one colour scale, which holds that of each; those without values are left out.
    ///
    /// # Errors
    /// The PNG encoder's.
    pub(crate) fn on_one_scale<'a>(
        fields: impl IntoIterator<Item = &'a Field>,
        kind: Kind,
    ) -> Result<Vec<Self>, ReportError> {
        let shown: Vec<(&Field, Shown)> =
            fields.into_iter().filter_map(|field| Some((field, Shown::of(field, kind)?))).collect();
        let low = shown.iter().fold(f64::INFINITY, |low, (_, shown)| low.min(shown.scale.0));
        let high = shown.iter().fold(f64::NEG_INFINITY, |high, (_, shown)| high.max(shown.scale.1));
        shown.iter().map(|(field, shown)| shown.coloured(field, kind, (low, high))).collect()
    }

    /// Height of the drawn image per width.
    pub(crate) fn aspect(&self) -> f64 {
        self.height_m / self.width_m
    }

    /// What the field holds.
    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }

    /// Length of the field along x in metre.
    pub(crate) fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Draws image and frame into `plot` with length axes at the left and below.
    pub(crate) fn draw(&self, canvas: &mut Canvas<'_>, plot: Rect, shows_x: bool) -> Result<(), ReportError> {
        self.draw_image(canvas, plot)?;
        let unit = Dimension::Length.unit(self.width_m.max(self.height_m));
        if shows_x {
            self.draw_x_axis(canvas, plot)?;
        }
        self.draw_y_axis(canvas, plot, if shows_x { unit } else { Dimension::Length.unit(self.height_m) })
    }

    /// Draws the image and its frame.
    pub(crate) fn draw_image(&self, canvas: &mut Canvas<'_>, plot: Rect) -> Result<(), ReportError> {
        canvas.image(plot, &self.data_uri);
        canvas.frame(plot, Pen::new(INK, 1.0, Dash::Solid))
    }

    /// Draws the axis below `plot`.
    pub(crate) fn draw_x_axis(&self, canvas: &mut Canvas<'_>, plot: Rect) -> Result<(), ReportError> {
        let pen = Pen::new(INK, 1.0, Dash::Solid);
        let x = Axis::linear("x", Dimension::Length.unit(self.width_m.max(self.height_m)), (0.0, self.width_m));
        for tick in fitting_ticks(&x, plot.width()) {
            let at = plot.left + tick.position * plot.width();
            canvas.line(&[(at, plot.bottom), (at, plot.bottom + 5.0)], pen)?;
            canvas.text((at, plot.bottom + 15.0), &tick.label, TEXT, Align::Middle)?;
        }
        let middle = 0.5 * (plot.left + plot.right);
        canvas.text((middle, plot.bottom + 36.0), &x.label(), LABEL, Align::Middle)
    }

    /// Draws the axis at the left of `plot`.
    pub(crate) fn draw_y_axis(&self, canvas: &mut Canvas<'_>, plot: Rect, unit: Unit) -> Result<(), ReportError> {
        let pen = Pen::new(INK, 1.0, Dash::Solid);
        let y = Axis::linear("y", unit, (0.0, self.height_m));
        for tick in y.ticks((plot.height() / 110.0).max(2.0) as usize) {
            let at = plot.top + tick.position * plot.height();
            canvas.line(&[(plot.left - 5.0, at), (plot.left, at)], pen)?;
            canvas.text((plot.left - 8.0, at), &tick.label, TEXT, Align::End)?;
        }
        let middle = 0.5 * (plot.top + plot.bottom);
        canvas.text((plot.left - 50.0, middle), &y.label(), LABEL, Align::Upward)
    }

    /// Draws the colour bar into `bar`, its ticks and label at the right.
    pub(crate) fn colour_bar(&self, canvas: &mut Canvas<'_>, bar: Rect) -> Result<(), ReportError> {
        let (name, dimension) = match self.kind {
            Kind::Height => ("Height", Dimension::Length),
            Kind::Pressure => ("Pressure", Dimension::Pressure),
            Kind::Probability => ("P(contact)", Dimension::None),
            Kind::Error => ("Leave-one-out error / variance", Dimension::None),
        };
        let axis = Axis::linear(name, dimension.unit(self.low.abs().max(self.high.abs())), (self.low, self.high));
        image::colour_bar(canvas, bar, &axis)
    }

    /// What the reserved colours mean, from `at` to the right.
    pub(crate) fn legend(&self, canvas: &mut Canvas<'_>, at: (f64, f64)) -> Result<(), ReportError> {
        let mut x = at.0;
        let missing = format!("missing ({} points)", self.missing);
        let entries = [
            (self.kind == Kind::Pressure, NO_CONTACT, "no contact (p = 0)"),
            (self.missing > 0, MISSING, missing.as_str()),
        ];
        for (_, colour, text) in entries.iter().filter(|(wanted, _, _)| *wanted) {
            let swatch = Rect::new(x, at.1 - 6.0, 18.0, 12.0);
            canvas.fill(swatch, *colour)?;
            canvas.frame(swatch, Pen::new(INK, 0.8, Dash::Solid))?;
            canvas.text((x + 24.0, at.1), text, TEXT, Align::Start)?;
            x += 24.0 + text_width(text, TEXT) + 20.0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;

    use super::*;

    fn decoded(raster: &Raster) -> (u32, u32, Vec<u8>) {
        let bytes = STANDARD.decode(raster.data_uri.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::IDENTITY);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        pixels.truncate(info.buffer_size());
        (info.width, info.height, pixels)
    }

    #[test]
    fn missing_and_contact_free_points_have_colours_of_their_own() {
        let values = vec![0.0, 1.0, f64::NAN, 0.5, 0.0, 1.0];
        let field = Field { nx: 3, ny: 2, dx_m: 1.0, dy_m: 1.0, values };
        let raster = Raster::new(&field, Kind::Pressure).unwrap().unwrap();
        let (width, height, pixels) = decoded(&raster);
        assert_eq!((width, height), (3, 2));
        assert_eq!([pixels[0], pixels[4]], [1, 1]);
        assert_eq!(pixels[2], 0);
        assert_eq!([pixels[1], pixels[5]], [255, 255]);
        assert!(pixels[3] > 120 && pixels[3] < 137);
        assert_eq!(raster.missing, 1);
    }

    #[test]
    fn a_large_field_is_averaged_and_keeps_its_size_in_metre() {
        let (nx, ny) = (2000, 1000);
        let values = (0..nx * ny).map(|i| (i % nx) as f64).collect();
        let field = Field { nx, ny, dx_m: 1e-6, dy_m: 2e-6, values };
        let raster = Raster::new(&field, Kind::Height).unwrap().unwrap();
        let (width, height, pixels) = decoded(&raster);
        assert_eq!(raster.block, 3);
        assert_eq!((width, height), (667, 334));
        assert!((raster.aspect() - 1.0).abs() < 1e-12);
        assert!(pixels[..667].windows(2).all(|pair| pair[0] <= pair[1]), "a ramp stays a ramp");
    }

    #[test]
    fn a_field_without_values_has_no_image() {
        let field = Field { nx: 2, ny: 2, dx_m: 1.0, dy_m: 1.0, values: vec![f64::NAN; 4] };
        assert!(Raster::new(&field, Kind::Height).unwrap().is_none());
    }

    #[test]
    fn a_flat_field_is_drawn_in_one_colour_on_a_scale_around_zero() {
        let field = Field { nx: 2, ny: 2, dx_m: 1.0, dy_m: 1.0, values: vec![0.1; 4] };
        let raster = Raster::new(&field, Kind::Height).unwrap().unwrap();
        assert_eq!((raster.low, raster.high), (-1e-9, 1e-9));
        assert!(decoded(&raster).2.iter().all(|&pixel| pixel == 128 || pixel == 129));
    }
}

//! Maps as images: fields become indexed PNGs with a colour bar.

use asperity_results::Field;

use crate::ReportError;
use crate::format::Dimension;
use crate::plot::axis::Axis;
use crate::plot::chart::mark::Mark;
use crate::plot::chart::{Backdrop, Chart};
use crate::plot::image::{ColourBar, HARDNESS_ENTRY, MISSING_ENTRY, NO_CONTACT_ENTRY, indexed, scale_palette, shade};
use crate::plot::palette::{HARDNESS, MISSING, NO_CONTACT};

/// Larger fields are averaged over blocks before they are embedded; form has long waves.
const MAX_POINTS: usize = 640 * 640;
const MAX_POINTS_OF_FORM: usize = 320 * 320;
const MAX_ALONG: usize = 2600;

/// Quantity of a field, which determines its colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// Heights relative to their mean.
    Height,
    /// Heights with their form, relative to their mean.
    Form,
    /// Pressures from zero; points at exactly zero are not in contact.
    Pressure,
    /// Contact probabilities from the least to the largest.
    Probability,
    /// Relative errors from zero.
    Error,
}

impl Kind {
    /// Returns the label of the colour bar and the dimension of the values.
    fn label(self) -> (&'static str, Dimension) {
        match self {
            Self::Height | Self::Form => ("Height", Dimension::Length),
            Self::Pressure => ("Pressure", Dimension::Pressure),
            Self::Probability => ("P(contact)", Dimension::None),
            Self::Error => ("Leave-one-out error / variance", Dimension::None),
        }
    }
}

/// Smallest number of equal largest pressures that are those at the hardness.
const PLASTIC: usize = 3;

/// A field as an image with its colour bar.
#[derive(Debug, Clone)]
pub(crate) struct Raster {
    data_uri: String,
    width_m: f64,
    height_m: f64,
    colour_bar: ColourBar,
    /// Points along an edge that were averaged into one pixel.
    block: usize,
    missing: usize,
    /// Whether a pixel is at zero pressure.
    no_contact: bool,
    /// Hardness in Pa, if pixels are at it.
    hardness: Option<f64>,
}

/// Averages the present points of blocks of k × k points. A block without a majority of present points is missing.
fn averaged(field: &Field, block: usize) -> (usize, usize, Vec<f64>) {
    if block == 1 {
        return (field.nx(), field.ny(), field.values().iter().copied().collect());
    }
    let (nx, ny) = (field.nx().div_ceil(block), field.ny().div_ceil(block));
    let mean = |place: usize| {
        let (row, column) = (place / nx * block, place % nx * block);
        let (mut sum, mut present, mut all) = (0.0, 0usize, 0usize);
        for y in row..(row + block).min(field.ny()) {
            for value in field.values().row(y).iter().skip(column).take(block) {
                all += 1;
                if value.is_finite() {
                    sum += value;
                    present += 1;
                }
            }
        }
        if 2 * present > all { sum / present as f64 } else { f64::NAN }
    };
    (nx, ny, (0..nx * ny).map(mean).collect())
}

/// A field reduced to the pixels of an image.
struct Pixels<'a> {
    field: &'a Field,
    kind: Kind,
    nx: usize,
    ny: usize,
    /// Heights relative to their mean, other quantities as they are.
    values: Vec<f64>,
    block: usize,
    /// Ends of the field's own colour scale.
    scale: (f64, f64),
    /// Largest pressure, if several pixels are at it as at a hardness.
    hardness: Option<f64>,
}

impl<'a> Pixels<'a> {
    /// Reduces a field; `None` if no value is present.
    fn new(field: &'a Field, kind: Kind) -> Option<Self> {
        let is_height = matches!(kind, Kind::Height | Kind::Form);
        let most = if kind == Kind::Form { MAX_POINTS_OF_FORM } else { MAX_POINTS };
        let fits = |block: &usize| {
            let (nx, ny) = (field.nx().div_ceil(*block), field.ny().div_ceil(*block));
            nx * ny <= most && nx.max(ny) <= MAX_ALONG
        };
        let block = (1..).find(fits)?;
        let (nx, ny, mut values) = averaged(field, block);
        let mut present: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        if is_height && !present.is_empty() {
            let mean = present.iter().sum::<f64>() / present.len() as f64;
            present.iter_mut().for_each(|v| *v -= mean);
            values.iter_mut().for_each(|v| *v -= mean);
        }
        present.sort_by(f64::total_cmp);
        let (least, largest) = (*present.first()?, *present.last()?);
        let quantile = |q: f64| present[((present.len() - 1) as f64 * q).round() as usize];
        // The scale saturates, so that a few outliers do not take all of it.
        let (low, high) = match kind {
            Kind::Height | Kind::Form => (quantile(0.001), quantile(0.999)),
            Kind::Pressure => (0.0, quantile(0.999).max(0.5 * largest)),
            Kind::Probability => (least, largest),
            Kind::Error => (0.0, largest),
        };
        // A flat field lies in the middle of a small scale.
        let magnitude = field.values().iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
        let scale = match kind {
            _ if is_height && high - low <= 1e-12 * magnitude => (-1e-9, 1e-9),
            Kind::Pressure | Kind::Error if high <= 0.0 => (0.0, 1.0),
            Kind::Probability if high <= low => (0.0, 1.0),
            _ => (low, high),
        };
        let at_largest = present.iter().rev().take_while(|value| **value >= largest * (1.0 - 1e-6)).count();
        let hardness = Some(largest).filter(|_| kind == Kind::Pressure && largest > 0.0 && at_largest >= PLASTIC);
        Some(Self { field, kind, nx, ny, values, block, scale, hardness })
    }

    fn coloured(&self, (low, high): (f64, f64)) -> Result<Raster, ReportError> {
        let &Self { field, kind, nx, ny, block, hardness, .. } = self;
        let index = |value: &f64| match value {
            value if !value.is_finite() => MISSING_ENTRY,
            value if hardness.is_some_and(|hardness| *value >= hardness * (1.0 - 1e-6)) => HARDNESS_ENTRY,
            value if kind == Kind::Pressure && *value <= 0.0 => NO_CONTACT_ENTRY,
            value => shade((value - low) / (high - low)),
        };
        let indices: Vec<u8> = self.values.iter().map(index).collect();
        let (label, dimension) = kind.label();
        Ok(Raster {
            data_uri: indexed(nx, ny, &indices, scale_palette())?,
            width_m: field.nx() as f64 * field.dx_m(),
            height_m: field.ny() as f64 * field.dy_m(),
            colour_bar: ColourBar::new(Axis::linear(label, dimension.unit(low.abs().max(high.abs())), (low, high)))?,
            block,
            missing: field.values().iter().filter(|v| !v.is_finite()).count(),
            hardness,
            no_contact: kind == Kind::Pressure && self.values.iter().any(|value| *value <= 0.0),
        })
    }
}

impl Raster {
    /// Encodes the image of a field; `None` if no value is present.
    ///
    /// # Errors
    /// The PNG encoder failed.
    pub(crate) fn new(field: &Field, kind: Kind) -> Result<Option<Self>, ReportError> {
        Pixels::new(field, kind).map(|pixels| pixels.coloured(pixels.scale)).transpose()
    }

    /// Encodes the images of several fields on one colour scale, which contains the scale of each. Fields without values are left
    /// out.
    ///
    /// # Errors
    /// The PNG encoder failed.
    pub(crate) fn with_common_scale<'a>(
        fields: impl IntoIterator<Item = &'a Field>,
        kind: Kind,
    ) -> Result<Vec<Self>, ReportError> {
        let all: Vec<Pixels<'_>> = fields.into_iter().filter_map(|field| Pixels::new(field, kind)).collect();
        let low = all.iter().fold(f64::INFINITY, |low, pixels| low.min(pixels.scale.0));
        let high = all.iter().fold(f64::NEG_INFINITY, |high, pixels| high.max(pixels.scale.1));
        all.iter().map(|pixels| pixels.coloured((low, high))).collect()
    }

    /// Returns the height of the field over its width.
    pub(crate) fn aspect(&self) -> f64 {
        self.height_m / self.width_m
    }

    /// Returns the length of the field along x in metre.
    pub(crate) fn width_m(&self) -> f64 {
        self.width_m
    }

    /// Returns the colour scale.
    pub(crate) fn colour_bar(&self) -> &ColourBar {
        &self.colour_bar
    }

    /// Returns a sentence on the pixels for a caption; empty if each pixel is one point.
    pub(crate) fn pixel_sentence(&self) -> String {
        match self.block {
            1 => String::new(),
            block => format!(" Each pixel is the mean of {block} × {block} points."),
        }
    }

    /// Returns the map as a chart with one scale along both axes, y downward, and the meaning of the reserved colours in its legend.
    pub(crate) fn chart(&self) -> Chart {
        let unit = Dimension::Length.unit(self.width_m.max(self.height_m));
        // A narrow strip has a unit of its own along y.
        let across = if self.aspect() < 0.1 { Dimension::Length.unit(self.height_m) } else { unit.clone() };
        let (x, y) = ((0.0, self.width_m), (0.0, self.height_m));
        let mut chart = Chart::new(Axis::linear("x", unit, x), Axis::linear("y", across, y).downward());
        chart.backdrop = Some(Backdrop { data_uri: self.data_uri.clone(), x, y, aspect: Some(self.aspect()) });
        if self.no_contact {
            chart.add("no contact (p = 0)", Mark::Patch { colour: NO_CONTACT });
        }
        if let Some(hardness) = self.hardness {
            let name = format!("at the hardness, {}", Dimension::Pressure.show_short(hardness));
            chart.add(name, Mark::Patch { colour: HARDNESS });
        }
        if self.missing > 0 {
            chart.add(format!("missing ({} points)", self.missing), Mark::Patch { colour: MISSING });
        }
        chart
    }
}

#[cfg(test)]
mod tests {
    use base64::Engine as _;
    use base64::engine::general_purpose::STANDARD;

    use ndarray::{Array2, array};

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
        let field = Field::new([1.0, 1.0], "Pa", array![[0.0, 1.0, f64::NAN], [0.5, 0.0, 1.0]]);
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
    fn a_plastic_map_has_a_class_of_its_own_and_an_elastic_one_has_not() {
        let plastic = Field::new([1.0, 1.0], "Pa", array![[0.0, 3e7, 3e7], [1e7, 0.0, 3e7]]);
        let raster = Raster::new(&plastic, Kind::Pressure).unwrap().unwrap();
        let (_, _, pixels) = decoded(&raster);
        assert_eq!([pixels[1], pixels[2], pixels[5]], [HARDNESS_ENTRY; 3]);
        assert!(pixels[3] > HARDNESS_ENTRY && pixels[0] == NO_CONTACT_ENTRY);
        assert!(raster.chart().series.iter().any(|series| series.name == "at the hardness, 30\u{a0}MPa"));
        let elastic = Field::new([1.0, 1.0], "Pa", array![[0.0, 1e7, 2e7], [1e7, 0.0, 3e7]]);
        assert_eq!(Raster::new(&elastic, Kind::Pressure).unwrap().unwrap().hardness, None);
    }

    #[test]
    fn a_large_field_is_averaged_and_keeps_its_size_in_metre() {
        let (nx, ny) = (2000, 1000);
        let field = Field::new([1e-6, 2e-6], "m", Array2::from_shape_fn((ny, nx), |(_, column)| column as f64));
        let raster = Raster::new(&field, Kind::Height).unwrap().unwrap();
        let (width, height, pixels) = decoded(&raster);
        assert_eq!(raster.block, 3);
        assert_eq!((width, height), (667, 334));
        assert!((raster.aspect() - 1.0).abs() < 1e-12);
        assert!(pixels[..667].windows(2).all(|pair| pair[0] <= pair[1]), "a ramp stays a ramp");
    }

    #[test]
    fn a_field_without_values_has_no_image() {
        let field = Field::new([1.0, 1.0], "m", Array2::from_elem((2, 2), f64::NAN));
        assert!(Raster::new(&field, Kind::Height).unwrap().is_none());
    }

    #[test]
    fn a_flat_field_is_drawn_in_one_colour_on_a_scale_around_zero() {
        let field = Field::new([1.0, 1.0], "m", Array2::from_elem((2, 2), 0.1));
        let raster = Raster::new(&field, Kind::Height).unwrap().unwrap();
        assert_eq!(raster.colour_bar.axis.ends(), (-1e-9, 1e-9));
        assert!(decoded(&raster).2.iter().all(|&pixel| pixel == 128 || pixel == 129));
    }
}

//! Height map of a file, and its checks.

use std::collections::BTreeMap;

use ndarray::Array2;

use crate::error::cut;
use crate::unit::in_words;
use crate::{Format, FormatError, Location, ReadOptions, Result, Shape, large, per_metre, shown, some_of};

/// Maximum number of heights of one map: 16384 × 16384, or 2 GiB as `f64`.
pub const MAX_POINTS: u64 = 1 << 28;

/// Range of plausible pitches in metre: no instrument resolves a picometre or steps by a metre.
const PLAUSIBLE_PITCH_M: std::ops::RangeInclusive<f64> = 1e-12..=1.0;
/// Maximum number of characters of a warning, which may quote the file.
const WARNING_CHARS: usize = 1000;
/// Median slope above which heights without a unit are hardly in metre.
const STEEP: f64 = 10.0;
/// Ratio of the two pitches above which a warning is issued.
const PLAUSIBLE_PITCH_RATIO: f64 = 10.0;

/// Checks the shape and the pixel size of maps that are to be stored in `format`.
pub(crate) fn check(format: Format, (ny, nx): Shape, (dx_m, dy_m): (f64, f64)) -> Result<()> {
    if ny == 0 || nx == 0 {
        let found = format!("a map of {nx} × {ny} points");
        return Err(FormatError::not_storable(format, found, "at least one point"));
    }
    if [nx as f64 * dx_m, ny as f64 * dy_m].iter().any(|size| !(size.is_finite() && *size > 0.0)) {
        let found = format!("a pixel size of {} × {}", in_words(dx_m), in_words(dy_m));
        return Err(FormatError::not_storable(format, found, "positive numbers"));
    }
    Ok(())
}

/// Measured height map, or profile, as stated in a file.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Heights in metre, shape `[ny, nx]`, row 0 at the top; NaN for missing points. A profile is a single row.
    pub heights_m: Array2<f64>,
    /// Distance between points along (x, y) in metre; `None` if the file does not state it.
    pub pitch_m: Option<(f64, f64)>,
    /// Further information in the file, by its field names.
    pub metadata: BTreeMap<String, String>,
    /// Warnings about the content, for the user.
    pub warnings: Vec<String>,
    /// Names of all height maps in the file, in its order; empty for formats with a single map.
    pub channels: Vec<String>,
    /// Index in `channels` of the map that was read.
    pub channel: usize,
    /// Format that was read; `None` for a scan that is not from a file.
    pub format: Option<Format>,
    /// Unit of the heights in the file; `None` if the file states none, and its numbers count as metre.
    pub height_unit: Option<String>,
}

impl Scan {
    /// Creates a scan from heights and pitch.
    pub fn new(heights_m: Array2<f64>, pitch_m: Option<(f64, f64)>) -> Self {
        Self {
            heights_m,
            pitch_m,
            metadata: BTreeMap::new(),
            warnings: Vec::new(),
            channels: Vec::new(),
            channel: 0,
            format: None,
            height_unit: None,
        }
    }

    /// Adds the names of all maps of the file.
    pub(crate) fn with_channels(self, channels: Vec<String>, channel: usize) -> Self {
        Self { channels, channel, ..self }
    }

    /// Returns the shape and the pixel size of a scan that is to be stored in `format`.
    ///
    /// # Errors
    /// [`FormatError::NoPitch`] without a pixel size, [`FormatError::NotStorable`] for a scan without points or with
    /// a pixel size that is not positive.
    pub(crate) fn to_store(&self, format: Format) -> Result<(Shape, (f64, f64))> {
        let pitch_m = self.pitch_m.ok_or(FormatError::NoPitch { format })?;
        let shape = self.heights_m.dim();
        check(format, shape, pitch_m)?;
        Ok((shape, pitch_m))
    }

    /// Returns the name of the map that was read; `None` for formats with a single map.
    pub fn channel_name(&self) -> Option<&str> {
        self.channels.get(self.channel).map(String::as_str)
    }

    /// Returns whether the heights lie along one line.
    pub fn is_profile(&self) -> bool {
        self.heights_m.nrows() == 1 && self.heights_m.ncols() > 1
    }

    /// Returns the number of missing heights.
    pub fn missing_points(&self) -> usize {
        self.heights_m.iter().filter(|z| !z.is_finite()).count()
    }

    /// Returns the lowest and the highest height in metre; `None` if all are missing.
    pub(crate) fn height_range_m(&self) -> Option<(f64, f64)> {
        let present = self.heights_m.iter().copied().filter(|z| z.is_finite());
        present.fold(None, |range, z| match range {
            None => Some((z, z)),
            Some((low, high)) => Some((z.min(low), z.max(high))),
        })
    }

    /// Converts the heights to the unit in `options`, if there is one.
    fn in_stated_unit(mut self, options: &ReadOptions) -> Self {
        let Some(unit) = &options.height_unit else { return self };
        let replaced = self.height_unit.replace(unit.name().to_owned());
        let replaced_per_metre = replaced.as_deref().and_then(per_metre);
        if replaced_per_metre == Some(unit.per_metre()) {
            return self;
        }
        if let Some(replaced) = replaced {
            let (stated, replaced) = (unit.name(), shown(&replaced));
            self.warnings.push(format!("the stated height unit, {stated}, replaces the file's {replaced}"));
        }
        let (replaced, per_metre) = (replaced_per_metre.unwrap_or(1.0), unit.per_metre());
        self.heights_m.mapv_inplace(|z| z * replaced / per_metre);
        self
    }

    /// Sets the pixel size in `options`, if there is one.
    fn with_stated_pitch(mut self, options: &ReadOptions) -> Self {
        let Some((dx_m, dy_m)) = options.pitch_m else { return self };
        if let Some((x_m, y_m)) = self.pitch_m.replace((dx_m, dy_m)).filter(|&pitch_m| pitch_m != (dx_m, dy_m)) {
            let [dx, dy, x, y] = [dx_m, dy_m, x_m, y_m].map(in_words);
            self.warnings.push(format!("the stated pixel size, {dx} × {dy}, replaces the file's, {x} × {y}"));
        }
        self
    }

    /// Completes a scan after reading: applies the stated unit and pixel size, sets heights that are not finite to NaN, removes an invalid
    /// pitch, and adds warnings about implausible sizes.
    ///
    /// # Errors
    /// [`FormatError::NoHeightUnit`]
    pub(crate) fn checked(self, options: &ReadOptions) -> Result<Self> {
        self.in_stated_unit(options).with_stated_pitch(options).without_doubt(options)
    }

    fn without_doubt(mut self, options: &ReadOptions) -> Result<Self> {
        if options.channel.is_none()
            && let Some(read) = self.channels.get(self.channel).filter(|_| self.channels.len() > 1)
        {
            let (count, names) = (self.channels.len(), some_of(&self.channels));
            self.warnings.push(format!("the file holds {count} height maps ({names}); `{}` was read", shown(read)));
        }
        for warning in &mut self.warnings {
            *warning = cut(warning, WARNING_CHARS);
        }
        let range_m = normalise(&mut self.heights_m);
        let is_pitch = |pitch: f64| pitch.is_finite() && pitch > 0.0;
        let Some((dx_m, dy_m)) = self.pitch_m else { return Ok(self) };
        let [dx, dy] = [dx_m, dy_m].map(in_words);
        if !(is_pitch(dx_m) && is_pitch(dy_m)) {
            self.warnings.push(format!("the stated pixel size {dx} × {dy} is not positive and was left out"));
            self.pitch_m = None;
            return Ok(self);
        }
        for (axis, pitch_m, pitch) in [("x", dx_m, &dx), ("y", dy_m, &dy)] {
            if !PLAUSIBLE_PITCH_M.contains(&pitch_m) {
                self.warnings.push(format!("the pixel size along {axis}, {pitch}, is not between 1 pm and 1 m"));
            }
        }
        if dx_m.max(dy_m) > PLAUSIBLE_PITCH_RATIO * dx_m.min(dy_m) && !self.is_profile() {
            self.warnings.push(format!("the pixels are far from square: {dx} × {dy}"));
        }
        if let Some(range_m) = range_m {
            self.compare_with_field(range_m, (dx_m, dy_m))?;
        }
        Ok(self)
    }

    /// Warns about heights of a known unit that span more than the field of view.
    ///
    /// # Errors
    /// [`FormatError::NoHeightUnit`] for such heights, and for an offset above the field of view, if their unit is not known.
    fn compare_with_field(&mut self, (low_m, high_m): (f64, f64), (dx_m, dy_m): (f64, f64)) -> Result<()> {
        let (ny, nx) = self.heights_m.dim();
        let field_m = (nx as f64 * dx_m).max(ny as f64 * dy_m);
        let (span_m, reach_m) = (high_m - low_m, high_m.abs().max(low_m.abs()));
        let (spans, field_of_view) = (format!("span {}", in_words(span_m)), in_words(field_m));
        match self.format.filter(|_| self.height_unit.is_none()) {
            Some(format) if span_m > field_m || reach_m > field_m => {
                let found = if span_m > field_m { spans } else { format!("reach {}", in_words(reach_m)) };
                Err(FormatError::NoHeightUnit { format, found, field_of_view })
            }
            _ if span_m > field_m => {
                let doubt =
                    format!("the heights {spans}, more than the field of view, {field_of_view}; check the units");
                self.warnings.push(doubt);
                Ok(())
            }
            Some(_) if self.median_slope(dx_m) > STEEP => {
                self.warnings.push(format!(
                    "half of the neighbouring heights differ by more than {STEEP} pixels; the file states no unit of height, and metre was \
                     assumed: state it by `--height-unit`, in a study by `height_unit`"
                ));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Returns the median of the slopes between neighbours along x, over a part of the pairs; 0 without a pair.
    fn median_slope(&self, dx_m: f64) -> f64 {
        /// Number of pairs that tell heights in millimetre from heights in metre.
        const PAIRS: usize = 4096;

        let (ny, nx) = self.heights_m.dim();
        let pairs = ny * nx.saturating_sub(1);
        let places = (0..pairs).step_by(pairs.div_ceil(PAIRS).max(1)).map(|pair| (pair / (nx - 1), pair % (nx - 1)));
        let differences = places.map(|(row, column)| self.heights_m[[row, column + 1]] - self.heights_m[[row, column]]);
        let mut slopes: Vec<f64> = differences.filter(|d| d.is_finite()).map(|d| d.abs() / dx_m).collect();
        slopes.sort_unstable_by(f64::total_cmp);
        slopes.get(slopes.len() / 2).copied().unwrap_or(0.0)
    }
}

/// Sets heights that are not finite to NaN. Returns the lowest and the highest other height; `None` if there is none.
fn normalise(heights_m: &mut Array2<f64>) -> Option<(f64, f64)> {
    let pieces = match heights_m.as_slice_memory_order_mut() {
        Some(values) => large::pass(values, range),
        None => heights_m.iter_mut().map(|z| range(std::slice::from_mut(z))).collect(),
    };
    let join = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
    let (low, high) = pieces.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), join);
    (low <= high).then_some((low, high))
}

/// Does the work of [`normalise`] for a part of the heights. Returns an empty range if all are missing.
fn range(values: &mut [f64]) -> (f64, f64) {
    /// Number of independent ranges: with a single one, each comparison would wait for the previous.
    const LANES: usize = 8;

    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    for values in values.chunks_mut(LANES) {
        for ((z, low), high) in values.iter_mut().zip(&mut low).zip(&mut high) {
            *z = if z.is_finite() { *z } else { f64::NAN };
            // Comparisons with NaN keep the previous value.
            *low = if *z < *low { *z } else { *low };
            *high = if *z > *high { *z } else { *high };
        }
    }
    (low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

/// Checks the dimensions that a file declares for a map, each with the name and the place of its field.
///
/// # Errors
/// A dimension below 1, or a product above [`MAX_POINTS`].
pub(crate) fn shape<T>(format: Format, rows: (&str, Location, T), columns: (&str, Location, T)) -> Result<Shape>
where
    T: TryInto<u64> + ToString + Copy,
{
    let positive = |(field, at, found): &(&str, Location, T)| {
        let points = (*found).try_into().ok().filter(|&points| points > 0);
        points.ok_or_else(|| FormatError::field(format, *field, at.clone(), *found, "1 or more"))
    };
    let (ny, nx) = (positive(&rows)?, positive(&columns)?);
    let points = ny.saturating_mul(nx);
    match (usize::try_from(ny), usize::try_from(nx)) {
        (Ok(ny), Ok(nx)) if points <= MAX_POINTS => Ok((ny, nx)),
        _ => {
            let field = format!("the product of {} and {}", columns.0, rows.0);
            Err(FormatError::too_large(format, field, columns.1, points, MAX_POINTS))
        }
    }
}

/// Arranges heights as a map. An error names `field`, the source of the shape.
pub(crate) fn matrix(
    format: Format,
    field: &str,
    at: Location,
    shape: Shape,
    heights: Vec<f64>,
) -> Result<Array2<f64>> {
    let count = heights.len();
    Array2::from_shape_vec(shape, heights).map_err(|_| {
        let found = format!("{} × {} points", shape.1, shape.0);
        FormatError::field(format, shown(field), at, found, format!("a shape of {count} points"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn doubtful_heights_and_pitches_give_a_warning() {
        let flat = array![[0.0, 0.0], [0.0, 0.0]];
        let beyond = "between 1 pm and 1 m";
        for (heights_m, pitch_m, wanted) in [
            (array![[0.0, 1e-6], [2e-6, f64::NAN]], (1e-6, 2e-6), &[][..]),
            (array![[0.0, 5e-6], [0.0, 0.0]], (1e-6, 2e-6), &["more than the field of view"]),
            (flat.clone(), (0.9e-12, 0.9e-12), &[beyond, ""]),
            (flat.clone(), (1.1, 1.1), &[beyond, ""]),
            (flat.clone(), (1e-6, 1.1e-5), &["far from square"]),
            (flat.clone(), (1e-6, 0.9e-5), &[]),
        ] {
            let found = Scan::new(heights_m, Some(pitch_m)).checked(&ReadOptions::default()).unwrap().warnings;
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            assert!(found.iter().zip(wanted).all(|(found, words)| found.contains(words)), "{found:?}");
        }
        for pitch_m in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
            let scan = Scan::new(flat.clone(), Some((1e-6, pitch_m))).checked(&ReadOptions::default()).unwrap();
            assert_eq!((scan.pitch_m, scan.warnings.len()), (None, 1));
        }
    }

    #[test]
    fn the_map_that_was_read_is_reported_with_the_first_of_the_others() {
        let names = |count: usize| (1..=count).map(|number| format!("n{number}")).collect();
        let warnings_of = |count: usize, options: &ReadOptions| {
            Scan::new(array![[0.0]], None).with_channels(names(count), 0).checked(options).unwrap().warnings
        };
        let default = ReadOptions::default();
        assert_eq!(warnings_of(1, &default), [] as [String; 0]);
        assert_eq!(warnings_of(2, &default), ["the file holds 2 height maps (n1, n2); `n1` was read"]);
        let many = "the file holds 500 height maps (n1, n2, n3, n4, n5, n6, n7, n8 and 492 more); `n1` was read";
        assert_eq!(warnings_of(500, &default), [many]);
        let chosen = ReadOptions { channel: Some("n1".into()), ..ReadOptions::default() };
        assert_eq!(warnings_of(2, &chosen), [] as [String; 0]);
    }

    #[test]
    fn warnings_are_short_and_do_not_control_a_terminal() {
        let long = ["\u{1b}]0;".to_owned() + &"x".repeat(10_000), "units\ncontradict".into()];
        let scan = Scan { warnings: long.to_vec(), ..Scan::new(array![[0.0]], None) };
        let scan = scan.with_channels((0..9).map(|n| format!("{n}\u{7}")).collect(), 8);
        let scan = scan.checked(&ReadOptions::default()).unwrap();
        assert!(scan.warnings[0].starts_with("\\u{1b}]0;x") && scan.warnings[0].chars().count() == 6 + 999 + 1);
        assert_eq!(scan.warnings[1], "units\\ncontradict");
        assert!(scan.warnings[2].ends_with("6\\u{7}, 7\\u{7} and 1 more); `8\\u{7}` was read"), "{:?}", scan.warnings);
    }

    #[test]
    fn heights_that_are_not_finite_become_nan() {
        let scan = Scan::new(array![[f64::INFINITY, 1.0, f64::NEG_INFINITY, f64::NAN]], None);
        let scan = scan.checked(&ReadOptions::default()).unwrap();
        assert_eq!(scan.missing_points(), 3);
        assert!(scan.heights_m.iter().all(|z| !z.is_infinite()));
    }
}

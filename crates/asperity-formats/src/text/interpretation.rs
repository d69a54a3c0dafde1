//! Interpretation of headers: pixel size, unit and factor of the heights, missing points.

use crate::text::decimal::Decimal;
use crate::text::factor::{Factor, Factors};
use crate::text::header::{Header, PIXEL_SIZE, Pair, X_UNIT, Y_UNIT, bare, is_one_of, unit};
use crate::text::length::{Lengths, NoNumber};
use crate::unit::is_micro;
use crate::{ReadOptions, Shape, shown, warn_if};

/// Keys with one meaning, separated by bars.
const DX: &str = "dx|delta x|x step|step x|x spacing|x pitch|x pixel size|pixel size x|pixel width|scale x";
const DY: &str = "dy|delta y|y step|step y|y spacing|y pitch|y pixel size|pixel size y|pixel height|scale y";
const SIZE: &str = "size|sizes|scan size|physical size|physical sizes|field of view|image size|map size";
const WIDTH: &str = "width|x length|xlength|x size|size x|x range|breite|largeur|larghezza|anchura|šířka";
const HEIGHT: &str = "height|y length|ylength|y size|size y|y range|höhe|hauteur|altezza|altura|výška";
const NO_DATA: &str = "nodata value|no data value|nodata|no data|missing value|fill value";
/// Maximum number of factors that warnings quote.
const QUOTED_FACTORS: usize = 8;
/// Default mark of missing points in an ESRI grid.
const ESRI_NO_DATA: f64 = -9999.0;

/// Pair of a header that cannot be read.
pub(crate) struct Wrong<'a> {
    pub(crate) key: &'a str,
    pub(crate) value: &'a str,
    pub(crate) wanted: &'static str,
}

/// Interpretation of a header.
pub(crate) struct Interpretation {
    /// Distance between points along x and y in metre.
    pub(crate) pitch_m: Option<(f64, f64)>,
    /// Conversion of numbers to heights: multiplication by `factor`, then division by `per_metre`, so that units stay
    /// exact.
    pub(crate) factor: f64,
    pub(crate) per_metre: f64,
    /// Original unit or factor of converted numbers; `None` if they are in metre.
    pub(crate) converted: Option<String>,
    /// Unit of the heights in the header, after a factor.
    pub(crate) unit: Option<String>,
    /// Number that marks a missing point.
    pub(crate) no_data: Option<f64>,
    pub(crate) warnings: Vec<String>,
}

impl Header {
    /// Returns whether the numbers can be heights: they have a conversion factor, a unit of length or no unit.
    pub(crate) fn may_be_heights(&self, decimal: Option<Decimal>) -> bool {
        self.factors(decimal).is_ok_and(|factors| factors.used.is_some())
            || self.height_unit().is_none_or(|(_, _, per_metre)| per_metre.is_some())
    }

    /// Interprets the header of a matrix of `columns` × `rows` numbers. If the user stated the unit (`is_stated`),
    /// unknown units give no warning and no factor is applied.
    ///
    /// # Errors
    /// A conversion factor that is not a number or is 0, if no unit of length is stated, or a length of which a number cannot be read whole.
    pub(crate) fn interpret(&self, (rows, columns): Shape, options: &ReadOptions) -> Result<Interpretation, Wrong<'_>> {
        let is_stated = options.height_unit.is_some();
        let decimal = options.decimal.or_else(|| self.decimal());
        let mut warnings = Vec::new();
        let pitch_m = match self.pitch((rows, columns), decimal, &mut warnings) {
            // The stated pixel size replaces it.
            Err(_) if options.pitch_m.is_some() => None,
            found => found?,
        };
        if let Some(stated) = self.shape().filter(|&stated| stated != (rows, columns)) {
            let (ny, nx) = stated;
            warnings.push(format!("the header states {nx} × {ny} points; there are {columns} × {rows}"));
        }
        let replaced = |pair: &Pair| format!("the stated height unit replaces the header's {}", pair.quoted());
        let Factors { used, unused } = match self.factors(decimal) {
            Ok(Factors { used: Some(factor), unused }) if is_stated => {
                warnings.push(replaced(factor.pair));
                Factors { used: None, unused }
            }
            Err(pair) if is_stated => {
                warnings.push(replaced(pair));
                Factors { used: None, unused: Vec::new() }
            }
            Err(Pair { key, value, .. }) => {
                let wanted = "a number other than 0 (a stated height unit replaces the factor)";
                return Err(Wrong { key, value, wanted });
            }
            Ok(factors) => factors,
        };
        let not_used = |pair: &&Pair| format!("the header states {}, which was not used", pair.quoted());
        warnings.extend(unused.iter().take(QUOTED_FACTORS).map(not_used));
        let (mut factor, mut per_metre, mut converted, mut unit) = (1.0, 1.0, None, None);
        match (used, self.height_unit()) {
            (Some(Factor { pair, value, source, target }), stated) => {
                let (name, target_per_metre) =
                    target.map_or(("m", 1.0), |(name, per_metre)| (name, per_metre.unwrap_or(1.0)));
                (factor, per_metre, converted, unit) = (value, target_per_metre, Some(pair.key.as_str()), Some(name));
                if let Some((key, unit, Some(other))) = stated
                    && other != per_metre
                    && source.is_none()
                {
                    let (key, unit, factor) = (shown(key), shown(unit), shown(&pair.key));
                    warnings.push(format!("the header states `{key}: {unit}` and `{factor}`; the factor was used"));
                }
                let quoted = pair.quoted();
                warn_if!(warnings, target.is_none(), "the header states {quoted} without a unit; metre was assumed");
                if value < 0.0 {
                    let effect = "this negative factor turns the surface upside down";
                    warnings.push(format!("the header states {quoted}; {effect}"));
                }
            }
            (None, Some((_, stated, Some(stated_per_metre)))) => {
                (per_metre, converted, unit) = (stated_per_metre, Some(stated), Some(bare(stated)));
            }
            // `read_block` refuses it unless the user stated the unit.
            (None, Some((_, stated, None))) => unit = Some(stated),
            (None, None) => {
                let other = self.doubtful_unit().filter(|_| !is_stated);
                warnings.extend(other.map(|pair| unit_warning(&pair.key, &pair.value)));
            }
        }
        let converted = converted.filter(|_| factor != 1.0 || per_metre != 1.0).map(str::to_owned);
        let (unit, no_data) = (unit.map(str::to_owned), self.no_data());
        Ok(Interpretation { pitch_m, factor, per_metre, converted, unit, no_data, warnings })
    }

    /// Returns whether the header states a pixel size or the size of the map.
    pub(crate) fn states_extent(&self) -> bool {
        [PIXEL_SIZE, DX, SIZE, WIDTH, "cellsize"].iter().any(|names| self.find(names).is_some())
    }

    /// Returns a pair that may name a unit of the heights under another key.
    fn doubtful_unit(&self) -> Option<&Pair> {
        let is_height_unit = |name: &str| name.contains("unit") && !is_one_of(X_UNIT, name) && !is_one_of(Y_UNIT, name);
        self.pairs.iter().find(|pair| is_height_unit(&pair.name) && pair.value != "m")
    }

    fn no_data(&self) -> Option<f64> {
        let stated = self.find(NO_DATA).and_then(|pair| pair.value.parse().ok());
        stated.or_else(|| self.is_esri().then_some(ESRI_NO_DATA))
    }

    /// Returns the pixel size from the first key that states it.
    ///
    /// # Errors
    /// A number that cannot be read whole.
    fn pitch(
        &self,
        (rows, columns): Shape,
        decimal: Option<Decimal>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<(f64, f64)>, Wrong<'_>> {
        let [x_unit, y_unit, _] = self.units();
        let is_spip = || self.find("file format").is_some_and(|pair| pair.value == "ASCII");
        let read = |pair: &'_ Pair, unit: Option<f64>| Lengths::parse(&pair.value, pair.unit.or(unit), decimal);
        let lateral = [X_UNIT, Y_UNIT].into_iter().find_map(|names| self.find(names));
        let lateral = lateral.filter(|pair| is_micro(bare(&pair.value)));
        let of = |names, unit: Option<f64>| {
            let Some(pair) = self.find(names) else { return Ok(None) };
            let Pair { key, value, .. } = pair;
            let lengths = read(pair, unit).map_err(|reason| Wrong { key, value, wanted: reason.wanted() })?;
            if let Some(Pair { key, value, .. }) = lateral.filter(|_| lengths.as_ref().is_some_and(|of| !of.has_unit)) {
                return Err(Wrong { key, value, wanted: NoNumber::Prefix.wanted() });
            }
            Ok(lengths.map(|lengths| (pair, lengths)))
        };
        if let Some((_, lengths)) = of(PIXEL_SIZE, x_unit)? {
            return Ok(Some(lengths.pair(warnings)));
        }
        if let Some((_, x)) = of(DX, x_unit)? {
            let y = of(DY, y_unit)?;
            let (dx_m, _) = x.pair(warnings);
            return Ok(Some((dx_m, y.map_or(dx_m, |(_, y)| y.metre[0]))));
        }
        if let Some((_, cell)) = of("cellsize", x_unit)? {
            return Ok(Some((cell.metre[0], cell.metre[0])));
        }
        // Numbers equal to the numbers of points are counts, unless they have a unit or the header names a lateral
        // unit.
        let has_lateral = self.find(X_UNIT).is_some_and(|pair| unit(&pair.value).is_some());
        let is_length =
            |pair: &Pair| has_lateral || read(pair, None).is_ok_and(|lengths| lengths.is_some_and(|of| of.has_unit));
        // Sizes cover all points: columns · dx, as in Gwyddion and SPIP.
        let pitch = |(width_m, height_m): (f64, f64)| (width_m / columns as f64, height_m / rows as f64);
        if let Some((pair, size)) = of(SIZE, x_unit)?
            && size.has_unit
            && (is_length(pair) || size.stated != [columns as f64, rows as f64])
        {
            return Ok(Some(pitch(size.pair(warnings))));
        }
        let nanometre = is_spip().then_some(1e9);
        let Some((x, width)) = of(WIDTH, x_unit.or(nanometre))? else { return Ok(None) };
        let Some((y, height)) = of(HEIGHT, y_unit.or(nanometre))? else {
            warn_if!(warnings, width.has_unit, "the header states a width but no height; no pixel size was read");
            return Ok(None);
        };
        let counts = [&width.stated[..], &height.stated].concat();
        let are_counts =
            counts == [columns as f64, rows as f64] && nanometre.is_none() && !(is_length(x) && is_length(y));
        let are_lengths = width.has_unit && height.has_unit && !are_counts;
        Ok(are_lengths.then(|| pitch((width.metre[0], height.metre[0]))))
    }
}

fn unit_warning(key: &str, unit: &str) -> String {
    format!("a comment states `{}: {}`; heights count as metre", shown(key), shown(unit))
}

//! Prints best and median seconds of the surface analyses of one map: `time_surface MAP.npy [REPEATS [ONLY [FOLDER]]]`.
//!
//! ONLY is a part of the names of the lines to run. If FOLDER is given, the radial spectrum is written there as CSV.
//! The map's heights are in metre; without a pixel size in the file the pixels are 1 µm wide. `RAYON_NUM_THREADS` sets the
//! number of threads. Each line is one analysis, from the heights in memory to its numbers.

#![expect(clippy::print_stdout, reason = "prints times")]

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use asperity::correlation::{Autocorrelation, Axis, profile_spectrum, radial_spectrum};
use asperity::map::HeightMap;
use asperity::study::Table;
use asperity::surface::level::Level;
use asperity::surface::preparation::Preparation;
use asperity::surface::uncertainty::{Uncertainty, Values};
use asperity::surface::{areal, fractal};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("usage: time_surface MAP.npy [REPEATS [ONLY [FOLDER]]]")?;
    let repeats = arguments.next().map_or(Ok(7), |count| count.parse())?;
    let only = arguments.next().unwrap_or_default();
    let folder = arguments.next().map(PathBuf::from);
    let mut scan = asperity_formats::read(file.as_ref())?;
    scan.pitch_m.get_or_insert((1e-6, 1e-6));
    let map = HeightMap::try_from(scan)?;
    println!("{} x {} points, {} missing", map.grid().nx(), map.grid().ny(), map.missing_points());

    let time = |name: &str, work: &dyn Fn() -> Result<(), Box<dyn Error>>| -> Result<(), Box<dyn Error>> {
        if !name.contains(&only) {
            return Ok(());
        }
        let mut seconds = Vec::new();
        for _ in 0..repeats {
            let start = Instant::now();
            work()?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        println!("{name:<42} best {:.4} s   median {:.4} s", seconds[0], seconds[seconds.len() / 2]);
        Ok(())
    };
    time("texture parameters (ISO 25178-2)", &|| Ok(areal::parameters(&map).map(drop)?))?;
    time("autocorrelation up to half the field", &|| Ok(Autocorrelation::estimate(&map).map(drop)?))?;
    time("radial power spectrum", &|| Ok(radial_spectrum(&map).map(drop)?))?;
    if let Some(folder) = folder {
        let spectrum = radial_spectrum(&map)?;
        let columns = [("wavenumber_rad_per_m", spectrum.q_rad_per_m.clone()), ("psd_m4", spectrum.psd_m4.clone())];
        std::fs::write(folder.join("radial_spectrum.csv"), Table::new(columns).to_csv()?)?;
    }
    time("profile power spectra along x and y", &|| {
        profile_spectrum(&map, Axis::X)?;
        Ok(profile_spectrum(&map, Axis::Y).map(drop)?)
    })?;
    time("structure functions and Hurst exponent", &|| Ok(fractal::scaling(&map, None).map(drop)?))?;
    let prepared = Preparation { level: Level::None, ..Preparation::default() }.apply(map.clone())?;
    let (values, uncertainty) =
        (Values::new(&areal::parameters(&map)?, &Autocorrelation::estimate(&map)?), Uncertainty::default());
    time("intervals of the statistics", &|| Ok(uncertainty.of(&map, &values).map(drop)?))?;
    time("all of `surface stats`", &|| Ok(asperity::surface::scanned::MapStatistics::new(&prepared).map(drop)?))
}

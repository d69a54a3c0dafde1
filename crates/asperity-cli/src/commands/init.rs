//! Creation of an example study, or of a study of a scan.

use std::borrow::Cow;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use asperity::study::{QUICKSTART, ScanSizes, Study, StudyError, is_folder_name};
use asperity::surface::level::Level;
use clap::{Args, ValueEnum};

use super::study_file;
use crate::failure::{Failure, Kind};
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::replace_file;

/// Writes an annotated study file and the scan it needs.
#[derive(Debug, Args)]
pub(crate) struct Init {
    /// Folder to write into; created if missing.
    #[arg(default_value = ".")]
    dir: PathBuf,
    /// Example to write.
    #[arg(long, value_enum, default_value = "quickstart")]
    example: Example,
    /// Writes the study of this scan instead of an example: sizes of strips, windows and patches follow from its correlation lengths and
    /// from the shortest wave that it resolves. Copies the scan into the folder. Material and machine are those of the quickstart.
    #[arg(long, value_name = "FILE", conflicts_with = "example")]
    scan: Option<PathBuf>,
    /// Form to remove from the scan: none, mean, plane, quadratic, polynomial:N, cylinder or sphere. When left out, the first of plane,
    /// quadratic and polynomial:4 with which the correlation of the heights falls to 1/e within half of the scan.
    #[arg(long, value_name = "FORM", requires = "scan")]
    level: Option<Level>,
    #[command(flatten)]
    options: ScanOptions,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Example {
    /// A brake pad on a rough disc: from a scan to the probability of vibration.
    Quickstart,
    /// The study of Gaus et al. 2016.
    Paper,
}

/// File of a study: its name and its bytes.
type Piece = (Cow<'static, str>, Cow<'static, [u8]>);

const SCAN: &str = "brake_disc.x3p";
const STUDY: &str = "study.toml";
/// Forms to remove from a scan, in the order in which they are tried.
const LEVELS: [Level; 3] = [Level::Plane, Level::Quadratic, Level::Polynomial(4)];
/// Column of the comments of a study.
const COMMENT: usize = 41;

impl Example {
    fn pieces(self) -> Vec<Piece> {
        let text = |name: &'static str, text: &'static str| (name.into(), text.as_bytes().into());
        match self {
            Self::Quickstart => {
                let scan: &[u8] = include_bytes!("init/brake_disc.x3p");
                vec![text("quickstart.toml", QUICKSTART), (SCAN.into(), scan.into())]
            }
            Self::Paper => vec![text("paper.toml", include_str!("init/paper.toml"))],
        }
    }
}

impl Init {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        if self.scan.is_none() && !self.options.study_keys().is_empty() {
            return Err(Failure::usage(
                "--channel, --pixel-size, --height-unit and --decimal describe the file of --scan",
            ));
        }
        if self.dir.is_file() {
            return Err(Failure::usage(format!("{} is a file; choose a folder", self.dir.display())));
        }
        let pieces = match &self.scan {
            Some(scan) => self.pieces_of_scan(scan, monitor)?,
            None => self.example.pieces(),
        };
        let pieces = self.named(pieces);
        // Write nothing unless all files can be written. An existing file may contain someone's work.
        if let Some((name, _)) = pieces.iter().find(|(name, _)| self.dir.join(&**name).exists()) {
            let path = self.dir.join(&**name);
            return Err(Failure::usage(format!("{} exists already; choose another folder", path.display())));
        }
        fs::create_dir_all(&self.dir)
            .map_err(|e| Failure::io(Kind::Runtime, format_args!("cannot make {}", self.dir.display()), &e))?;
        for (name, bytes) in &pieces {
            replace_file(&self.dir.join(&**name), |file| std::io::Write::write_all(file, bytes))?;
            monitor.note(&format!("wrote {}", self.dir.join(&**name).display()));
        }
        let study = self.dir.join(&*pieces[0].0);
        monitor.note(&format!("next: asperity run {}", shown(&study)));
        Ok(())
    }

    /// Returns the pieces with the name of the folder in the study, so that its run has this name too; unchanged if the file has it already.
    fn named(&self, mut pieces: Vec<Piece>) -> Vec<Piece> {
        let (file, bytes) = &mut pieces[0];
        let folder = self.dir.file_name().and_then(|name| name.to_str()).filter(|name| is_folder_name(name));
        if let Some(folder) = folder.filter(|folder| Path::new(&**file).file_stem() != Some(OsStr::new(folder)))
            && let Ok(text) = std::str::from_utf8(bytes)
        {
            let name = toml::Value::from(folder);
            let line = format!("{:<COMMENT$}# of the run: runs/{folder}\n", format!("name = {name}"));
            *bytes = text.replacen("\nseed = ", &format!("\n{line}seed = "), 1).into_bytes().into();
        }
        pieces
    }

    /// Returns the study of a scan, and the scan unless it is in the folder.
    fn pieces_of_scan(&self, scan: &Path, monitor: &Terminal) -> Result<Vec<Piece>, Failure> {
        let name = scan.file_name().and_then(|name| name.to_str()).map(str::to_owned);
        let name = name.ok_or_else(|| Failure::usage(format!("{} is no file with a name in UTF-8", scan.display())))?;
        let bytes =
            fs::read(scan).map_err(|e| Failure::io(Kind::Data, format_args!("cannot read {}", scan.display()), &e))?;
        let folder = scan.parent().unwrap_or(Path::new(""));
        let mut text = with_value(QUICKSTART, "surface", "file", &toml::Value::from(name.as_str()));
        text = text.replacen("synthetic scan; put your own here", "your scan", 1);
        if input::is_profile(scan, &self.options) {
            let line = format!("{:<COMMENT$}# a profile stands for a surface without lay", "isotropic = true");
            text = text.replacen("\nlevel = ", &format!("\n{line}\nlevel = "), 1);
        }
        for (key, value) in self.options.study_keys() {
            text = text.replacen("\nlevel = ", &format!("\n{key} = {value}\nlevel = "), 1);
        }
        let (text, sizes) = self.levelled(&text, scan, folder, monitor)?;
        monitor.note(&sizes.to_string());
        let text = with_sizes(&text, &name, &sizes);
        let mut pieces = vec![(STUDY.into(), text.into_bytes().into())];
        let is_there = fs::canonicalize(folder).ok() == fs::canonicalize(&self.dir).ok();
        if !is_there {
            pieces.push((name.into(), bytes.into()));
        }
        Ok(pieces)
    }

    /// Returns the text of the study of a scan with the form to remove, and the sizes that follow.
    fn levelled(
        &self,
        text: &str,
        scan: &Path,
        folder: &Path,
        monitor: &Terminal,
    ) -> Result<(String, ScanSizes), Failure> {
        let failure = |error| study_file::failure(scan, None, &error);
        let levels = self.level.as_ref().map_or(&LEVELS[..], std::slice::from_ref);
        for (place, level) in levels.iter().enumerate() {
            let text = with_level(text, *level, &levels[..place]);
            let study = Study::parse(&text, STUDY).map_err(|e| Failure::usage(e.to_string()))?;
            if place == 0 {
                study.check_scans(folder).map_err(failure)?.iter().for_each(|warning| monitor.warn(warning));
            }
            match monitor.killable(|| study.scan_sizes(folder))? {
                Err(StudyError::NoCorrelationLength) if self.level.is_none() => {
                    monitor.note(&format!(
                        "With level = \"{level}\" the correlation of the heights does not fall to 1/e."
                    ));
                }
                sizes => return Ok((text, sizes.map_err(failure)?)),
            }
        }
        let tried = levels.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        Err(Failure::new(
            Kind::Data,
            format!(
                "{}: the correlation of the heights does not fall to 1/e within half of the scan, whichever form is removed ({tried}); \
                 take a larger scan, or state another form by `--level`",
                scan.display()
            ),
        ))
    }
}

/// Returns the text of a study with this form, and with a comment on the `others` that were tried before.
fn with_level(text: &str, level: Level, others: &[Level]) -> String {
    let text = with_value(text, "surface", "level", &toml::Value::from(level.to_string()));
    if others.is_empty() {
        return text;
    }
    let others = others.iter().map(|level| format!("\"{level}\"")).collect::<Vec<_>>().join(" or ");
    let comment =
        format!("# with {others} the correlation of the heights does not fall to 1/e within half of the scan");
    text.replacen("\nlevel = ", &format!("\n{comment}\nlevel = "), 1)
}

/// Returns the text of a study with another value of a key that it states. Comments stay where they are.
fn with_value(text: &str, section: &str, key: &str, value: &toml::Value) -> String {
    let mut within = false;
    let changed = text.lines().map(|line| {
        if line.starts_with('[') {
            within = line.starts_with(&format!("[{section}]"));
        }
        if !within || !line.starts_with(&format!("{key} = ")) {
            return format!("{line}\n");
        }
        let written = format!("{key} = {value}");
        match line.split_once(" # ") {
            Some((_, comment)) => format!("{written:<COMMENT$}# {comment}\n"),
            None => written + "\n",
        }
    });
    changed.collect()
}

/// Formats a length in metre with six digits.
fn written(length_m: f64) -> String {
    let units = [("nm", 1e-9), ("um", 1e-6), ("mm", 1e-3)];
    let (unit, size_m) = units.into_iter().rfind(|(_, size_m)| length_m >= *size_m).unwrap_or(units[0]);
    let number = length_m / size_m;
    let places = 5_usize.saturating_sub(number.log10().max(0.0) as usize);
    let digits = format!("{number:.places$}");
    format!("{} {unit}", digits.trim_end_matches('0').trim_end_matches('.'))
}

/// Returns the study of the scan `name` with these sizes.
fn with_sizes(text: &str, name: &str, sizes: &ScanSizes) -> String {
    let length = |m: f64| toml::Value::from(written(m));
    let pair = |sides: [f64; 2]| toml::Value::Array(sides.map(length).into());
    let points = toml::Value::Array(sizes.strip_points.map(|n| toml::Value::Integer(n as i64)).into());
    let values = [
        ("pressure", "size", pair(sizes.patch_m)),
        ("friction", "strip", pair(sizes.strip_m)),
        ("friction", "points", points),
        ("friction", "window", length(ScanSizes::window_m(sizes.strip_m[0]))),
    ];
    let text =
        values.iter().fold(text.to_owned(), |text, (section, key, value)| with_value(&text, section, key, value));
    let first = format!(
        "# Study of {name}. {sizes}\n# Sizes and points follow from these. Material and machine are those of an example: put your own."
    );
    text.split_once('\n').map_or_else(String::new, |(_, rest)| format!("{first}\n{rest}"))
}

/// Formats a path without a leading `./`.
fn shown(path: &Path) -> String {
    path.strip_prefix(".").unwrap_or(path).display().to_string()
}

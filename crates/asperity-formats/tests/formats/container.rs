use asperity_formats::{Format, ReadOptions};

use crate::check::{assert_error, assert_no_warning, assert_pitch, assert_refused, assert_warns};
use crate::fixture::{Content, Fixture, read_bytes, read_bytes_with, read_channel};
use crate::{assert_heights, memory, netcdf};

/// A description as written by `yaml.dump` of Python: keys in the order of the alphabet, texts in quotes over several lines.
const YAML: &str = r#"creation_time: '2021-06-21 15:06:49+00:00'
surfaces:
- category: exp
  description: "A \"seal\" of
    original: unknown.txt"
  topographies:
  - creator:
      name: It's me
    data_source: 0
    datafile:
      original: 0-matrix.txt
    height_scale: 2.0
    instrument:
      unit: mm
    size: !!python/tuple
    - 6.0
    - 4.0
    unit: um
  - datafile:
      original: 1-map.nc
      squeezed-netcdf: 1-map-squeezed.nc
    height_scale: 3.0
    unit: mm
versions:
  topobank: 0.13.0
"#;

/// The same as JSON of TopoBank.
const JSON: &str = r#"{
    "versions": {"topobank": "1.70"},
    "surfaces": [
        {
            "name": "a \"seal\", original: unknown.txt",
            "topographies": [
                {
                    "datafile": {
                        "original": "0-matrix.txt",
                        "squeezed-netcdf": null
                    },
                    "instrument": {
                        "unit": "mm"
                    },
                    "unit": "um",
                    "size": [
                        6.0,
                        4.0
                    ],
                    "height_scale": 2.0
                },
                {
                    "datafile": {
                        "original": "1-map.nc",
                        "squeezed-netcdf": "1-map-squeezed.nc"
                    },
                    "size": [3.0, 6.0]
                }
            ]
        }
    ]
}
"#;

/// A container with a matrix without units and a map of SurfaceTopography.
fn container(folder: &str, name: &str, description: &str) -> Content {
    let file = |name: &str, bytes: &[u8]| (format!("{folder}{name}"), bytes.to_vec());
    Content::Zip(vec![
        file("0-matrix.txt", b"0 1 2\n0.5 0.25 1\n"),
        file("1-map.nc", b"of another program"),
        file("1-map-squeezed.nc", &netcdf::of_surface_topography()),
        file(name, description.as_bytes()),
    ])
}

fn with(text: &str, other: &str) -> Vec<u8> {
    container("", "meta.yml", &YAML.replace(text, other)).bytes()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let fixture = |name, content: Content| Fixture { name, needed: content.bytes().len(), content };
    vec![
        fixture("Container with YAML", container("", "meta.yml", YAML)),
        fixture("Container with JSON in a folder", container("a/", "index.json", JSON)),
    ]
}

#[test]
fn an_original_without_units_takes_unit_size_and_scale_of_the_description() {
    for bytes in [container("", "meta.yml", YAML).bytes(), container("a/", "index.json", JSON).bytes()] {
        let scan = read_bytes(&bytes).unwrap();
        assert_eq!((scan.format, scan.channels.as_slice()), (Some(Format::Container), &names()[..]));
        assert_heights(&scan, &[0.0, 2e-6, 4e-6, 1e-6, 0.5e-6, 2e-6]);
        assert_pitch(&scan, (2e-6, 2e-6));
        assert_eq!(scan.height_unit.as_deref(), Some("um"));
        // The user's unit takes precedence, and the scale then has no meaning.
        let options = ReadOptions { height_unit: Some("nm".parse().unwrap()), ..ReadOptions::default() };
        let scan = read_bytes_with(&bytes, &options).unwrap();
        assert_heights(&scan, &[0.0, 1e-9, 2e-9, 0.5e-9, 0.25e-9, 1e-9]);
        assert_warns(&scan, "height scale 2");
    }
}

fn names() -> [String; 2] {
    ["0-matrix.txt".into(), "1-map-squeezed.nc".into()]
}

#[test]
fn a_squeezed_file_is_read_rather_than_its_original() {
    let bytes = container("", "meta.yml", YAML).bytes();
    let wanted = read_bytes(&netcdf::of_surface_topography()).unwrap();
    for channel in ["2", "1-map-squeezed.nc"] {
        let scan = read_channel(&bytes, channel).unwrap();
        assert_no_warning(&scan);
        assert_eq!((scan.heights_m, scan.pitch_m, scan.channel), (wanted.heights_m.clone(), wanted.pitch_m, 1));
    }
    assert_error(
        read_channel(&bytes, "1-map.nc"),
        "Container: no height map `1-map.nc`; the file holds `0-matrix.txt`",
    );
}

#[test]
fn the_scale_of_heights_with_a_unit_is_reported_and_not_applied() {
    let only_original =
        YAML.replace("      squeezed-netcdf: 1-map-squeezed.nc\n", "").replace("1-map.nc", "1-map-squeezed.nc");
    let scan = read_channel(&container("", "meta.yml", &only_original).bytes(), "2").unwrap();
    assert_warns(&scan, "the height scale 3 of the container was not applied");
    assert_eq!(scan.heights_m, read_bytes(&netcdf::of_surface_topography()).unwrap().heights_m);
}

#[test]
fn containers_without_a_readable_measurement_are_refused() {
    let nested = Content::Zip(vec![
        ("0-matrix.txt".into(), container("", "meta.yml", YAML).bytes()),
        ("meta.yml".into(), YAML.as_bytes().to_vec()),
    ]);
    assert_refused([
        (with("datafile:", "files:"), "Container: the container holds no measurement; wanted a measurement"),
        (with("0-matrix.txt", "gone.txt"), "Container: gone.txt: no such file in the archive"),
        (nested.bytes(), "Container: a container in a container"),
    ]);
    let unread = "Container: `1-map.nc` of 0-matrix.txt, 1-map.nc is not read (text: ";
    assert_error(read_channel(&with("      squeezed-netcdf: 1-map-squeezed.nc\n", ""), "2"), unread);
    assert_ne!(Format::detect(&with("surfaces:", "objects:")), Some(Format::Container));
}

/// A container with the first measurement alone.
fn first(description: &str) -> Vec<u8> {
    container("", "index.json", description).bytes()
}

#[test]
fn descriptions_are_yaml_and_json_in_any_layout() {
    let flow = |unit: &str| {
        format!(
            r#"{{"surfaces": [{{"unit": "mm", "topographies": [{{"properties": {{"datafile": {{"original": "no"}}, "unit": "km"}}, "name": "a",
            "datafile": {{"original": "0-matrix.txt"}}, "size": [6.0, 4.0], "unit": {unit}, "height_scale": 2.0}}]}}]}}"#
        )
    };
    for unit in [r#""um""#, r#""\u00b5m""#, r#""\xB5m""#, r#""\u03BCm""#, r#""\u03bcm""#, "um # micrometre\n", "'µm'"]
    {
        for text in [flow(unit), flow(unit).replace('\n', " ").replace("# micrometre", "")] {
            let scan = read_bytes(&first(&text)).unwrap();
            assert_heights(&scan, &[0.0, 2e-6, 4e-6, 1e-6, 0.5e-6, 2e-6]);
            assert_pitch(&scan, (2e-6, 2e-6));
        }
    }
    // Names with escapes or over several lines, in two scripts.
    for (written, name) in [
        ("\"Pr\\xFCfteil \\\n        a\"", "Prüfteil a"),
        (r#""\ud83d\ude00.txt""#, "😀.txt"),
        (r#""a\\ud83d.txt""#, "a\\ud83d.txt"),
        ("a long\n        name", "a long name"),
        (">-\n        a long\n        name", "a long name"),
    ] {
        let description = YAML.replace("0-matrix.txt", written);
        let files = [(name.to_owned(), b"0 1 2\n0.5 0.25 1\n".to_vec()), ("meta.yml".into(), description.into_bytes())];
        let scan = read_channel(&Content::Zip(files.into()).bytes(), "1").unwrap();
        assert_eq!(scan.channel_name(), Some(name));
    }
}

#[test]
fn aliases_and_depth_of_descriptions_cannot_fill_the_memory_or_the_stack() {
    let list = |letter: char| format!("&{letter} [{}]", vec![format!("*{}", (letter as u8 - 1) as char); 9].join(","));
    let bomb: String = ('b'..='y').map(|letter| format!("{letter}: {}\n", list(letter))).collect();
    let bomb = format!("a: &a [x,x,x,x]\n{bomb}");
    let deep = |start: &str, open: &str| format!("surfaces: \n{start}{}", open.repeat(60_000));
    for description in [
        format!("{bomb}surfaces: *y\n"),
        deep("", "["),
        deep("", "{a: "),
        deep("", "- "),
        deep("", "? "),
        deep("", "[{"),
        format!("surfaces: [{}]", r#"{"topographies":[{}]},"#.repeat(4200)),
    ] {
        let bytes = first(&description);
        let (read, peak) = memory::peak_bytes(|| read_bytes(&bytes));
        let error = read.unwrap_err().to_string();
        assert!(error.starts_with("Container: index.json: line "), "{error}");
        assert!(peak < 32 << 20, "{peak}");
    }
    // Aliases elsewhere have no effect.
    let bytes = first(&(bomb + YAML).replace("data_source: 0", "data_source: *y"));
    assert_heights(&read_bytes(&bytes).unwrap(), &[0.0, 2e-6, 4e-6, 1e-6, 0.5e-6, 2e-6]);
}

#[test]
fn units_that_are_no_length_are_refused_and_nothing_is_left_out_silently() {
    let other = with("    unit: um", "    unit: V");
    assert_refused([
        (other.clone(), "Container: numbers in `V`; wanted a unit of length"),
        (
            with("height_scale: 2.0", "height_scale: two"),
            "`height_scale` in meta.yml (line 12) is `two`; wanted a number",
        ),
        (with("- 6.0", "- wide"), "`size` in meta.yml (line 16) is `wide`; wanted a number"),
    ]);
    let options = ReadOptions { height_unit: Some("nm".parse().unwrap()), ..ReadOptions::default() };
    let scan = read_bytes_with(&other, &options).unwrap();
    assert_heights(&scan, &[0.0, 1e-9, 2e-9, 0.5e-9, 0.25e-9, 1e-9]);
    assert_warns(&scan, "the height scale 2 of the container was not applied: the stated unit replaces it");
    assert_warns(&scan, "a size without a unit of length; no pixel size was read");
    let scan = read_bytes(&with("    unit: um", "    unit: null")).unwrap();
    assert_heights(&scan, &[0.0, 2.0, 4.0, 1.0, 0.5, 2.0]);
    assert_warns(&scan, "a size without a unit of length");
}

#[test]
fn a_measurement_is_chosen_by_its_own_name_if_no_other_has_it() {
    let named = |second: &str| {
        let names = YAML.replace("    height_scale: 2.0", "    name: first\n    height_scale: 2.0");
        container("", "meta.yml", &names.replace("    height_scale: 3.0", &format!("    name: {second}"))).bytes()
    };
    assert_eq!(read_channel(&named("second"), "second").unwrap().channel, 1);
    assert_eq!(read_channel(&named("second"), "first").unwrap().channel, 0);
    assert_error(read_channel(&named("first"), "first"), "Container: no height map `first`");
    assert_error(read_channel(&named("second"), "It's me"), "Container: no height map `It's me`");
}

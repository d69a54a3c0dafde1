use asperity_formats::{Format, ReadOptions};

use crate::check::{assert_error, assert_no_warning, assert_pitch, assert_refused, assert_warns};
use crate::fixture::{Content, Fixture, read_bytes, read_bytes_with, read_channel};
use crate::{assert_heights, netcdf};

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

//! Binary formats with many parts, long texts, or types that take eight times their size as heights.

use crate::Crafted;

fn u32s(numbers: &[usize]) -> Vec<u8> {
    numbers.iter().flat_map(|&number| (number as u32).to_le_bytes()).collect()
}

/// An NPY file of version 2.
fn npy_of(header: &str, data: &[u8]) -> Vec<u8> {
    [b"\x93NUMPY\x02\x00", &u32s(&[header.len()])[..], header.as_bytes(), data].concat()
}

pub(crate) fn npy(descr: &str, column_major: bool, (rows, columns): (usize, usize), data: &[u8]) -> Vec<u8> {
    let order = if column_major { "True" } else { "False" };
    npy_of(&format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({rows}, {columns})}}"), data)
}

/// GWY: a component, an object, an image of one point, and a file of images and other components.
fn component(name: &str, kind: u8, value: &[u8]) -> Vec<u8> {
    [name.as_bytes(), &[0, kind], value].concat()
}

fn object(kind: &str, content: &[u8]) -> Vec<u8> {
    [kind.as_bytes(), &[0], &u32s(&[content.len()]), content].concat()
}

fn image(number: usize, title: &[u8]) -> Vec<u8> {
    let real = 1e-6_f64.to_le_bytes();
    let unit = |name| component(name, b'o', &object("GwySIUnit", b"unitstr\0sm\0"));
    let field = [
        component("xres", b'i', &u32s(&[1])),
        component("yres", b'i', &u32s(&[1])),
        component("xreal", b'd', &real),
        component("yreal", b'd', &real),
        component("data", b'D', &[u32s(&[1]), vec![0; 8]].concat()),
        unit("si_unit_xy"),
        unit("si_unit_z"),
    ];
    let title = component(&format!("/{number}/data/title"), b's', &[title, &[0]].concat());
    [component(&format!("/{number}/data"), b'o', &object("GwyDataField", &field.concat())), title].concat()
}

fn gwy(components: &[Vec<u8>]) -> Vec<u8> {
    [b"GWYP".to_vec(), object("GwyContainer", &components.concat())].concat()
}

fn gwy_with_meta(meta: &[u8]) -> Vec<u8> {
    gwy(&[image(0, b""), component("/0/meta", b'o', &object("GwyContainer", meta))])
}

/// A TIFF page of one float that begins after the directory, with texts at the same place: tag and length.
fn tiff(texts: &[usize], text: &[u8]) -> Vec<u8> {
    const START: usize = 1024;
    let numbers = [(256, 1), (257, 1), (258, 32), (262, 1), (273, START), (277, 1), (278, 1), (279, 4), (339, 3)];
    let mut fields: Vec<(usize, usize, usize, usize)> =
        numbers.iter().map(|&(tag, value)| (tag, 4, 1, value)).collect();
    fields.extend(texts.iter().map(|&tag| (tag, 2, text.len(), START)));
    fields.sort_unstable();
    let mut bytes = [b"II\x2a\0".to_vec(), u32s(&[8]), (fields.len() as u16).to_le_bytes().to_vec()].concat();
    for (tag, kind, count, value) in fields {
        bytes.extend([(tag as u16).to_le_bytes(), (kind as u16).to_le_bytes()].concat());
        bytes.extend(u32s(&[count, value]));
    }
    bytes.resize(START, 0);
    bytes.extend(text);
    bytes
}

/// An FRT file of these blocks beside the sizes and the scale.
fn frt(blocks: &[(u16, Vec<u8>)]) -> Vec<u8> {
    let millimetres = [1e-3_f64; 2].iter().flat_map(|size| size.to_le_bytes()).collect();
    let scale = [u32s(&[2]), 1e-8_f64.to_le_bytes().to_vec()].concat();
    let known = [(0x67, millimetres), (0x6c, scale), (0x66, u32s(&[2, 2, 16])), (0x0b, vec![0; 8])];
    let mut bytes = b"FRTM_GLIDERV1.00\0\0".to_vec();
    for (tag, content) in known.iter().chain(blocks) {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(u32s(&[content.len()]));
        bytes.extend(content);
    }
    bytes
}

/// Returns an OPD file of these blocks after a wavelength: name, type, content.
fn opd(blocks: &[(String, u16, Vec<u8>)]) -> Vec<u8> {
    let wavelength = ("Wavelength".to_owned(), 7, 600_f32.to_le_bytes().to_vec());
    let entry = |name: &str, kind: u16, length: usize| {
        let mut entry = name.as_bytes().to_vec();
        entry.resize(16, 0);
        [entry, kind.to_le_bytes().to_vec(), u32s(&[length]), vec![0; 2]].concat()
    };
    let mut bytes = [vec![1, 0], entry("Directory", 1, 24 * (blocks.len() + 2))].concat();
    for (name, kind, content) in std::iter::once(&wavelength).chain(blocks) {
        bytes.extend(entry(name, *kind, content.len()));
    }
    bytes.extend(std::iter::once(&wavelength).chain(blocks).flat_map(|(.., content)| content.clone()));
    bytes
}

/// A SUR object of one point in a series.
fn sur_object() -> Vec<u8> {
    let mut bytes = b"DIGITAL SURF".to_vec();
    bytes.resize(514, 0);
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    // Number of objects, type, bits per point; points along x, along y, in all; spacings; units.
    put(14, &[100, 0]);
    put(18, &[5, 0]);
    put(98, &[16, 0]);
    put(108, &u32s(&[1, 1, 1]));
    put(120, &1_f32.to_le_bytes().repeat(3));
    put(180, &b"um\0\0\0\0\0\0\0\0\0\0\0\0\0\0".repeat(6));
    bytes
}

pub(crate) fn crafted(size: usize) -> Vec<Crafted> {
    let side = size.isqrt();
    let latin1 = vec![0xe9; size];
    let pairs: Vec<u8> = (0..size / 10).flat_map(|n| component(&n.to_string(), b's', b"x\0")).collect();
    let lines: String = (0..size / 9).map(|n| format!("{n}=\n")).collect();
    let raw = || ("Raw".to_owned(), 3, [&[1, 0, 1, 0, 4, 0][..], &1_f32.to_le_bytes()].concat());
    let small = [u32s(&[4, 2, 2, 16]), vec![2; 8]].concat();
    let all_texts = [269, 270, 271, 272, 305, 306, 315, 316, 33432];
    vec![
        ("NPY of commas", npy_of(&format!("{{{}}}", ",".repeat(size)), &[])),
        (
            "NPY of many dimensions",
            npy_of(&format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({})}}", "1,".repeat(30_000)), &[]),
        ),
        ("NPY of int8 in column order", npy("|i1", true, (side, side), &vec![1; side * side])),
        ("GWY with many texts", gwy_with_meta(&pairs)),
        ("GWY with a long text", gwy_with_meta(&component("a", b's', &[&latin1[..], &[0]].concat()))),
        ("GWY with a long name", gwy(&[image(0, b""), [&latin1[..], &[0, b'!']].concat()])),
        ("GWY with long titles", gwy(&(0..20).map(|n| image(n, &latin1[..size / 20])).collect::<Vec<_>>())),
        ("GWY of many images", gwy(&(0..size / 240).map(|n| image(n, b"\x1b[2J")).collect::<Vec<_>>())),
        ("TIFF with one text for all fields", tiff(&all_texts, &latin1)),
        ("TIFF with many lines", tiff(&[270], format!("ImageJ=1\n{lines}").as_bytes())),
        ("FRT of empty blocks", frt(&vec![(0x1234, Vec::new()); size / 6])),
        ("FRT of many images", frt(&[(0x7d, [vec![0; 8], small.repeat(size / 24)].concat())])),
        ("FRT with a long text", frt(&[(0x65, latin1.clone()), (0x77, latin1[..size / 2].to_vec())])),
        ("OPD of many arrays", opd(&vec![raw(); (size / 34).min(65_000)])),
        (
            "OPD of many texts",
            opd(&(0..(size / 400).min(65_000))
                .map(|n| (n.to_string(), 5, latin1[..376].to_vec()))
                .chain([raw()])
                .collect::<Vec<_>>()),
        ),
        ("SUR of many objects", sur_object().repeat(size / 514)),
    ]
}

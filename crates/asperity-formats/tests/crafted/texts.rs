//! Text: matrices, points, and formats whose headers are text.

use crate::Crafted;

/// So many bytes of a piece again and again.
fn filled(piece: &[u8], size: usize) -> Vec<u8> {
    piece.repeat(size / piece.len())
}

/// Two rows of numbers below a head.
fn headed(head: Vec<u8>) -> Vec<u8> {
    [head, b"\n1 2\n3 4\n".to_vec()].concat()
}

/// An SDF file of one height with a line in its header and a trailer.
fn sdf(line: &[u8], trailer: &[u8]) -> Vec<u8> {
    let start = b"aISO-1.0\nManufacID = a\n";
    let rest = b"\nCreateDate = 1\nModDate = 1\nNumPoints = 1\nNumProfiles = 1\nXscale = 1e-6\nYscale = 1e-6\n\
        Zscale = 1e-6\nZresolution = 1e-9\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n1\n*\n";
    [start, line, rest, trailer].concat()
}

/// A BCR file of one height whose header ends with `rest`.
fn bcr(rest: &[u8]) -> Vec<u8> {
    let start = b"fileformat = bcrstm\nxpixels = 1\nypixels = 1\nbit2nm = 1\nheadersize = ";
    let size = format!("{:>10}\n", start.len() + 11 + rest.len());
    [start, size.as_bytes(), rest, &[1, 0]].concat()
}

pub(crate) fn crafted(size: usize) -> Vec<Crafted> {
    let grid = |width: usize| -> Vec<u8> {
        (0..size / 10).flat_map(|place| format!("{} {} 0\n", place % width, place / width).into_bytes()).collect()
    };
    let latin1 = filled(b"\xe9 ", size);
    let words = filled(b"a ", size);
    vec![
        ("ones in rows", filled(b"1 1 1 1 1 1 1 1\n", size)),
        ("ones in a column", filled(b"1\n", size)),
        ("ones in one line", filled(b"1 ", size)),
        ("empty fields in one line", filled(b",", size)),
        ("empty fields in rows", filled(b",,,,,,,\n", size)),
        ("tabs", filled(b"\t", size)),
        ("empty lines", headed(filled(b"\n", size))),
        ("empty comments", headed(filled(b"#\n", size))),
        ("keys without values", headed(filled(b"a:\n", size))),
        ("comments before channels", [filled(b"#x\n", size), b"# Channel: a\n1\n# Channel: b\n2\n".to_vec()].concat()),
        ("channels", filled(b"# Channel: a\n1 2\n", size)),
        ("a long comment", headed([b"#", &words[..]].concat())),
        ("a long comment in Latin-1", headed([b"#", &latin1[..]].concat())),
        ("a long key in Latin-1", headed([b"#", &latin1[..], b": 1"].concat())),
        ("a long pixel size", headed([b"# pixel size: ", &filled(b"(", size)[..], b"1 um"].concat())),
        ("a dense first row", [b",,,,,\n#".to_vec(), words.clone()].concat()),
        ("comments behind the rows", headed(b"#".to_vec()).into_iter().chain(filled(b"#x\n", size)).collect()),
        ("words", filled(b"lorem ipsum ", size)),
        ("blanks", [filled(b" ", size), b"1".to_vec()].concat()),
        ("a long number", [b"0.".to_vec(), filled(b"1", size)].concat()),
        ("numbers with decimal commas", filled(b"1,5;2,5\n", size)),
        ("nothing but NaN", filled(b"nan inf -inf BAD\n", size)),
        ("errors of a spreadsheet", filled(b"#N/A,#DIV/0!\n", size)),
        ("UTF-16", [b"\xff\xfe".to_vec(), filled(b"1\0\t\x002\0\n\0", size)].concat()),
        ("points in squares", grid(1 << 9)),
        ("points in long lines", grid(1 << 17)),
        (
            "points far below their header",
            [b"# x [mm] y [mm] z [um]\n#", &words[..], b"\n", &grid(1 << 9)[..]].concat(),
        ),
        ("SDF with a long line", sdf(&[b"a ", &latin1[..], b"= 1"].concat(), b"")),
        ("SDF with many lines", sdf(&filled(b"a = b\n", size), b"")),
        ("SDF with a long trailer", sdf(b"", &[&latin1[..], b"= 1"].concat())),
        ("SDF with a trailer of many lines", sdf(b"", &filled(b"<a>\n", size))),
        ("BCR with a long line", bcr(&[&latin1[..size.min(900_000)], b"= 1"].concat())),
        ("BCR with many lines", bcr(&filled(b"a=b\n", size.min(900_000)))),
    ]
}

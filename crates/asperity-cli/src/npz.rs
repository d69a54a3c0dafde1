//! NumPy archives: a ZIP of NPY files. Equal arrays give equal bytes.

use std::io::{Seek, Write};
use std::path::Path;

use asperity_formats::{Scan, write_npy};
use ndarray::Array2;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::failure::Failure;
use crate::output::replace_file;

/// Writes an archive of the named arrays, readable with `numpy.load`, and replaces an existing file.
pub(crate) fn write(path: &Path, arrays: &[(&str, &Array2<f64>)]) -> Result<(), Failure> {
    replace_file(path, |file| Ok(write_archive(file, arrays)?))
}

fn write_archive<W: Write + Seek>(target: W, arrays: &[(&str, &Array2<f64>)]) -> zip::result::ZipResult<()> {
    // The archive stores no time and no attributes of this machine, so equal arrays give equal bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut archive = ZipWriter::new(target);
    for (name, array) in arrays {
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&write_npy(&Scan::new((*array).clone(), None)))?;
    }
    archive.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_formats::read_bytes;
    use ndarray::array;
    use std::io::{Cursor, Read};

    #[test]
    fn an_archive_stores_arrays_bit_for_bit_and_equal_arrays_give_equal_bytes() {
        let (pressure, gap) = (array![[0.1, 2e9], [-0.0, 1.0 / 3.0]], array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let archive = || {
            let mut bytes = Cursor::new(Vec::new());
            write_archive(&mut bytes, &[("pressure_pa", &pressure), ("gap_m", &gap)]).unwrap();
            bytes.into_inner()
        };
        assert_eq!(archive(), archive());
        let mut zip = zip::ZipArchive::new(Cursor::new(archive())).unwrap();
        let mut read = |name: &str| {
            let mut bytes = Vec::new();
            zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
            read_bytes(&bytes).unwrap().heights_m
        };
        assert_eq!(read("pressure_pa.npy"), pressure);
        assert_eq!(read("gap_m.npy"), gap);
    }
}

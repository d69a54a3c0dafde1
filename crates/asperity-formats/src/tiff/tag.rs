//! Supported fields, by their names in the specification.

use super::Tag;

pub(super) const NEW_SUBFILE_TYPE: Tag = Tag(254, "NewSubfileType");
pub(super) const IMAGE_WIDTH: Tag = Tag(256, "ImageWidth");
pub(super) const IMAGE_LENGTH: Tag = Tag(257, "ImageLength");
pub(super) const BITS_PER_SAMPLE: Tag = Tag(258, "BitsPerSample");
pub(super) const COMPRESSION: Tag = Tag(259, "Compression");
pub(super) const PHOTOMETRIC: Tag = Tag(262, "PhotometricInterpretation");
pub(super) const FILL_ORDER: Tag = Tag(266, "FillOrder");
pub(super) const IMAGE_DESCRIPTION: Tag = Tag(270, "ImageDescription");
pub(super) const MAKE: Tag = Tag(271, "Make");
pub(super) const MODEL: Tag = Tag(272, "Model");
pub(super) const STRIP_OFFSETS: Tag = Tag(273, "StripOffsets");
pub(super) const ORIENTATION: Tag = Tag(274, "Orientation");
pub(super) const SAMPLES_PER_PIXEL: Tag = Tag(277, "SamplesPerPixel");
pub(super) const ROWS_PER_STRIP: Tag = Tag(278, "RowsPerStrip");
pub(super) const STRIP_BYTE_COUNTS: Tag = Tag(279, "StripByteCounts");
pub(super) const X_RESOLUTION: Tag = Tag(282, "XResolution");
pub(super) const Y_RESOLUTION: Tag = Tag(283, "YResolution");
pub(super) const PAGE_NAME: Tag = Tag(285, "PageName");
pub(super) const RESOLUTION_UNIT: Tag = Tag(296, "ResolutionUnit");
pub(super) const PREDICTOR: Tag = Tag(317, "Predictor");
pub(super) const TILE_WIDTH: Tag = Tag(322, "TileWidth");
pub(super) const TILE_LENGTH: Tag = Tag(323, "TileLength");
pub(super) const TILE_OFFSETS: Tag = Tag(324, "TileOffsets");
pub(super) const TILE_BYTE_COUNTS: Tag = Tag(325, "TileByteCounts");
pub(super) const SAMPLE_FORMAT: Tag = Tag(339, "SampleFormat");
pub(super) const GDAL_NODATA: Tag = Tag(42113, "GDAL_NODATA");

//! Results of a study as one self-contained HTML page and SVG figures.

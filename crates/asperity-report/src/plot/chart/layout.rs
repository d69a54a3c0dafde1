//! Figures of several charts.

use super::Chart;
use super::legend::{Legend, PRINTED_ROW};
use crate::plot::canvas::{Rect, draw};
use crate::plot::image::ColourBar;

/// Room for the colour bar with its labels in pixels.
const BAR: f64 = 98.0;

/// Width of a figure: the pixels in which it is laid out, and millimetres in print.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Width {
    pub(crate) px: f64,
    pub(crate) mm: f64,
    /// Height of one row of the legend in pixels.
    pub(crate) row: f64,
}

/// Two columns of a paper.
pub(crate) const TWO_COLUMNS: Width = Width { px: 640.0, mm: 170.0, row: PRINTED_ROW };
/// One column of a paper.
pub(crate) const ONE_COLUMN: Width = Width { px: 400.0, mm: 85.0, row: PRINTED_ROW };
/// Page of a report: texts stay readable at the width of a phone.
pub(crate) const PAGE: Width = Width { px: 460.0, mm: 127.0, row: PRINTED_ROW };
/// Part of a page; a finger can touch the entries of its legend.
pub(crate) const SCREEN: Width = Width { px: 480.0, mm: 127.0, row: 34.0 };

/// Charts of a figure in columns, row by row, with one legend above them and one colour bar for all of their maps.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub(crate) columns: usize,
    pub(crate) charts: Vec<Chart>,
    pub(crate) colours: Option<ColourBar>,
}

/// Arranges charts over one x axis, one above the other and equally high; the lowest has the labels of the axis.
pub(crate) fn stacked(charts: Vec<Chart>, height: f64) -> Vec<Chart> {
    let last = charts.len().saturating_sub(1);
    let place = |(index, chart)| {
        let shows_x = index == last;
        Chart { shows_x, height: if shows_x { height + 42.0 } else { height }, ..chart }
    };
    charts.into_iter().enumerate().map(place).collect()
}

impl Layout {
    pub(crate) fn new(columns: usize, charts: &[Chart]) -> Self {
        Self { columns, charts: charts.to_vec(), colours: None }
    }

    /// Draws the figure as an SVG document.
    pub(crate) fn svg(&self, title: &str, description: &str, width: Width) -> String {
        let legend = Legend::new(self.charts.iter().flat_map(|chart| &chart.series), 72.0, width.px - 76.0, width.row);
        let (places, height) = self.places(width.px, legend.height());
        draw((width.px, height), width.mm, title, description, |canvas| {
            legend.draw(canvas, 0.0);
            for (chart, place) in self.charts.iter().zip(&places) {
                chart.draw(canvas, *place);
            }
            let maps = self.charts.iter().zip(&places).filter(|(chart, _)| chart.backdrop.is_some());
            let maps: Vec<Rect> = maps.map(|(chart, place)| chart.plot(*place)).collect();
            let ends = |of: fn(&Rect) -> f64, choose: fn(f64, f64) -> f64| maps.iter().map(of).reduce(choose);
            let ends = (ends(|r| r.top, f64::min), ends(|r| r.bottom, f64::max), ends(|r| r.right, f64::max));
            if let (Some(bar), (Some(top), Some(bottom), Some(right))) = (&self.colours, ends) {
                bar.draw(canvas, Rect::new(right + 18.0, top, 16.0, (bottom - top).max(60.0)));
            }
        })
    }

    /// Returns the places of the charts, whose plots are equally wide in a row, and the height of the figure.
    fn places(&self, width: f64, legend: f64) -> (Vec<Rect>, f64) {
        let width = width - if self.colours.is_some() { BAR } else { 0.0 };
        let (mut places, mut top) = (Vec::new(), legend);
        for row in self.charts.chunks(self.columns.max(1)) {
            let margins: f64 = row.iter().map(Chart::horizontal_margins).sum();
            // A last row with fewer charts has plots as wide as those above.
            let plot = (width - margins * self.columns as f64 / row.len() as f64) / self.columns as f64;
            let height = row.iter().map(|chart| chart.height_for(plot)).fold(0.0, f64::max);
            let mut left = 0.0;
            for chart in row {
                let width = plot + chart.horizontal_margins();
                places.push(Rect::new(left, top, width, height));
                left += width;
            }
            top += height;
        }
        (places, top.max(if self.colours.is_some() { legend + 160.0 } else { 0.0 }))
    }
}

//! Published values of contact and stick-slip.

/// Contact of a parabola at a fixed approach under a hardness, over the elastic contact (Hertz).
#[derive(Debug, Clone, Copy)]
pub struct CappedHertz {
    /// Hardness over the highest elastic pressure.
    pub hardness: f64,
    /// Load over the elastic load.
    pub load: f64,
    /// Area over the elastic area.
    pub area: f64,
    /// Relative error of `load`.
    pub load_tolerance: f64,
}

/// Values of an independent fine solution.
pub const CAPPED_HERTZ: [CappedHertz; 4] = [
    CappedHertz { hardness: 0.8, load: 0.98526, area: 1.012, load_tolerance: 3e-4 },
    CappedHertz { hardness: 0.6, load: 0.91633, area: 1.083, load_tolerance: 3e-4 },
    CappedHertz { hardness: 0.4, load: 0.76164, area: 1.274, load_tolerance: 3e-4 },
    CappedHertz { hardness: 0.1, load: 0.2675, area: 1.783, load_tolerance: 2e-3 },
];

/// Cycle of the oscillator with μ_st = 1, a = 3, ζ = 0 and V = 0.2, each value with half a unit of its last digit, times two.
///
/// # References
/// Leine, van Campen, de Kraker & van den Steen, *Nonlinear Dynamics* **16** (1998) 41, pp. 41–54.
pub const LEINE: [(&str, f64, f64); 5] = [
    ("period", 12.001_031, 1e-6),
    ("slip duration", 4.296_00, 1e-5),
    ("displacement at re-attachment", -0.541_006, 1e-6),
    ("largest displacement", 1.133_945, 1e-6),
    ("least velocity", -0.839_902, 1e-6),
];

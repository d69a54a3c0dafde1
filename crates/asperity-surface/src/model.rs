//! Random surfaces like a scan: the choices.

asperity_base::choice! {
    /// Generator of random surfaces.
    #[derive(Default)]
    pub enum SurfaceGenerator: "generator of surfaces" {
        /// Truncated Karhunen–Loève expansion (paper, eq. 2).
        #[default]
        KarhunenLoeve = "karhunen_loeve",
        /// Weierstrass–Mandelbrot function (paper, eq. 1) in its two-dimensional form.
        WeierstrassMandelbrot = "weierstrass_mandelbrot",
        /// All Fourier modes of the grid.
        Spectral = "spectral",
    }
}

asperity_base::choice! {
    /// Covariance of random surfaces.
    #[derive(Default)]
    pub enum CovarianceSource: "covariance" {
        /// The best of the models, fitted to the scan by likelihood; the scan's own where none keeps its spectrum and slopes.
        ///
        /// Spectrum and heights do not determine the contact. Copies of a scan with random phases and the scan's own heights need
        /// 0.75 to 1.44 times its mean pressure for 5 % contact on reference scans (st_al3d-1 and st_x3p-2 of
        /// SurfaceTopography): a study presses drawn maps and a part of the scan, and warns where they touch on different areas.
        #[default]
        Measured = "measured",
        /// The scan's own, made positive definite: no model, lays at any angle.
        Empirical = "empirical",
        /// ρ = e^{−r²}.
        SquaredExponential = "squared_exponential",
        /// ρ = e^{−r}.
        Exponential = "exponential",
        /// Matérn.
        Matern = "matern",
        /// Self-affine with roll-off.
        SelfAffine = "self_affine",
    }
}

impl CovarianceSource {
    /// Returns whether the covariance is taken from a scan.
    pub fn is_of_the_scan(self) -> bool {
        matches!(self, Self::Measured | Self::Empirical)
    }
}

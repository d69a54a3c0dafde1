//! Records of a known process: a translated Ornstein–Uhlenbeck process, with or without a window.

#![expect(clippy::expect_used, reason = "the distributions are constants of this program")]

use asperity::distribution::Marginal;
use asperity::random;
use asperity_testing::autoregressive;

/// Number of steps per correlation length.
pub(crate) const STEPS: usize = 10;

/// Process and layout of the records of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Planted {
    pub(crate) distribution: &'static str,
    /// Number of correlation lengths in all records together.
    pub(crate) lengths: usize,
    pub(crate) strips: usize,
    pub(crate) periodic: bool,
    /// Window in correlation lengths of the process; 0 shows the process itself.
    pub(crate) window: f64,
}

impl Planted {
    pub(crate) fn name(&self) -> String {
        let ends = if self.periodic { "periodic" } else { "free" };
        let window = if self.window > 0.0 { format!(", W = {} ℓ", self.window) } else { String::new() };
        format!("{}, {} × {} ℓ, {ends}{window}", self.distribution, self.strips, self.lengths / self.strips)
    }

    pub(crate) fn distribution(&self) -> Marginal {
        self.distribution.parse().expect("a distribution")
    }

    /// Returns the number of values in a window.
    pub(crate) fn cells(&self) -> usize {
        ((self.window * STEPS as f64) as usize).max(1)
    }

    /// Returns the records of a run.
    pub(crate) fn records(&self, run: u64) -> Vec<Vec<f64>> {
        let distribution = self.distribution();
        let n = self.lengths * STEPS / self.strips;
        (0..self.strips as u64)
            .map(|strip| {
                let cells = self.cells();
                let seed = run * 1000 + strip;
                let long = if self.periodic { circle(n, seed) } else { line(n + cells - 1, seed) };
                let values: Vec<f64> = long.iter().map(|g| distribution.translate(*g)).collect();
                let mean = |start: usize| (start..start + cells).map(|i| values[i % values.len()]).sum::<f64>();
                // A sixteenth of the window is less than a step, so every position is kept.
                (0..n).map(|start| mean(start) / cells as f64).collect()
            })
            .collect()
    }
}

fn phi() -> f64 {
    (-1.0 / STEPS as f64).exp()
}

fn line(n: usize, index: u64) -> Vec<f64> {
    autoregressive(phi(), n, &mut random::stream(7, "planted", index))
}

/// Returns a periodic record, with the correlation (φᵏ + φⁿ⁻ᵏ)/(1 + φⁿ).
fn circle(n: usize, index: u64) -> Vec<f64> {
    let phi = phi();
    let noise = random::standard_normal(&mut random::stream(7, "planted", index), n);
    let closed = 1.0 - phi.powi(n as i32);
    // One period from zero ends at the value of the path, except for the earlier periods, which add a geometric series.
    let mut last = noise.iter().fold(0.0, |last, e| phi * last + e) / closed;
    let scale = ((1.0 - phi * phi) * closed / (1.0 + phi.powi(n as i32))).sqrt();
    noise
        .iter()
        .map(|e| {
            last = phi * last + e;
            scale * last
        })
        .collect()
}

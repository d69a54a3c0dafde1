//! Works that the stages rest on.

use crate::figures::Stage;

/// The references for the stages present; the paper comes first, always.
pub(super) fn references(stages: &[Stage]) -> Vec<&'static str> {
    const PAPER: &str = "N. Gaus, C. Proppe, C. Zaccardi: Influence of surface roughness on friction induced vibrations. \
                         Meccanica dei Materiali e delle Strutture VI (2016) 1, 115–122.";
    let of = |stage: Stage| -> &'static [&'static str] {
        match stage {
            Stage::Surface => &[
                "ISO 25178-2:2021, Geometrical product specifications (GPS), Surface texture: Areal, Part 2: Terms, \
                 definitions and surface texture parameters.",
                "R. G. Ghanem, P. D. Spanos: Stochastic Finite Elements: A Spectral Approach. Springer, 1991. \
                 doi:10.1007/978-1-4612-3094-6",
            ],
            Stage::Pressure => &[
                "A. E. H. Love: The stress produced in a semi-infinite solid by pressure on part of the boundary. \
                 Philosophical Transactions of the Royal Society A 228 (1929) 377–420. doi:10.1098/rsta.1929.0009",
                "H. M. Stanley, T. Kato: An FFT-based method for rough surface contact. Journal of Tribology 119 (1997) \
                 481–485. doi:10.1115/1.2833523",
            ],
            Stage::Friction => &[
                "F. P. Bowden, D. Tabor: The Friction and Lubrication of Solids. Clarendon Press, Oxford, 1950.",
                "V. A. Yastrebov, G. Anciaux, J.-F. Molinari: On the accurate computation of the true contact-area in \
                 mechanical contact of random rough surfaces. Tribology International 114 (2017) 161–171. \
                 doi:10.1016/j.triboint.2017.04.023",
            ],
            Stage::Quotient => &[],
            Stage::Vibration => {
                &["E. Vanmarcke: Random Fields: Analysis and Synthesis. MIT Press, 1983 (the variance function behind \
                   the upscaling “area”)."]
            }
        }
    };
    std::iter::once(PAPER).chain(stages.iter().flat_map(|stage| of(*stage).iter().copied())).collect()
}

//! References for the stages.

/// Returns the references of the stages surface, pressure, friction and vibration that are present; the paper comes first, always.
pub(super) fn references(present: [bool; 5]) -> Vec<&'static str> {
    const PAPER: &str = "N. Gaus, C. Proppe, C. Zaccardi: Influence of surface roughness on friction induced vibrations. \
                         Meccanica dei Materiali e delle Strutture VI (2016) 1, 115–122.";
    const STAGES: [&[&str]; 5] = [
        &[
            "ISO 25178-2:2021, Geometrical product specifications (GPS), Surface texture: Areal, Part 2: Terms, \
             definitions and surface texture parameters.",
            "R. G. Ghanem, P. D. Spanos: Stochastic Finite Elements: A Spectral Approach. Springer, 1991. \
             doi:10.1007/978-1-4612-3094-6",
        ],
        &[
            "A. E. H. Love: The stress produced in a semi-infinite solid by pressure on part of the boundary. \
             Philosophical Transactions of the Royal Society A 228 (1929) 377–420. doi:10.1098/rsta.1929.0009",
            "H. M. Stanley, T. Kato: An FFT-based method for rough surface contact. Journal of Tribology 119 (1997) \
             481–485. doi:10.1115/1.2833523",
        ],
        &[
            "F. P. Bowden, D. Tabor: The Friction and Lubrication of Solids. Clarendon Press, Oxford, 1950.",
            "V. A. Yastrebov, G. Anciaux, J.-F. Molinari: On the accurate computation of the true contact-area in \
             mechanical contact of random rough surfaces. Tribology International 114 (2017) 161–171. \
             doi:10.1016/j.triboint.2017.04.023",
        ],
        &["E. Vanmarcke: Random Fields: Analysis and Synthesis. MIT Press, 1983 (the variance function behind \
           the upscaling “area”)."],
        &[
            "N. Hoffmann, M. Fischer, R. Allgaier, L. Gaul: A minimal model for studying properties of the mode-coupling type \
           instability in friction induced oscillations. Mechanics Research Communications 29 (2002) 197–205. \
           doi:10.1016/S0093-6413(02)00254-9",
        ],
    ];
    let stages = STAGES.iter().zip(present).filter(|(_, present)| *present);
    std::iter::once(PAPER).chain(stages.flat_map(|(works, _)| works.iter().copied())).collect()
}

/// Returns the entries of the program and of the paper for BibTeX.
pub(super) fn bibtex(version: &str) -> String {
    let version = if version.is_empty() { String::new() } else { format!("  version = {{{version}}},\n") };
    format!(
        "@software{{asperity,\n  title = {{asperity: from measured rough surfaces to contact pressure, friction and stick-slip}},\n  \
         author = {{{{The asperity developers}}}},\n{version}}}\n\n\
         @article{{gaus2016roughness,\n  title = {{Influence of surface roughness on friction induced vibrations}},\n  \
         author = {{Gaus, N. and Proppe, C. and Zaccardi, C.}},\n  \
         journal = {{Meccanica dei Materiali e delle Strutture}},\n  volume = {{VI}},\n  number = {{1}},\n  \
         pages = {{115--122}},\n  year = {{2016}}\n}}\n"
    )
}

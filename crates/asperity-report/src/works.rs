//! Papers behind the methods of a run, as text and for BibTeX.

use std::fmt::Write as _;

use asperity_results::Results;

use crate::Input;

/// Machines below which an event is rare.
const FEW: f64 = 40.0;

/// A cited work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Work {
    /// Key in BibTeX.
    pub key: &'static str,
    kind: &'static str,
    /// As `Family, G. and Family, G.`.
    authors: &'static str,
    title: &'static str,
    /// Names and values of the other fields, in the order of the text.
    fields: &'static [(&'static str, &'static str)],
}

impl Work {
    fn field(&self, name: &str) -> Option<&'static str> {
        self.fields.iter().find(|(own, _)| *own == name).map(|(_, value)| *value)
    }

    /// Returns the work in a sentence.
    pub fn text(&self) -> String {
        let given_first = |author: &str| match author.split_once(", ") {
            Some((family, given)) => format!("{given} {family}"),
            None => author.trim_matches(['{', '}']).to_owned(),
        };
        let authors: Vec<String> = self.authors.split(" and ").map(given_first).collect();
        let mut text = format!("{}: {}.", authors.join(", "), self.title);
        if let Some(journal) = self.field("journal") {
            let issue = self.field("number").map_or_else(String::new, |number| format!(" {number},"));
            let [volume, year, pages] =
                ["volume", "year", "pages"].map(|name| self.field(name).unwrap_or_default().replace("--", "–"));
            let _ = write!(text, " {journal} {volume} ({year}){issue} {pages}.");
        } else {
            let publisher = self.field("publisher").or(self.field("institution")).unwrap_or_default();
            let _ = write!(text, " {publisher}, {}.", self.field("year").unwrap_or_default());
        }
        if let Some(doi) = self.field("doi") {
            let _ = write!(text, " doi:{doi}");
        }
        text
    }

    /// Returns the work as an entry of BibTeX.
    pub fn bibtex(&self) -> String {
        let mut entry =
            format!("@{}{{{},\n  author = {{{}}},\n  title = {{{}}},\n", self.kind, self.key, self.authors, self.title);
        for (name, value) in self.fields {
            let _ = writeln!(entry, "  {name} = {{{value}}},");
        }
        entry + "}\n"
    }
}

/// Returns the entry of the program for BibTeX.
pub fn program_bibtex(version: &str) -> String {
    let version = if version.is_empty() { String::new() } else { format!("  version = {{{version}}},\n") };
    format!(
        "@software{{asperity,\n  author = {{{{The asperity developers}}}},\n  title = {{asperity: from measured rough surfaces to \
         contact pressure, friction and stick-slip}},\n{version}}}\n"
    )
}

/// Returns the works whose methods a run with these results and inputs used, the paper first.
pub fn works(results: &Results, inputs: &[Input]) -> Vec<&'static Work> {
    let stated = |section: &str, key: &str, value: &str| {
        inputs
            .iter()
            .any(|own| own.section == section && own.key == key && own.value.split(", ").any(|own| own == value))
    };
    let present = |section: &str, key: &str| inputs.iter().any(|own| own.section == section && own.key == key);
    let (pressure, friction) = (results.pressure.is_some(), results.friction.is_some());
    let contact = pressure || friction;
    let boundary = |kind: &str| {
        pressure && stated("pressure", "boundary", kind) || friction && stated("friction", "boundary", kind)
    };
    let generator = |kind: &str| results.surface.is_some() && stated("surface", "generator", kind);
    let normal = stated("surface", "marginal", "normal") || !present("surface", "marginal");
    let chaos = ["polynomial_chaos", "polynomial_chaos_log", "polynomial_chaos_local"];
    let verdict = results.verdict.is_some();
    // An event of fewer machines is estimated by subset simulation.
    let rare = results
        .verdict
        .as_ref()
        .is_some_and(|own| own.probability.min(1.0 - own.probability) * (own.evaluations as f64) < FEW);
    let used: [(bool, &'static Work); 20] = [
        (true, &PAPER),
        (results.surface.is_some(), &ISO),
        (generator("karhunen_loeve"), &GHANEM),
        (generator("spectral") || friction, &DIETRICH),
        (generator("weierstrass_mandelbrot"), &AUSLOOS),
        (results.surface.is_some() && !normal, &GRIGORIU),
        (boundary("free"), &LOVE),
        (boundary("periodic"), &STANLEY),
        (contact, &POLONSKY),
        (contact, &YASTREBOV),
        (pressure && chaos.iter().any(|method| stated("pressure", "methods", method)), &XIU),
        (pressure && stated("pressure", "methods", "latin_hypercube"), &MCKAY),
        (pressure, &GILES),
        (friction && !stated("friction", "law", "coulomb"), &BOWDEN),
        (stated("vibration", "upscaling", "area"), &VANMARCKE),
        (results.mode_coupling.is_some(), &HOFFMANN),
        (verdict, &OWEN),
        (verdict, &SUDRET),
        (rare, &AU),
        (verdict && results.verdict.as_ref().is_some_and(|own| own.friction_fluctuates), &HORVITZ),
    ];
    used.into_iter().filter(|(used, _)| *used).map(|(_, work)| work).collect()
}

const PAPER: Work = Work {
    key: "gaus2016roughness",
    kind: "article",
    authors: "Gaus, N. and Proppe, C. and Zaccardi, C.",
    title: "Influence of surface roughness on friction induced vibrations",
    fields: &[
        ("journal", "Meccanica dei Materiali e delle Strutture"),
        ("volume", "VI"),
        ("number", "1"),
        ("pages", "115--122"),
        ("year", "2016"),
    ],
};
const ISO: Work = Work {
    key: "iso25178-2",
    kind: "techreport",
    authors: "{ISO 25178-2:2021}",
    title: "Geometrical product specifications (GPS), Surface texture: Areal, Part 2: Terms, definitions and surface texture \
            parameters",
    fields: &[("institution", "International Organization for Standardization"), ("year", "2021")],
};
const GHANEM: Work = Work {
    key: "ghanem1991stochastic",
    kind: "book",
    authors: "Ghanem, R. G. and Spanos, P. D.",
    title: "Stochastic Finite Elements: A Spectral Approach",
    fields: &[("publisher", "Springer"), ("year", "1991"), ("doi", "10.1007/978-1-4612-3094-6")],
};
const DIETRICH: Work = Work {
    key: "dietrich1997fast",
    kind: "article",
    authors: "Dietrich, C. R. and Newsam, G. N.",
    title: "Fast and exact simulation of stationary Gaussian processes through circulant embedding of the covariance matrix",
    fields: &[
        ("journal", "SIAM Journal on Scientific Computing"),
        ("volume", "18"),
        ("pages", "1088--1107"),
        ("year", "1997"),
        ("doi", "10.1137/S1064827592240555"),
    ],
};
const AUSLOOS: Work = Work {
    key: "ausloos1985multivariate",
    kind: "article",
    authors: "Ausloos, M. and Berman, D. H.",
    title: "A multivariate Weierstrass–Mandelbrot function",
    fields: &[
        ("journal", "Proceedings of the Royal Society A"),
        ("volume", "400"),
        ("pages", "331--350"),
        ("year", "1985"),
        ("doi", "10.1098/rspa.1985.0083"),
    ],
};
const GRIGORIU: Work = Work {
    key: "grigoriu1984crossings",
    kind: "article",
    authors: "Grigoriu, M.",
    title: "Crossings of non-Gaussian translation processes",
    fields: &[
        ("journal", "Journal of Engineering Mechanics"),
        ("volume", "110"),
        ("pages", "610--620"),
        ("year", "1984"),
        ("doi", "10.1061/(ASCE)0733-9399(1984)110:4(610)"),
    ],
};
const LOVE: Work = Work {
    key: "love1929stress",
    kind: "article",
    authors: "Love, A. E. H.",
    title: "The stress produced in a semi-infinite solid by pressure on part of the boundary",
    fields: &[
        ("journal", "Philosophical Transactions of the Royal Society A"),
        ("volume", "228"),
        ("pages", "377--420"),
        ("year", "1929"),
        ("doi", "10.1098/rsta.1929.0009"),
    ],
};
const STANLEY: Work = Work {
    key: "stanley1997fft",
    kind: "article",
    authors: "Stanley, H. M. and Kato, T.",
    title: "An FFT-based method for rough surface contact",
    fields: &[
        ("journal", "Journal of Tribology"),
        ("volume", "119"),
        ("pages", "481--485"),
        ("year", "1997"),
        ("doi", "10.1115/1.2833523"),
    ],
};
const POLONSKY: Work = Work {
    key: "polonsky1999numerical",
    kind: "article",
    authors: "Polonsky, I. A. and Keer, L. M.",
    title: "A numerical method for solving rough contact problems based on the multi-level multi-summation and conjugate \
            gradient techniques",
    fields: &[
        ("journal", "Wear"),
        ("volume", "231"),
        ("pages", "206--219"),
        ("year", "1999"),
        ("doi", "10.1016/S0043-1648(99)00113-1"),
    ],
};
const YASTREBOV: Work = Work {
    key: "yastrebov2017accurate",
    kind: "article",
    authors: "Yastrebov, V. A. and Anciaux, G. and Molinari, J.-F.",
    title: "On the accurate computation of the true contact-area in mechanical contact of random rough surfaces",
    fields: &[
        ("journal", "Tribology International"),
        ("volume", "114"),
        ("pages", "161--171"),
        ("year", "2017"),
        ("doi", "10.1016/j.triboint.2017.04.023"),
    ],
};
const XIU: Work = Work {
    key: "xiu2002wiener",
    kind: "article",
    authors: "Xiu, D. and Karniadakis, G. E.",
    title: "The Wiener–Askey polynomial chaos for stochastic differential equations",
    fields: &[
        ("journal", "SIAM Journal on Scientific Computing"),
        ("volume", "24"),
        ("pages", "619--644"),
        ("year", "2002"),
        ("doi", "10.1137/S1064827501387826"),
    ],
};
const MCKAY: Work = Work {
    key: "mckay1979comparison",
    kind: "article",
    authors: "McKay, M. D. and Beckman, R. J. and Conover, W. J.",
    title: "A comparison of three methods for selecting values of input variables in the analysis of output from a computer code",
    fields: &[
        ("journal", "Technometrics"),
        ("volume", "21"),
        ("pages", "239--245"),
        ("year", "1979"),
        ("doi", "10.1080/00401706.1979.10489755"),
    ],
};
const GILES: Work = Work {
    key: "giles2015multilevel",
    kind: "article",
    authors: "Giles, M. B.",
    title: "Multilevel Monte Carlo methods",
    fields: &[
        ("journal", "Acta Numerica"),
        ("volume", "24"),
        ("pages", "259--328"),
        ("year", "2015"),
        ("doi", "10.1017/S096249291500001X"),
    ],
};
const BOWDEN: Work = Work {
    key: "bowden1950friction",
    kind: "book",
    authors: "Bowden, F. P. and Tabor, D.",
    title: "The Friction and Lubrication of Solids",
    fields: &[("publisher", "Clarendon Press, Oxford"), ("year", "1950")],
};
const VANMARCKE: Work = Work {
    key: "vanmarcke1983random",
    kind: "book",
    authors: "Vanmarcke, E.",
    title: "Random Fields: Analysis and Synthesis",
    fields: &[("publisher", "MIT Press"), ("year", "1983")],
};
const HOFFMANN: Work = Work {
    key: "hoffmann2002minimal",
    kind: "article",
    authors: "Hoffmann, N. and Fischer, M. and Allgaier, R. and Gaul, L.",
    title: "A minimal model for studying properties of the mode-coupling type instability in friction induced oscillations",
    fields: &[
        ("journal", "Mechanics Research Communications"),
        ("volume", "29"),
        ("pages", "197--205"),
        ("year", "2002"),
        ("doi", "10.1016/S0093-6413(02)00254-9"),
    ],
};
const OWEN: Work = Work {
    key: "owen1998scrambling",
    kind: "article",
    authors: "Owen, A. B.",
    title: "Scrambling Sobol' and Niederreiter–Xing points",
    fields: &[
        ("journal", "Journal of Complexity"),
        ("volume", "14"),
        ("pages", "466--489"),
        ("year", "1998"),
        ("doi", "10.1006/jcom.1998.0487"),
    ],
};
const SUDRET: Work = Work {
    key: "sudret2008global",
    kind: "article",
    authors: "Sudret, B.",
    title: "Global sensitivity analysis using polynomial chaos expansions",
    fields: &[
        ("journal", "Reliability Engineering and System Safety"),
        ("volume", "93"),
        ("pages", "964--979"),
        ("year", "2008"),
        ("doi", "10.1016/j.ress.2007.04.002"),
    ],
};
const AU: Work = Work {
    key: "au2001estimation",
    kind: "article",
    authors: "Au, S.-K. and Beck, J. L.",
    title: "Estimation of small failure probabilities in high dimensions by subset simulation",
    fields: &[
        ("journal", "Probabilistic Engineering Mechanics"),
        ("volume", "16"),
        ("pages", "263--277"),
        ("year", "2001"),
        ("doi", "10.1016/S0266-8920(01)00019-4"),
    ],
};
const HORVITZ: Work = Work {
    key: "horvitz1952generalization",
    kind: "article",
    authors: "Horvitz, D. G. and Thompson, D. J.",
    title: "A generalization of sampling without replacement from a finite universe",
    fields: &[
        ("journal", "Journal of the American Statistical Association"),
        ("volume", "47"),
        ("pages", "663--685"),
        ("year", "1952"),
        ("doi", "10.1080/01621459.1952.10483446"),
    ],
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn works_are_sentences_and_entries() {
        assert_eq!(
            LOVE.text(),
            "A. E. H. Love: The stress produced in a semi-infinite solid by pressure on part of the boundary. Philosophical \
             Transactions of the Royal Society A 228 (1929) 377–420. doi:10.1098/rsta.1929.0009"
        );
        assert_eq!(
            PAPER.text(),
            "N. Gaus, C. Proppe, C. Zaccardi: Influence of surface roughness on friction induced vibrations. Meccanica dei Materiali \
             e delle Strutture VI (2016) 1, 115–122."
        );
        assert_eq!(
            BOWDEN.text(),
            "F. P. Bowden, D. Tabor: The Friction and Lubrication of Solids. Clarendon Press, Oxford, 1950."
        );
        assert!(ISO.text().starts_with("ISO 25178-2:2021: Geometrical"), "{}", ISO.text());
        assert_eq!(
            VANMARCKE.bibtex(),
            "@book{vanmarcke1983random,\n  author = {Vanmarcke, E.},\n  title = {Random Fields: Analysis and Synthesis},\n  \
             publisher = {MIT Press},\n  year = {1983},\n}\n"
        );
    }
}

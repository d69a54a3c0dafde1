//! Inputs of the verdict with their origin: measured, stated, uncertain, unknown, or a default.

use std::path::PathBuf;

use asperity_results::keys::{DefaultValue, KEYS, Key, KeyDefault, Link};
use toml::{Table, Value};

use crate::friction::WindowFriction;
use crate::study::check::VerdictStudy;
use crate::study::result::{InputKind, InputValue, Pair, RestsOn, Results};
use crate::study::uncertain::{Place, Point, needs};
use crate::study::{QUICKSTART, Study, StudyFile};

/// Returns the inputs that a study file may leave out.
fn defaults() -> impl Iterator<Item = (&'static Key, KeyDefault)> {
    KEYS.iter().filter_map(|key| Some((key, key.default?)))
}

/// Returns a default as a study file states it.
fn in_file(value: DefaultValue) -> Value {
    match value {
        DefaultValue::Number(number) => Value::Float(number),
        DefaultValue::Pair(pair) => Value::Array(pair.map(Value::Float).into()),
        DefaultValue::Word(word) => word.into(),
    }
}

/// Returns the range of a number that the study does not state; `None` for any other input.
pub(super) fn assumed_range(input: &RestsOn) -> Option<Pair> {
    let (_, default) = defaults().find(|(key, _)| key.path() == input.input)?;
    default.range.filter(|_| input.kind == InputKind::Default)
}

/// Returns the number of ends of ranges, other than the default itself, of the values that a study file leaves out.
pub(super) fn assumed_ends(unstated: &[String]) -> usize {
    let of = |(_, default): (&Key, KeyDefault)| {
        let ends = default.range.into_iter().flatten();
        ends.filter(|end| default.value != DefaultValue::Number(*end)).count()
    };
    defaults().filter(|(key, _)| unstated.contains(&key.path())).map(of).sum()
}

impl StudyFile {
    /// Records which inputs of the verdict are defaults: those that the file `written` leaves out, and those that it lists as
    /// `defaults` and that still have the default value.
    pub(in crate::study) fn with_defaults_of(mut self, written: &Table) -> Result<Self, String> {
        let known: Vec<String> = defaults().map(|(key, _)| key.path()).collect();
        if let Some(other) = self.unstated.iter().find(|listed| !known.contains(listed)) {
            let known = known.join(", ");
            return Err(format!("unstated: `{other}` has no default that is listed here (known: {known})"));
        }
        let is_default = |(key, default): &(&Key, KeyDefault)| {
            let Some(section) = written.get(key.section) else { return false };
            match section.get(key.name) {
                None => needs(key).is_none_or(|(name, words)| {
                    let usual = Key::find(&format!("{}.{name}", key.section)).and_then(|key| key.default);
                    let own = match (section.get(name).and_then(Value::as_str), usual.map(|usual| usual.value)) {
                        (None, Some(DefaultValue::Word(usual))) => usual,
                        (stated, _) => stated.unwrap_or_default(),
                    };
                    words.contains(&own)
                }),
                Some(stated) => *stated == in_file(default.value) && self.unstated.contains(&key.path()),
            }
        };
        self.unstated = defaults().filter(is_default).map(|(key, _)| key.path()).collect();
        Ok(self)
    }
}

/// Returns the inputs of the verdict. `window` is the friction of the machine with all values at their centres.
pub(super) fn rests_on(whole: &Study, study: &VerdictStudy, window: &WindowFriction, fluctuates: bool) -> Vec<RestsOn> {
    let file = whole.file();
    let mut inputs = Vec::new();
    if window.computed {
        let own = file.surface.as_ref().map_or(0, |surface| surface.files().len());
        let other = file.counterface.as_ref().map_or(0, |counterface| counterface.files().len());
        for (name, count) in [("surface.file", own), ("counterface.file", other)] {
            if count > 0 {
                inputs.push(entry(name, InputValue::Number(count as f64), "", InputKind::Measured));
            }
        }
    } else if let Some(process) = file.vibration.as_ref().and_then(|vibration| vibration.friction_process.as_ref()) {
        let name = process.file_name().unwrap_or_default().to_string_lossy().into_owned();
        inputs.push(entry("vibration.friction_process", InputValue::Name(name), "", InputKind::Stated));
    }
    let sheared = file.friction.as_ref().is_some_and(|friction| friction.law.is_sheared());
    let coupled = whole.vibration.as_ref().is_some_and(|vibration| vibration.machine.coupled.is_some());
    let matters = |key: &&Key| match (key.section, key.name, key.link) {
        (_, _, Link::Model) => false,
        (_, _, Link::Fall) if coupled => false,
        // It equals that of the machine.
        ("friction", "nominal_area", _) => false,
        ("vibration", "upscaling", _) => fluctuates,
        ("vibration", "nominal_area", _) => fluctuates || window.computed,
        ("vibration", ..) => true,
        ("material", "shear_strength", _) => window.computed && sheared,
        _ => window.computed,
    };
    let stated = Table::try_from(file).unwrap_or_default();
    for key in KEYS.iter().filter(matters) {
        let name = key.path();
        // A number that may have a unit has two rows.
        if inputs.iter().any(|input| is_of(&input.input, &name)) {
            continue;
        }
        let before = inputs.len();
        inputs.extend(uncertain(study, &name));
        if inputs.len() > before {
            continue;
        }
        let kind = if file.unstated.contains(&name) { InputKind::Default } else { InputKind::Stated };
        match stated.get(key.section).and_then(|section| section.get(key.name)) {
            Some(Value::Array(list)) => {
                let isotropic = list.windows(2).all(|pair| pair[0] == pair[1]);
                let count = if isotropic { 1 } else { list.len() };
                inputs.extend((0..count).filter_map(|place| number(&format!("{name}[{place}]"), &study.central, kind)));
            }
            Some(value) => {
                let word = value.as_str().map(|text| entry(&name, InputValue::Name(text.into()), "", kind));
                inputs.extend(number(&name, &study.central, kind).or(word));
            }
            None => inputs.extend(left_out(&name, whole)),
        }
    }
    if let Some(replaced) = replaced_stribeck(whole, window) {
        inputs.retain(|input| input.input != replaced.input);
        inputs.push(replaced);
    }
    mark_examples(file, &mut inputs);
    inputs
}

impl Study {
    /// Returns the inputs of the motion of the machine; `window` is its friction. Empty without a machine.
    pub(in crate::study) fn rests_on(&self, results: &Results, window: Option<&WindowFriction>) -> Vec<RestsOn> {
        match (&results.verdict, &self.verdict, window) {
            (Some(verdict), ..) => verdict.rests_on.clone(),
            (None, Some(study), Some(window)) => rests_on(self, study, window, false),
            _ => Vec::new(),
        }
    }
}

/// Marks the values of a study of an own scan that are still those of the template.
fn mark_examples(file: &StudyFile, inputs: &mut [RestsOn]) {
    let example = StudyFile::parse(QUICKSTART, "").ok().and_then(|example| Some((example.to_table().ok()?, example)));
    let (Ok(own), Some((template, example))) = (file.to_table(), example) else { return };
    let scans = |file: &StudyFile| -> Vec<PathBuf> {
        let files = file.surface.iter().flat_map(|surface| surface.files().iter());
        files.map(|file| file.file_name().map_or_else(PathBuf::new, PathBuf::from)).collect()
    };
    if scans(file).is_empty() || scans(file) == scans(&example) {
        return;
    }
    let is_of_template = |input: &RestsOn| {
        let name = input.input.split('[').next().unwrap_or_default().split_once('.');
        let value = |table: &Table| Some(table.get(name?.0)?.get(name?.1)?.clone());
        value(&own).is_some_and(|value_of_own| Some(value_of_own) == value(&template))
    };
    let is_own = |kind: InputKind| matches!(kind, InputKind::Stated | InputKind::Uncertain | InputKind::Unknown);
    let (equal, others): (Vec<_>, Vec<_>) =
        inputs.iter_mut().filter(|input| is_own(input.kind)).partition(|input| is_of_template(input));
    // A few equal values are a coincidence.
    if equal.len() >= others.len() {
        equal.into_iter().for_each(|input| input.kind = InputKind::Example);
    }
}

fn entry(name: &str, value: InputValue, unit: &str, kind: InputKind) -> RestsOn {
    RestsOn { input: name.into(), value, unit: unit.into(), kind, range: None }
}

/// Returns whether an input is that of a key or an element of its list.
pub(in crate::study) fn is_of(input: &str, key: &str) -> bool {
    input.strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
}

/// Returns the uncertain values of a key: one, or one for each element of a list.
fn uncertain<'a>(study: &'a VerdictStudy, name: &'a str) -> impl Iterator<Item = RestsOn> + 'a {
    study.inputs.inputs().iter().zip(&study.places).filter(move |(input, _)| is_of(input.name(), name)).map(
        |(input, place)| {
            let kind = if input.is_unknown() { InputKind::Unknown } else { InputKind::Uncertain };
            let range = Some([0.05, 0.95].map(|probability| input.quantile(probability)));
            RestsOn { range, ..entry(input.name(), InputValue::Number(input.central()), place.key().unit, kind) }
        },
    )
}

/// Returns a number or quantity at the central values.
fn number(name: &str, central: &Point, kind: InputKind) -> Option<RestsOn> {
    let place = Place::named(name, central)?;
    Some(entry(name, InputValue::Number(place.value_in(central)?), place.key().unit, kind))
}

/// Returns the default that a study file does not show even with its defaults filled in.
fn left_out(name: &str, whole: &Study) -> Option<RestsOn> {
    let counterface = whole.file().counterface.as_ref();
    let value = match name {
        "material.hardness" if counterface.is_none_or(|counterface| counterface.hardness.is_none()) => {
            InputValue::Name("elastic".into())
        }
        "counterface.poisson_ratio" => {
            counterface?.youngs_modulus?;
            InputValue::Number(0.3)
        }
        _ => return None,
    };
    Some(entry(name, value, "", InputKind::Default))
}

/// Returns the Stribeck coefficient of a friction process, if it replaces the one of the study.
fn replaced_stribeck(whole: &Study, window: &WindowFriction) -> Option<RestsOn> {
    let stated = whole.vibration.as_ref()?.machine.dimensionless_stribeck()?;
    let own = window.stribeck.filter(|own| *own != stated)?;
    Some(entry("vibration.stribeck", InputValue::Number(own), "", InputKind::Stated))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::distribution::Marginal;
    use crate::friction::StatedFriction;

    /// Study of computed friction.
    pub(in crate::study::verdict) const STUDY: &str = "seed = 1\n[surface]\nrms_height = \"1 um\"\ncorrelation_length = \"20 um\"\ncovariance = \"exponential\"\n\
                         marginal = \"normal\"\n[material]\nyoungs_modulus = \"210 GPa\"\nshear_strength = \"385 MPa\"\n\
                         [friction]\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\ndamping_ratio = 0.17\n\
                         normal_force = \"2.5 kN\"\nnominal_area = \"833 mm^2\"\nbelt_velocity = \"0.1 m/s\"\n";

    /// Returns the friction .3 of a window, as if it was computed.
    pub(in crate::study::verdict) fn computed_window(stribeck: Option<f64>) -> WindowFriction {
        let marginal = Marginal::STANDARD_NORMAL;
        let stated = StatedFriction { mean: 0.3, std: 0.0, length_m: 1e-3, marginal, window_m: [6e-4, 7.5e-5] };
        WindowFriction { computed: true, ..WindowFriction::from_statement(stated, 833e-6, stribeck) }
    }

    fn resolved(text: &str) -> String {
        toml::to_string(&Study::parse(text, "study.toml").unwrap().file().to_table().unwrap()).unwrap()
    }

    #[test]
    fn a_key_that_is_left_out_has_the_listed_default() {
        let coupled = STUDY.replace("[vibration]", "[vibration]\nmodel = \"mode_coupling\"");
        let studies = [STUDY, &coupled].map(|text| Study::parse(text, "study.toml").unwrap());
        for (key, default) in defaults() {
            let is_spring = key.needs == Some(("model", "mode_coupling"));
            let file = studies[usize::from(is_spring)].file();
            assert_eq!(file.to_table().unwrap()[key.section][key.name], in_file(default.value), "{key:?}");
            let [alone, coupled] = studies.each_ref().map(|study| study.file().unstated.contains(&key.path()));
            assert!(alone != is_spring && coupled, "{key:?}");
        }
    }

    #[test]
    fn defaults_are_recognised_in_the_study_of_a_run_folder() {
        let defaults = |text: &str| Study::parse(text, "study.toml").unwrap().file().unstated.clone();
        let stated = STUDY.replace("[vibration]", "[vibration]\nstribeck = 4.2");
        for text in [STUDY, &stated] {
            assert_eq!(defaults(&resolved(text)), defaults(text));
        }
        assert!(!defaults(&stated).contains(&"vibration.stribeck".to_owned()));
        // Only Stribeck's law has a Stribeck coefficient.
        for (law, has) in
            [("velocity_law = \"stribeck\"", true), ("velocity_law = \"linear\"\nlinear_weakening = 0.1", false)]
        {
            let of_law = defaults(&STUDY.replace("[vibration]", &format!("[vibration]\n{law}")));
            assert_eq!(of_law.contains(&"vibration.stribeck".to_owned()), has, "{law}");
        }
        // A changed value is stated, even if the list still names it.
        let changed = resolved(STUDY).replace("stribeck = 4.2", "stribeck = 5.0");
        let left: Vec<String> = defaults(STUDY).into_iter().filter(|name| name != "vibration.stribeck").collect();
        assert_eq!(defaults(&changed), left);
        let wrong = Study::parse(&format!("unstated = [\"vibration.mass\"]\n{STUDY}"), "study.toml").unwrap_err();
        assert!(wrong.line == 1 && wrong.message.contains("`vibration.mass`"), "{wrong}");
    }

    #[test]
    fn ends_of_ranges_that_are_the_default_do_not_count() {
        // Two ends of the Stribeck coefficient, and the low end of kinetic over static friction.
        for (stated, ends) in [("", 3), ("stribeck = 5\n", 1), ("kinetic_share = 0.95\n", 2)] {
            let text = STUDY.replace("[vibration]\n", &format!("[vibration]\n{stated}"));
            assert_eq!(assumed_ends(&Study::parse(&text, "study.toml").unwrap().file().unstated), ends, "{stated}");
        }
    }

    #[test]
    fn every_kind_of_origin_is_recognised() {
        let text = STUDY
            .replace("damping_ratio = 0.17", "damping_ratio = \"0.17 ± 0.02\"")
            .replace("\"385 MPa\"", "{ uniform = [\"300 MPa\", \"400 MPa\"], unknown = true }");
        let study = Study::parse(&text, "study.toml").unwrap();
        let verdict = study.verdict.as_ref().unwrap();
        let nominal = study.vibration.as_ref().unwrap();
        let window = computed_window(nominal.machine.dimensionless_stribeck());
        let of = |computed: bool, fluctuates: bool| {
            rests_on(&study, verdict, &WindowFriction { computed, ..window.clone() }, fluctuates)
        };
        let found = |computed: bool, name: &str| of(computed, false).into_iter().find(|input| input.input == name);
        for (name, value, unit, kind) in [
            ("surface.correlation_length[0]", 2e-5, "m", InputKind::Stated),
            ("material.poisson_ratio", 0.3, "", InputKind::Default),
            ("material.shear_strength", 3.5e8, "Pa", InputKind::Unknown),
            ("vibration.damping_ratio", 0.17, "", InputKind::Uncertain),
            ("vibration.normal_force", 2500.0, "N", InputKind::Stated),
            ("vibration.belt_velocity", 0.1, "m/s", InputKind::Stated),
            ("vibration.stribeck", 4.2, "", InputKind::Default),
        ] {
            let input = found(true, name).unwrap_or_else(|| panic!("{name}"));
            let InputValue::Number(number) = input.value else { panic!("{input:?}") };
            assert!((number / value - 1.0).abs() < 1e-9, "{input:?}");
            assert_eq!((input.unit.as_str(), input.kind), (unit, kind), "{name}");
        }
        assert_eq!(found(true, "material.hardness").unwrap().value, InputValue::Name("elastic".into()));
        assert_eq!(found(true, "friction.law").unwrap().kind, InputKind::Default);
        // The contact does not matter to friction that is stated.
        assert!(of(false, false).iter().all(|input| input.input.starts_with("vibration.")));
        assert!(found(false, "vibration.nominal_area").is_none());
        // The area shares the fluctuation of friction, or carries the contact.
        for (computed, fluctuates, area, upscaling) in
            [(false, true, true, true), (true, false, true, false), (true, true, true, true)]
        {
            let all = of(computed, fluctuates);
            let has = |name: &str| all.iter().any(|input| input.input == name);
            assert_eq!((has("vibration.nominal_area"), has("vibration.upscaling")), (area, upscaling));
        }
        // A friction process has its own fall of friction.
        let own = WindowFriction { stribeck: Some(5.0), ..window.clone() };
        let replaced = rests_on(&study, verdict, &own, false);
        let stribeck: Vec<_> = replaced.iter().filter(|input| input.input == "vibration.stribeck").collect();
        assert_eq!((stribeck.len(), &stribeck[0].value), (1, &InputValue::Number(5.0)));
        assert_eq!(stribeck[0].kind, InputKind::Stated);
    }

    #[test]
    fn scans_and_each_length_of_an_anisotropic_surface_are_inputs() {
        let text = STUDY
            .replace("rms_height = \"1 um\"", "file = [\"a.x3p\", \"b.x3p\"]")
            .replace("correlation_length = \"20 um\"", "correlation_length = [\"20 um\", \"30 um\"]");
        for (text, wanted) in [(text.as_str(), (Some(2.0), 2)), (STUDY, (None, 1))] {
            let study = Study::parse(text, "study.toml").unwrap();
            let window = computed_window(None);
            let inputs = rests_on(&study, study.verdict.as_ref().unwrap(), &window, false);
            let files = inputs.iter().find(|input| input.input == "surface.file");
            let lengths = inputs.iter().filter(|input| input.input.starts_with("surface.correlation_length[")).count();
            let count = files.map(|files| {
                assert_eq!(files.kind, InputKind::Measured);
                let InputValue::Number(count) = files.value else { panic!("{files:?}") };
                count
            });
            assert_eq!((count, lengths), wanted);
            assert!(inputs.iter().all(|input| input.input != "counterface.file"), "{inputs:?}");
        }
    }

    #[test]
    fn a_counterface_has_its_own_poisson_ratio_and_hardness() {
        let origins = |counterface: &str| {
            let study = Study::parse(&STUDY.replace("[friction]", counterface), "study.toml").unwrap();
            let found = |name: &str| left_out(name, &study).map(|input| (input.value, input.kind));
            ["material.hardness", "counterface.poisson_ratio"].map(found)
        };
        let elastic = || Some((InputValue::Name("elastic".into()), InputKind::Default));
        let usual = || Some((InputValue::Number(0.3), InputKind::Default));
        assert_eq!(origins("[friction]"), [elastic(), None]);
        assert_eq!(origins("[counterface]\nhardness = \"2 GPa\"\n[friction]"), [None, None]);
        assert_eq!(origins("[counterface]\nyoungs_modulus = \"100 GPa\"\n[friction]"), [elastic(), usual()]);
    }

    #[test]
    fn values_of_the_template_are_marked_in_a_study_of_another_scan() {
        let kinds = |text: &str| {
            let study = Study::parse(text, "study.toml").unwrap();
            let found = rests_on(&study, study.verdict.as_ref().unwrap(), &computed_window(None), false);
            let kind = move |name: &str| found.iter().find(|input| input.input == name).unwrap().kind;
            ["material.youngs_modulus", "material.hardness", "vibration.stribeck", "vibration.kinetic_share"].map(kind)
        };
        let own = QUICKSTART.replace("brake_disc.x3p", "disc.sur").replace("\"100 MPa\"", "\"120 MPa\"");
        assert_eq!(kinds(&own), [InputKind::Example, InputKind::Stated, InputKind::Example, InputKind::Default]);
        assert_eq!(kinds(QUICKSTART), [InputKind::Stated, InputKind::Stated, InputKind::Unknown, InputKind::Default]);
    }
}

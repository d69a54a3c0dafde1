//! The verdict in words and on the page.

use asperity_report::{Run, not_stated, render, verdict_sentence, verdict_text};
use asperity_results::{ErrorCause, InputKind, InputValue, MachineModel, Remedy, RestsOn, Table, VerdictResult};

use crate::documents::{elements, resources, text, without_scripts};
use crate::synthetic::{example, full_run};

/// Returns the page of a run with this verdict, with plain spaces.
fn rendered(verdict: VerdictResult) -> String {
    let mut run = Run { name: "brake".into(), results: example::results(), ..Run::default() };
    run.results.verdict = Some(verdict);
    render(&run).unwrap().html
}

/// Returns the page without the data of its images.
fn page(verdict: VerdictResult) -> String {
    text(&rendered(verdict))
}

/// Returns the text of a page without its elements.
fn plain(html: &str) -> String {
    html.split('<').filter_map(|piece| piece.split_once('>')).map(|(_, text)| text).collect()
}

/// Returns the points of the outline of an area of the margin.
fn outline(html: &str, class: &str) -> Vec<(f64, f64)> {
    let path = html.split(&format!("<path class=\"area {class}\" d=\"")).nth(1).unwrap().split('"').next().unwrap();
    let points = path.trim_end_matches('Z').split(['M', 'L']).filter(|point| !point.is_empty());
    points.map(|point| point.split_once(' ').map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).unwrap()).collect()
}

/// Returns the area inside an outline.
fn area(points: &[(f64, f64)]) -> f64 {
    let next = points.iter().cycle().skip(1);
    0.5 * points.iter().zip(next).map(|((x0, y0), (x1, y1))| x0 * y1 - x1 * y0).sum::<f64>().abs()
}

/// Returns the fraction of the areas that vibrates.
fn vibrating(html: &str) -> f64 {
    let [quiet, vibrates] = ["quiet", "vibrates"].map(|class| area(&outline(html, class)));
    vibrates / (quiet + vibrates)
}

/// Returns a verdict without unknown values.
fn known() -> VerdictResult {
    let verdict = example::verdict::verdict();
    VerdictResult { probability_range: None, probability_over_unknowns: None, guesses: Vec::new(), ..verdict }
}

/// Returns a verdict on machines whose friction fluctuates.
fn fluctuating() -> VerdictResult {
    VerdictResult {
        friction_fluctuates: true,
        probability: 0.82,
        probability_interval: [0.8, 0.84],
        expected_vibration_share: 0.29,
        expected_vibration_share_interval: [0.28, 0.3],
        probability_half: 0.108,
        probability_half_interval: [0.1, 0.12],
        probability_from_steady_sliding: None,
        probability_from_steady_sliding_interval: None,
        ..known()
    }
}

/// Returns a page with 1,000 sampled machines, whose margins are uniform between the ends.
fn sampled(probability: f64, low: f64, high: f64) -> String {
    let mut run = Run { results: example::results(), ..Run::default() };
    let half = 0.5 * 0.02;
    let interval = [probability - half, probability + half];
    let verdict = VerdictResult { probability, probability_interval: interval, ..known() };
    run.results.verdict = Some(verdict);
    let margins = (0..1000).map(|i| low + (high - low) * (f64::from(i) + 0.5) / 1000.0).collect();
    let columns = vec![("vibration.stribeck".to_owned(), vec![4.2; 1000]), ("damping_margin".to_owned(), margins)];
    run.tables.insert("verdict_samples".into(), Table::new(columns));
    text(&render(&run).unwrap().html)
}

#[test]
fn the_sentence_states_the_probability_with_its_interval() {
    let likely = known();
    assert_eq!(
        verdict_sentence(&likely),
        "Stick-slip at 312 Hz is likely: 64 % (61 % to 67 %) of machines like this one vibrate, once started from standstill; 12 % from \
         steady sliding."
    );
    let mut rare = likely.clone();
    (rare.probability, rare.probability_interval) = (2e-5, [1e-5, 4e-5]);
    let sentence = verdict_sentence(&rare);
    assert!(sentence.contains("fewer than 1 in 1,000") && sentence.contains("assumed tails"), "{sentence}");
    // Nothing was seen in 2,048 machines: that is not yet 1 in 1,000.
    (rare.probability, rare.probability_interval) = (0.0, [0.0, 0.0019]);
    let sentence = verdict_sentence(&rare);
    assert!(
        !sentence.contains("1 in 1,000") && sentence.contains("very unlikely: less than 0.19 % of machines"),
        "{sentence}"
    );
    let mut certain = likely.clone();
    (certain.probability, certain.probability_interval) = (0.9995, [0.994, 0.9999]);
    assert!(verdict_sentence(&certain).contains("more than 99.9 % (99.4 % to more than 99.9 %)"));
    (certain.probability, certain.probability_interval) = (0.99995, [0.9995, 0.99999]);
    assert!(
        verdict_sentence(&certain).starts_with("Stick-slip at 312 Hz is very likely: more than 99.9 % of machines")
    );
    let mut exact = likely;
    (exact.evaluations, exact.if_vibrating, exact.probability_interval) = (1, None, [1.0; 2]);
    let sentence = verdict_sentence(&exact);
    assert!(
        sentence.contains(
            "The machine vibrates (stick-slip), once started from standstill: its damping ratio of 0.0155 is 86 % of"
        ) && sentence.contains("13\u{a0}mm/s"),
        "{sentence}"
    );
    exact.nominal.vibrates = false;
    assert!(verdict_sentence(&exact).contains("does not vibrate"));
    // Friction whose error crosses the limit, and friction that is not resolved.
    exact.probability_interval = [0.0, 1.0];
    assert!(verdict_sentence(&exact).starts_with("The machine may vibrate: the error of its friction"));
    let coupled = VerdictResult { model: MachineModel::ModeCoupling, ..exact.clone() };
    assert!(verdict_sentence(&coupled).starts_with("The machine may squeal: the error of its friction"));
    let turning_points = example::verdict::turning_points();
    let text =
        verdict_text(&VerdictResult { turning_points, remedies: Vec::new(), drivers: Vec::new(), ..exact.clone() });
    assert!(
        text.contains("\nAt the printed friction coefficient nothing needs to change: the normal force may"),
        "{text}"
    );
    (exact.friction_unresolved, exact.unresolved_by) = (true, vec![ErrorCause::Grid]);
    let sentence = verdict_sentence(&exact);
    assert!(
        sentence.starts_with("No verdict yet: the pitch of the strips does not resolve the friction"),
        "{sentence}"
    );
    exact.unresolved_by.push(ErrorCause::Model);
    assert!(verdict_sentence(&exact).contains(", and the random strips do not stand for the scan; the warnings"));
}

#[test]
fn the_range_over_unknown_values_leads_where_it_is_wider_than_the_error_of_the_computation() {
    let mut verdict = example::verdict::verdict();
    assert_eq!(
        verdict_sentence(&verdict),
        "Stick-slip at 312 Hz is uncertain: 22 % to 91 % of machines like this one vibrate, once started from standstill, depending on the unknown \
         Stribeck coefficient; 64 % (61 % to 67 %) on average; 12 % from steady sliding."
    );
    verdict.probability_range = Some([0.57, 0.64]);
    assert!(verdict_sentence(&verdict).starts_with("Stick-slip at 312 Hz is likely: 57 % to 64 % of machines"));
    verdict.probability_range = Some([0.63, 0.65]);
    assert!(verdict_sentence(&verdict).starts_with("Stick-slip at 312 Hz is likely: 64 % (61 % to 67 %) of machines"));
    assert!(verdict_text(&verdict).contains("Over the unknown Stribeck coefficient the probability lies between 63 %"));
}

#[test]
fn under_fluctuating_friction_the_fraction_of_the_time_leads() {
    let mut verdict = fluctuating();
    verdict.vibration_threshold = 0.1;
    assert_eq!(
        verdict_sentence(&verdict),
        "Stick-slip is likely: 29 % (28 % to 30 %) of the time on average; 82 % (80 % to 84 %) of machines like this one vibrate more than \
         a tenth of the time, once started from standstill. This holds if the Stribeck coefficient is 4.2, which the study does not state."
    );
    let text = verdict_text(&verdict);
    for wanted in [
        "\n11 % of the machines vibrate at least half of the time.\n",
        "0.0260: vibration for more than a tenth of the time is then 5 % probable.",
        "Sensitivity of the event: vibration for more than a tenth of the time",
    ] {
        assert!(text.contains(wanted), "`{wanted}` is missing in\n{text}");
    }
    assert!(!text.contains("steady sliding"), "{text}");
    verdict.vibration_threshold = 0.3;
    assert!(verdict_sentence(&verdict).contains("vibrate more than 30 % of the time"));
    let words = plain(&page(verdict.clone()));
    assert!(words.contains("Stick-slip is likely: 29 % of the time on average; 82 % of machines"), "{words}");
    assert!(words.contains("fraction of the time in vibration"));
    (verdict.evaluations, verdict.expected_vibration_share_interval) = (1, [0.27, 0.31]);
    assert_eq!(
        verdict_sentence(&verdict),
        "The machine vibrates 29 % of the time (27 % to 31 %), once started from standstill. No value is uncertain. This holds if the \
         Stribeck coefficient is 4.2, which the study does not state."
    );
}

#[test]
fn a_number_that_is_not_stated_stands_with_both_ends_of_its_range_below_the_verdict() {
    let mut verdict = known();
    // All 256 machines vibrate at the high end.
    assert_eq!(
        not_stated(&verdict),
        ["Stribeck coefficient (stribeck), assumed 4.2: 21 % at 2.1, more than 99.4 % at 8.4"]
    );
    let lines = verdict_text(&verdict);
    let mut lines = lines.lines();
    assert_eq!(lines.next(), Some(verdict_sentence(&verdict).as_str()));
    assert_eq!(
        lines.next(),
        Some("Not stated: Stribeck coefficient (stribeck), assumed 4.2: 21 % at 2.1, more than 99.4 % at 8.4.")
    );
    let words = plain(&page(verdict.clone()));
    assert!(
        words.contains(
            "Not stated: Stribeck coefficient (stribeck), assumed 4.2: 21 % at 2.1, more than 99.4 % at 8.4."
        ),
        "{words}"
    );
    let table = "Stribeck coefficient4.22.1: 21 % (20 % to 22 %)8.4: more than 99.4 % (99.4 % to 100 %)";
    assert!(words.replace('\n', "").contains(table), "{words}");
    let entry = &mut verdict.assumed[0];
    (entry.probability_at, entry.probability_interval_at) = ([0.0, 0.0], [[0.0, 0.013], [0.0, 1e-6]]);
    assert_eq!(
        not_stated(&verdict),
        ["Stribeck coefficient (stribeck), assumed 4.2: less than 1.3 % at 2.1, less than 0.1 % at 8.4"]
    );
    // The fraction of the time leads under fluctuating friction.
    verdict.friction_fluctuates = true;
    assert_eq!(
        not_stated(&verdict),
        ["Stribeck coefficient (stribeck), assumed 4.2: 8 % of the time at 2.1, 97 % of the time at 8.4"]
    );
    (verdict.friction_fluctuates, verdict.evaluations) = (false, 1);
    let entry = &mut verdict.assumed[0];
    (entry.probability_at, entry.probability_interval_at) = ([0.0, 1.0], [[0.0; 2], [1.0; 2]]);
    assert_eq!(
        not_stated(&verdict),
        ["Stribeck coefficient (stribeck), assumed 4.2: does not vibrate at 2.1, vibrates at 8.4"]
    );
    verdict.assumed[0].probability_interval_at[1] = [0.0, 1.0];
    assert_eq!(
        not_stated(&verdict),
        ["Stribeck coefficient (stribeck), assumed 4.2: does not vibrate at 2.1, may vibrate at 8.4"]
    );
    verdict.friction_unresolved = true;
    assert!(not_stated(&verdict).is_empty());
}

#[test]
fn a_remedy_names_the_damping_that_it_keeps_and_the_range_without_a_value() {
    let mut verdict = known();
    let remedy = &mut verdict.remedies[0];
    (remedy.input, remedy.unit, remedy.now) = ("vibration.mass".into(), "kg".into(), 5.0);
    (remedy.held, remedy.range) = (Some("damper".into()), [0.5, 60.0]);
    remedy.reach[0].value = Some(12.0);
    assert!(
        verdict_text(&verdict).contains("Raise the mass (same damper in N s/m) from 5"),
        "{}",
        verdict_text(&verdict)
    );
    verdict.remedies[0].held = Some("damping_ratio".into());
    verdict.remedies[0].reach[0].value = None;
    let text = verdict_text(&verdict);
    assert!(text.contains("No mass (same damping ratio) from 500 g to 60 kg reaches 5 %."), "{text}");
}

#[test]
fn only_unknown_values_are_measured_next() {
    let mut verdict = example::verdict::verdict();
    // The strength narrows the margin less, but the Stribeck coefficient varies from part to part.
    verdict.guesses[0].input = "material.shear_strength".into();
    assert!(
        verdict_text(&verdict).contains("Measure the shear strength next: the margin’s range would shrink by 12 %.")
    );
    verdict.guesses[0].input = "vibration.static_friction".into();
    assert!(verdict_text(&verdict).contains("No single measurement of an unknown value would narrow the margin."));
    let text = verdict_text(&known());
    assert!(text.contains("nothing to measure next. Parts with equal Stribeck coefficient would shrink"), "{text}");
}

#[test]
fn the_text_has_the_sentence_and_aligned_tables_of_everything_else() {
    let verdict = example::verdict::verdict();
    let text = verdict_text(&verdict);
    assert!(text.starts_with(&verdict_sentence(&verdict)), "{text}");
    for wanted in [
        "12 % from steady sliding.\nNot stated: Stribeck coefficient (stribeck), assumed 4.2: 21 % at 2.1, more than 99.4 % at 8.4.\nIf it vibrates: 312 Hz (298–325), with amplitudes",
        "\nRaise the damping ratio from 0.0155 to 0.0260: vibration is then 5 % probable.\n",
        "\nMeasure the Stribeck coefficient next",
        "\nQuantiles of the margin ζ − ζ_v\n  Quantile  Margin\n",
        "\nWhat would stop it\n  Change",
        "none from 0.001 to 0.1",
        "\nHow much of the area acts as one",
        "unknown",
    ] {
        assert!(text.contains(wanted), "`{wanted}` is missing in\n{text}");
    }
    assert!(!text.contains(['<', '{', '\u{a0}']), "{text}");
    // The columns of a table begin at the same place.
    let mut lines = text.lines().skip_while(|line| *line != "What would stop it").skip(1);
    let mut column = |words: &str| lines.next().and_then(|line| Some(line[..line.find(words)?].chars().count()));
    assert_eq!(column("Now").unwrap(), column("0.0155").unwrap());
    let mut met = verdict.clone();
    // The first target is met, the second is not.
    met.probability = 0.03;
    assert!(!verdict_text(&met).contains("Nothing needs to change"), "{}", verdict_text(&met));
    met.probability = 0.003;
    (met.probability_range, met.probability_interval) = (None, [0.001, 0.06]);
    let text = verdict_text(&met);
    assert!(
        text.contains("On average nothing needs to change: vibration is at most 1 % probable, but it may be 6 %."),
        "{text}"
    );
    met.probability_interval = [0.001, 0.005];
    assert!(verdict_text(&met).contains("Nothing needs to change: vibration is at most 1 % probable."));
    let mut rare = VerdictResult { probability_range: None, ..verdict };
    (rare.probability, rare.probability_interval) = (2e-5, [1e-5, 4e-5]);
    assert!(
        verdict_text(&rare).contains("\nThe probability is 2.0·10⁻⁵ (1.0·10⁻⁵ to 4.0·10⁻⁵).\n"),
        "{}",
        verdict_text(&rare)
    );
}

#[test]
fn the_first_screen_is_the_verdict_with_four_cards_and_the_chain() {
    let html = page(example::verdict::verdict());
    let place = |words: &str| html.find(words).unwrap_or_else(|| panic!("`{words}` is missing"));
    assert!(place("<nav class=\"bar\"") < place("<section id=\"answer\""));
    assert!(place("<nav class=\"chain\"") < place("<section id=\"surface\">"));
    assert!(place("<section id=\"details\">") < place("<div id=\"details-verdict\">"));
    assert!(!html.contains("<section id=\"answers\""), "the answers stand on the first screen alone");
    assert_eq!(html.matches("<section class=\"card\">").count(), 4);
    assert_eq!(html.matches("<li><span>").count(), 3, "three drivers");
    let words = plain(&html);
    for wanted in [
        "Stick-slip at 312 Hz is uncertain: 22 % to 91 % of machines like this one vibrate, once started from standstill, depending on the unknown \
         Stribeck coefficient; 64 % on average.",
        "Computed to ±3 percentage points (95 % interval). Largest of 2 errors of the probability: the number of machines, up to 2.6 percentage points; to \
         reduce it, lower half_width and, if needed, raise evaluations in [verdict]. Started from steady sliding: 12 %.",
        "If it vibrates: 312 Hz (298–325), with amplitudes of 46.0 mm/s (31.0–60.0) and 23.0 µm (16.0–31.0)",
        "Not stated: Stribeck coefficient (stribeck), assumed 4.2: 21 % at 2.1, more than 99.4 % at 8.4.",
        "Measure the Stribeck coefficient next: the margin’s range would shrink by 30 %.",
        "Raise the damping ratio from 0.0155 to 0.0260: vibration is then 5 % probable.",
        "none from 0.001 to 0.1",
        "surface: 3 scans",
        "stated: normal force",
        "unknown: shear strength 40.0 MPa (32.0–48.0)",
        "uncertain: damping ratio 0.0155 (0.0124–0.0186)",
        "not stated: Stribeck coefficient 4.2 (default, not measured)",
        "For squeal choose the model of two coupled modes.",
    ] {
        assert!(words.contains(wanted), "{wanted}");
    }
    let html = rendered(example::verdict::verdict());
    for resource in resources(&html) {
        let inside = resource.strip_prefix('#').map(|id| html.contains(&format!("id=\"{id}\"")));
        let found = inside.unwrap_or_else(|| resource.starts_with("data:image/png;base64,"));
        assert!(found, "{resource:.60} leads nowhere");
    }
}

#[test]
fn the_verdict_has_figures_of_its_map_and_of_the_windows_that_share_the_load() {
    let mut run = Run { name: "brake".into(), results: example::results(), ..Run::default() };
    run.results.verdict = Some(example::verdict::verdict());
    let caption = |run: &Run| text(&render(run).unwrap().html);
    let shown = caption(&run);
    for words in [
        "Probability of vibration over two inputs",
        "Friction has its mean value: the map leaves out its fluctuation",
        "The answer depends on how much of the area acts as one: vibration has the probability 30 % at n = 1 and 64 % at n =",
    ] {
        assert!(shown.contains(words), "`{words}` is missing");
    }
    let verdict = run.results.verdict.as_mut().unwrap();
    verdict.leaves_out_fluctuation = true;
    verdict.remedies.push(Remedy { input: "vibration.normal_force".into(), now: 8e3, ..Remedy::default() });
    let shown = caption(&run);
    for words in [
        "At the present values it is 64 %.",
        "along the path, as the verdict does",
        "The mean friction coefficient decides; its fluctuation",
    ] {
        assert!(shown.contains(words), "`{words}` is missing");
    }
    let verdict = run.results.verdict.as_mut().unwrap();
    verdict.area_as_one.as_mut().unwrap()[0].probability_interval = [0.1, 0.6];
    verdict.map.as_mut().unwrap().leaves_out_fluctuation = false;
    let shown = caption(&run);
    assert!(shown.contains("does not depend on how much of the area acts as one: the probability stays between 30 %"));
    assert!(!shown.contains("Friction has its mean value"));
    // The map with fluctuation has another probability than the verdict without it.
    assert!(!shown.contains("At the present values"), "{shown}");
    let verdict = run.results.verdict.as_mut().unwrap();
    (verdict.map, verdict.area_as_one) = (None, None);
    let shown = caption(&run);
    assert!(!shown.contains("Probability of vibration over two inputs") && !shown.contains("acts as one"));
}

#[test]
fn the_areas_of_the_margin_are_the_probabilities() {
    for (probability, low, high) in [(0.64, -0.0064, 0.0036), (0.25, -0.01, 0.03), (0.03, -0.0003, 0.0097)] {
        let html = sampled(probability, low, high);
        assert!((vibrating(&html) - probability).abs() < 0.002, "{} for {probability}", vibrating(&html));
        // The colours change at the damping ratio.
        let mark = html.split("<line class=\"mark\" x1=\"").nth(1).unwrap().split('"').next().unwrap();
        let first = outline(&html, "vibrates")[0].0;
        assert!((mark.parse::<f64>().unwrap() - first).abs() < 0.1, "{mark} and {first}");
        assert!(html.contains("A machine vibrates if its limit lies above its damping ratio."));
    }
    let html = sampled(0.64, -0.0064, 0.0036);
    assert!(html.contains(">quiet 36 %<") && html.contains(">vibrates 64 %<"));
    // Without samples the quantiles of the margin are drawn; here the damping ratio is uncertain.
    let html = page(example::verdict::verdict());
    assert!((vibrating(&html) - 0.64).abs() < 0.002, "{}", vibrating(&html));
    assert!(html.contains("shifted by how far its damping differs from the central one"));
    let svg = html.split("<svg class=\"margin\"").nth(1).unwrap().split("</svg>").next().unwrap();
    assert!(
        elements(&format!("<svg{svg}</svg>")) > 8
            && svg.contains("aria-label=\"Distribution of the damping ratio needed")
    );
}

#[test]
fn the_risk_falls_from_now_to_beyond_the_targets() {
    let html = page(example::verdict::verdict());
    let curve = html.split("<svg class=\"risk\"").nth(1).unwrap().split("</svg>").next().unwrap();
    assert!(curve.contains("aria-label=\"Probability of vibration against the damping ratio\""), "{curve}");
    let path = curve.split(" d=\"M").nth(1).unwrap().split('Z').next().unwrap();
    let points: Vec<[f64; 2]> = path
        .split('L')
        .map(|point| point.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap())
        .collect();
    // Between both feet the four values of the example: .64 at .0155 is highest, and the last one, .02 at .03, is 1/32 as high.
    let (foot, heights) = (points[0][1], points[1..5].iter().map(|[_, y]| points[0][1] - y).collect::<Vec<f64>>());
    assert!(points.len() == 6 && points[5][1] == foot && points.is_sorted_by(|a, b| a[0] <= b[0]), "{points:?}");
    for (height, probability) in heights.iter().zip([0.64, 0.3, 0.05, 0.02]) {
        assert!((height / heights[0] - probability / 0.64).abs() < 2e-3, "{heights:?}");
    }
    assert_eq!(curve.matches("<circle").count(), 1);
    let mut verdict = example::verdict::verdict();
    verdict.remedies[0].risk.clear();
    assert!(!page(verdict).contains("class=\"risk\""));
}

#[test]
fn unknown_values_that_decide_everything_leave_a_degree_of_belief() {
    let verdict = VerdictResult { probability_range: Some([0.0, 1.0]), ..example::verdict::verdict() };
    assert_eq!(
        verdict_sentence(&verdict).split(" on average").next().unwrap().split(';').next().unwrap(),
        "Stick-slip at 312 Hz is not known: 0 % to 100 % of machines like this one vibrate, once started from standstill, depending on the \
         unknown Stribeck coefficient"
    );
    assert!(verdict_sentence(&verdict).contains("; 64 % (61 % to 67 %) is your degree of belief; 12 %"));
}

#[test]
fn with_fluctuating_friction_the_sign_of_the_margin_does_not_decide() {
    // A third of the margins is negative, but half of the machines vibrate.
    let html = sampled(0.5, -0.01, 0.02);
    assert!((vibrating(&html) - 0.5).abs() < 0.002, "{}", vibrating(&html));
    assert!(html.contains("Friction fluctuates, so machines near the limit"));
    let verdict = VerdictResult { remedies: Vec::new(), ..example::verdict::verdict() };
    assert!(page(verdict).contains("The study asks for no changes."));
}

#[test]
fn exact_values_are_two_marks_on_an_axis() {
    let verdict = VerdictResult {
        evaluations: 1,
        probability: 1.0,
        probability_interval: [1.0; 2],
        drivers: Vec::new(),
        remedies: Vec::new(),
        assumed: Vec::new(),
        turning_points: example::verdict::turning_points(),
        ..example::verdict::verdict()
    };
    // The damping ratio of the example is not that of the user.
    let mut example = verdict.clone();
    example.rests_on.iter_mut().for_each(|input| input.kind = InputKind::Example);
    assert!(plain(&page(example)).contains("Damping ratio: example 0.0155, limit 0.018"));
    let html = page(verdict);
    let words = plain(&html);
    for wanted in [
        "The machine vibrates (stick-slip), once started from standstill: its damping ratio of 0.0155 is 86 % of the 0.018 that it needs.",
        "normal force90 N81 N−10 %\ndamping ratio0.01550.018+16 %",
        "for example damping_ratio = &quot;0.0155 ± 0.002&quot; in [vibration]",
        "Steady sliding stays quiet, unless a kick of 13 mm/s starts it.",
        "Damping ratio: yours 0.0155, limit 0.018",
        "A normal force below 81 N instead of 90 N, or a damping ratio above 0.018 instead of 0.0155.",
    ] {
        assert!(words.contains(wanted), "{wanted}");
    }
    let marks: Vec<f64> = html
        .split("<line class=\"mark")
        .skip(1)
        .map(|mark| mark.split("x1=\"").nth(1).unwrap())
        .map(|mark| mark.split('"').next().unwrap().parse().unwrap())
        .collect();
    assert!(marks.len() == 2 && marks[0] < marks[1], "{marks:?}");
}

#[test]
fn names_and_values_of_inputs_are_escaped() {
    const EVIL: &str = "vibration.\"><script>alert(1)</script>&'";
    let mut verdict = example::verdict::verdict();
    verdict.drivers[0].input = EVIL.into();
    verdict.remedies[0].input = EVIL.into();
    verdict.guesses[0].input = EVIL.into();
    verdict.assumed[0].input = EVIL.into();
    for kind in [
        InputKind::Measured,
        InputKind::Stated,
        InputKind::Uncertain,
        InputKind::Unknown,
        InputKind::Default,
        InputKind::Example,
    ] {
        let value = InputValue::Name(EVIL.into());
        verdict.rests_on.push(RestsOn { input: EVIL.into(), value, unit: EVIL.into(), kind, range: Some([0.0, 1.0]) });
    }
    let mut run = full_run();
    run.results.verdict = Some(verdict);
    let html = render(&run).unwrap().html;
    assert!(!without_scripts(&html).contains("<script"));
    assert!(html.matches("&lt;script&gt;").count() >= 10);
}

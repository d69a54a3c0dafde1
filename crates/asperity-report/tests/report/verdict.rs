//! The verdict in words and on the page.

use asperity_report::{Run, render, verdict_sentence};

use crate::documents::text;
use crate::synthetic::example;

#[test]
fn the_sentence_states_the_probability_with_its_interval() {
    let likely = example::verdict::verdict();
    assert_eq!(
        verdict_sentence(&likely),
        "Stick–slip is as likely as not: 64 % (61 % to 67 %) of machines like this one vibrate, once started from standstill; 12 % from \
         steady sliding."
    );
    let mut rare = likely.clone();
    (rare.probability, rare.probability_interval) = (2e-5, [1e-5, 4e-5]);
    let sentence = verdict_sentence(&rare);
    assert!(sentence.contains("fewer than 1 in 1,000") && sentence.contains("assumed tails"), "{sentence}");
    // Nothing was seen in 2,048 machines: that is not yet 1 in 1,000.
    (rare.probability, rare.probability_interval) = (0.0, [0.0, 0.0019]);
    let sentence = verdict_sentence(&rare);
    assert!(!sentence.contains("1 in 1,000") && sentence.contains("0 % (0 % to 0.19 %)"), "{sentence}");
    let mut certain = likely.clone();
    (certain.probability, certain.probability_interval) = (0.9995, [0.994, 0.9999]);
    assert!(verdict_sentence(&certain).contains("more than 99.9 % (99.4 % to more than 99.9 %)"));
    let mut exact = likely;
    (exact.evaluations, exact.if_vibrating) = (1, None);
    let sentence = verdict_sentence(&exact);
    assert!(sentence.contains("The machine vibrates (stick–slip)") && sentence.contains("13\u{a0}mm/s"), "{sentence}");
    exact.nominal.vibrates = false;
    assert!(verdict_sentence(&exact).contains("does not vibrate"));
}

#[test]
fn the_verdict_is_the_first_answer_and_the_first_section() {
    let mut run = Run { name: "brake".into(), results: example::results(), ..Run::default() };
    run.results.verdict = Some(example::verdict::verdict());
    let html = render(&run).unwrap().html;
    let shown = text(&html);
    let place = |words: &str| shown.find(words).unwrap_or_else(|| panic!("`{words}` is missing"));
    assert!(place("Does a machine like this one vibrate?") < place("How likely is contact at a point?"));
    assert!(html.find("<section id=\"verdict\">").unwrap() < html.find("<section id=\"surface\">").unwrap());
    for words in ["between 22 % and 91 %", "not in the range", "0.026", "shear strength", "312", "23 µm"] {
        place(words);
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
    verdict.area_as_one.as_mut().unwrap()[0].probability_interval = [0.1, 0.6];
    verdict.map.as_mut().unwrap().leaves_out_fluctuation = false;
    let shown = caption(&run);
    assert!(shown.contains("does not depend on how much of the area acts as one: the probability stays between 30 %"));
    assert!(!shown.contains("Friction has its mean value"));
    let verdict = run.results.verdict.as_mut().unwrap();
    (verdict.map, verdict.area_as_one) = (None, None);
    let shown = caption(&run);
    assert!(!shown.contains("Probability of vibration over two inputs") && !shown.contains("acts as one"));
}

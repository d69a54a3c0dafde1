//! The page of a campaign: where the verdict changes, a figure of the main answer over the values, and a table of the members.

mod answers;
mod figure;
mod table;
mod words;

use asperity_results::{CampaignResults, MemberWarning, Provenance};

use self::words::{SOURCE, members_in_words};
use crate::Report;
use crate::format::count;
use crate::markup::{Html, html};
use crate::page::Page;
use crate::page::answer::Answer;
use crate::page::section::Section;
use crate::page::verdict::{card, rests_on};

/// Script that sorts the table.
const SORT: &str = include_str!("page/sort.js");
/// Largest number of rows of the page.
const MOST_ROWS: usize = 5000;

/// The data of the page of a campaign.
#[derive(Debug, Clone, Default)]
pub struct CampaignRun {
    /// Name of the campaign.
    pub name: String,
    /// The content of `results.json`.
    pub results: CampaignResults,
    /// The content of `provenance.json`.
    pub provenance: Option<Provenance>,
}

/// Renders the page of a campaign. It is a pure function.
pub fn render_campaign(run: &CampaignRun) -> Report {
    let results = &run.results;
    let shown = results.members.len().min(MOST_ROWS);
    let rest = match results.members.len() - shown {
        0 => String::new(),
        more => format!(" {} more are in {SOURCE}.", count(more)),
    };
    let lead = format!("A click on the head of a column sorts the table.{rest}");
    let figures = figure::figure(results).into_iter().collect();
    let warning = |found: &MemberWarning| format!("{} ({})", found.warning, members_in_words(&found.members));
    let warnings: Vec<String> = results.member_warnings.iter().map(warning).collect();
    let answers = answers::answers(results);
    let (opening, cards) = first_screen(&answers, results);
    let sections = [
        Some(Section::of_html("comparison", "Comparison", "", figures, cards)),
        Some(Section::of_html("members", "Members", lead, Vec::new(), table::table(results, shown))),
        Section::sentences(
            "warnings",
            "Warnings of the members",
            "A warning of several members has the numbers of the first of them.",
            &warnings,
        ),
        Section::provenance(run.provenance.as_ref()),
    ];
    let page = Page {
        title: run.name.clone(),
        intro: "One study with many values, a member for each set of them: report of a campaign by asperity. The report of a single run of the \
                study shows what decides and what would stop vibration.",
        first_screen: Some(opening),
        answers: Vec::new(),
        warnings: results.warnings.clone(),
        sections: sections.into_iter().flatten().collect(),
        details: Vec::new(),
        script: SORT,
        machine: None,
    };
    page.render()
}

/// Returns the most important answer, and cards with the others and with the values in common.
fn first_screen(answers: &[Answer], results: &CampaignResults) -> (Html, Html) {
    let Some((first, others)) = answers.split_first() else { return Default::default() };
    let opening = html!(
        "<section id=\"answer\" aria-label=\"Verdict\">\n<p class=\"sub\">{}</p>\n<p class=\"headline\">{}</p>\n<p class=\"sub\">{}</p>\n</section>\n",
        first.question,
        &first.answer,
        &first.detail,
    );
    let of_answer = |Answer { question, answer, detail }: &Answer| {
        card(question, &html!("<p class=\"found\">{}</p>\n<p>{}</p>\n", answer, detail))
    };
    let rests_on = match results.rests_on.as_slice() {
        [] => Html::default(),
        inputs => {
            let ranges = rests_on::ranges(inputs);
            card(answers::RESTS_ON, &html!("{}<p class=\"note\">{}</p>\n", rests_on::chips(inputs), ranges))
        }
    };
    let cards = others.iter().map(of_answer).chain([rests_on]);
    (opening, html!("<div class=\"column\">\n{}</div>\n", cards.collect::<Html>()))
}

/// Returns the answers of the page of a campaign, each with its question in one line.
pub fn campaign_summary(results: &CampaignResults) -> Vec<String> {
    let lines = answers::answers(results).into_iter().chain(answers::inputs(results)).map(
        |Answer { question, answer, detail }| {
            format!("{question} {answer}{}", if answer.ends_with('.') { "" } else { "." }) + " " + &detail
        },
    );
    lines.map(|line| line.trim_end().replace('\u{a0}', " ")).collect()
}

#[cfg(test)]
mod tests {
    use asperity_results::{
        InputKind, InputValue, MemberAnswers, MemberRemedy, MemberResult, MotionKind, RestsOn, VariedKey,
    };

    use super::answers::answers;
    use super::figure::figure;
    use super::words::number;
    use super::*;

    /// Returns a campaign of two hardnesses and three damping ratios, the last of which has no answer.
    fn campaign() -> CampaignResults {
        let key = |key: &str, unit: &str| VariedKey { key: key.into(), unit: unit.into(), sampled: false };
        let member = |hardness_pa: f64, damping: f64| MemberResult {
            values: vec![InputValue::Number(damping), InputValue::Number(hardness_pa)],
            answers: MemberAnswers { probability: Some(0.9 - damping), ..MemberAnswers::default() },
            ..MemberResult::default()
        };
        let mut members: Vec<_> =
            [0.05, 0.1, 0.2].into_iter().flat_map(|d| [member(1e8, d), member(1.5e8, d)]).collect();
        let last = &mut members[5];
        (last.failed, last.reason, last.answers) = (true, Some("a <reason>".into()), MemberAnswers::default());
        CampaignResults {
            keys: vec![key("vibration.damping_ratio", ""), key("material.hardness", "Pa")],
            members,
            ..CampaignResults::default()
        }
    }

    #[test]
    fn the_page_has_a_sortable_row_for_each_member_and_a_curve_for_each_second_value() {
        let run = CampaignRun { name: "sweep".into(), results: campaign(), provenance: None };
        let Report { html, figures } = render_campaign(&run);
        assert_eq!(html.matches("<tr><td class=\"\" data-value=").count(), 6, "{html}");
        assert!(html.contains("data-value=\"150000000.0\" data-name=\"Hardness (MPa)\">150</td>"));
        assert!(html.contains("a &lt;reason&gt;") && html.contains("85 %") && !html.contains("Motion</th>"));
        let [figure] = figures.as_slice() else { panic!("{} figures", figures.len()) };
        for name in ["hardness 100", "hardness 150", "Damping ratio", "Probability of vibration"] {
            assert!(figure.svg.contains(name), "{name} is missing: {}", figure.svg);
        }
    }

    #[test]
    fn only_the_script_of_the_page_may_run() {
        let page = render_campaign(&CampaignRun { results: campaign(), ..CampaignRun::default() }).html;
        assert_eq!(page.matches("<script>").count(), 2);
        assert!(page.contains("default-src 'none'") && page.matches(" 'sha256-").count() == 3, "{page}");
        let run = crate::render(&crate::Run::default()).unwrap().html;
        assert!(!run.contains("<script") && run.contains("script-src 'none'"));
    }

    /// Returns a campaign whose machines vibrate below a damping ratio of 0.15, or of 0.08 if they are harder.
    fn judged() -> CampaignResults {
        let mut results = campaign();
        for member in &mut results.members {
            let [damping, hardness] = [0, 1].map(|place| number(&member.values[place]).unwrap());
            let limit = if hardness > 1.2e8 { 0.08 } else { 0.15 };
            (member.failed, member.reason) = (false, None);
            member.answers = MemberAnswers {
                vibrates: Some(damping < limit),
                kind: Some(if damping < limit { MotionKind::StickSlip } else { MotionKind::None }),
                limit_damping_ratio: Some(limit),
                damping_margin: Some(damping - limit),
                ..MemberAnswers::default()
            };
        }
        results
    }

    fn answer(results: &CampaignResults, question: &str) -> (String, String) {
        let found = answers(results).into_iter().find(|answer| answer.question == question);
        let plain = |text: String| text.replace('\u{a0}', " ");
        found.map(|found| (plain(found.answer), plain(found.detail))).unwrap()
    }

    #[test]
    fn the_first_screen_states_where_the_verdict_changes() {
        let mut results = judged();
        let (vibrating, which) = answer(&results, "How many vibrate?");
        assert!(vibrating == "3 of 6" && which.starts_with("Members 1 to 3."), "{vibrating} {which}");
        let (place, why) = answer(&results, "Where does the verdict change?");
        assert_eq!(place, "At a damping ratio of 0.08 to 0.15");
        assert_eq!(why, "Vibration ends at 0.08 with hardness 150 MPa and at 0.15 with hardness 100 MPa.");
        // Without these limits the values of the members show it.
        results.members.iter_mut().for_each(|member| member.answers.limit_damping_ratio = None);
        let (place, why) = answer(&results, "Where does the verdict change?");
        assert_eq!(place, "Between damping ratio 0.05 and 0.2");
        assert!(
            why.starts_with("Up to damping ratio 0.05 all members vibrate; from 0.2 on no member vibrates."),
            "{why}"
        );
        assert!(why.contains("other values decide, too"), "{why}");
        // Scans decide alone.
        for (index, member) in results.members.iter_mut().enumerate() {
            member.scan = Some(format!("{}.x3p", index % 2));
            member.answers.vibrates = Some(index % 2 == 0);
        }
        let values = results.keys.iter_mut().map(|key| key.unit.clear()).count();
        results.members.iter_mut().for_each(|member| member.values = vec![InputValue::Integer(1); values]);
        let found = answer(&results, "Where does the verdict change?");
        let why = "All members with scan 0.x3p vibrate. No member with scan 1.x3p vibrates.";
        assert_eq!(found, ("With the scan".into(), why.into()));
    }

    #[test]
    fn the_first_screen_states_which_value_changes_the_probability() {
        // 0.85 at a damping ratio of 0.05 and 0.7 at 0.2, at both hardnesses.
        let mut results = campaign();
        let (most, others) = answer(&results, "What changes the probability of vibration?");
        assert_eq!(most, "Damping ratio matters: 85 % vibrate at 0.05, 70 % at 0.2");
        assert!(
            others.starts_with("Hardness has no effect beyond the errors: 82 % vibrate at 100 MPa, 82 % at 150 MPa."),
            "{others}"
        );
        // One value alone, with intervals that are wider than its effect, or narrower.
        results.members.retain(|member| !member.failed && number(&member.values[1]) == Some(1e8));
        for (half, words) in [(0.2, "has no resolved effect"), (0.01, "matters")] {
            for member in &mut results.members {
                let own = member.answers.probability.unwrap();
                member.answers.probability_interval = Some([own - half, own + half]);
            }
            let found = answer(&results, "What changes the probability of vibration?");
            assert_eq!(found, (format!("Damping ratio {words}: 85 % vibrate at 0.05, 70 % at 0.2"), String::new()));
        }
        let answers = answers(&results);
        assert!(answers.iter().all(|answer| answer.question != "How many vibrate?"), "{answers:?}");
        assert!(figure(&results).unwrap().svg().contains("95 % interval"));
    }

    #[test]
    fn the_first_screen_states_what_all_members_rest_on() {
        let mut results = judged();
        let input = |name: &str, value: f64, kind| RestsOn {
            input: name.into(),
            value: InputValue::Number(value),
            unit: String::new(),
            kind,
            range: (kind == InputKind::Unknown).then_some([0.85, 0.95]),
        };
        results.rests_on = vec![
            input("surface.file", 2.0, InputKind::Measured),
            input("vibration.stribeck", 4.2, InputKind::Default),
            input("vibration.kinetic_share", 0.9, InputKind::Unknown),
        ];
        let Answer { answer: first, detail: others, .. } = answers::inputs(&results).unwrap();
        assert_eq!(first, "Surface: 2 scans");
        let unknown = "Unknown: kinetic over static friction 0.900 (0.850–0.950).";
        let default = "Not stated: Stribeck coefficient 4.2 (default, not measured).";
        assert_eq!(others.replace('\u{a0}', " "), format!("{unknown} {default}"));
        let html = render_campaign(&CampaignRun { results, ..CampaignRun::default() }).html;
        assert!(html.contains("<li class=\"chip measured\">surface: 2 scans</li>"), "{html}");
    }

    #[test]
    fn the_margin_is_drawn_where_the_limit_does_not_depend_on_the_first_key() {
        let drawn = figure(&judged()).unwrap();
        assert_eq!(drawn.title, "Margin of the damping ratio");
        for words in ["Margin ζ − ζ_v", "ζ &lt; ζ_v: vibrates", "ζ &gt; ζ_v: quiet", "hardness 100"] {
            assert!(drawn.svg().contains(words), "{words}: {}", drawn.svg());
        }
    }

    #[test]
    fn many_choices_have_the_colour_of_their_scan_or_of_their_verdict() {
        let mut results = judged();
        let all: Vec<MemberResult> = (0..10).flat_map(|_| results.members.clone()).collect();
        results.members = all;
        for (index, member) in results.members.iter_mut().enumerate() {
            member.values[1] = InputValue::Number(1e8 + 1e6 * index as f64);
        }
        let drawn = figure(&results).unwrap().svg();
        assert!(drawn.contains(">vibrates<") && drawn.contains(">quiet<"), "{drawn}");
        for (index, member) in results.members.iter_mut().enumerate() {
            member.scan = Some(["a.x3p", "b.x3p"][index % 2].into());
        }
        let drawn = figure(&results).unwrap().svg();
        assert!(drawn.contains(">a.x3p<") && drawn.contains(">b.x3p<") && !drawn.contains(">quiet<"), "{drawn}");
    }

    #[test]
    fn what_would_stop_vibration_are_the_values_of_the_first_remedy() {
        let mut results = judged();
        let limits = answer(&results, "What would stop it?");
        assert_eq!(limits.0, "A damping ratio above 0.15");
        for (place, member) in results.members.iter_mut().enumerate() {
            member.answers.probability = Some(0.5);
            member.answers.remedy = Some(MemberRemedy {
                input: "vibration.normal_force".into(),
                unit: "N".into(),
                probability: 0.05,
                value: (place > 0).then_some(9e3 - 1e3 * place as f64),
            });
        }
        let (value, how) = answer(&results, "What would stop it?");
        assert_eq!(value, "Normal force of 4 kN to 8 kN, by member");
        assert!(how.starts_with("At most 5 % vibrate at this value. 4 kN in member 6 ("), "{how}");
        assert!(how.ends_with("No value in the range of the study is enough for one member."), "{how}");
        results
            .members
            .iter_mut()
            .filter_map(|member| member.answers.remedy.as_mut())
            .for_each(|remedy| remedy.value = None);
        assert_eq!(answer(&results, "What would stop it?").0, "No normal force in the range of the study");
    }

    #[test]
    fn the_table_has_the_answers_before_the_values() {
        let mut results = judged();
        results.members[1].answers = MemberAnswers {
            vibrates: Some(false),
            probability: Some(2.93e-12),
            probability_interval: Some([0.0, 1e-10]),
            ..MemberAnswers::default()
        };
        results.members[2].answers.probability = Some(0.5);
        results.members[2].answers.probability_interval = Some([0.0, 1.0]);
        (results.members[3].failed, results.members[3].reason) = (true, Some("no scan".into()));
        results.member_warnings = vec![MemberWarning { warning: "It is small.".into(), members: vec![1, 2, 4] }];
        let html = render_campaign(&CampaignRun { results: results.clone(), ..CampaignRun::default() }).html;
        let place = |words: &str| html.find(words).unwrap_or_else(|| panic!("{words} is missing: {html}"));
        assert!(place("Verdict</th>") < place("Probability of vibration</th>"));
        assert!(place("Probability of vibration</th>") < place("Damping ratio</th>"));
        assert!(
            place("<span class=\"chip failed\">failed</span> <small class=\"reason\">no scan</small>")
                > place("chip vibrates")
        );
        assert!(html.contains("&lt; 0.01 %") && html.contains(">not determined<") && !html.contains("·10"));
        assert!(html.contains("It is small. (members 1, 2, 4)"));
        assert_eq!(
            answer(&results, "How probable is vibration?").0,
            "Below 5 % in 4, above 95 % in 1, not determined in 1 of 6 members"
        );
    }

    #[test]
    fn members_without_numbers_are_drawn_in_their_order() {
        let mut results = campaign();
        for member in &mut results.members {
            (member.scan, member.values) = (Some("a.x3p".into()), Vec::new());
        }
        results.keys.clear();
        let drawn = figure(&results).unwrap();
        assert!(
            drawn.svg().contains("Member") && drawn.caption.contains("One member has no value"),
            "{}",
            drawn.caption
        );
    }
}

//! The figures of the vibration's commands, complete, partial and hostile.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use asperity_results::{MapResolutionResult, MapResult, Table};

use crate::documents::{check_figure, elements, text, without_scripts};
use crate::synthetic::edit;
use asperity_report::{CoupledModes, Figure, Report, VibrationFigures, render_vibration};
use serde_json::json;

type Tables = BTreeMap<String, Table>;
/// Figures with their tables.
type Given = (VibrationFigures, Tables);
/// The name of a figure and words in it.
type Wanted = (&'static str, Vec<&'static str>);

fn table(columns: &[(&str, Vec<f64>)]) -> Table {
    Table::new(columns.iter().map(|(name, values)| (*name, values.clone())))
}

fn drawn(figures: &VibrationFigures, tables: &Tables) -> Vec<Figure> {
    render_vibration("map", figures, &[], &[], tables).unwrap().figures
}

fn grid(count: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..count).map(|i| f(i as f64 / (count - 1) as f64)).collect()
}

fn tables(tables: Vec<(&str, Table)>) -> Tables {
    tables.into_iter().map(|(name, table)| (name.to_owned(), table)).collect()
}

/// A circle as a phase portrait.
fn circle(radius: f64) -> Table {
    table(&[
        ("tau", grid(60, |t| TAU * t)),
        ("displacement", grid(60, |t| radius * (TAU * t).sin())),
        ("velocity", grid(60, |t| radius * (TAU * t).cos())),
    ])
}

/// A large cell with probability 1 beside four small ones.
fn map() -> Given {
    let cells = table(&[
        ("damping_ratio_low", vec![0.1, 0.2, 0.25, 0.2, 0.25]),
        ("damping_ratio_high", vec![0.2, 0.25, 0.3, 0.25, 0.3]),
        ("belt_velocity_low", vec![0.0, 0.0, 0.0, 0.05, 0.05]),
        ("belt_velocity_high", vec![0.1, 0.05, 0.05, 0.1, 0.1]),
        ("probability", vec![1.0, 0.5, 0.0, 0.25, 0.125]),
    ]);
    let contours = table(&[
        ("level", vec![0.05, 0.05, 0.5, 0.5, 0.95, 0.95]),
        ("line", vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0]),
        ("damping_ratio", vec![0.28, 0.27, 0.22, 0.21, 0.2, 0.2]),
        ("belt_velocity", vec![0.0, 0.1, 0.0, 0.1, 0.0, 0.1]),
    ]);
    let limit =
        table(&[("line", vec![0.0, 0.0]), ("damping_ratio", vec![0.2048, 0.19]), ("belt_velocity", vec![0.0, 0.1])]);
    let resolution = MapResolutionResult { x: 0.05, y: 0.05, unresolved_share: 0.0 };
    let map = MapResult { x: "damping_ratio".into(), y: "belt_velocity".into(), resolution };
    (VibrationFigures::Map(map), tables(vec![("map_cells", cells), ("map_contours", contours), ("map_limit", limit)]))
}

fn bifurcation() -> Given {
    let way = |end: f64| {
        let cycle = move |zeta: f64| if zeta < end { 1.0 } else { 0.0 };
        table(&[
            ("damping_ratio", grid(21, |t| 0.1 + 0.2 * t)),
            ("attractor", grid(21, |t| 2.0 * cycle(0.1 + 0.2 * t))),
            ("multiplicity", vec![1.0; 21]),
            ("velocity_min", grid(21, |t| -0.5 * cycle(0.1 + 0.2 * t))),
            ("velocity_max", grid(21, |t| 0.4 * cycle(0.1 + 0.2 * t))),
            ("displacement_min", grid(21, |t| 0.3 - 0.5 * cycle(0.1 + 0.2 * t))),
            ("displacement_max", grid(21, |t| 0.3 + 0.5 * cycle(0.1 + 0.2 * t))),
        ])
    };
    let marks = table(&[
        ("hopf", vec![0.181, f64::NAN]),
        ("fold", vec![f64::NAN, 0.221]),
        ("locked_fold", vec![f64::NAN, f64::NAN]),
    ]);
    let turns = table(&[
        ("way", vec![0.0; 5]),
        ("damping_ratio", vec![0.15; 5]),
        ("duration", vec![6.0; 5]),
        ("reattachment_displacement", grid(5, |t| 0.1 + 0.1 * t)),
        ("velocity_min", grid(5, |t| -0.5 + 0.1 * t)),
    ]);
    let all = vec![
        ("bifurcation_up", way(0.221)),
        ("bifurcation_down", way(0.181)),
        ("bifurcation_marks", marks),
        ("bifurcation_turnovers", turns),
    ];
    (VibrationFigures::Bifurcation { parameter: "damping_ratio".into() }, tables(all))
}

fn curve() -> Given {
    let curve = table(&[
        ("belt_velocity", grid(30, |t| 0.003 * 30.0_f64.powf(t))),
        ("critical_damping_ratio", grid(30, |t| 0.2 - 0.05 * t)),
        ("hopf_damping_ratio", grid(30, |t| 0.2 - 0.06 * t)),
        ("detachment_phase", vec![f64::NAN; 30]),
    ]);
    (VibrationFigures::CriticalCurve { parameter: "belt_velocity".into() }, tables(vec![("critical_curve", curve)]))
}

fn sound() -> Given {
    let spectrum = table(&[
        ("frequency", grid(40, |t| 0.01 * 1000.0_f64.powf(t))),
        ("density", grid(40, |t| 1e-8 / (0.01 + (t - 0.66).powi(2)))),
        ("density_low", grid(40, |t| if t == 0.0 { 0.0 } else { 0.8e-8 / (0.01 + (t - 0.66).powi(2)) })),
        ("density_high", grid(40, |t| 1.3e-8 / (0.01 + (t - 0.66).powi(2)))),
    ]);
    let (level_db, level_db_interval, cycle_period) = (Some(-0.22), Some([-0.32, -0.13]), Some(TAU));
    (VibrationFigures::Sound { level_db, level_db_interval, cycle_period }, tables(vec![("sound_spectrum", spectrum)]))
}

fn ensemble() -> Given {
    let cloud = table(&[
        ("trajectory", grid(120, |t| (1.99 * t).floor())),
        ("tau", grid(120, |t| TAU * t)),
        ("displacement", grid(120, |t| 1.1 * (TAU * t).sin())),
        ("velocity", grid(120, |t| 1.1 * (TAU * t).cos())),
    ]);
    let law = table(&[
        ("displacement", grid(20, |t| t)),
        ("density", grid(20, |t| t * (1.0 - t))),
        ("normal_density", grid(20, |t| t * (1.0 - t))),
    ]);
    let survival = table(&[
        ("tau", grid(50, |t| 600.0 * t)),
        ("share", grid(50, |t| 1.0 - 0.8 * t)),
        ("share_low", grid(50, |t| 0.95 - 0.8 * t)),
        ("share_high", grid(50, |t| 1.0 - 0.75 * t)),
    ]);
    let all = vec![
        ("phase_cloud", cloud),
        ("limit_cycle", circle(1.0)),
        ("reattachment", law.clone()),
        ("release", law),
        ("survival", survival),
    ];
    (VibrationFigures::Ensemble, tables(all))
}

fn basin() -> Given {
    let places =
        || (0..30).flat_map(|row| (0..40).map(move |column| (f64::from(column) - 20.0, f64::from(row) - 15.0)));
    let attractor = |(x, y): (f64, f64)| if x.hypot(y) < 8.0 { 0.0 } else { 2.0 };
    let basin = table(&[
        ("displacement", places().map(|p| p.0).collect()),
        ("velocity", places().map(|p| p.1).collect()),
        ("attractor", places().map(attractor).collect()),
    ]);
    let all = vec![("basin", basin), ("separatrix", circle(8.0)), ("limit_cycle", circle(12.0))];
    (VibrationFigures::Basin, tables(all))
}

fn modes() -> Given {
    let scan = table(&[
        ("friction", grid(50, |t| t)),
        ("growth_1", grid(50, |t| (t - 0.75).max(0.0).sqrt())),
        ("frequency_1", grid(50, |t| 1.0 + 0.4 * t)),
        ("growth_2", grid(50, |t| -(t - 0.75).max(0.0).sqrt())),
        ("frequency_2", grid(50, |t| 1.7 - 0.3 * t)),
    ]);
    let cycle = table(&[
        ("tau", grid(80, |t| t)),
        ("tangential", grid(80, |t| (TAU * t).cos())),
        ("tangential_velocity", grid(80, |t| -(TAU * t).sin())),
        ("normal", grid(80, |t| (TAU * t).sin())),
        ("normal_velocity", grid(80, |t| (TAU * t).cos())),
        ("contact", grid(80, |t| (3.0 * t).floor().min(2.0))),
    ]);
    let modes = CoupledModes {
        coalescence: Some(0.75),
        critical_friction: Some(0.7506),
        friction: 0.8,
        belt_velocity: Some(0.5),
        mean_growth: Some(0.07),
    };
    (VibrationFigures::ModeCoupling(modes), tables(vec![("modes_over_friction", scan), ("mode_cycle", cycle)]))
}

/// Figures and tables with the files that they make and words in each.
fn all() -> Vec<(Given, Vec<Wanted>)> {
    vec![
        (
            map(),
            vec![(
                "stability_map",
                vec![
                    "Damping ratio ζ",
                    "Belt velocity V",
                    "5 %",
                    "50 %",
                    "95 %",
                    "end of vibration without fluctuation",
                    "Probability of sustained vibration",
                ],
            )],
        ),
        (
            bifurcation(),
            vec![(
                "bifurcation",
                vec![
                    "ζ_H = 0.181",
                    "ζ_c = 0.221",
                    "stick-slip",
                    "steady sliding",
                    "upwards",
                    "downwards",
                    "each turn: least velocity, re-attachment",
                    "Velocity dX/dτ",
                    "Displacement X",
                ],
            )],
        ),
        (
            curve(),
            vec![(
                "critical_curve",
                vec!["sliding and stick-slip coexist", "ζ_c − ζ_H", "ζ_H: sliding is stable above"],
            )],
        ),
        (
            sound(),
            vec![("sound_spectrum", vec!["95 % band", "limit cycle, ω/ω₀ = 1", "−0.22 dB [−0.32, −0.13]", "ω/ω₀"])],
        ),
        (
            ensemble(),
            vec![
                ("phase_portrait", vec!["many trajectories", "deterministic limit cycle"]),
                ("reattachment", vec!["re-attachments", "detachments", "normal distribution"]),
                ("survival", vec!["Fraction in vibration", "never left vibration", "Time τ"]),
            ],
        ),
        (basin(), vec![("basin", vec!["steady sliding", "stick-slip", "separatrix", "limit cycle"])]),
        (
            modes(),
            vec![
                ("modes", vec!["Growth rate", "critical μ = 0.7506", "undamped modes meet, μ = 0.75", "mean growth"]),
                ("mode_cycle", vec!["stick", "slip", "faster than the belt", "velocity of the belt"]),
            ],
        ),
    ]
}

#[test]
fn every_command_has_its_labelled_figures() {
    for ((given, tables), wanted) in all() {
        let figures = drawn(&given, &tables);
        assert_eq!(
            figures.iter().map(|f| f.name.as_str()).collect::<Vec<_>>(),
            wanted.iter().map(|w| w.0).collect::<Vec<_>>()
        );
        for (figure, (name, words)) in figures.iter().zip(wanted) {
            check_figure(figure);
            let shown = text(&figure.svg);
            for word in words {
                assert!(shown.contains(word), "{name}: {word:?}");
            }
        }
        assert_eq!(figures, drawn(&given, &tables), "equal tables give equal bytes");
        let html = render_vibration("map", &given, &[], &[], &tables).unwrap().html;
        for name in tables.keys() {
            assert!(html.contains(&format!("<code>tables/{name}.csv</code>")), "{name}");
        }
    }
}

#[test]
fn absent_and_undefined_data_are_left_out() {
    for ((given, tables), _) in all() {
        assert!(drawn(&given, &Tables::new()).is_empty());
        let check = |tables: &Tables| drawn(&given, tables).iter().for_each(check_figure);
        for name in tables.keys() {
            let mut without = tables.clone();
            without.remove(name);
            check(&without);
            for hidden in 0..tables[name].columns().len() {
                let mut holed = tables.clone();
                edit(&mut holed, name, |columns| columns[hidden].1[0] = f64::NAN);
                check(&holed);
                let mut absent = tables.clone();
                edit(&mut absent, name, |columns| drop(columns.remove(hidden)));
                check(&absent);
            }
            let mut empty = tables.clone();
            edit(&mut empty, name, |columns| columns.iter_mut().for_each(|(_, values)| values.clear()));
            check(&empty);
        }
    }
}

#[test]
fn names_of_parameters_are_escaped() {
    let (_, mut tables) = curve();
    let hostile = "<script>\"&";
    edit(&mut tables, "critical_curve", |columns| columns[0].0 = hostile.into());
    let answer = [("parameter".to_owned(), json!(hostile)), (hostile.to_owned(), json!(hostile))];
    let figures = VibrationFigures::CriticalCurve { parameter: hostile.into() };
    let warnings = [hostile.to_owned()];
    let Report { html, figures } = render_vibration(hostile, &figures, &answer, &warnings, &tables).unwrap();
    assert!(!without_scripts(&html).contains("<script") && html.contains("&lt;script"));
    assert_eq!(figures.len(), 1);
    elements(&figures[0].svg);
    assert!(!figures[0].svg.contains("<script") && figures[0].svg.contains("&lt;script"));
}

#[test]
fn the_curve_under_forcing_is_the_fold_of_the_locked_cycle() {
    let (figures, mut tables) = curve();
    edit(&mut tables, "critical_curve", |columns| columns[3].1.fill(1.0));
    let drawn = text(&drawn(&figures, &tables)[0].svg);
    assert!(drawn.contains("the locked cycle ends (fold)") && !drawn.contains("coexist"));
}

#[test]
fn a_sparse_cloud_is_drawn_as_points() {
    let (figures, mut tables) = ensemble();
    let count = |tables: &Tables| drawn(&figures, tables)[0].svg.matches("<circle").count();
    assert!(count(&tables) < 10);
    edit(&mut tables, "phase_cloud", |columns| columns[1].1.iter_mut().for_each(|tau| *tau *= 100.0));
    assert!(count(&tables) >= 120);
}

//! A complete run made of analytic functions: every table and field that a study can hold.

#[path = "../../../asperity-results/tests/example/mod.rs"]
pub(crate) mod example;

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

use asperity_report::{Input, Run};
use asperity_results::{Field, Machine, Program, Provenance, Results, Table};
use ndarray::Array2;

/// A reproducible number in [0, 1) for texture (a hash of the index, no statistics are drawn from it).
fn noise(index: u64) -> f64 {
    let mut z = index.wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z >> 11) as f64 / (1u64 << 53) as f64
}

/// A sum of waves with wavelengths between the given ones and random phases, of unit variance.
fn rough(x: f64, y: f64, longest: f64, shortest: f64, seed: u64) -> f64 {
    let waves = 60;
    let sum: f64 = (0..waves)
        .map(|i| {
            let draw = |j: u64| noise(seed * 10_000 + i * 10 + j);
            let wavelength = longest * (shortest / longest).powf(draw(0));
            let (angle, phase) = (TAU * draw(1), TAU * draw(2));
            (TAU / wavelength * (x * angle.cos() + y * angle.sin()) + phase).cos() * (wavelength / longest).powf(0.8)
        })
        .sum();
    sum * 0.35
}

fn field(nx: usize, ny: usize, width_m: f64, height_m: f64, value: impl Fn(f64, f64) -> f64) -> Field {
    let (dx_m, dy_m) = (width_m / nx as f64, height_m / ny as f64);
    let at = |(row, column)| value((column as f64 + 0.5) * dx_m, (row as f64 + 0.5) * dy_m);
    Field::new([dx_m, dy_m], "", Array2::from_shape_fn((ny, nx), at))
}

fn table(columns: &[(&str, Vec<f64>)]) -> Table {
    Table::new(columns.iter().map(|(name, values)| (*name, values.clone())))
}

/// Returns a table with changed columns.
pub(crate) fn changed(table: &Table, change: impl FnOnce(&mut Vec<(String, Vec<f64>)>)) -> Table {
    let mut columns = table.columns().to_vec();
    change(&mut columns);
    Table::new(columns)
}

/// Changes the columns of one of the tables.
pub(crate) fn edit(
    tables: &mut BTreeMap<String, Table>,
    name: &str,
    change: impl FnOnce(&mut Vec<(String, Vec<f64>)>),
) {
    let table = changed(&tables[name], change);
    tables.insert(name.to_owned(), table);
}

/// Changes the values of a field.
pub(crate) fn edit_field(field: &mut Field, change: impl FnOnce(&mut Array2<f64>)) {
    let mut values = field.values().clone();
    change(&mut values);
    *field = Field::new([field.dx_m(), field.dy_m()], field.unit(), values);
}

fn grid(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64).collect()
}

fn map(x: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    x.iter().map(|&x| f(x)).collect()
}

fn normal(x: f64, mean: f64, std: f64) -> f64 {
    (-0.5 * ((x - mean) / std).powi(2)).exp() / (std * TAU.sqrt())
}

/// An approximation of the normal distribution function, good enough to draw.
fn normal_cdf(x: f64) -> f64 {
    1.0 / (1.0 + (-1.5976 * x - 0.070_566 * x.powi(3)).exp())
}

fn surface(tables: &mut BTreeMap<String, Table>, fields: &mut BTreeMap<String, Field>) {
    let edge = 2e-4;
    let height = |x: f64, y: f64| 1e-6 * rough(x, y, 6e-5, 6e-6, 1);
    let missing = |x: f64, y: f64| {
        ((x - 4e-5).hypot(y - 1.5e-4) < 8e-6) || noise((x * 1e9) as u64 * 7919 + (y * 1e9) as u64) < 0.002
    };
    let raw = |x: f64, y: f64| if missing(x, y) { f64::NAN } else { height(x, y) + 0.08 * x - 0.03 * y };
    let levelled = |x: f64, y: f64| if missing(x, y) { f64::NAN } else { height(x, y) };
    fields.insert("height_raw".into(), field(256, 256, edge, edge, raw));
    fields.insert("height_levelled".into(), field(256, 256, edge, edge, levelled));
    let sample = |x: f64, y: f64| 1e-6 * rough(x, y, 6e-5, 8e-6, 2);
    fields.insert("surface_sample".into(), field(128, 128, edge, edge, sample));

    let z = grid(-4e-6, 4e-6, 61);
    let measured = z.iter().enumerate().map(|(i, &z)| {
        let density = normal(z, 0.0, 1e-6) * (1.0 + 0.25 * (z / 1e-6).tanh()) * (0.9 + 0.2 * noise(i as u64));
        if density < 200.0 { 0.0 } else { density }
    });
    let fitted = map(&z, |z| normal(z, 0.0, 1e-6) * (1.0 + 0.25 * (z / 1e-6).tanh()));
    tables.insert(
        "height_pdf".into(),
        table(&[
            ("height_m", z.clone()),
            ("density_per_m", measured.collect()),
            ("fitted_density_per_m", fitted),
            ("normal_density_per_m", map(&z, |z| normal(z, 0.0, 1e-6))),
            ("johnson_su_density_per_m", map(&z, |z| normal(z, 1e-7, 1.02e-6))),
            ("beta_density_per_m", map(&z, |z| normal(z, 5e-8, 1.05e-6))),
            ("study_density_per_m", map(&z, |z| normal(z, 0.0, 1.1e-6))),
        ]),
    );
    let none = f64::NAN;
    tables.insert(
        "height_fits".into(),
        table(&[
            ("rank", vec![1.0, 2.0, 3.0, 4.0]),
            ("free_parameters", vec![4.0, 4.0, 2.0, 3.0]),
            ("delta_aic", vec![0.0, 1.7, 12.3, 13.1]),
            ("akaike_weight", vec![0.69, 0.3, 0.0015, 0.001]),
            ("ks_distance", vec![0.008, 0.011, 0.031, 0.032]),
            ("ks_p_value", vec![0.98, 0.93, 0.21, 0.2]),
            ("effective_heights", vec![412.0; 4]),
            ("johnson_su_gamma", vec![0.11, none, none, none]),
            ("johnson_su_delta", vec![2.3, none, none, none]),
            ("johnson_su_xi_m", vec![1e-7, none, none, none]),
            ("johnson_su_lambda_m", vec![2.1e-6, none, none, none]),
            ("beta_a", vec![none, 5.1, none, none]),
            ("beta_b", vec![none, 6.2, none, none]),
            ("beta_low_m", vec![none, -4.4e-6, none, none]),
            ("beta_high_m", vec![none, 5.2e-6, none, none]),
            ("normal_mean_m", vec![none, none, 0.0, none]),
            ("normal_std_m", vec![none, none, 1e-6, none]),
            ("weibull_shape", vec![none, none, none, 3.4]),
        ]),
    );
    let lag = grid(0.0, 8e-5, 129);
    let decay = |length: f64| map(&lag, move |lag| (-(lag / length).powi(2)).exp());
    let wavy =
        |length: f64| map(&lag, move |lag| (-(lag / length).powi(2)).exp() + 0.08 * (lag / 7e-6).sin() * (lag / 8e-5));
    tables.insert(
        "height_acf".into(),
        table(&[
            ("lag_m", lag.clone()),
            ("acf_x", wavy(2e-5)),
            ("acf_y", wavy(1.4e-5)),
            ("fit_x", decay(2e-5)),
            ("fit_y", decay(1.4e-5)),
            ("acf_x_low", wavy(2e-5).iter().map(|rho| rho - 0.12).collect()),
            ("acf_x_high", wavy(2e-5).iter().map(|rho| rho + 0.12).collect()),
            ("acf_y_low", wavy(1.4e-5).iter().map(|rho| rho - 0.1).collect()),
            ("acf_y_high", wavy(1.4e-5).iter().map(|rho| rho + 0.1).collect()),
        ]),
    );
    let q: Vec<f64> = (1..=127).map(|i| TAU * f64::from(i) / edge).collect();
    let psd = |seed: u64| {
        q.iter()
            .enumerate()
            .map(move |(i, q)| 1.2e-17 / (1.0 + (q * 2e-5).powi(2)).powf(1.3) * (0.5 + noise(seed + i as u64)))
            .collect::<Vec<_>>()
    };
    tables.insert(
        "height_psd".into(),
        table(&[
            ("wavenumber_rad_per_m", q.clone()),
            ("psd_x_m3", psd(1000)),
            ("psd_y_m3", psd(2000)),
            ("psd_model_x_m3", map(&q, |q| 1e-12 * 2e-5 * PI.sqrt() * (-(q * 2e-5).powi(2) / 4.0).exp())),
        ]),
    );
    let q: Vec<f64> = grid((TAU / edge).ln(), (127.0 * TAU / edge).ln(), 36).iter().map(|q| q.exp()).collect();
    for (name, unit, scale, seed) in [("radial", "m4", 1e-21, 300), ("x", "m3", 1.2e-17, 400), ("y", "m3", 1e-17, 500)]
    {
        let model = map(&q, |q| scale / (1.0 + (q * 2e-5).powi(2)).powf(1.3));
        let psd: Vec<f64> = model.iter().zip(0..).map(|(p, i)| p * (0.9 + 0.2 * noise(seed + i))).collect();
        let spread = |sign: f64| psd.iter().zip(&q).map(|(p, q)| p * (sign * 1e5 / (1e5 + q)).exp()).collect();
        let columns =
            [("psd", psd.clone()), ("psd_low", spread(-1.0)), ("psd_high", spread(1.0)), ("psd_model", model)];
        let named = columns.map(|(column, values)| (format!("{column}_{unit}"), values));
        let all = std::iter::once(("wavenumber_rad_per_m".to_owned(), q.clone())).chain(named);
        tables.insert(format!("height_psd_{name}"), Table::new(all));
    }
}

fn pressure(tables: &mut BTreeMap<String, Table>, fields: &mut BTreeMap<String, Field>) {
    let pressure = |x: f64, y: f64| (2.4e9 * (rough(x, y, 6e-5, 8e-6, 2) - 0.6)).clamp(0.0, 2e9);
    fields.insert("pressure_sample".into(), field(128, 128, 2e-4, 2e-4, pressure));
    let to_edge = |x: f64, y: f64| x.min(y).min(2e-4 - x).min(2e-4 - y);
    let probability = move |x: f64, y: f64| 0.32 + 0.12 * (-to_edge(x, y) / 1e-5).exp();
    let share = |scale: f64| move |x: f64, y: f64| scale * probability(x, y);
    fields.insert("contact_probability".into(), field(64, 64, 2e-4, 2e-4, probability));
    for (name, scale) in [("mean", 5e8), ("quantile_10", 0.0), ("quantile_50", 0.0), ("quantile_90", 3e9)] {
        fields.insert(format!("pressure_{name}"), field(64, 64, 2e-4, 2e-4, share(scale)));
    }
    fields.insert("expansion_error".into(), field(64, 64, 2e-4, 2e-4, |x, y| 0.9 + 0.1 * rough(x, y, 6e-5, 2e-5, 4)));
    let p = grid(0.0, 2e9, 201);
    let law = |contact: f64, scale: f64| {
        map(&p, move |p| if p >= 2e9 { 1.0 } else { 1.0 - contact + contact * (2.0 * normal_cdf(p / scale) - 1.0) })
    };
    let rippled = |amplitude: f64, seed: u64| {
        law(0.32, 7e8)
            .iter()
            .zip(&p)
            .map(|(f, p)| (f + amplitude * (p / 1.3e8 + seed as f64).sin() * (1.0 - f)).min(1.0))
            .collect::<Vec<_>>()
    };
    tables.insert(
        "pressure_cdf".into(),
        table(&[
            ("pressure_pa", p.clone()),
            ("monte_carlo", rippled(0.05, 1)),
            ("latin_hypercube", rippled(0.03, 2)),
            ("sobol", rippled(0.015, 3)),
            ("polynomial_chaos", law(0.34, 6.2e8)),
            ("polynomial_chaos_log", law(0.32, 8.6e8)),
            ("polynomial_chaos_local", law(0.317, 6.6e8)),
            ("default", law(0.325, 7.1e8)),
            ("reference", law(0.32, 7e8)),
        ]),
    );
    let nodes: Vec<f64> = p.iter().step_by(5).copied().collect();
    let middle: Vec<f64> = law(0.325, 7.1e8).iter().step_by(5).copied().collect();
    let beside = |half: f64| map(&middle, |f| (f + half * (f * (1.0 - f)).sqrt()).clamp(0.0, 1.0));
    tables.insert(
        "pressure_bands".into(),
        table(&[
            ("default_pressure_pa", nodes),
            ("default_pointwise_low", beside(-0.02)),
            ("default_pointwise_high", beside(0.02)),
            ("default_simultaneous_low", beside(-0.032)),
            ("default_simultaneous_high", beside(0.032)),
            ("default_cdf", middle),
        ]),
    );
    let share = grid(0.0025, 0.9975, 200);
    let quantile = |mean: f64, std: f64| map(&share, |u| mean + std * 0.55 * (u / (1.0 - u)).ln());
    tables.insert(
        "pressure_scalar_distributions".into(),
        table(&[
            ("contact_fraction", quantile(0.21, 0.02)),
            ("mean_pressure_pa", quantile(1.6e8, 1.5e7)),
            ("mean_gap_m", quantile(4e-7, 5e-8)),
            ("probability", share.clone()),
        ]),
    );
}

fn friction(tables: &mut BTreeMap<String, Table>, fields: &mut BTreeMap<String, Field>) {
    let strip = |x: f64, y: f64| (2.2e9 * (rough(x, y, 8e-5, 1.5e-5, 3) - 0.7)).clamp(0.0, 2e9);
    fields.insert("pressure_strip".into(), field(1024, 16, 6e-3, 7.5e-5, strip));
    let depth = grid(0.6e-6, 3.7e-6, 6);
    let pressure = |share: f64| map(&depth, move |d| share * 3e6 * (d / 0.6e-6).powf(2.5));
    tables.insert(
        "friction_load_curve".into(),
        table(&[
            ("penetration_m", depth.clone()),
            ("mean_pressure_pa", pressure(1.0)),
            ("low", pressure(0.9)),
            ("high", pressure(1.1)),
            ("contact_fraction", map(&depth, |d| 1e-3 * (d / 0.6e-6).powf(2.4))),
        ]),
    );
    let mu = grid(0.186, 0.224, 32);
    let beta = |mu: f64| {
        let t = (mu - 0.185) / 0.045;
        34.53 * t.powf(1.1) * (1.0 - t).powi(4) / 0.045 * 1.03
    };
    tables.insert(
        "friction_histogram".into(),
        table(&[
            ("mu", mu.clone()),
            ("density", mu.iter().enumerate().map(|(i, mu)| beta(*mu) * (0.8 + 0.4 * noise(i as u64))).collect()),
            ("fitted_density", map(&mu, |mu| 0.98 * beta(mu))),
            ("beta_density", map(&mu, beta)),
            ("normal_density", map(&mu, |mu| normal(mu, 0.196, 0.007))),
            ("shifted_gamma_density", map(&mu, |mu| 0.9 * beta(mu))),
        ]),
    );
    let share = grid(0.025, 0.975, 20);
    tables.insert(
        "friction_pit".into(),
        table(&[
            ("probability", share.clone()),
            ("density", share.iter().enumerate().map(|(i, _)| 0.9 + 0.2 * noise(i as u64)).collect()),
            ("low", vec![0.7; 20]),
            ("high", vec![1.3; 20]),
        ]),
    );
    let fitted = map(&share, |u| 0.196 + 0.004 * (u / (1.0 - u)).ln());
    tables.insert(
        "friction_qq".into(),
        table(&[("probability", share), ("measured", map(&fitted, |mu| mu + 0.02 * (mu - 0.196))), ("fitted", fitted)]),
    );
    let frequency: Vec<f64> = (0..30).map(|i| 160.0 * 1.18f64.powi(i)).collect();
    let power = |share: f64, length_m: f64| {
        let window = |f: f64| ((PI * f * 6e-4).sin() / (PI * f * 6e-4)).powi(2) + 1e-3;
        map(&frequency, move |f| share * 4e-8 * window(f) / (1.0 + (TAU * f * length_m).powi(2)))
    };
    tables.insert(
        "friction_spectrum".into(),
        table(&[
            ("frequency_per_m", frequency.clone()),
            ("density_m", power(1.0, 4e-5)),
            ("density_m_low", power(0.7, 4e-5)),
            ("density_m_high", power(1.5, 4e-5)),
            ("window_only_m", power(1.0, 0.0)),
            ("windowed_fit_m", power(1.0, 3e-5)),
        ]),
    );
    let lag = grid(-1.2e-3, 1.2e-3, 61);
    let correlation = map(&lag, |s| 0.98 * (1.0 - s.abs() / 6e-4).max(-0.2));
    tables.insert("friction_area_load".into(), table(&[("lag_m", lag), ("correlation", correlation)]));
    let window = vec![6e-4, 3e-4, 1.5e-4, 7.5e-5];
    tables.insert(
        "friction_windows".into(),
        table(&[
            ("window_m", window.clone()),
            ("std", map(&window, |w| 0.0055 * (6e-4 / w).sqrt())),
            ("expected_std", map(&window, |w| 0.0056 * (6e-4 / w).powf(0.48))),
            ("correlation_length_m", map(&window, |w| 0.62 * w + 3e-5)),
            ("own_length_m", vec![0.0, 2e-5, 2.4e-5, 2.6e-5]),
            ("own_length_low_m", vec![0.0, 0.0, 1.6e-5, 2.2e-5]),
            ("own_length_high_m", map(&window, |w| 0.1 * w + 2.2e-5)),
        ]),
    );
    let lag = grid(0.0, 1.5e-3, 101);
    tables.insert(
        "friction_acf".into(),
        table(&[
            ("lag_m", lag.clone()),
            ("acf", map(&lag, |lag| (-(lag / 4.2e-4)).exp() * (1.0 - 0.2 * (lag / 2e-4).sin().powi(2)))),
            ("fit", map(&lag, |lag| (-(lag / 4e-4)).exp())),
            ("window_only", map(&lag, |lag| (1.0 - lag / 6e-4).max(0.0))),
            ("windowed_fit", map(&lag, |lag| (1.0 - lag / 6.4e-4).max(0.0))),
            ("fit_matern", map(&lag, |lag| (1.0 + lag / 2e-4) * (-(lag / 2e-4)).exp())),
        ]),
    );
    let position = grid(3e-4, 5.7e-3, 800);
    let course = |level: f64, spread: f64, seed: u64| {
        map(&position, move |s| level + spread * rough(s, 0.0, 1.8e-3, 2e-4, seed))
    };
    tables.insert(
        "friction_trace".into(),
        table(&[
            ("position_m", position.clone()),
            ("mu_p5", course(0.212, 0.0055, 11)),
            ("mu_p25", course(0.2, 0.003, 12)),
            ("mu_p50", course(0.1945, 0.0016, 13)),
            ("mu_load", course(0.226, 0.008, 14)),
        ]),
    );
}

fn vibration(tables: &mut BTreeMap<String, Table>) {
    // Coulomb friction without damping: slip is a circle about the kinetic coefficient, stick a line at belt velocity.
    let (static_friction, kinetic, belt): (f64, f64, f64) = (0.4, 0.3, 0.05);
    let cycle = |drop: f64, next: f64| {
        let slip = TAU - 2.0 * (drop / belt).atan();
        let slipping = grid(0.0, slip, 120).into_iter();
        let slipping =
            slipping.map(move |t| (t, kinetic + drop * t.cos() + belt * t.sin(), belt * t.cos() - drop * t.sin()));
        let stick = (drop + next) / belt;
        let sticking = grid(0.0, stick, 30).into_iter().map(move |t| (slip + t, kinetic - drop + belt * t, belt));
        slipping.chain(sticking).collect::<Vec<_>>()
    };
    let portrait = |points: &[(f64, f64, f64)]| {
        table(&[
            ("tau", points.iter().map(|p| p.0).collect()),
            ("displacement", points.iter().map(|p| p.1).collect()),
            ("velocity", points.iter().map(|p| p.2).collect()),
        ])
    };
    let drop = static_friction - kinetic;
    tables.insert("limit_cycle".into(), portrait(&cycle(drop, drop)));
    let drops: Vec<f64> = (0..41).map(|i| drop + 0.05 * (noise(i) + noise(i + 100) - 1.0)).collect();
    let path: Vec<_> = drops.windows(2).flat_map(|pair| cycle(pair[0], pair[1])).collect();
    tables.insert("trajectory".into(), portrait(&path));
    // A cloud of cycles with other drops, at equal times.
    let cloud: Vec<(f64, (f64, f64, f64))> =
        (0..30).flat_map(|i| cycle(drops[i], drops[i + 1]).into_iter().map(move |point| (i as f64, point))).collect();
    tables.insert(
        "phase_cloud".into(),
        table(&[
            ("trajectory", cloud.iter().map(|(i, _)| *i).collect()),
            ("tau", cloud.iter().map(|(_, p)| p.0).collect()),
            ("displacement", cloud.iter().map(|(_, p)| p.1).collect()),
            ("velocity", cloud.iter().map(|(_, p)| p.2).collect()),
        ]),
    );
    for (name, std) in [("reattachment_area", 4e-4), ("reattachment_paper", 9e-3)] {
        let x = grid(0.2 - 4.0 * std, 0.2 + 4.0 * std, 41);
        let density =
            x.iter().enumerate().map(|(i, &x)| normal(x, 0.2, std) * (0.85 + 0.3 * noise(i as u64 + 7))).collect();
        tables.insert(
            name.into(),
            table(&[
                ("displacement", x.clone()),
                ("density", density),
                ("normal_density", map(&x, |x| normal(x, 0.2, std))),
            ]),
        );
    }
    for (name, rate) in [("survival_area", 1e-4), ("survival_paper", 8e-3)] {
        let tau = grid(0.0, 640.0, 81);
        let share = map(&tau, |t| (-rate * t).exp());
        tables.insert(
            name.into(),
            table(&[
                ("tau", tau),
                ("share", share.clone()),
                ("share_low", map(&share, |s| s - 0.1 * s * (1.0 - 0.9 * s))),
                ("share_high", map(&share, |s| s + 0.1 * (1.0 - s))),
            ]),
        );
    }
}

/// Tables of a run that no figure draws.
pub(crate) const WITHOUT_FIGURE: [&str; 5] = [
    "friction_area_load",
    "friction_windows",
    "height_fits",
    "pressure_scalar_distributions",
    "pressure_sensitivities",
];

/// The full run.
pub(crate) fn full_run() -> Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(build).clone()
}

fn build() -> Run {
    let (mut tables, mut fields) = (BTreeMap::new(), BTreeMap::new());
    surface(&mut tables, &mut fields);
    pressure(&mut tables, &mut fields);
    friction(&mut tables, &mut fields);
    vibration(&mut tables);
    let input =
        |section: &str, key: &str, value: &str| Input { section: section.into(), key: key.into(), value: value.into() };
    Run {
        name: "Ground steel against a rigid flat".into(),
        results: example::results(),
        tables,
        fields,
        inputs: vec![
            input("surface", "file", "brake_disc.x3p"),
            input("surface", "level", "plane"),
            input("surface", "modes", "101"),
            input("material", "youngs_modulus", "210 GPa"),
            input("material", "poisson_ratio", "0.3"),
            input("material", "hardness", "2 GPa"),
            input("vibration", "mass", "1 kg"),
            input("vibration", "damping_ratio", "0.17"),
            input("vibration", "duration", "637.2"),
            input("vibration", "nominal_area", "833 mm²"),
        ],
        provenance: Some(Provenance {
            asperity: "0.1.0".into(),
            study: "brake".into(),
            seed: 2016,
            inputs: BTreeMap::from([("brake_disc.x3p".into(), "sha256:9f86d081884c7d65".into())]),
            machine: Machine { threads: 2, ..Machine::default() },
            program: Program { instruction_sets: vec!["avx2".into()], ..Program::default() },
            ..Provenance::default()
        }),
        machine: Some("{\"parameters\":{\"damping_ratio\":0.17},\"note\":\"</script><b>\"}".into()),
    }
}

/// The same run after `--only surface`.
pub(crate) fn surface_run() -> Run {
    let mut run = full_run();
    run.results = Results { surface: run.results.surface, ..Results::default() };
    run.machine = None;
    run.tables.retain(|name, _| name.starts_with("height_"));
    run.fields.retain(|name, _| name.starts_with("height_") || name == "surface_sample");
    run
}

//! Contact of a sphere with a flat, next to the solution of Hertz: `cargo run --example hertz`.

#![expect(clippy::print_stdout, reason = "the numbers are what this example shows")]

use std::error::Error;

use asperity::contact::{Boundary, ContactProblem, Control, HalfSpace, Solver, contact_modulus_pa, exact};
use asperity::map::{Grid, HeightMap};

fn main() -> Result<(), Box<dyn Error>> {
    // A steel sphere of radius 10 mm under 10 N.
    let (radius_m, load_n) = (10e-3, 10.0);
    let modulus_pa = contact_modulus_pa(210e9, 0.3);
    let hertz = exact::Hertz::new(modulus_pa, radius_m, load_n);

    println!("points       contact radius   highest pressure   approach     load");
    for points in [32, 64, 128, 256] {
        let grid = Grid::with_size(points, points, 200e-6, 200e-6)?;
        let height_m = |x: f64, y: f64| -((x - 100e-6).powi(2) + (y - 100e-6).powi(2)) / (2.0 * radius_m);
        let sphere = HeightMap::from_function(grid, height_m)?;
        let half_space = HalfSpace::new(grid, modulus_pa, Boundary::Free)?;
        let control = Control::Penetration { metre: hertz.approach_m };
        let problem = ContactProblem::new(&half_space, sphere.complete_heights_m()?, control, None)?;
        let solution = Solver::default().solve(&problem)?;
        let area_m2 = solution.contact_fraction() * grid.width_m() * grid.height_m();
        println!(
            "{points:>3} × {points:<3}    {:.2} µm         {:.4} GPa         {:.4} µm    {:.3} N",
            1e6 * (area_m2 / std::f64::consts::PI).sqrt(),
            1e-9 * solution.max_pressure_pa(),
            1e6 * hertz.approach_m,
            solution.mean_pressure_pa() * grid.width_m() * grid.height_m(),
        );
    }
    println!(
        "Hertz        {:.2} µm         {:.4} GPa         {:.4} µm    {load_n:.3} N",
        1e6 * hertz.contact_radius_m,
        1e-9 * hertz.max_pressure_pa,
        1e6 * hertz.approach_m
    );
    Ok(())
}

//! Contact of a rough surface with a rigid flat.

mod counterface;
mod layering;
mod unloading;

use asperity::map::BoundaryKind;
use std::io::Write;
use std::path::{Path, PathBuf};

use asperity::contact::{
    Boundary, ContactError, ContactNumbers, ContactProblem, ContactStiffness, Control, Elastic, HalfSpace, Neighbours,
    Solver, SolverStop, StiffnessSolver, Substrate, memory_bytes,
};
use asperity::map::Grid;
use asperity::quantity::{Compliance, Force, Length, Pressure};
use asperity::study::implausible_material;
use asperity_formats::{Format, Scan, write_npy, write_npz, write_vtk_fields};
use clap::Args;
use ndarray::Array2;

use counterface::Counterface;
use layering::Layering;
use unloading::Unloaded;

use super::surface::preparation::LevelOption;
use crate::args;
use crate::failure::{Failure, Kind};
use crate::input::{self, ScanOptions};
use crate::monitor::Terminal;
use crate::output::{Answer, check_target, replace_file};
use crate::resources::{require_disk, require_memory};

/// Approximate disk space of a cell's fields in a NumPy archive, in bytes: displacement and gap hardly shrink.
const ARCHIVE_BYTES: f64 = 20.0;
/// Disk space of a cell's fields in a VTK image, in bytes: six doubles in base64.
const IMAGE_BYTES: f64 = 64.0;

/// Presses a rough surface against a rigid flat, or against a counterface.
///
/// Clusters are groups of contact cells that share edges; on a periodic map they continue around the border. The
/// elastic energy ½ Σ p u includes the energy of the stated mean compliance. Plastic work is the hardness times the
/// displaced volume. Two theories give contact fractions for comparison, from the rms gradient h' by forward
/// differences and the mean pressure p: Persson's, erf(√2 p/(E* h')) without a hardness, and Bush, Gibson and Thomas's,
/// √(2π) p/(E* h'), for light elastic contact.
#[derive(Debug, Args)]
pub(crate) struct Contact {
    /// Measured or generated heights, in any format that `asperity formats` lists; the content decides the format.
    file: PathBuf,
    #[command(flatten)]
    options: ScanOptions,
    #[command(flatten)]
    level: LevelOption,
    /// Young's modulus of the surface.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true)]
    youngs_modulus: Pressure,
    /// Poisson's ratio of the surface.
    #[arg(long, value_name = "X", default_value_t = Elastic::POISSON_RATIO, value_parser = args::of_input("material.poisson_ratio"),
          allow_hyphen_values = true)]
    poisson_ratio: f64,
    #[command(flatten)]
    layering: Layering,
    /// Continuation of the surface beyond the edge of the map.
    #[arg(long, value_parser = args::named::<BoundaryKind>())]
    boundary: BoundaryKind,
    /// Displacement of the mean plane per mean pressure of a periodic surface. When left out: if the position of the
    /// flat is prescribed, max(L)/(πE*), or the compliance of the longest wave on a layer; otherwise 0, so that
    /// displacements have mean zero. A layer on a rigid base has its own.
    #[arg(long, value_name = "Q", value_parser = args::non_negative_quantity::<Compliance>, allow_hyphen_values = true)]
    mean_compliance: Option<Compliance>,
    #[command(flatten)]
    counterface: Counterface,
    #[command(flatten)]
    press: Press,
    /// Upper bound of the pressure; the contact is elastic when left out.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true)]
    hardness: Option<Pressure>,
    /// Also compute the state after unloading: the work of plastic flow and the residual heights; --out then writes
    /// residual_height_m.
    #[arg(long, requires = "hardness")]
    unload: bool,
    /// Bound on the relative residuals, below 1.
    #[arg(long, value_name = "X", value_parser = args::tolerance, allow_hyphen_values = true)]
    tolerance: Option<f64>,
    /// Also compute the contact stiffness: load per approach as the surfaces are pressed further. On a periodic map it
    /// is the stiffness of the mean planes, without the mean compliance; infinite (null) in complete contact.
    #[arg(long)]
    stiffness: bool,
    /// Write the fields to a NumPy archive, or to a VTK image for ParaView if the name ends in .vti: pressure_pa,
    /// displacement_m, gap_m, plastic_displacement_m, clusters (numbered from 1; 0 out of contact), and with --unload
    /// residual_height_m.
    #[arg(long, value_name = "F.npz|F.vti")]
    out: Option<PathBuf>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// Prescribed load or position: exactly one of these.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct Press {
    /// Depth of the flat below the highest point.
    #[arg(long, value_name = "Q", value_parser = args::non_negative_quantity::<Length>, allow_hyphen_values = true)]
    penetration: Option<Length>,
    /// Percentage of the undeformed heights above the flat.
    #[arg(long, value_name = "X", value_parser = args::percent, allow_hyphen_values = true)]
    percentile: Option<f64>,
    /// Mean pressure over the whole map.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true)]
    mean_pressure: Option<Pressure>,
    /// Total force on the map.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Force>, allow_hyphen_values = true)]
    load: Option<Force>,
    /// Mean gap over the whole map.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    mean_gap: Option<Length>,
}

impl Press {
    fn control(&self) -> Result<Control, Failure> {
        let given = [
            self.penetration.map(|q| Control::Penetration { metre: q.0 }),
            self.percentile.map(|percent| Control::Percentile { percent }),
            self.mean_pressure.map(|q| Control::MeanPressure { pascal: q.0 }),
            self.load.map(|q| Control::Load { newton: q.0 }),
            self.mean_gap.map(|q| Control::MeanGap { metre: q.0 }),
        ];
        given.into_iter().flatten().next().ok_or_else(|| Failure::usage("state a load, pressure, depth or mean gap"))
    }
}

impl Contact {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let control = self.press.control()?;
        if let Some(out) = &self.out {
            let inputs: Vec<&Path> = std::iter::once(self.file.as_path()).chain(self.counterface.file()).collect();
            check_target("--out", out, &inputs)?;
        }
        let scan = input::scan(&self.file, &self.options, monitor)?;
        let source = input::source(&scan);
        let map = input::height_map(scan, &self.file)?;
        require_memory(memory_bytes(map.grid().points(), self.boundary), "the contact problem")?;
        if let Some(out) = &self.out {
            let bytes = if is_image(out) { IMAGE_BYTES } else { ARCHIVE_BYTES };
            require_disk(bytes * map.grid().points() as f64, out, "writing the fields")?;
        }
        let map = self.level.remove(map, &self.file, monitor)?;
        let map = self.counterface.composite_with(map, &self.options, self.level, monitor)?;
        let substrate = self.substrate()?;
        let boundary = self.boundary(map.grid(), &substrate, control)?;
        let hardness_pa = self.hardness.map(|q| q.0);
        for warning in implausible_material(self.youngs_modulus.0, self.poisson_ratio, hardness_pa, None) {
            monitor.warn(&warning);
        }
        if let Some(warning) = self.layering.warning(unloading::span(map.heights_m())) {
            monitor.warn(&warning);
        }
        let failed = |e: ContactError| self.contact_failure(&e);
        let half_space = HalfSpace::with_substrate(substrate, map.grid(), boundary).map_err(failed)?;
        let problem = ContactProblem::new(&half_space, map.heights_m(), control, hardness_pa).map_err(failed)?;
        let mut solver = Solver::default();
        if let Some(tolerance) = self.tolerance {
            solver.tolerance = tolerance;
        }
        let solution = monitor.killable(|| solver.solve(&problem))?.map_err(failed)?;
        let unloaded = self.unload.then(|| Unloaded::new(&solution, map.heights_m()));
        let clusters = solution.clusters(Neighbours::Edges);
        let stiffness = || StiffnessSolver::default().solve(&half_space, &solution);
        let stiffness = monitor.killable(|| self.stiffness.then(stiffness).transpose())?.map_err(failed)?;
        if let Some(out) = &self.out {
            let (gap_m, plastic_m) = (solution.gap_m(), solution.plastic_displacement_m());
            let clusters = clusters.labels().mapv(f64::from);
            let mut fields = vec![
                ("pressure_pa", solution.pressure_pa()),
                ("displacement_m", solution.displacement_m()),
                ("gap_m", &gap_m),
                ("plastic_displacement_m", &plastic_m),
                ("clusters", &clusters),
            ];
            if let Some(Some(unloaded)) = &unloaded {
                fields.push(("residual_height_m", &unloaded.residual_height_m));
            }
            write_fields(out, map.grid(), &fields)?;
        }
        let mut answer = Answer::new(&ContactNumbers::new(&problem, &solution, &clusters, stiffness))?;
        if let Some(unloaded) = &unloaded {
            answer = Unloaded::add_to(unloaded.as_ref(), answer);
        }
        if self.json {
            answer = answer.and(source);
        }
        answer.print(self.json)?;
        let why = match solution.stop_reason() {
            SolverStop::Converged => return check_stiffness(stiffness),
            SolverStop::PrecisionLimit => "limit of double precision",
            SolverStop::IterationLimit => "iteration limit",
            SolverStop::Cancelled => "cancelled",
        };
        Err(Failure::new(
            Kind::NotConverged,
            format!(
                "not converged after {} iterations ({why}): residual {:.1e}, tolerance {:.1e}",
                solution.iterations(),
                solution.residual().worst(),
                solver.tolerance
            ),
        ))
    }

    /// Returns the elastic body under the composite roughness.
    fn substrate(&self) -> Result<Substrate, Failure> {
        let surface = Elastic::new(self.youngs_modulus.0, self.poisson_ratio).map_err(Failure::usage)?;
        match self.layering.layer(surface)? {
            Some(_) if self.counterface.is_elastic() => Err(Failure::usage(
                "a layer is pressed against a rigid counterface; remove --counterface-youngs-modulus",
            )),
            Some(layer) => Ok(Substrate::Layer(layer)),
            None => Ok(Substrate::HalfSpace { modulus_pa: self.counterface.contact_modulus_pa(surface)? }),
        }
    }

    fn boundary(&self, grid: Grid, substrate: &Substrate, control: Control) -> Result<Boundary, Failure> {
        match (self.boundary, self.mean_compliance) {
            (BoundaryKind::Free, None) => Ok(Boundary::Free),
            (BoundaryKind::Free, Some(_)) => {
                Err(Failure::usage("--mean-compliance requires --boundary periodic; a free surface has its own"))
            }
            (BoundaryKind::Periodic, Some(_)) if substrate.mean_compliance_m_per_pa().is_some() => {
                Err(Failure::usage("--mean-compliance does not apply to a layer on a rigid base, which has its own"))
            }
            (BoundaryKind::Periodic, None)
                if control.prescribes_plane() && substrate.mean_compliance_m_per_pa() == Some(0.0) =>
            {
                Err(Failure::usage(
                    "an incompressible layer bonded to a rigid base has zero mean compliance, so a periodic one cannot be \
                     pressed by a stated distance; prescribe the mean pressure, the load or the mean gap",
                ))
            }
            (BoundaryKind::Periodic, given) => Ok(substrate.periodic(grid, control, given.map(|given| given.0))),
        }
    }

    /// Converts an error of the contact stage: unusable data if the map cannot be pressed, otherwise wrong flags.
    fn contact_failure(&self, error: &ContactError) -> Failure {
        match error {
            ContactError::Flat | ContactError::Missing { .. } => {
                Failure::data(self.counterface.names_with(&self.file), error)
            }
            _ => Failure::usage(error),
        }
    }
}

/// Returns whether the name of a file is that of a VTK image.
fn is_image(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.and_then(Format::from_extension) == Some(Format::Vtk)
}

/// Writes fields on one grid, and replaces an existing file.
fn write_fields(path: &Path, grid: Grid, fields: &[(&str, &Array2<f64>)]) -> Result<(), Failure> {
    let bytes = if is_image(path) {
        write_vtk_fields((grid.dx_m(), grid.dy_m()), fields)
            .map_err(|error| Failure::new(Kind::Runtime, error.to_string()))?
    } else {
        let arrays = fields.iter().map(|(name, values)| (*name, write_npy(&Scan::new((*values).clone(), None))));
        write_npz(&arrays.collect::<Vec<_>>()).map_err(|error| Failure::new(Kind::Runtime, error.to_string()))?
    };
    replace_file(path, |file| file.write_all(&bytes))
}

/// Fails if the stiffness was computed and did not converge.
fn check_stiffness(stiffness: Option<ContactStiffness>) -> Result<(), Failure> {
    match stiffness {
        Some(stiffness) if !stiffness.converged => Err(Failure::new(
            Kind::NotConverged,
            format!(
                "the contact stiffness did not converge in {} iterations: residual {:.1e}",
                stiffness.iterations, stiffness.residual
            ),
        )),
        _ => Ok(()),
    }
}

//! Flags of the machine.

use std::path::{Path, PathBuf};

use asperity::friction::measured::ColumnTable;
use asperity::study::{implausible_damping, implausible_friction};
use asperity::vibration::law::{Exponential, Linear, Stribeck};
use asperity::vibration::{Forcing, FrictionTable, MotionKind, Oscillator, Parameters, VelocityLaw};
use asperity_formats::read_limited;
use clap::Args;

use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;

/// Friction law, belt and forcing.
#[derive(Debug, Args)]
pub(super) struct Machine {
    #[command(flatten)]
    pub(super) friction: Friction,
    /// Dimensionless belt velocity V = v_b·mω₀/N.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    belt_velocity: f64,
    /// Amplitude q = Q/N of a harmonic force.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true,
          requires = "forcing_frequency")]
    pub(super) forcing: Option<f64>,
    /// Frequency η = Ω/ω₀ of the harmonic force.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true, requires = "forcing")]
    forcing_frequency: Option<f64>,
}

/// Stick limit, and friction in sliding.
#[derive(Debug, Args)]
pub(super) struct Friction {
    /// Static friction coefficient, the stick limit.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    pub(super) static_friction: f64,
    /// Kinetic friction coefficient at vanishing velocity; the static coefficient when left out.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true)]
    kinetic_friction: Option<f64>,
    #[command(flatten)]
    law: Law,
    /// Friction coefficient at high velocity, for the exponential law.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true,
          requires = "stribeck_velocity", conflicts_with_all = ["stribeck", "linear_weakening", "friction_table"])]
    high_speed_friction: Option<f64>,
}

/// Dependence of friction on the velocity: exactly one of these.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct Law {
    /// Weakening a of the kinetic law μ_k/(1 + a|v|), per unit of dimensionless velocity; 0 is Coulomb's law.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true)]
    stribeck: Option<f64>,
    /// Slope b of the linear law μ_k − b|v|.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true)]
    linear_weakening: Option<f64>,
    /// Velocity v₀ of the exponential law μ_∞ + (μ_k − μ_∞)e^{−|v|/v₀}; `--high-speed-friction` is μ_∞.
    #[arg(long, value_name = "X", value_parser = args::positive, allow_hyphen_values = true,
          requires = "high_speed_friction")]
    stribeck_velocity: Option<f64>,
    /// Table of two columns, velocity from 0 upwards and friction coefficient, interpolated by monotone cubics.
    #[arg(long, value_name = "FILE", conflicts_with = "kinetic_friction")]
    friction_table: Option<PathBuf>,
}

impl Machine {
    /// Returns the oscillator; warns about implausible values.
    pub(super) fn oscillator(&self, damping_ratio: f64, monitor: &Terminal) -> Result<Oscillator, Failure> {
        let parameters = Parameters {
            static_friction: self.friction.static_friction,
            law: self.friction.law()?,
            damping_ratio,
            belt_velocity: self.belt_velocity,
            forcing: self
                .forcing
                .zip(self.forcing_frequency)
                .map(|(amplitude, frequency)| Forcing { amplitude, frequency }),
        };
        let oscillator = Oscillator::new(parameters).map_err(Failure::usage)?;
        let warnings = [implausible_friction(self.friction.static_friction), implausible_damping(damping_ratio)];
        warnings.iter().flatten().for_each(|warning| monitor.warn(warning));
        Ok(oscillator)
    }
}

impl Friction {
    /// Returns the input files.
    pub(super) fn inputs(&self) -> Vec<&Path> {
        self.law.friction_table.as_deref().into_iter().collect()
    }

    pub(super) fn law(&self) -> Result<VelocityLaw, Failure> {
        let kinetic = self.kinetic_friction.unwrap_or(self.static_friction);
        let Law { stribeck, linear_weakening, stribeck_velocity, friction_table } = &self.law;
        if let Some(path) = friction_table {
            let points = table(path)?;
            let table = FrictionTable::new(&points).map_err(|e| Failure::data(path.display(), &e))?;
            return Ok(table.into());
        }
        if let Some(slope) = *linear_weakening {
            return Ok(Linear { kinetic, slope }.into());
        }
        if let Some((stribeck_velocity, high_speed)) = stribeck_velocity.zip(self.high_speed_friction) {
            return Ok(Exponential { kinetic, high_speed, stribeck_velocity }.into());
        }
        Ok(Stribeck { kinetic, decay: stribeck.unwrap_or(0.0) }.into())
    }
}

/// Reads the points of a friction law: a table of two columns.
fn table(path: &Path) -> Result<Vec<[f64; 2]>, Failure> {
    let bytes = read_limited(path).map_err(|e| Failure::io(Kind::Data, path.display(), &e))?;
    let points = |table: ColumnTable| {
        let (velocities, coefficients) = (table.values(0)?, table.values(1)?);
        Ok(velocities.iter().zip(coefficients).map(|(v, mu)| [*v, *mu]).collect())
    };
    match ColumnTable::read(&bytes) {
        Ok(table) if table.names().len() != 2 => {
            let message = format!("{}: expected two columns, a velocity and a friction coefficient", path.display());
            Err(Failure::new(Kind::Data, message))
        }
        table => table.and_then(points).map_err(|e| Failure::data(path.display(), &e)),
    }
}

/// Damping of the oscillator.
#[derive(Debug, Args)]
pub(super) struct Damping {
    /// Damping ratio ζ.
    #[arg(long, value_name = "X", value_parser = args::non_negative, allow_hyphen_values = true)]
    pub(super) damping_ratio: f64,
}

/// Returns the number that denotes a kind of motion in tables.
pub(super) fn code(kind: MotionKind) -> f64 {
    match kind {
        MotionKind::None | MotionKind::Flutter | MotionKind::Divergence => 0.0,
        MotionKind::SlipCycle => 1.0,
        MotionKind::StickSlip => 2.0,
        MotionKind::Overtaking => 3.0,
    }
}

//! Columns of the tables of curves, for the stages that write them and the figures that draw them.

use std::borrow::Cow;

use crate::Table;

/// Declares tables by their columns.
macro_rules! curves {
    ($($(#[$doc:meta])* $name:ident { $($column:ident),+ $(,)? })+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Default, PartialEq)]
        pub struct $name<'a> {
            $(#[doc = concat!("Column `", stringify!($column), "`.")] pub $column: Cow<'a, [f64]>,)+
        }

        impl<'a> $name<'a> {
            /// Reads a table. A column is empty if it is absent or has no number.
            pub fn of(table: &'a Table) -> Self {
                Self { $($column: table.defined_column(stringify!($column)).unwrap_or_default().into()),+ }
            }
        }

        impl From<$name<'_>> for Table {
            /// Returns the columns in the order of their declaration, without empty ones beside others.
            fn from(curves: $name<'_>) -> Self {
                let columns = [$((stringify!($column), curves.$column.into_owned())),+];
                let has_rows = columns.iter().any(|(_, values)| !values.is_empty());
                Self::new(columns.into_iter().filter(|(_, values)| !(has_rows && values.is_empty())))
            }
        }
    )+};
}

curves! {
    /// Structure functions of heights along x and y with fitted power laws.
    StructureFunctions { lag_m, structure_x_m2, structure_y_m2, fit_x_m2, fit_y_m2 }
    /// Autocorrelation of heights along x and y with its 95 % limits, and that of the model.
    HeightCorrelation { lag_m, acf_x, acf_y, acf_x_low, acf_x_high, acf_y_low, acf_y_high, fit_x, fit_y }
    /// Load over the depth of the plane, from the shallowest level; `low` and `high` are the 95 % interval of the pressure.
    LoadCurve { penetration_m, mean_pressure_pa, low, high, contact_fraction }
    /// Power spectral density of friction with its 95 % limits, of the window alone, and of the process seen through the window.
    FrictionSpectrum { frequency_per_m, density_m, density_m_low, density_m_high, window_only_m, windowed_fit_m }
    /// Correlation of the contact area of a window with the load of the window at a lag.
    AreaAndLoad { lag_m, correlation }
    /// Friction through windows of several lengths; `own_length` is the correlation length without the window.
    FrictionWindows { window_m, std, expected_std, correlation_length_m, own_length_m, own_length_low_m, own_length_high_m }
    /// Histogram of displacements with the normal density of equal mean and standard deviation.
    DisplacementHistogram { displacement, density, normal_density }
    /// Fraction of the trajectories that have never left vibration, with its 95 % interval.
    Survival { tau, share, share_low, share_high }
    /// Motion in the phase plane.
    Portrait { tau, displacement, velocity }
    /// Motions in the phase plane, numbered.
    PhaseCloud { trajectory, tau, displacement, velocity }
    /// Attractor that a motion reaches from a point of the phase plane.
    AttractorMap { displacement, velocity, attractor }
    /// Power spectral density of the velocity with its 95 % limits.
    SoundSpectrum { frequency, density, density_low, density_high }
    /// Growth rates and frequencies of two modes over the friction coefficient.
    ModesOverFriction { friction, growth_1, frequency_1, growth_2, frequency_2 }
    /// Motion of a mass with two modes, along and across the belt, with its state of contact.
    CoupledPortrait { tau, tangential, tangential_velocity, normal, normal_velocity, contact }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_as_they_were_written_without_absent_columns() {
        let written =
            LoadCurve { penetration_m: vec![1.0, 2.0].into(), low: vec![f64::NAN, 0.5].into(), ..LoadCurve::default() };
        let table = Table::from(written);
        assert_eq!(table.columns().iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["penetration_m", "low"]);
        let read = LoadCurve::of(&table);
        assert_eq!((&*read.penetration_m, read.low.len(), read.high.len()), (&[1.0, 2.0][..], 2, 0));
        assert_eq!(Table::from(Survival::default()).columns().len(), 4);
    }
}

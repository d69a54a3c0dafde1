//! Cycles of stick-slip.

use asperity::vibration::{Oscillator, limit_cycle};
use asperity_testing::LEINE;

use crate::{Result, error, table};

pub(crate) fn leine() -> Result<String> {
    let regime = limit_cycle(&Oscillator::with_stribeck(1.0, 3.0, 0.0, 0.2)?)?;
    let cycle = regime.cycle().ok_or("no cycle")?;
    let reattachment = cycle.reattachment_displacement.ok_or("no re-attachment")?;
    let found = [cycle.period, cycle.slip_duration, reattachment, cycle.displacement_max, cycle.velocity_min];
    let rows = found.into_iter().zip(LEINE).map(|(found, (name, wanted, digit))| {
        vec![name.to_owned(), format!("{wanted}"), format!("{found:.9}"), error(found - wanted), error(0.5 * digit)]
    });
    let headers = ["", "published", "asperity", "difference", "half a unit of the last digit"];
    Ok(format!(
        "## Leine's oscillator\n\nMass on a belt with μ = 1/(1 + 3|v|), without damping, V = 0.2 (Leine, van Campen, de Kraker & van den Steen, *Nonlinear \
         Dynamics* 16 (1998) 41), in units of the machine. Differences are absolute.\n\n{}",
        table(&headers, rows)
    ))
}

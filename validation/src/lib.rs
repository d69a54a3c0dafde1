//! Pressure methods that the comparison in `docs/validation/pressure.md` needs and the product does not offer.

pub mod methods;

//! Parts of the validation programs that tests use too, and the pressure methods that only `docs/validation/pressure.md` compares.

pub mod brake_disc;
pub mod contact;
pub mod methods;

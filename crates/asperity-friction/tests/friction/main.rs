//! Windows, strips and statistics of friction.

#![expect(clippy::unwrap_used, reason = "a test that cannot pose its problem has failed")]

mod stiffness;
mod strips;
mod tracks;
mod two_bodies;
mod windows;

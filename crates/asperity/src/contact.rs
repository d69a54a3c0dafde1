//! Frictionless contact of a rough half-space with a rigid flat (paper §2.3, eq. 3–7).

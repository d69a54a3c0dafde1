//! Sampling, Hermite expansions and distances of laws. Knows no tribology.

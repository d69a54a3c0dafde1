//! The command line of asperity.

fn main() {}

//! Copies the list of the versions of all libraries, so that the program can state its hash.

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let own = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let lock = own.ancestors().map(|folder| folder.join("Cargo.lock")).find(|file| file.is_file());
    let copy = Path::new(&env::var_os("OUT_DIR").unwrap_or_default()).join("Cargo.lock");
    println!("cargo::rerun-if-changed=build.rs");
    match lock {
        Some(lock) => {
            println!("cargo::rerun-if-changed={}", lock.display());
            fs::copy(lock, copy).map(|_| ())
        }
        None => fs::write(copy, ""),
    }
}

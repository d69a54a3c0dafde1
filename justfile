# Recipes of the house. `just check` is what CI runs; .ci/requirements.txt lists the tools it needs.

# Tools that .ci/run installed come first.
export PATH := justfile_directory() / ".venv" / "bin" + ":" + env("PATH")

# List the recipes.
default:
    @just --list

# Everything CI checks.
check: test slow lint

# The quick tests, documentation examples included.
test:
    cargo test --workspace

# The tests that count statistics or follow many machines, above two seconds each.
slow:
    cargo test --workspace --tests -- --ignored

# Damages small files of every surface format, COUNT times each, and reads them: about a minute.
damage COUNT="150000":
    ASPERITY_MUTATIONS={{COUNT}} cargo test -p asperity-formats --test formats damaged_files

# Coverage-guided fuzzing of every reader, SECONDS each for some thirty targets: installs cargo-fuzz; needs a C++ compiler. docs/reliability.md
# states a long run.
fuzz SECONDS="20":
    cargo install --quiet --root target/tools --locked cargo-fuzz --version 0.13.2
    PATH="$PWD/target/tools/bin:$PATH" scripts/fuzz {{SECONDS}}

# Random studies through the program: CHECKS through `asperity check`, RUNS small ones through `asperity run`, some seven seconds each.
wild CHECKS="100000" RUNS="1000":
    cargo build --release
    scripts/wild-studies target/wild --checks {{CHECKS}} --runs {{RUNS}}

# Mutation testing of the numerical core: COUNT changed expressions, each with the tests of its crate; some two hours for 400. Installs
# cargo-mutants.
mutants COUNT="400":
    cargo install --quiet --root target/tools --locked cargo-mutants --version 27.1.0
    PATH="$PWD/target/tools/bin:$PATH" scripts/mutants target/mutants --count {{COUNT}}

# The quick unit tests of the crates below the study on the processors TARGETS: 32-bit x86, WebAssembly and emulated 64-bit ARM, which need
# Debian's gcc-multilib, Node.js, and gcc-aarch64-linux-gnu with qemu-user.
portable *TARGETS="wasm":
    scripts/test-portable {{TARGETS}}

# Follows random stick-slip machines for COUNT cycles and checks every step against the laws of motion: some twenty minutes.
fuzz-vibration COUNT="1000000":
    ASPERITY_CYCLES={{COUNT}} cargo test --release -p asperity-vibration --lib of_random_machines -- --nocapture

# Writes docs/validation: solves 1,000 contact problems and checks each answer, compares distributions of the pressure with references, and
# counts how often the intervals of each kind contain the true value. Takes about an hour.
validate:
    cargo run --release -p asperity-validation --bin validate_closed_forms > docs/validation/closed-forms.md
    cargo run --release -p asperity-validation --bin validate_contact -- docs
    cargo run --release -p asperity-validation --bin validate_pressure > docs/validation/pressure.md
    cargo run --release -p asperity-validation --bin validate_friction > docs/validation/friction.md
    cargo run --release -p asperity-validation --bin validate_verdict > docs/validation/verdict.md
    scripts/count-coverage

# The Python package: builds its wheel with PROFILE and installs it into the environment; stubs and results are current; tests,
# examples, types, style. `dev` builds faster for the next change, and computes more slowly.
python PROFILE="release":
    rm -rf target/wheel
    maturin build --quiet --locked --profile {{PROFILE}} --out target/wheel
    python -m pip install --quiet --force-reinstall --no-deps target/wheel/*.whl
    maturin generate-stubs --quiet --profile {{PROFILE}} --out target/stubs
    diff python/asperity/_core.pyi target/stubs/asperity/_core.pyi
    python scripts/generate_python_results.py --check
    pytest --quiet python/tests
    pytest --quiet --pyargs asperity
    mypy python/asperity python/tests/client.py
    ruff check --quiet python scripts/generate_python_results.py scripts/build-gallery scripts/build-book scripts/book-links scripts/check-docs scripts/list-api scripts/fuzz scripts/wild-studies scripts/mutants scripts/count-coverage
    ruff format --check --quiet python scripts/generate_python_results.py scripts/build-gallery scripts/build-book scripts/book-links scripts/check-docs scripts/list-api scripts/fuzz scripts/wild-studies scripts/mutants scripts/count-coverage

# The notebooks of the gallery: executes them with the installed package and compares their text with docs/gallery.
gallery:
    scripts/build-gallery --check

# The scripts of the reports, and the explorer in one file, web/dist/explorer.html: installs the tools, builds, checks types,
# and tests the explorer and reports of every kind in Chromium with the program `asperity`.
web:
    rustup target add wasm32-unknown-unknown
    cargo install --quiet --root target/tools wasm-bindgen-cli --version "$(sed -n 's/^wasm-bindgen = "=\(.*\)"/\1/p' Cargo.toml)"
    npm --prefix web ci --no-audit --no-fund
    npm --prefix web run oscillator
    npm --prefix web run explorer
    npm --prefix web run check
    cargo build
    npm --prefix web test

# The book of docs, target/book: builds it and fails on warnings, broken links and generated pages that are not current; then runs the
# commands of README.md and docs.
book:
    cargo install --quiet --root target/tools --locked --no-default-features --features search mdbook --version 0.5.4
    cargo build
    PATH="$PWD/target/tools/bin:$PATH" scripts/build-book --check
    scripts/check-docs

# Everything but the tests.
lint: fmt clippy doc typos deny

# Formatting, without changing a file.
fmt:
    cargo fmt --all --check

# Lints of the compiler and of clippy, warnings denied.
clippy:
    cargo clippy --workspace --all-targets -- -D warnings

# Documentation of the library, warnings denied.
doc:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# Spelling.
typos:
    typos

# Licences, banned crates and sources of the dependencies (advisories are left out: fetching them needs a network).
deny:
    CARGO="$PWD/.ci/cargo-metadata" cargo-deny --log-level error check bans licenses sources

# Completions of shells and manual pages: written, checked and packed below target.
shell-files:
    scripts/pack-shell-files

# The public interface of the published crates: fails if crates/NAME/api.txt is not current, or if a signature has a type of a crate
# below 1.0. scripts/list-api writes the listings.
api:
    rustup toolchain install --profile minimal "$(sed -n 's/^NIGHTLY = "\(.*\)"/\1/p' scripts/list-api)"
    cargo install --quiet --root target/tools --locked cargo-public-api --version 0.52.0
    PATH="$PWD/target/tools/bin:$PATH" scripts/list-api --check

# The published crates against those of the last tag: fails if a change needs another version.
semver:
    cargo install --quiet --root target/tools --locked cargo-semver-checks
    if tag=$(git describe --tags --abbrev=0 2>/dev/null); then target/tools/bin/cargo-semver-checks semver-checks --baseline-rev "$tag"; else echo "no tag yet"; fi

# The Python package for a release: wheel and source distribution, each installed and used.
wheels:
    scripts/build-wheels

# The published crates, packed as for a registry; each is built from its package alone. Uploads nothing.
package:
    cargo package --workspace --exclude asperity-benchmarks --exclude asperity-py --exclude asperity-testing --exclude asperity-validation --exclude asperity-wasm

# Compiles with the oldest Rust that Cargo.toml states, which rustup installs where it is missing.
oldest:
    rustup toolchain install --profile minimal "$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)"
    cargo +"$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)" check --workspace --locked

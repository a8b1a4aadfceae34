//! Builds for the chip: with rustup's target where it is installed, else with the distribution's compiler and `core` from
//! its sources.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use crate::{Outcome, output};

const TARGET: &str = "thumbv7em-none-eabihf";
const DISTRIBUTION_RUSTC: &str = "/usr/bin/rustc";
const DISTRIBUTION_CARGO: &str = "/usr/bin/cargo";
const ADVICE: &str = "nothing here compiles for the chip; install one of
  rustup target add thumbv7em-none-eabihf
  apt-get install rustc-web cargo-web rust-web-src lld      (Debian 12)";

/// What was built.
pub struct Images {
    /// The image that flies.
    pub flight: PathBuf,
    /// The image that counts.
    pub selftest: PathBuf,
}

/// Root of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}

/// Where cargo builds.
pub fn target() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// Builds both images, with `feature` if one is named.
pub fn build(feature: Option<&str>) -> Outcome<Images> {
    // a directory of its own: two compilers and their features do not share one
    let target = target().join("chip-image");
    let mut cargo = compiler()?;
    cargo
        .current_dir(root())
        .env("CARGO_TARGET_DIR", &target)
        .env("DEFMT_LOG", "info")
        .env("DEFMT_RTT_BUFFER_SIZE", "512");
    cargo.args(["--target", TARGET, "--profile", "chip", "--package", "firmware", "--bins"]);
    cargo.args(feature.map(|feature| format!("--features={feature}")));
    let status = cargo.status().map_err(|error| format!("cargo cannot be run ({error})"))?;
    if !status.success() {
        return Err("the image does not build".into());
    }
    keep(&target.join(TARGET).join("chip"), &target.join(feature.unwrap_or("plain")))
}

/// Copies the images to where the next build leaves them alone.
fn keep(built: &Path, place: &Path) -> Outcome<Images> {
    let copy = |name: &str| {
        let copied = fs::create_dir_all(place).and_then(|()| fs::copy(built.join(name), place.join(name)));
        copied.map(|_| place.join(name)).map_err(|error| format!("{name}: {error}"))
    };
    Ok(Images { flight: copy("flight")?, selftest: copy("selftest")? })
}

fn compiler() -> Outcome<Command> {
    let installed = |rustc: &str| {
        output(Command::new(rustc).args(["--print", "sysroot"])).map(|s| PathBuf::from(s.trim()))
    };
    let current = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    if installed(&current).is_ok_and(|root| root.join("lib/rustlib").join(TARGET).exists()) {
        let mut cargo = Command::new(env::var("CARGO").unwrap_or_else(|_| "cargo".into()));
        cargo.arg("build");
        return Ok(cargo);
    }
    let sources =
        installed(DISTRIBUTION_RUSTC).map_err(|_| ADVICE)?.join("lib/rustlib/src/rust/library/core");
    let linker = Command::new("ld.lld").arg("--version").output();
    if !sources.exists() || linker.is_err() {
        return Err(ADVICE.into());
    }
    let mut cargo = Command::new(DISTRIBUTION_CARGO);
    // `-Z build-std` is not stable, but all that a distribution without the target offers
    cargo
        .args(["build", "-Z", "build-std=core"])
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTC", DISTRIBUTION_RUSTC);
    cargo.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld").env_remove("RUSTUP_TOOLCHAIN");
    Ok(cargo)
}

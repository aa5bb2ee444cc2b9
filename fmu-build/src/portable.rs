//! Binaries for other machines than this one: Linux with an old glibc and Windows, both on x86-64; for FMI 3.0 also Linux on ARM and
//! macOS.
//!
//! Zig contains the linker and the C library for each (PyPI package `ziglang`, started by `cargo-zigbuild`). rustup installs
//! Rust's standard library.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};

use crate::platform::{Platform, Version};
use crate::python::{BUILDING, Environment};
use crate::workspace::Workspace;
use crate::{binary, cargo, exports, progress};

/// Oldest glibc with which the Linux binary loads.
pub const GLIBC: (u32, u32) = (2, 17);

/// A target of the portable build.
struct Target {
    platform: Platform,
    triple: &'static str,
    /// Its name for `cargo zigbuild`.
    zig: &'static str,
}

/// All targets. FMI 2.0 gets the first [`OF_FMI2`].
const TARGETS: [Target; 5] = [
    Target {
        platform: Platform::LINUX64,
        triple: "x86_64-unknown-linux-gnu",
        zig: "x86_64-unknown-linux-gnu.2.17",
    },
    Target {
        platform: Platform::WIN64,
        triple: "x86_64-pc-windows-gnu",
        zig: "x86_64-pc-windows-gnu",
    },
    Target {
        platform: Platform::LINUX_ARM,
        triple: "aarch64-unknown-linux-gnu",
        zig: "aarch64-unknown-linux-gnu.2.17",
    },
    Target {
        platform: Platform::DARWIN_ARM,
        triple: "aarch64-apple-darwin",
        zig: "aarch64-apple-darwin",
    },
    Target {
        platform: Platform::DARWIN64,
        triple: "x86_64-apple-darwin",
        zig: "x86_64-apple-darwin",
    },
];
const OF_FMI2: usize = 2;

/// Compiles the binary for every target whose standard library can be installed, and prints the others.
///
/// # Errors
/// The tools can't be installed, a compilation fails, or a binary doesn't meet its requirements.
pub fn build(workspace: &Workspace, version: Version) -> anyhow::Result<Vec<(Platform, PathBuf)>> {
    let tools = Environment::prepare(workspace, &BUILDING)?;
    let mut binaries = Vec::new();
    let targets = match version {
        Version::Two => &TARGETS[..OF_FMI2],
        Version::Three => &TARGETS[..],
    };
    for target in targets {
        let folder = target.platform.tuple;
        if let Err(why) = ensure_installed(target.triple) {
            eprintln!("  {folder} is left out: {why:#}");
            continue;
        }
        progress::headline(&format!("Compiling the FMU's binary for {folder}"));
        // A library for C alone, optimised as a whole: unused functions are removed, also those of Rust's standard library. So the
        // Windows library doesn't import `bcryptprimitives.dll`, which older compatibility layers lack.
        let mut command = cargo::command_of(workspace, tools.program("cargo-zigbuild"));
        command
            .arg("rustc")
            .args(["--target", target.zig, "--crate-type", "cdylib"])
            .env("PATH", tools.path()?)
            .env("CARGO_PROFILE_RELEASE_LTO", "fat")
            .env("CARGO_ENCODED_RUSTFLAGS", flags(workspace, target)?);
        let library = cargo::build_library_with(&mut command)?;
        check(&library)?;
        binaries.push((target.platform, library));
    }
    ensure!(!binaries.is_empty(), "there is no target to build for");
    Ok(binaries)
}

/// Installs Rust's standard library for a target unless it is there.
fn ensure_installed(triple: &str) -> anyhow::Result<()> {
    let output = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", triple])
        .output()
        .context("can't start rustc")?;
    let folder = String::from_utf8_lossy(&output.stdout);
    if output.status.success() && Path::new(folder.trim()).is_dir() {
        return Ok(());
    }
    let added = Command::new("rustup")
        .args(["target", "add", triple])
        .output()
        .with_context(|| format!("the Rust target {triple} is not installed, and there is no rustup to install it"))?;
    let messages = String::from_utf8_lossy(&added.stderr);
    let last = messages.trim().lines().last().unwrap_or_default().to_owned();
    ensure!(
        added.status.success(),
        "the Rust target {triple} can't be installed: {last}"
    );
    Ok(())
}

/// Compiler flags: those of the environment instead of the workspace's own (which require AVX2), and the removal of this
/// machine's paths from messages, so that the bytes don't depend on the location of the sources.
fn flags(workspace: &Workspace, target: &Target) -> anyhow::Result<OsString> {
    let given = std::env::var("RUSTFLAGS").unwrap_or_default();
    let mut flags: Vec<String> = given.split_whitespace().map(str::to_owned).collect();
    let cargo_home = std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    if let Some(home) = cargo_home {
        flags.push(format!("--remap-path-prefix={}=cargo", home.display()));
    }
    flags.push(format!("--remap-path-prefix={}=pushbelt", workspace.root().display()));
    if target.platform == Platform::WIN64 {
        // `cargo-zigbuild` drops the compiler's list of exports for the linker. Without a list, everything is exported.
        flags.push(format!("-Clink-arg={}", exports::definition(workspace)?.display()));
    }
    Ok(flags.join("\x1f").into())
}

fn check(library: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::read(library).with_context(|| format!("can't read {}", library.display()))?;
    if let Some((major, minor)) = binary::newest_glibc(&bytes)? {
        ensure!(
            (major, minor) <= GLIBC,
            "{} needs glibc {major}.{minor}: it would not load with {}.{}",
            library.display(),
            GLIBC.0,
            GLIBC.1
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_linker_gets_the_oldest_glibc() {
        let (major, minor) = GLIBC;
        for target in TARGETS.iter().filter(|target| target.triple.contains("linux")) {
            assert_eq!(target.zig, format!("{}.{major}.{minor}", target.triple));
        }
    }

    #[test]
    fn fmi_2_gets_the_targets_that_it_has_folders_for() {
        for target in &TARGETS[..OF_FMI2] {
            assert!(target.platform.binary(Version::Two, "Model").is_ok());
        }
    }
}

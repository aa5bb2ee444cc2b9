//! Binaries for other machines than this one: Linux with an old glibc and Windows, both on x86-64;
//! Linux on ARM where it is asked for, and for FMI 3.0 always, with macOS.
//!
//! Zig contains the linker and the C library for each (PyPI package `ziglang`, started by
//! `cargo-zigbuild`). rustup installs Rust's standard library.
//!
//! Linux and Windows on x86-64 get two libraries: one for all processors, and the variant for AVX2
//! that it opens where it can. Cargo compiles the dependencies once for both. For the variant it
//! compiles again what [`WITH_AVX2`](crate::wrapper::WITH_AVX2) lists and what depends on it, with
//! this tool between cargo and the compiler ([`crate::wrapper`]), because flags in the environment
//! would compile everything again.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, ensure};

use crate::commands::side_by_side;
use crate::platform::{Platform, Version};
use crate::python::{BUILDING, Environment};
use crate::workspace::{LIBRARY_PACKAGE, MAP_IDENTIFIER, MAP_PACKAGE, MODEL_IDENTIFIER, Workspace};
use crate::wrapper::AS_COMPILER;
use crate::{binary, cargo, exports, hash, progress};

/// Oldest glibc with which the Linux binary loads.
pub const GLIBC: (u32, u32) = (2, 17);

/// A compiled library, and its name in the FMU.
pub struct Binary {
    pub platform: Platform,
    /// Name without extension.
    pub name: String,
    pub path: PathBuf,
}

/// What is built for each target.
pub struct Product {
    package: &'static str,
    identifier: &'static str,
    /// Whether it exports functions beyond the standard, and has a variant for AVX2.
    is_model: bool,
}

/// The library in `PushbeltVariator.fmu`.
pub const MODEL: Product = Product {
    package: LIBRARY_PACKAGE,
    identifier: MODEL_IDENTIFIER,
    is_model: true,
};
/// The library in `PushbeltMap.fmu`.
pub const MAP: Product = Product {
    package: MAP_PACKAGE,
    identifier: MAP_IDENTIFIER,
    is_model: false,
};

/// A target of the portable build.
struct Target {
    platform: Platform,
    triple: &'static str,
    /// Its name for `cargo zigbuild`.
    zig: &'static str,
    /// Whether there is a variant for AVX2.
    has_variant: bool,
}

/// All targets. FMI 2.0 gets the first [`OF_FMI2`]: each costs more than a minute, and few need the
/// next one.
const TARGETS: [Target; 5] = [
    Target {
        platform: Platform::LINUX64,
        triple: "x86_64-unknown-linux-gnu",
        zig: "x86_64-unknown-linux-gnu.2.17",
        has_variant: true,
    },
    Target {
        platform: Platform::WIN64,
        triple: "x86_64-pc-windows-gnu",
        zig: "x86_64-pc-windows-gnu",
        has_variant: true,
    },
    Target {
        platform: Platform::LINUX_ARM,
        triple: "aarch64-unknown-linux-gnu",
        zig: "aarch64-unknown-linux-gnu.2.17",
        has_variant: false,
    },
    Target {
        platform: Platform::DARWIN_ARM,
        triple: "aarch64-apple-darwin",
        zig: "aarch64-apple-darwin",
        has_variant: false,
    },
    Target {
        platform: Platform::DARWIN64,
        triple: "x86_64-apple-darwin",
        zig: "x86_64-apple-darwin",
        has_variant: false,
    },
];
const OF_FMI2: usize = 2;
/// The same with Linux on ARM.
const WITH_ARM: usize = 3;

/// Suffix of the variant's name.
const VARIANT: &str = "-avx2";

/// A setting without effect on the first of [`WITH_AVX2`](crate::wrapper::WITH_AVX2), which is one
/// small unit in any case. By it cargo keeps the compiled crates of the variant apart.
const APART: &str = "profile.release.package.safe_arch.codegen-units=2";

/// Compiles the libraries for every target whose standard library can be installed, and prints the
/// others. Libraries of the same sources are not compiled again.
///
/// # Errors
/// The tools can't be installed, a compilation fails, or a library doesn't meet its requirements;
/// one for `arm` can't be built.
pub fn build(
    workspace: &Workspace,
    product: &Product,
    version: Version,
    arm: bool,
) -> anyhow::Result<Vec<Binary>> {
    let tools = Environment::prepare(workspace, &BUILDING)?;
    let build = identity(workspace)?;
    let folder = workspace.target().join("portable");
    remove_others(&folder, &build)?;
    let (first, others) = match version {
        Version::Two if arm => &TARGETS[..WITH_ARM],
        Version::Two => &TARGETS[..OF_FMI2],
        Version::Three => &TARGETS[..],
    }
    .split_at(1);
    // The model is one unit of compilation, so a target takes one core. Cargo locks its folder, so
    // the second one has a folder of its own.
    let compile = |targets, cargo| {
        let place = Place {
            libraries: &folder.join(&build),
            cargo,
        };
        libraries(workspace, &tools, product, targets, &place)
    };
    let (mut binaries, others) = side_by_side(
        || compile(first, workspace.target().to_owned()),
        || compile(others, workspace.target().join("portable-cargo")),
    )?;
    binaries.extend(others);
    ensure!(!binaries.is_empty(), "there is no target to build for");
    let has_arm = binaries.iter().any(|one| one.platform == Platform::LINUX_ARM);
    ensure!(has_arm || !arm, "there is no library for Linux on ARM");
    Ok(binaries)
}

/// Where libraries are kept, and where cargo compiles them.
struct Place<'a> {
    libraries: &'a Path,
    cargo: PathBuf,
}

/// Compiles the libraries of targets, one after the other.
fn libraries(
    workspace: &Workspace,
    tools: &Environment,
    product: &Product,
    targets: &[Target],
    place: &Place<'_>,
) -> anyhow::Result<Vec<Binary>> {
    let mut binaries = Vec::new();
    for target in targets {
        let tuple = target.platform.tuple;
        if let Err(why) = ensure_installed(target.triple) {
            eprintln!("  {tuple} is left out: {why:#}");
            continue;
        }
        // The variant first: the other library contains its hash.
        let mut variant = None;
        for is_variant in [true, false] {
            if is_variant && !(product.is_model && target.has_variant) {
                continue;
            }
            let suffix = if is_variant { VARIANT } else { "" };
            let name = format!("{}{suffix}", product.identifier);
            let path = place.libraries.join(tuple).join(&name);
            let path = path.with_extension(target.platform.extension);
            if !path.is_file() {
                progress::headline(&format!("Compiling {name} for {tuple}"));
                let variant = variant.as_deref();
                let library = compile(workspace, tools, product, target, &place.cargo, is_variant, variant)?;
                keep(&library, &path)?;
            }
            if is_variant {
                let bytes = fs::read(&path).with_context(|| format!("can't read {}", path.display()))?;
                variant = Some(hash::of_file(&bytes));
            }
            let platform = target.platform;
            binaries.push(Binary { platform, name, path });
        }
    }
    Ok(binaries)
}

/// Compiles a library, or a variant, and returns its path in cargo's `folder`, where the next one
/// replaces it. `variant` is the hash of the library's variant.
fn compile(
    workspace: &Workspace,
    tools: &Environment,
    product: &Product,
    target: &Target,
    folder: &Path,
    is_variant: bool,
    variant: Option<&str>,
) -> anyhow::Result<PathBuf> {
    // A library and its variant have the same path there, and cargo could take one for the other.
    let name = product.package.replace('-', "_");
    for file in [
        format!("lib{name}.so"),
        format!("{name}.dll"),
        format!("lib{name}.dylib"),
    ] {
        let path = folder.join(target.triple).join("release/deps").join(file);
        if path.exists() {
            fs::remove_file(&path).with_context(|| format!("can't remove {}", path.display()))?;
        }
    }
    // Elsewhere than on Linux, linkers keep unused functions of Rust's standard library. Then the
    // Windows library would import `bcryptprimitives.dll`, which older compatibility layers lack.
    // Optimised as a whole, the library has no unused functions.
    let is_linux = target.platform.extension == "so";
    let mut command = cargo::command_of(workspace, tools.program("cargo-zigbuild"));
    command
        .arg("rustc")
        .args(["--target", target.zig, "--crate-type", "cdylib"])
        .env("CARGO_TARGET_DIR", folder)
        .env("PATH", tools.path()?)
        .env_remove("PUSHBELT_VARIANT")
        .envs(variant.map(|hash| ("PUSHBELT_VARIANT", hash)))
        .env("CARGO_PROFILE_RELEASE_LTO", if is_linux { "off" } else { "fat" })
        .env("CARGO_ENCODED_RUSTFLAGS", flags(workspace, product, target)?);
    if is_variant {
        let tool = std::env::current_exe().context("the path of this tool is unknown")?;
        command
            .args(["--config", APART])
            .env(AS_COMPILER, std::env::var_os("RUSTC_WRAPPER").unwrap_or_default())
            .env("RUSTC_WRAPPER", tool);
    }
    let library = cargo::build_library_with(&mut command, product.package)?;
    check(&library)?;
    Ok(library)
}

/// Copies a library to where it is kept. A draft is renamed, so that no incomplete file is kept.
fn keep(library: &Path, path: &Path) -> anyhow::Result<()> {
    let mut bytes = fs::read(library).with_context(|| format!("can't read {}", library.display()))?;
    binary::clear_time_stamp(&mut bytes);
    let draft = path.with_extension("part");
    path.parent()
        .map_or(Ok(()), fs::create_dir_all)
        .and_then(|()| fs::write(&draft, bytes))
        .and_then(|()| fs::rename(&draft, path))
        .with_context(|| format!("can't write {}", path.display()))
}

/// Removes the libraries of other sources.
fn remove_others(folder: &Path, build: &str) -> anyhow::Result<()> {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let entry = entry?;
        if entry.file_name() != build {
            fs::remove_dir_all(entry.path())
                .with_context(|| format!("can't remove {}", entry.path().display()))?;
        }
    }
    Ok(())
}

/// What identifies a build: a hash of everything that its libraries are compiled from.
fn identity(workspace: &Workspace) -> anyhow::Result<String> {
    let mut hash = DefaultHasher::new();
    (include_str!("portable.rs"), include_str!("wrapper.rs")).hash(&mut hash);
    let compiler = Command::new("rustc").arg("-vV").output().context("can't start rustc")?;
    compiler.stdout.hash(&mut hash);
    std::env::var_os("RUSTFLAGS").hash(&mut hash);
    let mut files = Vec::new();
    for place in [
        "Cargo.lock",
        "Cargo.toml",
        "crates",
        "library",
        "map-unit",
        "src",
        "python/portable-requirements.txt",
        "fmu-build/exports.def",
    ] {
        collect(&workspace.root().join(place), &mut files)?;
    }
    files.sort();
    for file in files {
        let name = file.strip_prefix(workspace.root()).unwrap_or(&file);
        name.components()
            .map(|part| part.as_os_str())
            .collect::<Vec<&OsStr>>()
            .hash(&mut hash);
        fs::read(&file)
            .with_context(|| format!("can't read {}", file.display()))?
            .hash(&mut hash);
    }
    Ok(format!("{:016x}", hash.finish()))
}

/// The files at or below a path.
fn collect(path: &Path, files: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    if !path.is_dir() {
        files.push(path.to_owned());
        return Ok(());
    }
    for entry in fs::read_dir(path).with_context(|| format!("can't read {}", path.display()))? {
        collect(&entry?.path(), files)?;
    }
    Ok(())
}

/// Installs Rust's standard library for a target unless it is there.
///
/// # Errors
/// rustup can't install it, or is missing.
pub fn ensure_installed(triple: &str) -> anyhow::Result<()> {
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
        .with_context(|| {
            format!("the Rust target {triple} is not installed, and there is no rustup to install it")
        })?;
    let messages = String::from_utf8_lossy(&added.stderr);
    let last = messages.trim().lines().last().unwrap_or_default().to_owned();
    ensure!(
        added.status.success(),
        "the Rust target {triple} can't be installed: {last}"
    );
    Ok(())
}

/// Compiler flags that remove this machine's paths from messages, so that the bytes don't depend on
/// the location of the sources.
pub fn without_paths(workspace: &Workspace) -> Vec<String> {
    let cargo_home = std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let cargo_home = cargo_home.map(|home| format!("--remap-path-prefix={}=cargo", home.display()));
    let own = format!("--remap-path-prefix={}=pushbelt", workspace.root().display());
    cargo_home.into_iter().chain([own]).collect()
}

/// Compiler flags: those of the environment instead of the workspace's own (which require AVX2),
/// and [`without_paths`].
fn flags(workspace: &Workspace, product: &Product, target: &Target) -> anyhow::Result<OsString> {
    let given = std::env::var("RUSTFLAGS").unwrap_or_default();
    let mut flags: Vec<String> = given.split_whitespace().map(str::to_owned).collect();
    flags.extend(without_paths(workspace));
    if target.platform == Platform::WIN64 {
        // `cargo-zigbuild` drops the compiler's list of exports for the linker. Without a list,
        // everything is exported.
        let list = exports::definition(workspace, product.is_model)?;
        flags.push(format!("-Clink-arg={}", list.display()));
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
    use crate::wrapper::WITH_AVX2;

    #[test]
    fn the_linker_gets_the_oldest_glibc() {
        assert_eq!(TARGETS[WITH_ARM - 1].platform, Platform::LINUX_ARM);
        let (major, minor) = GLIBC;
        for target in TARGETS.iter().filter(|target| target.triple.contains("linux")) {
            assert_eq!(target.zig, format!("{}.{major}.{minor}", target.triple));
        }
    }

    /// Cargo compiles the dependents of a crate again if a setting of that crate differs.
    #[test]
    fn the_variants_crates_depend_on_the_first() {
        let workspace = Workspace::find().expect("the workspace");
        let first = WITH_AVX2[0];
        assert!(APART.contains(&format!("package.{first}.")));
        let mut tree = cargo::command(&workspace);
        tree.args([
            "tree",
            "--locked",
            "--package",
            "pushbelt",
            "--prefix",
            "none",
            "--invert",
            first,
        ]);
        let output = tree.output().expect("cargo starts");
        let text = String::from_utf8_lossy(&output.stdout).replace('-', "_");
        for name in WITH_AVX2 {
            assert!(
                text.lines().any(|line| line.starts_with(&format!("{name} v"))),
                "{name}: {text}"
            );
        }
    }

    #[test]
    fn the_identity_of_a_build_is_that_of_its_sources() {
        let workspace = Workspace::find().expect("the workspace");
        let found = identity(&workspace).expect("a hash");
        assert_eq!(found, identity(&workspace).expect("a hash"));
        assert_eq!(found.len(), 16);
        let mut files = Vec::new();
        collect(&workspace.root().join("crates"), &mut files).expect("files");
        assert!(
            files.iter().any(|file| file.ends_with("fmi/src/c/dispatch.rs")),
            "{files:?}"
        );
    }
}

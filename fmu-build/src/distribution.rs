//! The Rust compiler of Debian that can compile for WebAssembly, `rustc-web`: for machines where
//! rustup has no standard library for that target, such as those behind a mirror of packages.
//!
//! The packages are downloaded and unpacked below the target directory, without root and without a
//! change of the system. Cargo and the linker are those of rustup. The standard library is compiled
//! from its sources.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail, ensure};

use crate::progress;
use crate::workspace::Workspace;

const COMPILER: &str = "rustc-web";
/// Sources of the standard library.
const SOURCES: &str = "rust-web-src";
/// Beginnings of the names of the packages that the compiler needs, among those on which it
/// depends. The others, such as the C library, are on every machine.
const NEEDED: [&str; 2] = ["libstd-rust-web", "libLLVM"];
/// Oldest version that compiles the workspace.
const OLDEST: &str = env!("CARGO_PKG_RUST_VERSION");

/// The unpacked compiler.
pub struct Distribution {
    folder: PathBuf,
}

impl Distribution {
    /// Downloads and unpacks the compiler unless it is there.
    ///
    /// # Errors
    /// The distribution has no such package, an older version, or can't be reached.
    pub fn prepare(workspace: &Workspace) -> anyhow::Result<Self> {
        let _alone = workspace.lock(COMPILER)?;
        let folder = workspace.target().join(COMPILER);
        // Written last, so that an interrupted installation has none.
        let stamp = folder.join("complete");
        if !stamp.is_file() {
            if folder.exists() {
                fs::remove_dir_all(&folder).with_context(|| format!("can't remove {}", folder.display()))?;
            }
            let apt = Apt::update(&folder.join("apt"))?;
            let version = apt.version()?;
            progress::headline(&format!("Unpacking {COMPILER} {version} in target/{COMPILER}"));
            apt.unpack(&version, &folder)?;
            fs::remove_dir_all(&apt.folder)?;
            wrap(&folder)?;
            fs::write(&stamp, version).with_context(|| format!("can't write {}", stamp.display()))?;
        }
        Ok(Self { folder })
    }

    /// Makes a cargo command compile with it, for a target without an operating system.
    ///
    /// # Errors
    /// rustup's toolchain has no linker.
    pub fn compile_with(&self, command: &mut Command, target: &str) -> anyhow::Result<()> {
        let name = target.to_uppercase().replace('-', "_");
        command
            .args(["-Z", "build-std=std,panic_abort", "--target-dir"])
            .arg(self.folder.join("cargo"))
            .env("RUSTC", program(&self.folder))
            // For `-Z` in a released cargo.
            .env("RUSTC_BOOTSTRAP", "1")
            .env(format!("CARGO_TARGET_{name}_LINKER"), linker()?);
        Ok(())
    }
}

/// apt with lists of its own.
struct Apt {
    folder: PathBuf,
}

impl Apt {
    /// Downloads the lists of packages.
    fn update(folder: &Path) -> anyhow::Result<Self> {
        for part in ["lists/partial", "cache/archives/partial"] {
            let part = folder.join(part);
            fs::create_dir_all(&part).with_context(|| format!("can't make {}", part.display()))?;
        }
        let apt = Self {
            folder: folder.to_owned(),
        };
        apt.output("apt-get", &["-qq", "update"])?;
        Ok(apt)
    }

    /// What a program of apt prints.
    fn output(&self, program: &str, words: &[&str]) -> anyhow::Result<String> {
        let place = |name: &str, folder: &Path| format!("{name}={}", folder.display());
        let options = [
            place("Dir::State", &self.folder),
            place("Dir::Cache", &self.folder.join("cache")),
            "Dir::State::status=/var/lib/dpkg/status".to_owned(),
            "APT::Sandbox::User=root".to_owned(),
        ];
        let mut command = Command::new(program);
        command.current_dir(&self.folder).env("LC_ALL", "C");
        for option in options {
            command.args(["-o", &option]);
        }
        printed(command.args(words))
    }

    /// The version of the compiler, if that is new enough.
    fn version(&self) -> anyhow::Result<String> {
        let policy = self.output("apt-cache", &["policy", COMPILER])?;
        let candidate = policy.lines().find_map(|line| line.trim().strip_prefix("Candidate: "));
        let Some(version) = candidate.filter(|version| *version != "(none)") else {
            bail!("this distribution has no package {COMPILER}");
        };
        ensure!(
            minor(version) >= minor(OLDEST),
            "this distribution's {COMPILER} is {version}, and the workspace needs {OLDEST}"
        );
        Ok(version.to_owned())
    }

    /// Unpacks the compiler with what it needs.
    fn unpack(&self, version: &str, folder: &Path) -> anyhow::Result<()> {
        let mut packages = vec![COMPILER.to_owned(), SOURCES.to_owned()];
        let mut next = 0;
        while let Some(package) = packages.get(next) {
            let depends = self.output("apt-cache", &["depends", "--important", package])?;
            next += 1;
            let names = depends.lines().filter_map(|line| line.trim().strip_prefix("Depends: "));
            for name in names.filter(|name| is_needed(name)) {
                if !packages.iter().any(|known| known == name) {
                    packages.push(name.to_owned());
                }
            }
        }
        // Sources and compiler belong together; other packages have versions of their own.
        packages[0] = format!("{COMPILER}={version}");
        packages[1] = format!("{SOURCES}={version}");
        let words: Vec<&str> = ["-qq", "download"]
            .into_iter()
            .chain(packages.iter().map(String::as_str))
            .collect();
        self.output("apt-get", &words)?;
        for entry in fs::read_dir(&self.folder)? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "deb") {
                printed(Command::new("dpkg").arg("-x").arg(&path).arg(folder))?;
            }
        }
        // The sources of the compiler itself are most of the package.
        for entry in fs::read_dir(folder.join("usr/src"))? {
            for part in ["compiler", "src"] {
                let part = entry.as_ref().map_or(PathBuf::new(), |entry| entry.path().join(part));
                if part.is_dir() {
                    fs::remove_dir_all(&part)?;
                }
            }
        }
        Ok(())
    }
}

fn is_needed(name: &str) -> bool {
    let name = name.to_lowercase();
    NEEDED
        .iter()
        .any(|beginning| name.starts_with(&beginning.to_lowercase()))
}

/// Major and minor number of a version.
fn minor(version: &str) -> Option<(u32, u32)> {
    let mut numbers = version.split(['.', '+', '-', '~']);
    let mut next = || numbers.next()?.parse().ok();
    Some((next()?, next()?))
}

fn program(folder: &Path) -> PathBuf {
    folder.join("rustc")
}

/// Writes a script that starts the compiler with its own libraries.
fn wrap(folder: &Path) -> anyhow::Result<()> {
    let mut folders = fs::read_dir(folder.join("usr/lib"))?.filter_map(|entry| Some(entry.ok()?.path()));
    let libraries = folders
        .find(|path| path.to_string_lossy().ends_with("-linux-gnu"))
        .context("the packages have no libraries")?;
    let script = format!(
        "#!/bin/sh\nLD_LIBRARY_PATH='{}' exec '{}' \"$@\"\n",
        libraries.display(),
        folder.join("usr/bin/rustc").display()
    );
    let path = program(folder);
    fs::write(&path, script).with_context(|| format!("can't write {}", path.display()))?;
    printed(Command::new("chmod").arg("+x").arg(&path))?;
    printed(Command::new(&path).arg("--version")).map(drop)
}

/// The linker of rustup's toolchain.
fn linker() -> anyhow::Result<PathBuf> {
    let root = printed(Command::new("rustc").args(["--print", "sysroot"]))?;
    let targets = fs::read_dir(Path::new(root.trim()).join("lib/rustlib"))?;
    let mut linkers = targets.filter_map(|entry| Some(entry.ok()?.path().join("bin").join("rust-lld")));
    linkers
        .find(|path| path.is_file())
        .with_context(|| format!("there is no rust-lld in {}", root.trim()))
}

/// What a program prints; its error if it fails.
fn printed(command: &mut Command) -> anyhow::Result<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .with_context(|| format!("there is no {name} on this machine"))?;
    let error = String::from_utf8_lossy(&output.stderr);
    let last = error.trim().lines().last().unwrap_or_default();
    ensure!(output.status.success(), "{name} fails: {last}");
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_compared_by_their_numbers() {
        assert_eq!(minor("1.96.0+dfsg1-1~deb12u2"), Some((1, 96)));
        assert!(minor("1.85.0+dfsg3-1") < minor("1.95") && minor("1.100") > minor("1.95"));
        assert_eq!(minor("none"), None);
    }

    #[test]
    fn the_compiler_needs_its_libraries_only() {
        let named = ["libstd-rust-web-1.96", "libllvm19", "libLLVM-14", "libc6", "gcc"];
        assert_eq!(named.map(is_needed), [true, true, true, false, false]);
    }
}

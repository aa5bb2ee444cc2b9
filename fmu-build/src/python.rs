//! Python: finding an interpreter, and a virtual environment with the packages of a lock file.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use anyhow::{Context, bail, ensure};

use crate::cargo;
use crate::platform::Version;
use crate::progress;
use crate::workspace::{MODEL_IDENTIFIER, Workspace};

/// Oldest Python that the tests and the demo run on.
const OLDEST: (u32, u32) = (3, 10);

/// A lock file in the source tree, and the folder below the target directory where its packages are
/// installed.
pub struct Packages {
    lock: &'static str,
    /// A lock file for the same folder that has these packages, and others.
    within: Option<&'static str>,
    folder: &'static str,
}

/// Imported by the tests and by the programs that run the FMU.
pub const RUNNING: Packages = Packages {
    lock: "python/requirements.txt",
    within: None,
    folder: "venv",
};

/// The part of them that the demo imports. The others are added to the same folder later.
pub const DEMO: Packages = Packages {
    lock: "python/requirements-demo.txt",
    within: Some(RUNNING.lock),
    folder: RUNNING.folder,
};

/// Needed to compile for other machines.
pub const BUILDING: Packages = Packages {
    lock: "python/portable-requirements.txt",
    within: None,
    folder: "venv-portable",
};

/// Needed to pack the Python package.
pub const PACKING: Packages = Packages {
    lock: "python/wheel-requirements.txt",
    within: None,
    folder: "venv-wheel",
};

/// Folders of the source tree with Python packages.
const SOURCES: [&str; 5] = ["python", "validation", "paper/python", "examples/cosim", "benches"];

/// A copy of the lock file in the environment lists its installed packages. It is written last, so
/// that an interrupted installation has none.
const STAMP: &str = "installed-requirements.txt";

/// A virtual environment below the target directory.
pub struct Environment {
    interpreter: PathBuf,
    root: PathBuf,
    fmu: PathBuf,
}

impl Environment {
    /// Returns the existing environment if it has the locked packages; otherwise installs them.
    ///
    /// # Errors
    /// No suitable Python, or pip can't install the locked packages.
    pub fn prepare(workspace: &Workspace, packages: &Packages) -> anyhow::Result<Self> {
        let _alone = workspace.lock(packages.folder)?;
        let folder = workspace.target().join(packages.folder);
        let environment = Self {
            interpreter: interpreter_in(&folder),
            root: workspace.root().to_owned(),
            fmu: workspace.fmu(MODEL_IDENTIFIER, Version::Two),
        };
        let read = |lock: &str| {
            let path = workspace.root().join(lock);
            fs::read_to_string(&path).with_context(|| format!("can't read {}", path.display()))
        };
        let stamp = folder.join(STAMP);
        let works = version(environment.interpreter.as_os_str()).is_some();
        let installed = fs::read_to_string(&stamp).ok().filter(|_| works);
        let wider = packages.within.map(read).transpose()?;
        let wanted = read(packages.lock)?;
        if installed.is_some() && (installed.as_ref() == Some(&wanted) || installed == wider) {
            return Ok(environment);
        }
        progress::headline(&format!("Installing Python packages in target/{}", packages.folder));
        // What the demo has installed stays. Otherwise the environment has packages that the lock
        // file no longer names.
        if packages.lock == RUNNING.lock && installed == Some(read(DEMO.lock)?) {
            fs::remove_file(&stamp).with_context(|| format!("can't remove {}", stamp.display()))?;
        } else {
            create(&find_interpreter()?, &folder)?;
        }
        install(&environment.interpreter, &workspace.root().join(packages.lock))?;
        fs::write(&stamp, wanted).with_context(|| format!("can't write {}", stamp.display()))?;
        Ok(environment)
    }

    /// The search path for programs, with those of this environment first.
    ///
    /// # Errors
    /// The search path has a folder with a separator in its name.
    pub fn path(&self) -> anyhow::Result<OsString> {
        let own = self.interpreter.parent().map(Path::to_owned);
        let others = std::env::var_os("PATH").unwrap_or_default();
        let folders = own.into_iter().chain(std::env::split_paths(&others));
        std::env::join_paths(folders).context("the search path can't be extended")
    }

    /// Path of a program of this environment.
    pub fn program(&self, name: &str) -> PathBuf {
        self.interpreter
            .with_file_name(format!("{name}{}", std::env::consts::EXE_SUFFIX))
    }

    /// A Python command in this environment, at the top level of the workspace. It can import the
    /// packages of `SOURCES` and finds the FMU by the variable `PUSHBELT_FMU`. Bytecode is kept
    /// below the target directory.
    pub fn command(&self) -> Command {
        let sources = SOURCES.map(|folder| self.root.join(folder).into_os_string());
        let separator = OsStr::new(if cfg!(windows) { ";" } else { ":" });
        let mut command = Command::new(&self.interpreter);
        command
            .current_dir(&self.root)
            .env("PYTHONPATH", sources.join(separator))
            .env("PYTHONPYCACHEPREFIX", self.fmu.with_file_name("bytecode"))
            .env("PUSHBELT_FMU", &self.fmu);
        cargo::clear_own(&mut command);
        command
    }
}

fn interpreter_in(folder: &Path) -> PathBuf {
    if cfg!(windows) {
        folder.join("Scripts").join("python.exe")
    } else {
        folder.join("bin").join("python")
    }
}

fn create(python: &OsString, folder: &Path) -> anyhow::Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("can't remove {}", folder.display()))?;
    }
    let made = Command::new(python).args(["-m", "venv"]).arg(folder).output();
    shown_if_failed(made, || {
        let python = python.to_string_lossy();
        format!(
            "{python} can't create a virtual environment (on Debian and Ubuntu: apt install python3-venv)"
        )
    })
}

fn install(interpreter: &Path, lock_file: &Path) -> anyhow::Result<()> {
    let pip = Command::new(interpreter)
        .args(["-m", "pip", "install", "--disable-pip-version-check"])
        // The lock file names every required package; missing dependencies are left out
        // deliberately.
        .args(["--no-deps", "--no-input", "--retries", "5"])
        // Most modules are never imported, so they are compiled when they are.
        .args(["--no-compile", "--requirement"])
        .arg(lock_file)
        .output();
    shown_if_failed(pip, || format!("pip can't install {}", lock_file.display()))
}

/// An error with what a program has printed, if it has failed.
fn shown_if_failed(output: std::io::Result<Output>, error: impl Fn() -> String) -> anyhow::Result<()> {
    let output = output.with_context(&error)?;
    let [said, errors] = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    ensure!(output.status.success(), "{}:\n{said}{errors}", error());
    Ok(())
}

/// The first interpreter that is new enough; the one in the environment variable `PYTHON` comes
/// first.
fn find_interpreter() -> anyhow::Result<OsString> {
    let mut seen = Vec::new();
    let names = [
        "python3",
        "python",
        "python3.13",
        "python3.12",
        "python3.11",
        "python3.10",
    ];
    let candidates = std::env::var_os("PYTHON").into_iter().chain(names.map(OsString::from));
    for candidate in candidates {
        if let Some((major, minor)) = version(&candidate) {
            if (major, minor) >= OLDEST {
                return Ok(candidate);
            }
            seen.push(format!("{} is {major}.{minor}", candidate.to_string_lossy()));
        }
    }
    let seen = if seen.is_empty() {
        "there is none on the path".to_owned()
    } else {
        seen.join(", ")
    };
    bail!(
        "Python {}.{} or newer is needed to drive the FMU, but {seen}. Install it, or name one in the environment \
         variable PYTHON",
        OLDEST.0,
        OLDEST.1
    )
}

/// Major and minor version of an interpreter; none if it doesn't run.
fn version(python: &std::ffi::OsStr) -> Option<(u32, u32)> {
    let output = Command::new(python)
        .args(["-c", "import sys; print(*sys.version_info[:2])"])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let (major, minor) = text.trim().split_once(' ')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::collections::HashSet;

    #[test]
    fn the_demo_uses_versions_of_the_full_lock_file() {
        let root = Workspace::find().unwrap().root().to_owned();
        let lines = |lock: &str| -> HashSet<String> {
            let text = fs::read_to_string(root.join(lock)).unwrap();
            let locked = text.lines().filter(|line| !line.starts_with('#'));
            locked
                .map(|line| line.split(" ; ").next().unwrap_or(line).to_owned())
                .collect()
        };
        let (demo, all) = (lines(DEMO.lock), lines(RUNNING.lock));
        assert!(
            demo.len() > 5 && 3 * demo.len() < all.len(),
            "{} of {}",
            demo.len(),
            all.len()
        );
        let other: Vec<_> = demo.difference(&all).collect();
        assert!(other.is_empty(), "not in {}: {other:?}", RUNNING.lock);
    }
}

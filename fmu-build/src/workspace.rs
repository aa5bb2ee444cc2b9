//! Paths in the source tree and in cargo's target directory.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, ensure};
use serde_json::Value;

use crate::platform::Version;

/// Name of the package of the model.
pub const MODEL_PACKAGE: &str = "pushbelt";

/// Name of the package whose library is the binary in the FMU.
pub const LIBRARY_PACKAGE: &str = "pushbelt-library";

/// Name of the package of the paper's belts.
pub const PAPER_PACKAGE: &str = "pushbelt-paper";

/// Name of the package whose library is the binary in their FMU.
pub const PAPER_LIBRARY_PACKAGE: &str = "pushbelt-paper-fmu";

/// Its model name and model identifier.
pub const PAPER_IDENTIFIER: &str = "PushbeltPaper";

/// Name of the package whose library is the binary in the FMU of maps.
pub const MAP_PACKAGE: &str = "pushbelt-map-unit";

/// Its model name and model identifier.
pub const MAP_IDENTIFIER: &str = "PushbeltMap";

/// Model name and model identifier of the FMU.
pub const MODEL_IDENTIFIER: &str = "PushbeltVariator";

/// Name of the package of the live page.
pub const LIVE_PACKAGE: &str = "pushbelt-live";

/// The workspace that the tool works on.
pub struct Workspace {
    root: PathBuf,
    target: PathBuf,
}

impl Workspace {
    /// Finds the workspace in which this tool was compiled.
    ///
    /// # Errors
    /// Cargo can't read the manifest.
    pub fn find() -> anyhow::Result<Self> {
        let metadata = metadata(&["--no-deps"])?;
        let path = |name: &str| {
            let path = metadata[name].as_str().map(PathBuf::from);
            path.with_context(|| format!("cargo names no {name}"))
        };
        Ok(Self {
            root: path("workspace_root")?,
            target: path("target_directory")?,
        })
    }

    /// Top level of the source tree.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Cargo's target directory.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// The packed FMU of a model.
    pub fn fmu(&self, identifier: &str, version: Version) -> PathBuf {
        let number = if version == Version::Three { "3" } else { "" };
        self.target.join(format!("{identifier}{number}.fmu"))
    }

    /// The folder with the tables of the published variator, checked in.
    pub fn map_tables(&self) -> PathBuf {
        self.root.join("resources").join("maps")
    }

    /// The checked-in model description, that of FMI 2.0 at the top level.
    pub fn model_description(&self, version: Version) -> PathBuf {
        self.root.join(match version {
            Version::Two => "modelDescription.xml",
            Version::Three => "resources/modelDescription3.xml",
        })
    }

    /// The connections and their places on the icon, checked in.
    pub fn terminals(&self) -> PathBuf {
        self.root.join("resources").join("terminalsAndIcons.xml")
    }

    /// The names that the FMU's library exports, for linkers, checked in with this tool.
    pub fn exports(&self) -> PathBuf {
        self.root.join("fmu-build").join("exports.def")
    }

    /// Waits until no other run of this tool writes `what` in the target directory. Other runs wait
    /// until the file is dropped.
    ///
    /// # Errors
    /// The lock file can't be written.
    pub fn lock(&self, what: &str) -> anyhow::Result<File> {
        let path = self.target.join(format!(".fmu-{what}.lock"));
        let file = fs::create_dir_all(&self.target)
            .and_then(|()| File::create(&path))
            .with_context(|| format!("can't write {}", path.display()))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                eprintln!("waiting for another `cargo fmu` ({what})");
                file.lock().with_context(|| format!("can't lock {}", path.display()))?;
            }
            // Some network file systems have no locks.
            Err(TryLockError::Error(_)) | Ok(()) => {}
        }
        Ok(file)
    }

    /// The packages of the workspace, as `cargo metadata` prints them.
    ///
    /// # Errors
    /// Cargo can't read a manifest.
    pub fn members(&self) -> anyhow::Result<Value> {
        metadata(&["--no-deps"])
    }

    /// Packages with their dependencies, resolved by the lock file, as `cargo metadata` prints
    /// them: for every machine if they are `portable`, or for this one alone. For every machine
    /// cargo downloads more than it needs to compile for this one.
    ///
    /// # Errors
    /// Cargo can't resolve the dependencies.
    pub fn packages(&self, portable: bool) -> anyhow::Result<Value> {
        if portable {
            metadata(&[])
        } else {
            metadata(&["--filter-platform", &host()?])
        }
    }
}

/// Copies a folder with its content, except Python's compiled files.
///
/// # Errors
/// A file can't be read or written.
pub fn copy_tree(from: &Path, to: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(to).with_context(|| format!("can't make {}", to.display()))?;
    for entry in fs::read_dir(from).with_context(|| format!("can't read {}", from.display()))? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if !entry.file_type()?.is_dir() {
            fs::copy(entry.path(), &target).with_context(|| format!("can't write {}", target.display()))?;
        } else if entry.file_name() != "__pycache__" {
            copy_tree(&entry.path(), &target)?;
        }
    }
    Ok(())
}

/// The compiler's name for this machine, such as `x86_64-unknown-linux-gnu`.
fn host() -> anyhow::Result<String> {
    let output = cargo().arg("-vV").output().context("can't start cargo")?;
    let text = String::from_utf8_lossy(&output.stdout);
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned).context("cargo names no host")
}

fn metadata(options: &[&str]) -> anyhow::Result<Value> {
    let mut command = cargo();
    command.args(["metadata", "--format-version=1", "--manifest-path"]);
    command
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .args(options);
    let output = command.stderr(Stdio::inherit()).output().context("can't start cargo")?;
    ensure!(output.status.success(), "cargo can't read the workspace's packages");
    serde_json::from_slice(&output.stdout).context("cargo prints no JSON")
}

fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;

    #[test]
    fn a_lock_keeps_others_waiting() {
        let target = std::env::temp_dir().join(format!("fmu-build-lock-{}", std::process::id()));
        let workspace = Workspace {
            root: target.clone(),
            target: target.clone(),
        };
        let held = workspace.lock("build").expect("a lock");
        let (sender, receiver) = mpsc::channel();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let _second = workspace.lock("build").expect("the lock, later");
                sender.send(()).expect("a receiver");
            });
            workspace.lock("venv").expect("another lock");
            assert!(receiver.recv_timeout(Duration::from_millis(100)).is_err());
            drop(held);
            receiver.recv().expect("the lock was passed on");
        });
        fs::remove_dir_all(target).expect("the folder goes");
    }
}

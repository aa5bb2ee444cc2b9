//! Paths in the source tree and in cargo's target directory.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use anyhow::Context;
use cargo_metadata::{Metadata, MetadataCommand};

/// Name of the package whose library is the binary in the FMU.
pub const MODEL_PACKAGE: &str = "pushbelt";

/// Model name and model identifier of the FMU.
pub const MODEL_IDENTIFIER: &str = "PushbeltVariator";

/// The workspace that the tool works on.
pub struct Workspace {
    root: PathBuf,
    target: PathBuf,
}

impl Workspace {
    /// Finds the workspace that this tool was compiled in.
    ///
    /// # Errors
    /// Cargo can't read the manifest.
    pub fn find() -> anyhow::Result<Self> {
        let metadata = metadata_command()
            .no_deps()
            .exec()
            .context("cargo can't read the workspace's manifest")?;
        Ok(Self {
            root: metadata.workspace_root.into(),
            target: metadata.target_directory.into(),
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

    /// The packed FMU.
    pub fn fmu(&self) -> PathBuf {
        self.target.join(format!("{MODEL_IDENTIFIER}.fmu"))
    }

    /// The same for FMI 3.0.
    pub fn fmu3(&self) -> PathBuf {
        self.target.join(format!("{MODEL_IDENTIFIER}3.fmu"))
    }

    /// The model description of FMI 2.0, checked in at the top level.
    pub fn model_description(&self) -> PathBuf {
        self.root.join("modelDescription.xml")
    }

    /// The model description of FMI 3.0, checked in at the top level.
    pub fn model_description3(&self) -> PathBuf {
        self.root.join("modelDescription3.xml")
    }

    /// The connections and their places on the icon, checked in at the top level.
    pub fn terminals(&self) -> PathBuf {
        self.root.join("terminalsAndIcons.xml")
    }

    /// The names that the FMU's library exports, for linkers, checked in beside this tool.
    pub fn exports(&self) -> PathBuf {
        self.root.join("fmu-build").join("exports.def")
    }

    /// Waits until no other run of this tool writes `what` in the target directory, and lets others wait until the
    /// file is dropped.
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

    /// All packages with their dependencies, resolved by the lock file.
    ///
    /// # Errors
    /// Cargo can't resolve the dependencies.
    pub fn packages(&self) -> anyhow::Result<Metadata> {
        metadata_command()
            .exec()
            .context("cargo can't resolve the dependencies")
    }
}

/// Copies a folder with all that is in it, but for what Python has compiled there.
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

fn metadata_command() -> MetadataCommand {
    let mut command = MetadataCommand::new();
    command.manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
    command
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

//! Where things lie: the source tree and the target directory that cargo uses.

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

    /// The model description, checked in at the top level.
    pub fn model_description(&self) -> PathBuf {
        self.root.join("modelDescription.xml")
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

fn metadata_command() -> MetadataCommand {
    let mut command = MetadataCommand::new();
    command.manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"));
    command
}

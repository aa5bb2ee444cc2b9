//! `cargo fmu wheel`: the Python package with the FMUs inside, for people without Rust.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use clap::Args;

use crate::commands::build;
use crate::platform::Version;
use crate::python::{Environment, PACKING};
use crate::workspace::{MAP_IDENTIFIER, MODEL_IDENTIFIER, Workspace, copy_tree};
use crate::{cargo, licenses, portable, progress};

/// 1 January 1980, the earliest date in an archive, so that the bytes of a wheel don't depend on
/// the date of its build.
const DATE: &str = "315532800";

/// Content and destination of the wheel.
#[derive(Args)]
pub struct Arguments {
    /// Pack this FMU with its binaries, and those of FMI 3.0 and of maps beside it, instead of
    /// building portable ones
    #[arg(long, value_name = "FILE.fmu")]
    fmu: Option<PathBuf>,
    /// For Linux on ARM: FMUs with its library beside the others, and its tag in the wheel's name
    #[arg(long, conflicts_with = "fmu")]
    arm: bool,
    /// Folder that the wheel is written to [default: target/wheels]
    #[arg(long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// Builds the wheel and prints where it is.
///
/// # Errors
/// The FMU doesn't build, or the package can't be packed.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let fmus = match &arguments.fmu {
        Some(fmu) => beside(fmu)?,
        None => build_all(workspace, arguments.arm)?,
    };
    let environment = Environment::prepare(workspace, &PACKING)?;
    let _alone = workspace.lock("wheel")?;
    progress::headline("Packing the Python package");
    let tree = workspace.target().join("wheel");
    lay_out(workspace, &fmus, &tree)?;
    let packed = tree.join("dist");
    let mut pip = environment.command();
    pip.args([
        "-m",
        "pip",
        "--disable-pip-version-check",
        "wheel",
        "--quiet",
        "--no-deps",
    ])
    // The environment already has the build backend in the version of the lock file.
    .arg("--no-build-isolation")
    .args(arguments.arm.then(arm_tag))
    .arg("--wheel-dir")
    .arg(&packed)
    .arg(&tree)
    .env("SOURCE_DATE_EPOCH", DATE)
    .env_remove("PYTHONPATH");
    cargo::run(&mut pip)?;

    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| workspace.target().join("wheels"));
    fs::create_dir_all(&output).with_context(|| format!("can't make {}", output.display()))?;
    let wheel = only_file(&packed)?;
    let path = output.join(wheel.file_name().context("a wheel has a name")?);
    fs::copy(&wheel, &path).with_context(|| format!("can't write {}", path.display()))?;
    let size = fs::metadata(&path)?.len().div_ceil(1024);
    println!("{} ({size} kB)", path.display());
    Ok(())
}

/// Names of the FMUs in the wheel, by identifier and version.
fn names() -> impl Iterator<Item = (&'static str, Version, String)> {
    [MODEL_IDENTIFIER, MAP_IDENTIFIER].into_iter().flat_map(|identifier| {
        [(Version::Two, ""), (Version::Three, "3")]
            .map(|(version, suffix)| (identifier, version, format!("{identifier}{suffix}.fmu")))
    })
}

/// The FMU of FMI 2.0 under the name that it has in the wheel, and the others in its folder.
fn beside(fmu: &Path) -> anyhow::Result<Vec<(PathBuf, String)>> {
    let folder = fmu.parent().context("a file has a folder")?;
    let found = names().map(|(identifier, version, name)| {
        let is_first = identifier == MODEL_IDENTIFIER && version == Version::Two;
        (if is_first { fmu.to_owned() } else { folder.join(&name) }, name)
    });
    Ok(found.filter(|(path, _)| path == fmu || path.is_file()).collect())
}

/// The option of pip that names the platform of a wheel for Linux on ARM.
fn arm_tag() -> String {
    let (major, minor) = portable::GLIBC;
    format!("--config-settings=--build-option=--plat-name=manylinux_{major}_{minor}_aarch64")
}

/// Builds all FMUs of the wheel.
fn build_all(workspace: &Workspace, arm: bool) -> anyhow::Result<Vec<(PathBuf, String)>> {
    let folder = workspace.target().join("wheel-fmus");
    fs::create_dir_all(&folder).with_context(|| format!("can't make {}", folder.display()))?;
    build::run_portable(workspace, arm, &folder)?;
    Ok(names().map(|(_, _, name)| (folder.join(&name), name)).collect())
}

/// Copies the files for the build backend: the package with FMUs and published data inside, and the
/// licences.
fn lay_out(workspace: &Workspace, fmus: &[(PathBuf, String)], tree: &Path) -> anyhow::Result<()> {
    if tree.exists() {
        fs::remove_dir_all(tree).with_context(|| format!("can't remove {}", tree.display()))?;
    }
    let (python, root) = (workspace.root().join("python"), workspace.root());
    let data = tree.join("pushbelt").join("data");
    copy_tree(&python.join("pushbelt"), &tree.join("pushbelt"))?;
    copy_tree(&root.join("resources"), &data.join("resources"))?;
    copy_tree(&root.join("docs"), &data.join("docs"))?;
    typeset(workspace, &data.join("docs").join("theory.md"))?;
    copy_tree(&root.join("examples"), &data.join("examples"))?;
    let copy = |from: &Path, to: &Path| {
        fs::copy(from, to)
            .map(drop)
            .with_context(|| format!("can't copy {} to {}", from.display(), to.display()))
    };
    for (fmu, name) in fmus {
        copy(fmu, &data.join(name))?;
    }
    copy(&python.join("pyproject.toml"), &tree.join("pyproject.toml"))?;
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&root.join(license), &tree.join(license))?;
    }
    let third_party = licenses::third_party(&workspace.packages(true)?)?;
    let path = tree.join("LICENSE-third-party.txt");
    fs::write(&path, third_party).with_context(|| format!("can't write {}", path.display()))
}

/// Writes a page of the book with its equations as HTML beside it.
fn typeset(workspace: &Workspace, page: &Path) -> anyhow::Result<()> {
    let mut program = cargo::book_program(workspace, "book-math");
    let html = cargo::printed(program.arg("page").arg(page))?;
    let path = page.with_extension("html");
    fs::write(&path, html).with_context(|| format!("can't write {}", path.display()))
}

/// The one file of a folder.
fn only_file(folder: &Path) -> anyhow::Result<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("can't read {}", folder.display()))? {
        found.push(entry?.path());
    }
    ensure!(
        found.len() == 1,
        "{} holds {} files instead of one",
        folder.display(),
        found.len()
    );
    found.pop().context("there is one")
}

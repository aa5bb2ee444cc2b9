//! `cargo fmu build`: compiles the binary and packs the FMU.

use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use crate::archive::Archive;
use crate::description::{self, Description};
use crate::platform::{Platform, Version};
use crate::portable::Binary;
use crate::workspace::{MAP_IDENTIFIER, MODEL_IDENTIFIER, PAPER_IDENTIFIER, Workspace};
use crate::{binary, cargo, date, exports, icons, licenses, portable, progress};

/// The documentation in the FMU; values from the model description replace `{{…}}`.
const DOCUMENTATION: &str = include_str!("../../templates/documentation.html");

/// Folder of the licences in both versions of the standard (2.0.4, section 2.3); `license.txt` is
/// the entry.
const LICENSES: &str = "documentation/licenses";
const LICENSE: &str = include_str!("../../templates/license.txt");
/// Files of the layered standard for related files, FMI-LS-REF, and the page about them.
const REFERENCE: &str = "extra/org.fmi-standard.fmi-ls-ref";
const REFERENCE_PAGE: &str = include_str!("../../templates/fmi-ls-ref.html");
/// Supported features of each version of FMI, as a section of the documentation.
const FMI2: &str = include_str!("../../templates/fmi2.html");
const FMI3: &str = include_str!("../../templates/fmi3.html");

/// The machines to build for.
#[derive(Args, Clone, Copy, Default)]
#[group(skip)]
pub struct Arguments {
    /// Build for linux64 with glibc 2.17 or newer and for win64, on processors without AVX2 too,
    /// instead of for this machine
    #[arg(long)]
    pub portable: bool,
    /// With --portable, for Linux on ARM too, which takes some two minutes more
    #[arg(long, requires = "portable")]
    pub arm: bool,
}

/// What `cargo fmu build` builds.
#[derive(Args, Clone, Copy)]
pub struct Options {
    #[command(flatten)]
    machines: Arguments,
    /// Write target/PushbeltVariator3.fmu for FMI 3.0 instead; with --portable also for Linux on
    /// ARM and for macOS, as far as their Rust targets can be installed
    #[arg(long)]
    fmi3: bool,
    /// Write target/PushbeltPaper.fmu instead, with the rings that the paper compares, for this
    /// machine
    #[arg(long, conflicts_with_all = ["fmi3", "portable"])]
    paper: bool,
    /// Write target/PushbeltMap.fmu instead, a variator from maps; with --fmi3 target/PushbeltMap3.fmu
    #[arg(long, conflicts_with = "paper")]
    map: bool,
}

/// Builds the FMU of FMI 2.0 or 3.0.
///
/// # Errors
/// The library doesn't compile, or a file can't be read or written.
pub fn run_options(workspace: &Workspace, options: &Options) -> anyhow::Result<()> {
    if options.paper {
        return run_paper(workspace).map(drop);
    }
    let version = if options.fmi3 { Version::Three } else { Version::Two };
    if options.map {
        return run_map(workspace, options.machines, version).map(drop);
    }
    run_versions(workspace, options.machines, &[version])
}

/// Builds the FMU of FMI 2.0 and returns its path.
///
/// # Errors
/// As [`run_options`].
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<PathBuf> {
    run_versions(workspace, *arguments, &[Version::Two])?;
    Ok(workspace.fmu(MODEL_IDENTIFIER, Version::Two))
}

/// Builds the FMUs of both versions from the same binaries.
///
/// # Errors
/// As [`run_options`].
pub fn run_both(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    run_versions(workspace, *arguments, &[Version::Two, Version::Three])
}

/// Builds the FMUs of versions from the binaries of the first.
fn run_versions(workspace: &Workspace, machines: Arguments, versions: &[Version]) -> anyhow::Result<()> {
    let _alone = workspace.lock("build")?;
    let binaries = compile(workspace, machines, versions[0])?;
    for &version in versions {
        let archive = collect(workspace, &binaries, machines, version)?;
        write(archive, &workspace.fmu(MODEL_IDENTIFIER, version))?;
    }
    Ok(())
}

fn compile(workspace: &Workspace, machines: Arguments, version: Version) -> anyhow::Result<Vec<Binary>> {
    if machines.portable {
        return portable::build(workspace, &portable::MODEL, version, machines.arm);
    }
    progress::headline("Compiling the FMU's binary");
    Ok(vec![Binary {
        platform: Platform::host()?,
        name: MODEL_IDENTIFIER.to_owned(),
        path: cargo::build_library(workspace)?,
    }])
}

/// Builds all portable FMUs, of both versions from the same binaries, in a folder, and leaves those
/// in the target directory alone.
///
/// # Errors
/// As [`run_options`].
pub fn run_portable(workspace: &Workspace, arm: bool, folder: &Path) -> anyhow::Result<()> {
    let _alone = workspace.lock("build")?;
    let machines = Arguments { portable: true, arm };
    let binaries = compile(workspace, machines, Version::Two)?;
    let of_maps = portable::build(workspace, &portable::MAP, Version::Two, arm)?;
    for version in [Version::Two, Version::Three] {
        let path = workspace.fmu(MODEL_IDENTIFIER, version);
        let name = path.file_name().context("an FMU has a name")?;
        write(collect(workspace, &binaries, machines, version)?, &folder.join(name))?;
        let (_, description) = cargo::build_map(workspace, version)?;
        let path = workspace.fmu(MAP_IDENTIFIER, version);
        let name = path.file_name().context("an FMU has a name")?;
        write(
            collect_map(workspace, &of_maps, description, machines, version)?,
            &folder.join(name),
        )?;
    }
    Ok(())
}

/// Writes an FMU and prints its path and size.
fn write(archive: Archive, path: &Path) -> anyhow::Result<()> {
    save(archive, path)?;
    let size = fs::metadata(path)?.len().div_ceil(1024);
    println!("{} ({size} kB)", path.display());
    Ok(())
}

fn save(archive: Archive, path: &Path) -> anyhow::Result<()> {
    // Written to another file that is then renamed, so that no program reads an incomplete FMU.
    let draft = path.with_extension("fmu.part");
    let output = File::create(&draft).with_context(|| format!("can't write {}", draft.display()))?;
    let mut output = archive.write(BufWriter::new(output))?;
    output.flush()?;
    drop(output);
    fs::rename(&draft, path).with_context(|| format!("can't write {}", path.display()))
}

/// Builds the FMU of the paper's belts for this machine and returns its path.
///
/// # Errors
/// As [`run_options`].
pub fn run_paper(workspace: &Workspace) -> anyhow::Result<PathBuf> {
    let _alone = workspace.lock("build")?;
    progress::headline("Compiling the binary of the paper's belts");
    let (library, description) = cargo::build_paper(workspace)?;
    let mut archive = Archive::default();
    let binary = Platform::host()?.binary(Version::Two, PAPER_IDENTIFIER);
    archive.add(binary, read(&library)?)?;
    archive.add("modelDescription.xml", description.into_bytes())?;
    add_resources(&mut archive, workspace)?;
    let path = workspace.fmu(PAPER_IDENTIFIER, Version::Two);
    write(archive, &path)?;
    Ok(path)
}

/// Packs the model description alone, for programs that read the variables and run nothing, and
/// returns the path.
///
/// # Errors
/// A file can't be read or written.
pub fn run_description(workspace: &Workspace) -> anyhow::Result<PathBuf> {
    let _alone = workspace.lock("variables")?;
    let mut archive = Archive::default();
    archive.add(
        "modelDescription.xml",
        read(&workspace.model_description(Version::Two))?,
    )?;
    let path = workspace.target().join("variables.fmu");
    save(archive, &path)?;
    Ok(path)
}

/// Builds the FMU of maps, with the tables of the published variator.
///
/// # Errors
/// As [`run_options`].
pub fn run_map(workspace: &Workspace, machines: Arguments, version: Version) -> anyhow::Result<()> {
    let _alone = workspace.lock("build")?;
    progress::headline("Compiling the binary of the variator from maps");
    // For its description on this machine, too.
    let (path, description) = cargo::build_map(workspace, version)?;
    let binaries = if machines.portable {
        portable::build(workspace, &portable::MAP, version, machines.arm)?
    } else {
        let name = MAP_IDENTIFIER.to_owned();
        vec![Binary {
            platform: Platform::host()?,
            name,
            path,
        }]
    };
    let archive = collect_map(workspace, &binaries, description, machines, version)?;
    write(archive, &workspace.fmu(MAP_IDENTIFIER, version))
}

fn collect_map(
    workspace: &Workspace,
    binaries: &[Binary],
    description: String,
    machines: Arguments,
    version: Version,
) -> anyhow::Result<Archive> {
    let mut archive = Archive::default();
    for Binary { platform, name, path } in binaries {
        let bytes = read(path)?;
        exports::check_standard(&bytes).with_context(|| format!("{} can't be packed", path.display()))?;
        archive.add(platform.binary(version, name), bytes)?;
    }
    archive.add("modelDescription.xml", description.into_bytes())?;
    archive.add("resources/maps.json", read(&workspace.map_tables().join("maps.json"))?)?;
    add_licenses(&mut archive, workspace)?;
    add_third_party(&mut archive, workspace, machines.portable)?;
    Ok(archive)
}

/// Adds the parameter sets, as JSON and as SSV, and the project's licences.
fn add_resources(archive: &mut Archive, workspace: &Workspace) -> anyhow::Result<()> {
    let parameters = workspace.root().join("resources").join("parameters");
    for extension in ["json", "ssv"] {
        for (name, content) in files(&parameters, extension)? {
            archive.add(format!("resources/{name}"), content)?;
        }
    }
    add_licenses(archive, workspace)
}

/// Adds the project's licences.
fn add_licenses(archive: &mut Archive, workspace: &Workspace) -> anyhow::Result<()> {
    for license in ["LICENSE-MIT", "LICENSE-APACHE"] {
        let content = read(&workspace.root().join(license))?;
        archive.add(format!("{LICENSES}/{license}.txt"), content)?;
    }
    Ok(())
}

/// Adds the licences of what is linked.
fn add_third_party(archive: &mut Archive, workspace: &Workspace, portable: bool) -> anyhow::Result<()> {
    archive.add(format!("{LICENSES}/license.txt"), LICENSE.as_bytes().to_vec())?;
    let third_party = licenses::third_party(&workspace.packages(portable)?)?;
    archive.add(format!("{LICENSES}/third-party.txt"), third_party.into_bytes())
}

fn collect(
    workspace: &Workspace,
    binaries: &[Binary],
    machines: Arguments,
    version: Version,
) -> anyhow::Result<Archive> {
    let mut archive = Archive::default();
    for Binary { platform, name, path } in binaries {
        let mut bytes = read(path)?;
        exports::check(&bytes).with_context(|| format!("{} can't be packed", path.display()))?;
        binary::clear_time_stamp(&mut bytes);
        archive.add(platform.binary(version, name), bytes)?;
    }
    let interface = match version {
        Version::Two => {
            archive.add("model.png", icons::MODEL.to_vec())?;
            FMI2
        }
        Version::Three => FMI3,
    };
    let xml = read(&workspace.model_description(version))?;
    let dated = match date::of_content(workspace)? {
        Some(date) => description::with_date(std::str::from_utf8(&xml)?, &date)?.into_bytes(),
        None => xml,
    };
    archive.add("modelDescription.xml", dated)?;
    archive.add("terminalsAndIcons/terminalsAndIcons.xml", read(&workspace.terminals())?)?;
    for (name, content) in icons::files() {
        archive.add(format!("terminalsAndIcons/{name}"), content)?;
    }

    // The variables are the same in both versions.
    let description = read(&workspace.model_description(Version::Two))?;
    let description = Description::parse(std::str::from_utf8(&description)?)?;
    archive.add("documentation/index.html", documentation(&description, interface))?;
    archive.add("documentation/fmi-ls-ref.html", REFERENCE_PAGE.as_bytes().to_vec())?;
    let reference = workspace.root().join("resources/reference");
    for extension in ["xml", "exp", "ssv", "csv"] {
        for (name, content) in files(&reference, extension)? {
            archive.add(format!("{REFERENCE}/{name}"), content)?;
        }
    }
    let header = read(&workspace.root().join("resources/pushbelt.h"))?;
    archive.add("documentation/pushbelt.h", header)?;

    add_resources(&mut archive, workspace)?;
    add_third_party(&mut archive, workspace, machines.portable)?;
    Ok(archive)
}

fn documentation(description: &Description, interface: &str) -> Vec<u8> {
    DOCUMENTATION
        .replace("{{interface}}", interface)
        .replace("{{version}}", &description.version)
        .replace("{{about}}", &description.about)
        .replace("{{variables}}", &description.to_html())
        .into_bytes()
}

/// Files of a folder that have an extension, with their names.
fn files(folder: &Path, extension: &str) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("can't read {}", folder.display()))? {
        let path = entry?.path();
        if path.extension().is_some_and(|found| found == extension)
            && let Some(name) = path.file_name()
        {
            found.push((name.to_string_lossy().into_owned(), read(&path)?));
        }
    }
    Ok(found)
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("can't read {}", path.display()))
}

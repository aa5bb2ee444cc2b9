//! Running cargo.

use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, bail, ensure};
use serde_json::Value;

use crate::platform::Version;
use crate::workspace::{
    LIBRARY_PACKAGE, LIVE_PACKAGE, MAP_PACKAGE, MODEL_PACKAGE, PAPER_LIBRARY_PACKAGE, PAPER_PACKAGE,
    Workspace,
};

/// A cargo command at the top level of the workspace, with the cargo that started this tool.
pub fn command(workspace: &Workspace) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    command_of(workspace, cargo)
}

/// The same for a program that replaces cargo.
pub fn command_of(workspace: &Workspace, program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    command.current_dir(workspace.root());
    clear_own(&mut command);
    command
}

/// A program of this package for the book, which the other commands do without: they compile faster
/// without its parsers. Its arguments follow.
pub fn book_program(workspace: &Workspace, name: &str) -> Command {
    let mut command = command(workspace);
    command.args(["run", "--profile", "tool", "--quiet", "--package"]);
    command.args([env!("CARGO_PKG_NAME"), "--features", "book", "--bin", name, "--"]);
    command
}

/// Removes the variables that `cargo run` sets for the tool itself from a program's environment:
/// build scripts of other packages depend on them, and cargo would compile these again.
pub fn clear_own(command: &mut Command) {
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        if text.starts_with("CARGO_PKG_") || text.starts_with("CARGO_MANIFEST_") {
            command.env_remove(name);
        }
    }
}

/// Runs a command to its end.
///
/// # Errors
/// It can't be started, or reports a failure.
pub fn run(command: &mut Command) -> anyhow::Result<()> {
    let line = shown(command);
    let status = command.status().with_context(|| format!("can't start `{line}`"))?;
    if !status.success() {
        bail!("`{line}` failed ({status})");
    }
    Ok(())
}

/// An example or a benchmark: its package, cargo's option for its kind, its name.
pub type Program = [&'static str; 3];

/// The example that prints generated files.
pub const DESCRIPTION: Program = [MODEL_PACKAGE, "--example", "model_description"];
/// The benchmark of the variator.
pub const BENCHMARK: Program = [MODEL_PACKAGE, "--bench", "variator"];
/// The example that runs the tests of rings alone.
pub const RINGS: Program = [PAPER_PACKAGE, "--example", "paper_rings"];

/// The model of single elements.
pub const ELEMENTS: Program = ["pushbelt-elements", "--bin", "pushbelt-elements"];

/// Compiles the model's shared library, optimised for this machine, and returns its path.
///
/// # Errors
/// The compilation fails.
pub fn build_library(workspace: &Workspace) -> anyhow::Result<PathBuf> {
    compile_library(release(workspace, LIBRARY_PACKAGE).arg("--lib"), LIBRARY_PACKAGE, drop)
}

/// Compiles the shared library of a package with a command that replaces `cargo build`, and returns
/// its path.
///
/// # Errors
/// The compilation fails.
pub fn build_library_with(command: &mut Command, package: &str) -> anyhow::Result<PathBuf> {
    compile_library(
        command.args(["--release", "--lib", "--package", package]),
        package,
        drop,
    )
}

/// Compiles the module of the live page with a `cargo build` for WebAssembly, and returns its path.
///
/// # Errors
/// The compilation fails.
pub fn build_module(command: &mut Command) -> anyhow::Result<PathBuf> {
    compile_library(command.args(["--lib", "--package", LIVE_PACKAGE]), LIVE_PACKAGE, drop)
}

/// Compiles the shared library of the paper's belts, optimised for this machine, and returns its
/// path and its model description.
///
/// # Errors
/// The compilation or the program that prints the description fails.
pub fn build_paper(workspace: &Workspace) -> anyhow::Result<(PathBuf, String)> {
    let (library, program) = build_other(workspace, PAPER_LIBRARY_PACKAGE)?;
    Ok((library, printed(&mut Command::new(program))?))
}

/// Compiles the shared library of the variator from maps, optimised for this machine, and returns
/// its path and its model description of a version, with the tables of the published variator.
///
/// # Errors
/// As [`build_paper`].
pub fn build_map(workspace: &Workspace, version: Version) -> anyhow::Result<(PathBuf, String)> {
    let (library, program) = build_other(workspace, MAP_PACKAGE)?;
    let number = if version == Version::Three { "3" } else { "2" };
    let description = printed(Command::new(program).arg(number).arg(workspace.map_tables()))?;
    Ok((library, description))
}

/// Compiles another library and the program that prints its description, and returns both.
fn build_other(workspace: &Workspace, package: &str) -> anyhow::Result<(PathBuf, PathBuf)> {
    let mut program = None;
    let mut build = release(workspace, package);
    let library = compile_library(build.args(["--lib", "--bins"]), package, |artifact| {
        program = artifact.executable
    })?;
    let program = program
        .with_context(|| format!("cargo built no program that prints the description of {package}"))?;
    Ok((library, program))
}

/// Compiles the shared library of a package and returns its path. What else is built goes to
/// `others`.
fn compile_library(
    build: &mut Command,
    package: &str,
    mut others: impl FnMut(Artifact),
) -> anyhow::Result<PathBuf> {
    let mut library = None;
    compile(build, |artifact| {
        if artifact.name == package.replace('-', "_") {
            library = artifact.shared_library();
        } else if artifact.executable.is_some() {
            others(artifact);
        }
    })?;
    library.with_context(|| {
        format!("cargo built no shared library of {package}: is `cdylib` still among its crate types?")
    })
}

/// What a program prints; its messages go to the terminal.
///
/// # Errors
/// The program fails, or prints no text.
pub fn printed(program: &mut Command) -> anyhow::Result<String> {
    let line = shown(program);
    let output = program.stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "`{line}` failed ({})", output.status);
    Ok(String::from_utf8(output.stdout)?)
}

/// Compiles a program, optimised for this machine, and returns its path.
///
/// # Errors
/// The compilation fails.
pub fn build_program(workspace: &Workspace, [package, kind, name]: Program) -> anyhow::Result<PathBuf> {
    let mut executable = None;
    compile(release(workspace, package).args([kind, name]), |artifact| {
        if artifact.name == name {
            executable = artifact.executable;
        }
    })?;
    executable.with_context(|| format!("cargo built no program `{name}`"))
}

/// The build command of everything that is optimised for this machine. Library, examples and
/// benchmarks share one compiled library, because development dependencies enable no feature of its
/// dependencies; a test below checks this.
fn release(workspace: &Workspace, package: &str) -> Command {
    let mut build = command(workspace);
    build.args(["build", "--release", "--package", package]);
    build
}

/// A compiled target, from cargo's messages.
struct Artifact {
    name: String,
    files: Vec<PathBuf>,
    executable: Option<PathBuf>,
    /// Nothing had to be compiled.
    #[cfg_attr(not(test), expect(dead_code, reason = "a test counts what is compiled"))]
    fresh: bool,
}

impl Artifact {
    fn shared_library(self) -> Option<PathBuf> {
        let is_shared = |file: &PathBuf| {
            let extension = file.extension();
            extension.is_some_and(|extension| {
                ["so", "dylib", "dll", "wasm"].iter().any(|known| extension == *known)
            })
        };
        self.files.into_iter().find(is_shared)
    }

    /// The artifact in a line of cargo's output; none for other lines.
    fn of_line(line: &str) -> anyhow::Result<Option<Self>> {
        let message: Value = serde_json::from_str(line).context("cargo's output is not JSON")?;
        if message["reason"] != "compiler-artifact" {
            return Ok(None);
        }
        let texts = |value: &Value| -> Vec<String> {
            let items = value.as_array().into_iter().flatten();
            items.filter_map(Value::as_str).map(str::to_owned).collect()
        };
        let name = message["target"]["name"].as_str();
        Ok(Some(Self {
            name: name.context("cargo names no target")?.to_owned(),
            files: texts(&message["filenames"]).into_iter().map(PathBuf::from).collect(),
            executable: message["executable"].as_str().map(PathBuf::from),
            fresh: message["fresh"].as_bool().unwrap_or_default(),
        }))
    }
}

/// Runs a build command to its end and passes every artifact to `built`, also those that need no
/// compilation.
fn compile(build: &mut Command, mut built: impl FnMut(Artifact)) -> anyhow::Result<()> {
    let mut child = build
        .arg("--message-format=json-render-diagnostics")
        .stdout(Stdio::piped())
        .spawn()
        .context("can't start cargo")?;
    let output = child.stdout.take().context("cargo has no output")?;
    for line in BufReader::new(output).lines() {
        if let Some(artifact) = Artifact::of_line(&line?)? {
            built(artifact);
        }
    }
    if !child.wait()?.success() {
        bail!("`{}` failed", shown(build));
    }
    Ok(())
}

fn shown(command: &Command) -> String {
    std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::collections::BTreeSet;

    /// Names of the packages that a build command compiles.
    fn compiled(build: &mut Command) -> Vec<String> {
        let mut names = Vec::new();
        compile(build, |artifact| {
            if !artifact.fresh {
                names.push(artifact.name);
            }
        })
        .expect("a build");
        names
    }

    #[test]
    fn an_artifact_is_read_from_cargos_output() {
        let line = r#"{"reason":"compiler-artifact","target":{"name":"pushbelt","crate_types":["cdylib","rlib"]},
            "filenames":["/a/libpushbelt.so","/a/libpushbelt.rlib"],"executable":null,"fresh":true}"#;
        let artifact = Artifact::of_line(line).unwrap().expect("an artifact");
        assert_eq!((artifact.name.as_str(), artifact.fresh), ("pushbelt", true));
        assert_eq!(artifact.files[0], PathBuf::from("/a/libpushbelt.so"));
        assert_eq!(artifact.executable, None);
        assert!(
            Artifact::of_line(r#"{"reason":"build-finished","success":true}"#)
                .unwrap()
                .is_none()
        );
        assert!(Artifact::of_line("no JSON").is_err());
    }

    /// Crates of cargo's `tree`, with their features in it.
    fn features(workspace: &Workspace, tree: &[&str]) -> BTreeSet<String> {
        let output = command(workspace)
            .args([
                "tree",
                "--locked",
                "--prefix",
                "none",
                "--no-dedupe",
                "--format",
                "{p} [{f}]",
            ])
            .args(tree)
            .output();
        let output = output.expect("cargo starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout)
            .unwrap()
            .lines()
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn development_dependencies_change_no_feature_of_the_library() {
        let workspace = Workspace::find().expect("the workspace");
        let alone = features(&workspace, &["--package", MODEL_PACKAGE, "--edges", "normal,build"]);
        let tests = ["--workspace", "--exclude", env!("CARGO_PKG_NAME")];
        let beside = features(&workspace, &tests);
        assert!(alone.len() > 20, "{alone:?}");
        let changed: Vec<_> = alone.difference(&beside).collect();
        assert!(
            changed.is_empty(),
            "other features beside development dependencies: {changed:?}"
        );
    }

    /// The paper's library has the model without the C functions of the other one.
    #[test]
    #[ignore = "compiles the libraries, optimised: `cargo fmu test --all` runs it"]
    fn commands_share_one_optimised_model_and_replace_no_library() {
        let workspace = Workspace::find().expect("the workspace");
        let library = || compiled(release(&workspace, LIBRARY_PACKAGE).arg("--lib"));
        let example = || compiled(release(&workspace, MODEL_PACKAGE).args(["--example", "default_run"]));
        let paper = || compiled(release(&workspace, PAPER_LIBRARY_PACKAGE).args(["--lib", "--bins"]));
        library();
        let for_example = example();
        let again = for_example
            .iter()
            .any(|name| name.starts_with(MODEL_PACKAGE) && name != "pushbelt_support");
        assert!(!again, "the example compiles {for_example:?}");
        paper();
        for (name, built) in [("library", library()), ("example", example()), ("paper", paper())] {
            assert_eq!(built, Vec::<String>::new(), "compiled again for the {name}");
        }
    }
}

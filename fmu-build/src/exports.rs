//! The names that a library of the FMU exports: exactly those of `exports.def`.

use std::collections::BTreeSet;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};
use object::Object;
use object::read::NameOrOrdinal;

use crate::workspace::Workspace;

/// The list, one name per line, in the format of linkers of Windows libraries.
const LIST: &str = include_str!("../exports.def");

/// The names.
fn names() -> BTreeSet<&'static str> {
    let lines = LIST.lines().map(str::trim);
    lines
        .filter(|line| !line.is_empty() && !line.starts_with(';') && *line != "EXPORTS")
        .collect()
}

/// Checks that a library exports exactly the names of the list.
///
/// # Errors
/// The names differ, or the table of exports can't be read.
pub fn check(library: &[u8]) -> anyhow::Result<()> {
    check_against(&names(), library)
}

/// The same for the names that the crate `pushbelt-fmi` exports for every unit: those of the
/// standard, and that of a variant.
///
/// # Errors
/// As [`check`].
pub fn check_standard(library: &[u8]) -> anyhow::Result<()> {
    let standard = names().into_iter().filter(|name| is_standard(name)).collect();
    check_against(&standard, library)
}

fn is_standard(name: &str) -> bool {
    name.starts_with("fmi") || name == "pushbeltVariant"
}

fn check_against(listed: &BTreeSet<&str>, library: &[u8]) -> anyhow::Result<()> {
    let file = object::File::parse(library).context("the library can't be read")?;
    let mac = file.format() == object::BinaryFormat::MachO;
    let exports: Vec<_> = file
        .exports()
        .and_then(|exports| exports.collect())
        .context("the library's exports can't be read")?;
    let mut found = BTreeSet::new();
    for export in &exports {
        let NameOrOrdinal::Name(name) = export.name() else {
            bail!("something is exported without a name");
        };
        let name = std::str::from_utf8(name).context("an exported name is no text")?;
        let name = if mac {
            name.strip_prefix('_').unwrap_or(name)
        } else {
            name
        };
        // The linker that replaces Apple's keeps its own names and those of Rust's standard
        // library.
        if !mac || ["fmi", "pushbelt"].iter().any(|ours| name.starts_with(ours)) {
            found.insert(name);
        }
    }
    compare(listed, &found)
}

fn compare(listed: &BTreeSet<&str>, found: &BTreeSet<&str>) -> anyhow::Result<()> {
    let only = |these: &BTreeSet<&str>, others: &BTreeSet<&str>| {
        let names: Vec<_> = these.difference(others).copied().collect();
        match names.len() {
            0 => "none".to_owned(),
            1..=10 => names.join(", "),
            more => format!("{}, … ({more})", names[..3].join(", ")),
        }
    };
    ensure!(
        listed == found,
        "the library exports other names than fmu-build/exports.def lists: not listed {}; not exported {}",
        only(found, listed),
        only(listed, found)
    );
    Ok(())
}

/// A file with the list for a linker, of the model or of every unit. A different list is a different
/// file, so that cargo links again. Both kinds have one path: it is a flag of the compiler, and cargo
/// would compile everything again for another.
///
/// # Errors
/// The file can't be written.
pub fn definition(workspace: &Workspace, of_model: bool) -> anyhow::Result<PathBuf> {
    let kept = |line: &&str| of_model || *line == "EXPORTS" || is_standard(line.trim());
    let list: String = LIST.lines().filter(kept).flat_map(|line| [line, "\n"]).collect();
    let mut hash = DefaultHasher::new();
    LIST.hash(&mut hash);
    let path = workspace.target().join(format!("exports-{:016x}.def", hash.finish()));
    fs::create_dir_all(workspace.target())
        .and_then(|()| fs::write(&path, list))
        .with_context(|| format!("can't write {}", path.display()))?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_the_functions_of_the_standard() {
        let names = names();
        let of_fmi2 = names.iter().filter(|name| name.starts_with("fmi2"));
        assert_eq!(of_fmi2.count(), 44);
        let of_fmi3 = names.iter().filter(|name| name.starts_with("fmi3"));
        assert_eq!(of_fmi3.count(), 75);
        assert!(names.contains("fmi2Instantiate") && names.contains("fmi2GetStringStatus"));
        assert!(
            names.iter().all(|name| name.is_ascii() && !name.contains(' ')),
            "{names:?}"
        );
    }

    #[test]
    fn what_differs_is_named() {
        let listed = BTreeSet::from(["fmi2DoStep", "fmi2Reset"]);
        assert!(compare(&listed, &listed.clone()).is_ok());
        let other = BTreeSet::from(["fmi2DoStep", "_ZN4core"]);
        let said = compare(&listed, &other).unwrap_err().to_string();
        assert!(said.contains("not listed _ZN4core; not exported fmi2Reset"), "{said}");
        let many: Vec<String> = (0..4000).map(|k| format!("name{k}")).collect();
        let said = compare(&listed, &many.iter().map(String::as_str).collect()).unwrap_err();
        assert!(said.to_string().contains("… (4000)"), "{said}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_program_is_no_library_of_the_fmu() {
        let program = fs::read(std::env::current_exe().unwrap()).unwrap();
        let said = check(&program).unwrap_err().to_string();
        assert!(said.contains("not exported fmi2CancelStep"), "{said}");
        assert!(check(b"MZ").is_err());
    }
}

//! Licences of the model and of every crate that is linked into its binary.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::Context;
use serde_json::Value;

use crate::workspace::MODEL_PACKAGE;

/// The third-party crates linked into the binary, each with version, licence, source and its
/// licence texts; a text that several crates share is listed once. `metadata` is the output of
/// `cargo metadata`.
///
/// # Errors
/// The dependency graph is incomplete or a licence file can't be read.
pub fn third_party(metadata: &Value) -> anyhow::Result<String> {
    let mut packages = linked(metadata)?;
    packages.retain(|package| !is_own(package));
    packages.sort_by_key(|package| (text(package, "name"), text(package, "version")));

    let mut summary = String::from("Crates linked into the binary of this FMU.\n\n");
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in packages {
        let of = |field| text(package, field);
        let name = format!(
            "{} {}",
            of("name").context("a package has a name")?,
            of("version").unwrap_or_default()
        );
        let license = of("license").unwrap_or("see its text below");
        let source = of("repository").unwrap_or("crates.io");
        writeln!(summary, "{name}: {license} ({source})")?;
        for text in license_texts(package)? {
            texts.entry(text).or_default().insert(name.clone());
        }
    }

    for (text, users) in texts {
        let users = users.into_iter().collect::<Vec<_>>().join(", ");
        write!(summary, "\n{}\n{users}\n{}\n\n{text}\n", "=".repeat(78), "-".repeat(78))?;
    }
    Ok(summary)
}

fn text<'a>(value: &'a Value, field: &str) -> Option<&'a str> {
    value[field].as_str()
}

fn items<'a>(value: &'a Value, field: &str) -> impl Iterator<Item = &'a Value> {
    value[field].as_array().into_iter().flatten()
}

/// A package of this workspace has no registry as its source.
fn is_own(package: &Value) -> bool {
    package["source"].is_null()
}

/// Packages that are linked into the model, without the model itself. Procedural macros and build
/// scripts run at compile time only.
fn linked(metadata: &Value) -> anyhow::Result<Vec<&Value>> {
    let packages: HashMap<&str, &Value> = items(metadata, "packages")
        .filter_map(|package| Some((text(package, "id")?, package)))
        .collect();
    let nodes: HashMap<&str, &Value> = items(&metadata["resolve"], "nodes")
        .filter_map(|node| Some((text(node, "id")?, node)))
        .collect();
    let model = packages
        .values()
        .find(|package| text(package, "name") == Some(MODEL_PACKAGE))
        .and_then(|package| text(package, "id"))
        .context("the model is not in this workspace")?;
    let mut seen = HashSet::from([model]);
    let mut open = vec![model];
    let mut found = Vec::new();
    while let Some(id) = open.pop() {
        let node = nodes
            .get(id)
            .with_context(|| format!("{id} is not in the dependency graph"))?;
        for dependency in items(node, "deps") {
            // A normal dependency has no kind; others are `dev` or `build`.
            let normal = items(dependency, "dep_kinds").any(|kind| kind["kind"].is_null());
            let id = text(dependency, "pkg").context("a dependency has a package")?;
            let package = *packages.get(id).with_context(|| format!("{id} is no package"))?;
            let macros = items(package, "targets")
                .any(|target| items(target, "kind").any(|kind| kind == "proc-macro"));
            if normal && !macros && seen.insert(id) {
                found.push(package);
                open.push(id);
            }
        }
    }
    Ok(found)
}

fn license_texts(package: &Value) -> anyhow::Result<Vec<String>> {
    let manifest = text(package, "manifest_path").map(Path::new);
    let folder = manifest.and_then(Path::parent).context("a package has a folder")?;
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("can't read {}", folder.display()))? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().to_uppercase();
        let names = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];
        if names.iter().any(|start| name.starts_with(start)) && entry.path().is_file() {
            let text = fs::read_to_string(entry.path())
                .with_context(|| format!("can't read {}", entry.path().display()))?;
            texts.push(text.replace("\r\n", "\n").trim_end().to_owned());
        }
    }
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::Workspace;

    #[test]
    fn linked_crates_are_listed_but_neither_tools_nor_our_own() {
        let metadata = Workspace::find().unwrap().packages(false).unwrap();
        let text = third_party(&metadata).unwrap();
        for linked in ["faer ", "nalgebra ", "libc "] {
            assert!(text.contains(&format!("\n{linked}")), "{linked} is missing");
        }
        for other in ["clap ", "thiserror-impl ", "pushbelt"] {
            assert!(!text.contains(&format!("\n{other}")), "{other} is listed");
        }
    }
}

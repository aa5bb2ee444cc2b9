//! Licences of the model and of every crate that is linked into its binary.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fmt::Write as _;
use std::fs;

use anyhow::Context;
use cargo_metadata::{DependencyKind, Metadata, Package, PackageId, TargetKind};

use crate::workspace::MODEL_PACKAGE;

/// The crates linked into the binary, each with version, licence, source and the texts it ships; a text that
/// several crates share stands once.
///
/// # Errors
/// The dependency graph is incomplete or a licence file can't be read.
pub fn third_party(metadata: &Metadata) -> anyhow::Result<String> {
    let mut packages = linked(metadata)?;
    packages.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));

    let mut summary = String::from("Crates linked into the binary of this FMU.\n\n");
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in packages {
        let name = format!("{} {}", package.name, package.version);
        let license = package.license.as_deref().unwrap_or("see its text below");
        let source = package.repository.as_deref().unwrap_or("crates.io");
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

/// Packages that the model links, itself aside. Procedural macros and build scripts run at compile time only.
fn linked(metadata: &Metadata) -> anyhow::Result<Vec<&Package>> {
    let graph = metadata.resolve.as_ref().context("no dependency graph")?;
    let model = metadata
        .packages
        .iter()
        .find(|package| package.name == MODEL_PACKAGE)
        .context("the model is not in this workspace")?;
    let mut seen: HashSet<&PackageId> = HashSet::from([&model.id]);
    let mut open = vec![&model.id];
    let mut found = Vec::new();
    while let Some(id) = open.pop() {
        let node = graph.nodes.iter().find(|node| node.id == *id);
        let node = node.with_context(|| format!("{id} is not in the dependency graph"))?;
        for dependency in &node.deps {
            let normal = dependency
                .dep_kinds
                .iter()
                .any(|kind| kind.kind == DependencyKind::Normal);
            let package = &metadata[&dependency.pkg];
            let macros = package
                .targets
                .iter()
                .any(|target| target.kind.contains(&TargetKind::ProcMacro));
            if normal && !macros && seen.insert(&dependency.pkg) {
                found.push(package);
                open.push(&dependency.pkg);
            }
        }
    }
    Ok(found)
}

fn license_texts(package: &Package) -> anyhow::Result<Vec<String>> {
    let folder = package.manifest_path.parent().context("a manifest lies in a folder")?;
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| format!("can't read {folder}"))? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().to_uppercase();
        let names = ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"];
        if names.iter().any(|start| name.starts_with(start)) && entry.path().is_file() {
            let text =
                fs::read_to_string(entry.path()).with_context(|| format!("can't read {}", entry.path().display()))?;
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
    fn linked_crates_are_listed_and_tools_are_not() {
        let metadata = Workspace::find().unwrap().packages().unwrap();
        let text = third_party(&metadata).unwrap();
        for linked in ["faer ", "nalgebra ", "libc "] {
            assert!(text.contains(&format!("\n{linked}")), "{linked} is missing");
        }
        for tool in ["clap ", "thiserror-impl ", "pushbelt "] {
            assert!(!text.contains(&format!("\n{tool}")), "{tool} is listed");
        }
    }
}

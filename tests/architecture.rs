//! The one-way flow between the rooms of `src/`: a room uses only rooms above it in the list of
//! ARCHITECTURE.md.
//!
//! The compiler checks the boundaries of crates. Inside this package a room is a folder or a file
//! of `src/`; other rooms are imported by `crate::…`, or by `super::…`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Names of the rooms in the block ```` ```rooms ```` of a page, one per line, lowest first.
fn rooms(page: &str) -> Vec<String> {
    let (_, block) = page.split_once("```rooms\n").expect("a block of rooms");
    let (block, _) = block.split_once("```").expect("the end of the block");
    block.lines().map(|line| line.trim().to_string()).collect()
}

/// Text of every file below a folder, by module path, `variator/run` for `variator/run/mod.rs`.
fn files(folder: &Path, prefix: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let name = format!("{prefix}/{stem}").trim_start_matches('/').to_string();
        if path.is_dir() {
            files(&path, &name, found);
        } else {
            let module = if stem == "mod" { prefix.to_string() } else { name };
            found.insert(module, fs::read_to_string(&path).expect("UTF-8"));
        }
    }
}

/// Code before the file's own tests, without comments.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// Module paths that a file names after `crate::` and `super::`.
fn imports(module: &str, text: &str) -> Vec<String> {
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let code = code(text);
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        if code[..at].ends_with(|c: char| word(c) || c == '$') {
            continue;
        }
        let rest = &code[at..];
        let path = &rest[..rest.find(|c| !word(c)).unwrap_or(rest.len())];
        assert!(path != "crate::", "{module}: import from `crate` by one path a room");
        let mut base: Vec<&str> = module.split('/').collect();
        for part in path.split("::").filter(|part| !part.is_empty()) {
            match part {
                "crate" => base.clear(),
                // `super` of a file is its folder; a `mod.rs` represents its folder.
                "super" => drop(base.pop()),
                name => base.push(name),
            }
        }
        found.push(base.join("/"));
    }
    found
}

/// Index in the list of the room that a module path belongs to.
fn room(list: &[String], module: &str) -> Option<usize> {
    let inside = |room: &str| {
        let rest = module.strip_prefix(room);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    };
    let inside = (0..list.len()).filter(|&k| inside(&list[k]));
    inside.max_by_key(|&k| list[k].len())
}

/// Imports from a room further down in the list, and files without a room.
fn problems(list: &[String], files: &BTreeMap<String, String>) -> Vec<String> {
    let mut problems = Vec::new();
    for (module, text) in files {
        if ["lib", "variator", "variator/tests"].contains(&module.as_str()) {
            continue;
        }
        let Some(own) = room(list, module) else {
            problems.push(format!("{module} belongs to no room of ARCHITECTURE.md"));
            continue;
        };
        for import in imports(module, text) {
            if room(list, &import).is_some_and(|other| other > own) {
                problems.push(format!("{module}, in the room {}, uses {import}", list[own]));
            }
        }
    }
    problems
}

#[test]
fn rooms_use_only_rooms_above_them_in_the_list() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list = rooms(&fs::read_to_string(root.join("ARCHITECTURE.md")).expect("ARCHITECTURE.md"));
    let mut found = BTreeMap::new();
    files(&root.join("src"), "", &mut found);
    for room in &list {
        let path = root.join("src").join(room);
        assert!(path.exists() || path.with_extension("rs").exists(), "{room}");
    }
    let problems = problems(&list, &found);
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

#[test]
fn a_forbidden_import_is_found_in_every_spelling() {
    let list: Vec<String> = ["ring", "variator/law", "variator/run"].map(str::to_string).to_vec();
    let problems_of = |module: &str, text: &str| {
        let files = BTreeMap::from([(module.to_string(), text.to_string())]);
        problems(&list, &files).len()
    };
    #[rustfmt::skip]
    let cases = [
        ("ring/beam", "use crate::variator::run::Variator;", 1),
        ("ring/beam", "fn f() { crate::variator::law::slip() }", 1),
        ("variator/law/flanks", "use super::super::run::Variator;", 1),
        ("variator/law", "use super::run::{Variator, Event};", 1),
        ("attic/box", "", 1),
        ("variator/run/step", "use crate::variator::law::Slip; use super::Variator;", 0),
        ("variator/law/flanks", "// crate::variator::run\nuse super::place::Place;", 0),
        ("ring/beam", "#[cfg(test)]\nmod tests { use crate::variator::run::Variator; }", 0),
    ];
    for (module, text, expected) in cases {
        assert_eq!(problems_of(module, text), expected, "{module}: {text}");
    }
}

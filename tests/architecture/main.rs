//! Which room of `src/` may use which: the list in ARCHITECTURE.md against the imports of every file.

mod house;
mod rooms;
mod source;

use house::House;
use std::collections::BTreeMap;
use std::path::Path;

#[test]
fn rooms_use_only_what_the_list_allows() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let list = rooms::list(&page).unwrap_or_else(|error| panic!("ARCHITECTURE.md: {error}"));
    let problems = rooms::problems(&list, &House::read(&root.join("src")));
    assert!(problems.is_empty(), "\n{}", problems.join("\n"));
}

/// What a small house is found to have wrong.
fn problems(list: &str, files: &[(&str, &str)]) -> Vec<String> {
    let files: BTreeMap<_, _> = files
        .iter()
        .map(|&(path, text)| (path.to_owned(), text.to_owned()))
        .collect();
    let list = rooms::list(&format!("Rooms:\n\n```rooms\n{list}\n```\n")).expect("a list");
    rooms::problems(&list, &House::new(&files))
}

#[test]
fn what_the_list_allows_passes() {
    let files = [
        ("lib.rs", "//! About.\npub mod law; pub mod run;"),
        (
            "law/mod.rs",
            "mod friction; pub use friction::Friction; pub struct Law;",
        ),
        ("law/friction.rs", "use super::Law; pub struct Friction(Law);"),
        (
            "run.rs",
            "use crate::law::{self, Friction as F}; fn f(_: F) -> law::Law { law::Law }",
        ),
    ];
    assert_eq!(problems("law:\nrun: law", &files), Vec::<String>::new());
}

#[test]
fn an_arrow_up_is_named_with_file_and_import() {
    for import in [
        "use crate::run::Run;",
        "use super::run::{Run as R, other::X};",
        "fn f(_: crate::run::Run) {}",
        "macro_rules! run { () => { $crate::run::Run } }",
        "use super::run; fn f() { run::go() }",
        "fn f() { use crate::run::Kind::*; }",
        "use crate::run::*; fn f() {}",
        "mod inner { use super::super::run::Run; fn f() {} }",
    ] {
        let law = format!("{import} pub struct Law;");
        let files = [("law.rs", law.as_str()), ("run.rs", "pub struct Run;")];
        let found = problems("law:\nrun:", &files);
        assert_eq!(found.len(), 1, "{import}: {found:?}");
        let start = "law may not use run: src/law.rs uses src/run.rs by ";
        assert!(found[0].starts_with(start) && found[0].ends_with("line 1"), "{found:?}");
    }
}

#[test]
fn a_re_export_counts_as_the_file_that_defines_the_name() {
    let files = [
        (
            "ring/mod.rs",
            "pub mod beam; mod mesh; pub use mesh::Mesh; pub struct Ring;",
        ),
        ("ring/mesh.rs", "use super::beam::Beam; pub struct Mesh(Beam);"),
        ("ring/beam.rs", "use super::Mesh; pub struct Beam(Mesh);"),
    ];
    let found = problems("ring:", &files);
    assert_eq!(found.len(), 1, "{found:?}");
    for line in [
        "src/ring/mesh.rs uses src/ring/beam.rs by super::beam::Beam",
        "src/ring/beam.rs uses src/ring/mesh.rs by super::Mesh",
    ] {
        assert!(found[0].contains(line), "{found:?}");
    }
}

#[test]
fn a_module_that_uses_what_it_passes_on_is_in_the_circle() {
    let used = "mod mesh; pub use mesh::Mesh; pub struct Ring(Mesh);";
    let files = [
        ("ring/mod.rs", used),
        ("ring/mesh.rs", "use super::Ring; pub struct Mesh;"),
    ];
    assert_eq!(problems("ring:", &files).len(), 1);
}

#[test]
fn methods_stay_in_the_room_of_their_type() {
    let run = "use crate::law::{Law, Rule}; pub struct Run;
        impl<F: Fn() -> u8> Rule<F> for Run where for<'a> F: Fn(&'a u8) {}
        fn f() -> impl Rule { Run }
        impl Law<u8> { fn own() {} }
        impl<F: Fn() -> u8> Law<F> where for<'a> F: Fn(&'a u8) { pub fn all() {} }";
    let files = [
        (
            "law.rs",
            "pub struct Law<F>(F); pub trait Rule {} impl<F> Law<F> { pub fn f() {} }",
        ),
        ("run.rs", run),
    ];
    assert_eq!(
        problems("law:\nrun: law", &files),
        ["src/run.rs gives methods to a type of src/law.rs, another room: Law in line 5"]
    );
}

#[test]
fn tests_may_use_what_they_like_and_have_no_size() {
    let test = format!(
        "pub struct A;\n#[cfg(test)]\nmod tests {{\n    use crate::run::Run;\n{}}}\n",
        "\n".repeat(1500)
    );
    let files = [
        ("law.rs", test.as_str()),
        (
            "run.rs",
            "#[cfg(test)]\nmod check;\npub struct Run;\n#[cfg(test)]\nuse crate::other::Other;",
        ),
        ("run/check.rs", "use crate::other::Other;"),
        ("other.rs", "pub struct Other;"),
    ];
    assert_eq!(problems("law:\nrun:\nother:", &files), Vec::<String>::new());
}

#[test]
fn sizes_are_bounded() {
    let long = "fn f() {}\n".repeat(1501);
    let files = [("law.rs", long.as_str())];
    assert_eq!(
        problems("law:", &files),
        ["law has 1501 lines without its tests: at most 1500"]
    );
    assert_eq!(problems("law (1600 lines):", &files), Vec::<String>::new());
}

#[test]
fn the_list_is_whole_true_and_without_circles() {
    let files = [
        ("law.rs", "pub struct Law;"),
        ("run.rs", "use crate::law::Law; pub struct Run(Law);"),
    ];
    assert_eq!(problems("law:", &files), ["src/run.rs is in no room of the list"]);
    assert_eq!(
        problems("run: law\nlaw:", &files),
        ["run uses law, which doesn't stand above it in the list"]
    );
    assert_eq!(
        problems("law:\nrun: law\nend: run", &files),
        ["end doesn't use run: strike it", "end has no file"]
    );
    assert_eq!(
        problems("law:\nrun: law, mesh", &files),
        ["run uses mesh, which is not in the list"]
    );
    assert!(rooms::list("no list").is_err());
    assert!(rooms::list("```rooms\nlaw\n```").is_err());
}

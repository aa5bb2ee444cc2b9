//! Files of tables that a stranger hands over.

use std::fs;
use std::path::{Path, PathBuf};

use pushbelt_fmi::unit::Unit;
use pushbelt_map_unit::file::FILE;
use pushbelt_map_unit::tables::Tables;
use pushbelt_map_unit::unit::MapUnit;
use serde_json::{Value, json};

/// A folder of its own for a file of tables; removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("pushbelt maps {name} {}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn file(&self) -> PathBuf {
        self.0.join(FILE)
    }

    /// Why the file can't be used: one line that names it.
    fn refused(&self) -> String {
        let why = Tables::read(&self.0).map(drop).expect_err("a file that can't be used");
        assert!(
            why.contains(&self.file().display().to_string()) && !why.contains('\n'),
            "{why}"
        );
        why
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left in the temporary folder does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// What is no file of this size is not read: a pipe would keep the host waiting, and a device has no end.
#[cfg(unix)]
#[test]
fn what_is_no_file_and_a_large_file_are_refused_unread() {
    let folder = Folder::new("kinds");
    let makers: [&dyn Fn(&Path); 3] = [
        &|path| fs::create_dir(path).expect("a folder"),
        &|path| {
            assert!(
                std::process::Command::new("mkfifo")
                    .arg(path)
                    .status()
                    .expect("mkfifo")
                    .success()
            )
        },
        &|path| std::os::unix::fs::symlink("/dev/zero", path).expect("a link"),
    ];
    for make in makers {
        make(&folder.file());
        assert!(folder.refused().contains("not a file"));
        fs::remove_file(folder.file())
            .or_else(|_| fs::remove_dir(folder.file()))
            .expect("there");
    }
    // Sparse: it takes no room.
    let file = fs::File::create(folder.file()).expect("a file");
    file.set_len(1 << 40).expect("a length");
    let why = folder.refused();
    assert!(
        why.contains("1099511627776 bytes") && why.contains("more than 16777216"),
        "{why}"
    );
}

#[test]
fn a_byte_order_mark_is_no_part_of_the_tables() {
    let folder = Folder::new("mark");
    let text = fs::read(crate::folder().join(FILE)).expect("the tables");
    fs::write(folder.file(), [b"\xef\xbb\xbf", &*text].concat()).expect("a file");
    let found = Tables::read(&folder.0).expect("the same tables");
    assert_eq!(found.hash, Tables::read(&crate::folder()).expect("the tables").hash);
}

/// Why the checked-in document is refused after a change.
fn refused(change: impl FnOnce(&mut Value)) -> String {
    let text = fs::read(crate::folder().join(FILE)).expect("the tables");
    let mut document: Value = serde_json::from_slice(&text).expect("JSON");
    change(&mut document);
    let text = serde_json::to_vec(&document).expect("JSON");
    Tables::of_bytes(&text)
        .map(drop)
        .expect_err("tables that can't be used")
}

/// The first number in nested lists.
fn first(value: &mut Value) -> &mut Value {
    match value {
        Value::Array(items) => first(items.first_mut().expect("an item")),
        number => number,
    }
}

#[test]
fn a_number_out_of_range_is_named() {
    let text = fs::read(crate::folder().join(FILE)).expect("the tables");
    let document: Value = serde_json::from_slice(&text).expect("JSON");
    let names = |part| document[part].as_object().expect("an object").keys();
    let parts = ["parameters", "axes", "tables"];
    for part in parts {
        for name in names(part) {
            for wild in [1e308, -1e308] {
                let why = refused(|document| match part {
                    "parameters" => document[part][name] = json!(wild),
                    _ => *first(&mut document[part][name]["values"]) = json!(wild),
                });
                assert!(why.contains(name) && why.contains("out of range"), "{name}: {why}");
                assert!(why.contains(&format!("{wild:?}")), "{name}: {why}");
            }
        }
    }
    for (name, small) in [
        ("capacity", -1e-300),
        ("capacitySlip", -1e-300),
        ("thrustRatio", 1e-300),
    ] {
        let why = refused(|document| *first(&mut document["tables"][name]["values"]) = json!(small));
        assert!(why.contains(name), "{why}");
    }
    let why = refused(|document| document["axes"]["ratio"]["values"][1] = json!(0.397_304 + 1e-15));
    assert!(why.contains("ratio") && why.contains("ascend"), "{why}");
}

#[test]
fn tables_that_grow_too_large_are_refused_before_they_are_refined() {
    let axis = |count: usize| -> Vec<f64> { (1..=count).map(|k| k as f64).collect() };
    let why = refused(|document| document["axes"]["force"]["values"] = json!(axis(1000)));
    assert!(why.contains("16777216") && why.contains("forces"), "{why}");
    let why = refused(|document| {
        for name in ["force", "speed"] {
            document["axes"][name]["values"] = json!(axis(90_000));
        }
    });
    assert!(why.contains("16777216"), "{why}");
}

/// On the stack that the docs ask of hosts.
#[test]
fn deeply_nested_lists_are_refused() {
    let text = format!("{}0{}", "[".repeat(1_000_000), "]".repeat(1_000_000));
    let host = std::thread::Builder::new().stack_size(256 * 1024);
    let host = host.spawn(move || Tables::of_bytes(text.as_bytes()).map(drop));
    let why = host.expect("a thread").join().expect("no panic").unwrap_err();
    assert!(why.contains("not JSON"), "{why}");
}

#[test]
fn damaged_tables_are_refused() {
    let text = fs::read_to_string(crate::folder().join(FILE)).expect("the tables");
    let tables = Tables::of_bytes(text.as_bytes()).expect("tables");
    let damaged = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        Tables::of_bytes(text.replacen(from, to, 1).as_bytes())
            .map(drop)
            .unwrap_err()
    };
    assert!(damaged("{", "[").contains("not JSON"));
    assert!(damaged("pushbelt map unit", "maps").contains("format"));
    assert!(damaged("\"version\":1", "\"version\":2").contains("version"));
    assert!(damaged("\"thrustRatio\":", "\"other\":").contains("thrustRatio"));
    assert!(damaged("\"geometry.beltLength\":0.703", "\"geometry.beltLength\":0.3").contains("geometry"));
    assert!(
        damaged(
            "\"force\":{\"unit\":\"N\",\"values\":[2500.0",
            "\"force\":{\"unit\":\"N\",\"values\":[9500.0"
        )
        .contains("ascend")
    );
    let shorter = Tables::of_bytes(&text.as_bytes()[..text.len() / 2]).map(drop);
    assert!(shorter.unwrap_err().contains("not JSON"));
    let other = text.replacen("\"pushbelt map unit\"", " \"pushbelt map unit\"", 1);
    assert_ne!(
        Tables::of_bytes(other.as_bytes()).expect("the same tables").hash,
        tables.hash
    );
    let missing = Tables::read(Path::new("/no/such/folder")).map(drop).unwrap_err();
    assert!(missing.contains("maps.json"), "{missing}");
    assert!(MapUnit::load(None).map(drop).unwrap_err().contains("resources"));
}

//! Files of tables that a stranger hands over.

use std::fs;

use pushbelt_fmi::unit::Unit;
use pushbelt_map_unit::file::FILE;
use pushbelt_map_unit::tables::Tables;
use pushbelt_map_unit::unit::MapUnit;
use serde_json::{Value, json};

fn text() -> Vec<u8> {
    fs::read(crate::folder().join(FILE)).expect("the checked-in tables")
}

fn document() -> Value {
    serde_json::from_slice(&text()).expect("JSON")
}

/// What is no file of this size is not read: a pipe would keep the host waiting, and a device has no end. A mark is no part of a file.
#[cfg(unix)]
#[test]
fn other_than_files_and_large_files_are_refused_unread() {
    let folder = std::env::temp_dir().join(format!("pushbelt maps {}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(FILE);
    let refused = |word: &str| {
        let why = Tables::read(&folder).map(drop).expect_err("a file that can't be used");
        let named = why.contains(&file.display().to_string()) && !why.contains('\n');
        assert!(named && why.contains(word), "{why}");
    };
    refused("no such file");
    std::os::unix::fs::symlink("/dev/zero", &file).expect("a link");
    refused("not a file");
    fs::remove_file(&file).expect("there");
    let pipe = std::process::Command::new("mkfifo").arg(&file).status();
    assert!(pipe.expect("mkfifo").success());
    refused("not a file");
    fs::remove_file(&file).expect("there");
    // Sparse: it takes no room.
    let large = fs::File::create(&file).expect("a file");
    large.set_len(1 << 40).expect("a length");
    refused("more than 16777216 bytes");
    fs::write(&file, [b"\xef\xbb\xbf", &*text()].concat()).expect("a file");
    let marked = Tables::read(&folder).expect("the same tables").hash;
    assert_eq!(marked, Tables::of_bytes(&text()).expect("the tables").hash);
    fs::remove_dir_all(&folder).expect("there");
}

/// Why the content of a file is refused.
fn why(bytes: &[u8]) -> String {
    let read = Tables::of_bytes(bytes).map(drop);
    read.expect_err("tables that can't be used")
}

/// Why the checked-in document is refused after a change.
fn refused(change: impl FnOnce(&mut Value)) -> String {
    let mut document = document();
    change(&mut document);
    why(&serde_json::to_vec(&document).expect("JSON"))
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
    for part in ["parameters", "axes", "tables"] {
        for name in document()[part].as_object().expect("an object").keys() {
            for wild in [1e308, -1e308] {
                let why = refused(|document| match part {
                    "parameters" => document[part][name] = json!(wild),
                    _ => *first(&mut document[part][name]["values"]) = json!(wild),
                });
                let value = [wild.to_string(), format!("{wild:?}")]
                    .iter()
                    .any(|shown| why.contains(shown));
                assert!(
                    why.contains(name) && why.contains("out of range") && value,
                    "{name}: {why}"
                );
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
    for (names, count) in [
        (&["force"][..], 1000),
        (&["force", "speed"], 90_000),
        (&["utilisation"], 700_000),
    ] {
        let step = if names == ["utilisation"] { 1e-5 } else { 1.0 };
        let axis: Vec<f64> = (1..=count).map(|k| step * f64::from(k)).collect();
        let why = refused(|document| {
            names
                .iter()
                .for_each(|name| document["axes"][name]["values"] = json!(axis))
        });
        assert!(why.contains("16777216") && why.contains("forces"), "{why}");
    }
}

/// Between its ratios, the refined table is linear. Beyond the axes the values at the border hold.
#[test]
fn values_are_those_of_the_file() {
    let document = document();
    let tables = Tables::of_bytes(&text()).expect("tables");
    let [forces, speeds, ratios] = ["force", "speed", "ratio"]
        .map(|name| -> Vec<f64> { serde_json::from_value(document["axes"][name]["values"].clone()).expect("numbers") });
    let limits = |[force, speed, ratio]: [f64; 3]| {
        let place = tables.place(force, speed, ratio.ln());
        (tables.limits(&place), place.outside)
    };
    for (f, &force) in forces.iter().enumerate() {
        for (s, &speed) in speeds.iter().enumerate() {
            for (r, &ratio) in ratios.iter().enumerate() {
                let found = limits([force, speed, ratio]);
                let far = |is_last: bool| if is_last { 9.0 } else { 1.0 };
                let far = [
                    far(f + 1 == forces.len()),
                    far(s + 1 == speeds.len()),
                    far(r + 1 == ratios.len()),
                ];
                let held = limits([far[0] * force, far[1] * speed, far[2] * ratio]);
                assert_eq!(held, (found.0, far != [1.0; 3]));
                for (direction, found) in found.0[..2].iter().enumerate() {
                    let expected = document["tables"]["capacity"]["values"][f][s][r][direction].as_f64();
                    assert!(
                        (found - expected.expect("a number")).abs() < 1e-3,
                        "{found} {expected:?}"
                    );
                }
            }
        }
    }
}

/// On the stack that the docs ask of hosts.
#[test]
fn deeply_nested_lists_are_refused() {
    let text = format!("{}0{}", "[".repeat(1_000_000), "]".repeat(1_000_000));
    let host = std::thread::Builder::new().stack_size(256 * 1024);
    let host = host.spawn(move || why(text.as_bytes())).expect("a thread");
    assert!(host.join().expect("no panic").contains("not JSON"));
}

#[test]
fn damaged_tables_are_refused() {
    let bytes = text();
    let text = std::str::from_utf8(&bytes).expect("text");
    for (from, to, word) in [
        ("{", "[", "not JSON"),
        ("pushbelt map unit", "maps", "format"),
        (r#""version":1"#, r#""version":2"#, "version"),
        (r#""thrustRatio":"#, r#""other":"#, "thrustRatio"),
        (
            r#""geometry.beltLength":0.703"#,
            r#""geometry.beltLength":0.3"#,
            "geometry",
        ),
        (r#""N","values":[2500.0"#, r#""N","values":[9500.0"#, "ascend"),
    ] {
        assert!(text.contains(from), "{from}");
        let why = why(text.replacen(from, to, 1).as_bytes());
        assert!(why.contains(word), "{why}");
    }
    assert!(why(&bytes[..bytes.len() / 2]).contains("not JSON"));
    let hash = |text: &str| Tables::of_bytes(text.as_bytes()).expect("tables").hash;
    assert_ne!(hash(text), hash(&text.replacen(':', ": ", 1)));
    assert!(MapUnit::load(None).map(drop).unwrap_err().contains("resources"));
}

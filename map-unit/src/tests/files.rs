//! Damaged and other files of tables.

use std::array::from_fn;
use std::fs;

use pushbelt_fmi::unit::Unit;
use serde_json::{Value, json};

use crate::file::{FILE, flat};
use crate::tables::Tables;
use crate::unit::MapUnit;

fn text() -> Vec<u8> {
    fs::read(super::folder().join(FILE)).expect("the checked-in tables")
}

fn document() -> Value {
    serde_json::from_slice(&text()).expect("JSON")
}

/// A device has no end. A byte-order mark is no part of a file.
#[cfg(unix)]
#[test]
fn other_than_files_and_large_files_are_refused_unread() {
    let folder = std::env::temp_dir().join(format!("pushbelt maps {}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join(FILE);
    let refused = |word: &str| {
        let why = MapUnit::load(Some(&folder))
            .map(drop)
            .expect_err("a file that can't be used");
        let named = why.contains(&file.display().to_string()) && !why.contains('\n');
        assert!(named && why.contains(word), "{why}");
    };
    refused("no such file");
    std::os::unix::fs::symlink("/dev/zero", &file).expect("a link");
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
    assert!(MapUnit::load(None).map(drop).unwrap_err().contains("resources"));
}

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
                let value = why.contains(&format!("{wild}")) || why.contains(&format!("{wild:?}"));
                let named = why.contains(name) && why.contains("out of range");
                assert!(named && value, "{name}: {why}");
            }
        }
    }
    for name in ["capacity", "capacitySlip", "thrustRatioAtShare"] {
        let small = if name == "thrustRatioAtShare" { 1e-300 } else { -1e-300 };
        let why = refused(|document| *first(&mut document["tables"][name]["values"]) = json!(small));
        assert!(why.contains(name), "{why}");
    }
    let why = refused(|document| document["axes"]["ratio"]["values"][1] = json!(0.397_304 + 1e-15));
    assert!(why.contains("ratio") && why.contains("ascend"), "{why}");
}

#[test]
fn tables_that_grow_too_large_are_refused_before_they_are_refined() {
    for (name, count, step) in [("force", 1000, 1.0), ("shiftUtilisation", 700_000, 1e-5)] {
        let axis: Vec<f64> = (1..=count).map(|k| step * f64::from(k)).collect();
        let why = refused(|document| document["axes"][name]["values"] = json!(axis));
        assert!(why.contains("16777216") && why.contains("forces"), "{why}");
    }
}

/// Beyond the axes the values at the border hold.
#[test]
fn values_are_those_of_the_file() {
    let document = document();
    let tables = Tables::of_bytes(&text()).expect("tables");
    let axes = ["force", "speed", "ratio"].map(|name| flat(&document["axes"][name]["values"]));
    let limits = |[force, speed, ratio]: [f64; 3]| {
        let position = tables.position(force, speed, ratio.ln());
        let rates = [-1.0, 1.0].map(|utilisation| tables.shift_rate(&position, utilisation, 9.0).value);
        let limits = tables.limits.interpolate(&position, 0, 0.0);
        (limits.map(|limit| limit.value), rates, position.outside)
    };
    let [_, speeds, ratios] = axes.each_ref().map(Vec::len);
    let [capacity, rates] = ["capacity", "shiftRate"].map(|name| flat(&document["tables"][name]["values"]));
    let [excesses, utilisations] =
        ["excess", "shiftUtilisation"].map(|name| flat(&document["axes"][name]["values"]).len());
    let of_points = capacity.chunks(2).zip(rates.chunks(excesses * utilisations));
    for (k, (expected, rates)) in of_points.enumerate() {
        let indices = [k / ratios / speeds, k / ratios % speeds, k % ratios];
        let point = from_fn(|n| axes[n][indices[n]]);
        let is_last: [bool; 3] = from_fn(|n| indices[n] + 1 == axes[n].len());
        let (found, shifts, _) = limits(point);
        let beyond = from_fn(|n| if is_last[n] { 9.0 * point[n] } else { point[n] });
        assert_eq!(limits(beyond), (found, shifts, is_last.contains(&true)));
        let off = [0, 1].map(|direction| (found[direction] - expected[direction]).abs());
        assert!(off[0].max(off[1]) < 1e-3, "{found:?} {expected:?}");
        let off = [shifts[0] / rates[excesses - 1], shifts[1] / rates[rates.len() - 1]];
        let off = off.map(|share| (share - 1.0).abs());
        assert!(off[0].max(off[1]) < 1e-2, "{shifts:?} {rates:?}");
    }
}

#[test]
fn damaged_tables_are_refused() {
    let bytes = text();
    let text = std::str::from_utf8(&bytes).expect("text");
    for (from, to, word) in [
        ("{", "[", "not JSON"),
        ("{", &"[".repeat(1_000_000), "not JSON"),
        ("pushbelt map unit", "maps", "format"),
        (r#""version":2"#, r#""version":1"#, "version"),
        (r#""thrustRatioAtShare":"#, r#""other":"#, "thrustRatioAtShare"),
        (r#"Length":0.703"#, r#"Length":0.3"#, "geometry"),
        (r#""N","values":[2500.0"#, r#""N","values":[9500.0"#, "ascend"),
    ] {
        assert!(text.contains(from), "{from}");
        let why = why(text.replacen(from, to, 1).as_bytes());
        assert!(why.contains(word), "{why}");
    }
    assert!(why(&bytes[..bytes.len() / 2]).contains("not JSON"));
    let hash = |text: &str| Tables::of_bytes(text.as_bytes()).expect("tables").hash;
    assert_ne!(hash(text), hash(&text.replacen(':', ": ", 1)));
}

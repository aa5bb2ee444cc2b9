//! The program behind `cargo fmu elements`: files, runs that go on, bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // It is there if the test ran before.
    let _ = fs::remove_dir_all(&folder);
    folder
}

fn run(folder: &Path, words: &[&str]) -> (Output, String) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pushbelt-elements"));
    let output = program.arg("--output").arg(folder).args(words).output().unwrap();
    let errors = String::from_utf8(output.stderr.clone()).unwrap();
    (output, errors)
}

#[test]
fn a_run_goes_on_where_it_was_stored_and_ends_with_the_same_files() {
    let (whole, parts) = (folder("whole"), folder("parts"));
    let words = ["medium-0.4", "--duration", "0.004", "--store", "700"];
    run(&whole, &words);
    run(&parts, &words);
    // The run is done: it is read from its state, and nothing is computed again.
    let state = fs::read(parts.join("medium-0.4.state")).unwrap();
    let (_, errors) = run(&parts, &words);
    assert!(errors.contains("goes on at 0.0040 s"), "{errors}");
    assert_eq!(state, fs::read(parts.join("medium-0.4.state")).unwrap());
    for name in ["medium-0.4.csv", "medium-0.4-fields.csv", "results.csv"] {
        let [a, b] = [&whole, &parts].map(|folder| fs::read_to_string(folder.join(name)).unwrap());
        assert_eq!(a, b, "{name}");
        assert!(!a.contains("NaN") || name.contains("fields"), "{a}");
    }
    let rows = fs::read_to_string(parts.join("medium-0.4.csv")).unwrap();
    assert_eq!(rows.lines().count(), 5);
    // A state of other settings, or a damaged one, is not used.
    let (_, errors) = run(&parts, &["medium-0.4", "--duration", "0.003", "--force", "12000"]);
    assert!(!errors.contains("goes on"), "{errors}");
    fs::write(parts.join("medium-0.4.state"), &state[..state.len() - 3]).unwrap();
    let (_, errors) = run(&parts, &words);
    assert!(!errors.contains("goes on"), "{errors}");
}

#[test]
fn bad_input_is_one_line_and_no_run() {
    let place = folder("bad");
    for (name, word, expected) in [
        ("medium-1.5", "", "share = 1.5"),
        ("flat-0.4", "", "RATIO-SHARE"),
        ("medium", "", "RATIO-SHARE"),
        ("9-0.4", "", "ratio"),
        ("medium-0.4", "--set=belt.plai=1", "belt.plai"),
        ("medium-0.4", "--set=belt.play", "NAME=VALUE"),
        ("medium-0.4", "--set=belt.play=much", "much"),
        ("medium-0.4", "--set=ring.layers=1.5", "1.5"),
        ("medium-0.4", "--set=ring.layers=30", "lever"),
        ("medium-0.4", "--set=ring.layers=20", "lever"),
        ("medium-0.4", "--set=belt.play=-1", "belt.play"),
        (
            "medium-0.4",
            "--set=belt.elementThickness=0.09",
            "belt.elementThickness",
        ),
        ("medium-0.4", "--set=friction.pulley=0.5", "friction.pulley"),
        ("medium-0.4", "--lever=-1e-4", "lever"),
        ("medium-0.4", "--force=NaN", "force"),
        ("medium-0.4", "--step=1", "step"),
        ("medium-0.4", "--film=0", "film"),
    ] {
        let words = if word.is_empty() { vec![name] } else { vec![name, word] };
        let (output, errors) = run(&place, &words);
        assert!(
            !output.status.success() && errors.contains(expected),
            "{words:?}: {errors}"
        );
        assert_eq!(errors.lines().count(), 1, "{errors}");
    }
    assert!(!place.join("results.csv").exists());
}

#[test]
fn a_failure_keeps_the_results_so_far() {
    let place = folder("fails");
    let words = ["medium-0.4", "--duration", "0.05", "--step", "5e-5", "--store", "20"];
    let (output, errors) = run(&place, &words);
    let last = errors.lines().last().unwrap();
    assert!(
        !output.status.success() && last.starts_with("medium-0.4: element "),
        "{errors}"
    );
    assert!(last.contains(" s: ") && last.contains("step"), "{last}");
    let rows = fs::read_to_string(place.join("medium-0.4.csv")).unwrap();
    assert!(rows.starts_with("time,ratio,thrustRatio"));
}

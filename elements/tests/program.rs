//! The program behind `cargo fmu elements`: files, runs that go on, bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // It is there if the test ran before.
    let _ = fs::remove_dir_all(&folder);
    folder
}

/// Whether a run succeeds, and its errors.
fn run(folder: &Path, words: &[&str]) -> (bool, String) {
    let mut program = Command::new(env!("CARGO_BIN_EXE_pushbelt-elements"));
    let output = program.arg("--output").arg(folder).args(words).output().unwrap();
    (output.status.success(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_run_that_is_done_is_read_from_its_state_and_played() {
    let place = folder("parts");
    let words = ["medium-0.4", "--duration", "0.004", "--step", "8e-6", "--store", "200"];
    let text = |name: &str| fs::read_to_string(place.join(name)).unwrap();
    run(&place, &words);
    let names = ["medium-0.4.csv", "medium-0.4-fields.csv", "results.csv"];
    let before = names.map(text);
    assert!(!before[0].contains("NaN"), "{}", before[0]);
    assert_eq!(before[0].lines().count(), 5);
    let (_, errors) = run(&place, &[&words[..], &["--report"]].concat());
    assert!(errors.contains("goes on at 0.0040 s"), "{errors}");
    assert_eq!(before, names.map(text));
    let page = text("medium-0.4.html");
    assert!(!page.contains("{{") && !page.contains("://") && page.len() < 2_000_000);
    assert!(page.contains("count: 464") && page.contains("ratio 1.0"));
    // A state of other settings, or a damaged one, is not used.
    let state = fs::read(place.join("medium-0.4.state")).unwrap();
    let (_, errors) = run(&place, &["medium-0.4", "--duration", "0.003", "--force", "12000"]);
    assert!(!errors.contains("goes on"), "{errors}");
    fs::write(place.join("medium-0.4.state"), &state[..state.len() - 3]).unwrap();
    let (_, errors) = run(&place, &words);
    assert!(!errors.contains("goes on"), "{errors}");
}

#[test]
fn bad_input_is_one_line_and_no_run() {
    let place = folder("bad");
    for (name, word, expected) in [
        ("medium-1.5", "--restart", "share = 1.5"),
        ("medium", "--restart", "RATIO-SHARE"),
        ("9-0.4", "--restart", "ratio"),
        ("medium-0.4", "--set=belt.plai=1", "belt.plai"),
        ("medium-0.4", "--set=belt.play", "NAME=VALUE"),
        ("medium-0.4", "--set=belt.play=much", "much"),
        ("medium-0.4", "--set=ring.layers=1.5", "1.5"),
        ("medium-0.4", "--set=ring.layers=30", "lever"),
        ("medium-0.4", "--set=belt.play=-1", "belt.play"),
        ("medium-0.4", "--set=belt.elementThickness=0.09", "Thickness"),
        ("medium-0.4", "--set=friction.pulley=0.5", "friction.pulley"),
        ("medium-0.4", "--lever=-1e-4", "lever"),
        ("short", "--force=12e3", "a set's cases"),
        ("medium-0.4", "--force=NaN", "force"),
        ("medium-0.4", "--step=1", "step"),
        ("medium-0.4", "--film=0", "film"),
        ("medium-0.4", "--shift=-2", "shift"),
        ("medium-0.4", "--crown=-1", "crown"),
        ("medium-0.4", "--spread=0.5", "spread"),
    ] {
        let (done, errors) = run(&place, &[name, word]);
        assert!(!done && errors.contains(expected), "{name} {word}: {errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
    }
    assert!(!place.join("results.csv").exists());
}

#[test]
fn a_line_of_tone_has_amplitudes() {
    let place = folder("tone");
    let words = ["medium-0.4", "--pitch", "--tone", "--duration=0.006", "--step=4e-6"];
    run(&place, &words);
    let results = || fs::read_to_string(place.join("results.csv")).unwrap();
    let lines = results();
    let [names, values] = [0, 1].map(|k| lines.lines().nth(k).unwrap().split(',').collect::<Vec<_>>());
    assert_eq!(names.len(), values.len(), "{lines}");
    assert_eq!(names[10], "secondary.axialForce.N");
    assert!(values[10].parse::<f64>().unwrap() > 0.1, "{lines}");
    // The state of a run that is done has the samples.
    let (_, errors) = run(&place, &words);
    assert!(errors.contains("goes on"), "{errors}");
    assert_eq!(lines, results());
    let (_, errors) = run(&place, &["medium-0.4", "--pitch", "--continuum"]);
    assert!(errors.contains("neither pitch"), "{errors}");
}

#[test]
fn a_failure_keeps_the_results_so_far() {
    let place = folder("fails");
    let words = ["medium-0.4", "--duration", "0.05", "--step", "5e-5", "--store", "20"];
    let (done, errors) = run(&place, &words);
    let last = errors.lines().last().unwrap();
    assert!(!done && last.starts_with("medium-0.4: element "), "{errors}");
    assert!(last.contains(" s: ") && last.contains("step"), "{last}");
    let rows = fs::read_to_string(place.join("medium-0.4.csv")).unwrap();
    assert!(rows.starts_with("time,ratio,thrustRatio"));
}

/// Lines of the stored results are the cases of their sets.
#[test]
fn stored_lines_are_cases_of_their_sets() {
    let pitch = include_str!("../results/pitch.csv");
    let tone = include_str!("../../resources/tone.csv");
    for (set, stored) in [("pitch ", pitch), ("tone ", tone)] {
        let sets = include_str!("../results/sets.txt").lines();
        let names = sets.filter_map(|line| line.strip_prefix(set)).map(|line| {
            let words: Vec<_> = line.split(' ').collect();
            let label = words.windows(2).find(|pair| pair[0] == "--label");
            label.map_or(words[0].to_owned(), |label| format!("{}-{}", words[0], label[1]))
        });
        let mut expected: Vec<_> = names.collect();
        expected.sort_unstable();
        let found = stored.lines().skip(1).map(|line| line.split(',').next().unwrap());
        assert_eq!(found.collect::<Vec<_>>(), expected);
    }
}

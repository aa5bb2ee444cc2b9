//! Call sequences in random order with random and bad arguments on a belt, in FMI 2.0 and in FMI
//! 3.0 with an importer that handles events, early returns and intermediate updates, or some of
//! them.
//!
//! The long run: `PUSHBELT_SEQUENCES=100000 PUSHBELT_DEFAULT_SEQUENCES=1000 cargo test --test
//! sequences`. A short run under valgrind is a test, too. Where valgrind is not installed it counts
//! as ignored, and where `CI` is set it fails.

#![allow(unsafe_code, reason = "it calls C functions")]

mod calls;
#[allow(dead_code, reason = "it has more than these tests use")]
#[path = "../../crates/fmi/tests/fmi/importer.rs"]
mod importer;
mod random_importer;
#[allow(dead_code, reason = "it has more than these tests use")]
#[path = "../fmi/variator.rs"]
mod variator;

use libtest_mimic::{Arguments, Failed, Trial};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use pushbelt::fmi as layer;
use pushbelt::fmi::Version::{self, Three, Two};
use pushbelt_support::shared_library::count;
use random_importer::{RandomImporter, Seen};
use std::process::{Command, ExitCode, Stdio};

fn check(version: Version, coarse: bool) -> Result<(), Failed> {
    let (cases, length) = if coarse {
        (count("PUSHBELT_SEQUENCES", 1000), 60)
    } else {
        (count("PUSHBELT_DEFAULT_SEQUENCES", 3), 40)
    };
    let seen = Seen::default();
    let config = Config {
        cases,
        failure_persistence: None,
        max_shrink_iters: 2000,
        ..Config::default()
    };
    // The sequences are the same in every run; more cases extend them.
    let seed = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let sequences = (any::<[bool; 3]>(), vec(calls::calls(), 1..length));
    TestRunner::new_with_rng(config, seed).run(&sequences, |(modes, calls)| {
        let mut random = RandomImporter::new(version, &seen, coarse, modes);
        calls.iter().for_each(|call| random.make(call));
        Ok(())
    })?;
    let of_both = [&seen.steps, &seen.refused, &seen.restored];
    let of_three = [&seen.events, &seen.early].into_iter().filter(|_| version == Three);
    let needed = of_both.into_iter().chain(of_three);
    let least = needed.map(std::cell::Cell::get).min();
    let enough = least > Some(0) && 4 * seen.steps.get() > cases;
    assert!(cases < 1000 || enough, "{seen:?}");
    Ok(())
}

/// Names of the tests that run under valgrind.
const COARSE: &str = "random_sequences_with_a_coarse_reference_ring";
const COARSE3: &str = "random_sequences_of_fmi_3_with_a_coarse_reference_ring";

fn valgrind_is_there() -> bool {
    let mut command = Command::new("valgrind");
    let silent = command.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    silent.status().is_ok_and(|status| status.success())
}

/// No invalid access, no leak, in the test of this name.
fn valgrind(name: &str) -> Result<(), Failed> {
    let test = std::env::current_exe()?;
    let output = Command::new("valgrind")
        .args(["--quiet", "--error-exitcode=9", "--leak-check=full"])
        .args(["--errors-for-leak-kinds=definite", "--show-leak-kinds=definite"])
        .arg(test)
        .args(["--exact", name, "--test-threads=1"])
        .env("PUSHBELT_SEQUENCES", "6")
        .output()
        .map_err(|error| format!("valgrind can't be started: {error}"))?;
    let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    if !output.status.success() {
        return Err(format!("{out}{err}").into());
    }
    if !out.contains("1 passed") {
        return Err(format!("nothing ran under valgrind: {out}").into());
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = vec![
        Trial::test(COARSE, || check(Two, true)),
        Trial::test("random_sequences_with_the_default_model", || check(Two, false)),
        Trial::test(COARSE3, || check(Three, true)),
        Trial::test("random_sequences_of_fmi_3_with_the_default_model", || {
            check(Three, false)
        }),
    ];
    if cfg!(target_os = "linux") {
        let skipped = !valgrind_is_there() && std::env::var_os("CI").is_none();
        if skipped && !arguments.list {
            eprintln!("valgrind is not installed: valgrind_finds_nothing is ignored");
        }
        for (test, name) in [
            ("valgrind_finds_nothing", COARSE),
            ("valgrind_finds_nothing_in_fmi_3", COARSE3),
        ] {
            trials.push(Trial::test(test, move || valgrind(name)).with_ignored_flag(skipped));
        }
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

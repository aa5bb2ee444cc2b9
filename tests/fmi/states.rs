//! Stored states of a running belt, and their bytes.

use pushbelt::fmi::hash;
use pushbelt::fmi::log::Status::{Error, Ok};
use pushbelt::fmi::slave::Version::{Three, Two};

use crate::importer::Handles;
use crate::variator::{Importer, ramp, reference};

/// In the ramp of the loads and after it, with a parameter that is not yet in force, also in the other version.
#[test]
fn a_state_is_continued_bit_for_bit_in_every_instance() {
    let importer = Importer::coarse(Two, Handles::default());
    importer.choose("secondary.drive", 2);
    importer.start();
    importer.advance(0.0, 0.004);
    let early = (4, importer.bytes(), importer.run(4));
    importer.put("friction.pulley", 0.08);
    importer.advance(0.014, 0.006);
    importer.put("friction.ring", 0.04);
    ramp(&importer, "primary.torque", 3e3);
    let mut state = importer.stored();
    let late = (20, importer.bytes(), importer.run(20));
    assert_eq!(importer.restore(state), Ok);
    assert!(importer.run(20) == late.2, "the instance itself");
    assert_eq!(importer.free(&mut state), Ok);
    let required = [reference("thrustRatio")];
    for (from, bytes, expected) in [early, late] {
        let running = Importer::running(Three);
        running.advance(0.0, 0.007);
        let watching = Importer::handling(Three, Handles::of(false, false, &required));
        for other in [Importer::new(Two), running, watching] {
            assert_eq!(other.continue_from(&bytes), Ok, "{}", other.last());
            assert!(other.bytes() == bytes, "a state at rest is itself");
            assert!(other.run(from) == expected, "{from} ms");
        }
    }
}

/// A deliberate change of a stored state.
#[derive(Clone, Copy, Debug)]
enum Harm {
    Flip(u8),
    /// Eight bytes: numbers that no run produces, and counts that exceed the memory.
    Word(u64),
}

/// Deliberately changed bytes with a valid checksum are refused, or give a state that runs or fails in the ordinary way: no
/// panic, bounded memory, and steps that end.
#[test]
fn manipulated_bytes_cause_no_panic_and_no_unbounded_work() {
    use proptest::prelude::{Strategy, any, prop_oneof};
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

    let bytes = {
        let importer = Importer::running(Two);
        importer.advance(0.0, 0.003);
        importer.bytes()
    };
    let reseal = |bytes: &mut Vec<u8>| {
        bytes.truncate(bytes.len() - 16);
        bytes.extend(hash::of_words(bytes).to_le_bytes());
    };
    let importer = Importer::running(Two);
    let wild = [f64::NAN, f64::INFINITY, f64::MAX, -1e300].map(f64::to_bits);
    let wild = [&wild[..], &[u64::MAX, 1 << 40]].concat();
    let harm = prop_oneof![
        (0_u8..8).prop_map(Harm::Flip),
        proptest::sample::select(wild).prop_map(Harm::Word),
        any::<u64>().prop_map(Harm::Word),
    ];
    // The head and the settings are short compared with the matrices: half of the changes are there.
    let head = 52..2000.min(bytes.len() - 16);
    let place = prop_oneof![head, 52..bytes.len() - 24];
    let cases = pushbelt_support::shared_library::count("PUSHBELT_STRANGERS", 400);
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let taken = std::cell::Cell::new(0);
    let result = runner.run(&proptest::collection::vec((place, harm), 1..4), |harms| {
        let mut bytes = bytes.clone();
        for (at, harm) in harms {
            match harm {
                Harm::Flip(bit) => bytes[at] ^= 1 << bit,
                Harm::Word(word) => bytes[at..at + 8].copy_from_slice(&word.to_le_bytes()),
            }
        }
        reseal(&mut bytes);
        let allocated = allocation_counter::measure(|| {
            if importer.continue_from(&bytes) == Ok {
                taken.set(taken.get() + 1);
                importer.step(0.003, 0.001);
                importer.step(0.004, 0.001);
            }
        });
        assert!(allocated.bytes_max < 256 << 20, "{} bytes at once", allocated.bytes_max);
        let messages = importer.record.messages.borrow();
        let panic = messages.iter().find(|(_, _, text)| text.contains("internal error"));
        assert!(panic.is_none(), "{panic:?}");
        Result::Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
    let taken = taken.get();
    assert!((cases / 10..cases).contains(&taken), "{taken} of {cases} were taken");
    // The instance itself still works.
    assert_eq!(importer.continue_from(&bytes), Ok);
    importer.advance(0.003, 0.001);
    assert_eq!(importer.continue_from(&bytes[1..]), Error);
}

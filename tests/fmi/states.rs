//! Stored states of a running belt, and their bytes.

use crate::importer::Handles;
use crate::variator::{Importer, ramp, real_outputs, reference};
use pushbelt::fmi::Version::{Three, Two};
use pushbelt::fmi::hash;
use pushbelt::fmi::log::Status::{Error, Ok};

/// In the ramp of the loads and after it, with a parameter that is not yet in force, also in the
/// other version.
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
    let state = importer.stored();
    let late = (20, importer.bytes(), importer.run(20));
    assert_eq!(importer.restore(state), Ok);
    assert!(importer.run(20) == late.2, "the instance itself");
    let required = [reference("thrustRatio")];
    for (from, bytes, expected) in [early, late] {
        let running = Importer::running(Three);
        running.advance(0.0, 0.007);
        let watching = Importer::handling(Three, Handles::updates(&required));
        for other in [Importer::new(Two), running, watching] {
            assert_eq!(other.continue_from(&bytes), Ok, "{}", other.last());
            assert!(other.bytes() == bytes, "a state at rest is itself");
            assert!(other.run(from) == expected, "{from} ms");
        }
    }
}

/// Outputs, and their derivatives unless these are refused.
fn assert_finite(importer: &Importer) {
    let slopes = importer.derivatives(&real_outputs(), 1).unwrap_or_default();
    let outputs = importer.readings().into_iter().map(f64::from_bits);
    let wild: Vec<_> = outputs.chain(slopes).filter(|value| !value.is_finite()).collect();
    assert!(wild.is_empty(), "{wild:?}");
}

/// Deliberately changed bytes with a valid checksum are refused, or give a state that runs or fails
/// in the ordinary way: no panic, bounded memory, steps that end, and finite outputs.
#[test]
fn manipulated_bytes_cause_no_panic_and_no_unbounded_work() {
    use proptest::prelude::{Just, Strategy, any, prop_oneof};
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

    let running = |mode: i32| {
        let importer = Importer::coarse(Two, Handles::default());
        importer.choose("solver.mode", mode);
        importer.start();
        importer.advance(0.0, 0.003);
        importer
    };
    let stored = [1, 2].map(|mode| running(mode).bytes());
    let reseal = |bytes: &mut Vec<u8>| {
        bytes.truncate(bytes.len() - 16);
        bytes.extend(hash::of_words(bytes).to_le_bytes());
    };
    let importer = running(1);
    // Numbers that no run produces, counts that exceed the memory, any eight bytes; no word is a
    // flipped bit.
    let wild = [f64::NAN, f64::INFINITY, f64::MAX, -1e300].map(f64::to_bits);
    let wild = [&wild[..], &[u64::MAX, 1 << 40]].concat();
    let word = prop_oneof![proptest::sample::select(wild), any::<u64>()];
    let harm = prop_oneof![1 => Just(None), 2 => word.prop_map(Some)];
    // The head and the settings are short compared with the matrices: half of the changes are
    // there.
    let place = prop_oneof![0..40_usize, 0..1000_usize];
    let cases = pushbelt_support::shared_library::count("PUSHBELT_STRANGERS", 300);
    let config = Config {
        cases,
        failure_persistence: None,
        ..Config::default()
    };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let taken = std::cell::Cell::new(0);
    let harms = proptest::collection::vec((place, 0_u8..8, harm), 1..4);
    let result = runner.run(&(0..2_usize, harms), |(mode, harms)| {
        let mut bytes = stored[mode].clone();
        for (share, bit, harm) in harms {
            let at = 44 + share * (bytes.len() - 68) / 1000;
            match harm {
                None => bytes[at] ^= 1 << bit,
                Some(word) => bytes[at..at + 8].copy_from_slice(&word.to_le_bytes()),
            }
        }
        reseal(&mut bytes);
        let allocated = allocation_counter::measure(|| {
            if importer.continue_from(&bytes) == Ok {
                taken.set(taken.get() + 1);
                for from in [0.003, 0.004] {
                    assert_finite(&importer);
                    importer.step(from, 0.001);
                }
                assert_finite(&importer);
            }
        });
        assert!(allocated.bytes_max < 256 << 20, "{} bytes at once", allocated.bytes_max);
        let messages = importer.record.messages.borrow();
        let panic = messages.iter().find(|message| message.text.contains("internal error"));
        assert!(panic.is_none(), "{panic:?}");
        Result::Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
    let taken = taken.get();
    assert!((cases / 10..cases).contains(&taken), "{taken} of {cases} were taken");
    // The instance itself still works.
    assert_eq!(importer.continue_from(&stored[0]), Ok);
    importer.advance(0.003, 0.001);
    assert_eq!(importer.continue_from(&stored[0][1..]), Error);
}

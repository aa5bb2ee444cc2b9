//! Stored states, and their bytes.

use std::ptr::{null, null_mut};

use pushbelt::fmi::log::Status::{self, Error, Ok};
use pushbelt::unit::exports::c_abi::*;

use crate::importer::*;

#[test]
fn a_stored_state_is_continued_bit_for_bit() {
    let importer = Importer::running(c"stored");
    assert_eq!(importer.step(0.0, 0.003), Ok);
    let mut state = null_mut();
    let go_on = || {
        assert_eq!(importer.step(0.003, 0.002), Ok, "{:?}", importer.record);
        importer.readings()
    };
    // SAFETY: an instance and a state of it.
    unsafe {
        assert_eq!(fmi2GetFMUstate(importer.c, &mut state), Ok);
        assert!(!state.is_null());
        let at_first = go_on();
        assert_eq!(fmi2SetFMUstate(importer.c, state), Ok);
        assert_eq!(go_on(), at_first);
        let handle = state;
        assert_eq!(fmi2GetFMUstate(importer.c, &mut state), Ok);
        assert_eq!(state, handle, "a state that is not null is used again");
        assert_eq!(fmi2SetFMUstate(importer.c, null_mut()), Error);
        assert_eq!(fmi2GetFMUstate(importer.c, null_mut()), Error);
        assert_eq!(fmi2FreeFMUstate(importer.c, &mut state), Ok);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(importer.c, &mut state), Ok, "null is legal");
        assert_eq!(fmi2FreeFMUstate(importer.c, null_mut()), Ok, "null is legal");
    }
}

/// A state as bytes.
fn serialized(importer: &Importer) -> Vec<u8> {
    let (c, mut state, mut size) = (importer.c, null_mut(), 0);
    // SAFETY: an instance, a state of it, and as many bytes as its size.
    unsafe {
        assert_eq!(fmi2GetFMUstate(c, &mut state), Ok);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), Ok);
        let mut bytes = vec![0_u8; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), size), Ok);
        assert_eq!(
            fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), size - 1),
            Error
        );
        assert!(importer.last().contains("but only"), "{}", importer.last());
        assert_eq!(fmi2FreeFMUstate(c, &mut state), Ok);
        bytes
    }
}

/// Restores the state that the bytes contain.
fn continue_from(importer: &Importer, bytes: &[u8]) -> Status {
    let mut state = null_mut();
    // SAFETY: an instance and a state of it.
    unsafe {
        let status = fmi2DeSerializeFMUstate(importer.c, bytes.as_ptr().cast(), bytes.len(), &mut state);
        if status == Ok {
            assert_eq!(fmi2SetFMUstate(importer.c, state), Ok);
            assert_eq!(fmi2FreeFMUstate(importer.c, &mut state), Ok);
        }
        status
    }
}

#[test]
fn bytes_continue_bit_for_bit_in_another_instance() {
    let importer = Importer::new(c"bytes");
    importer.make_cheap();
    assert_eq!(importer.set_integer("secondary.drive", 2), Ok);
    importer.start();
    assert_eq!(importer.step(0.0, 0.004), Ok, "in the ramp of the loads");
    let early = serialized(&importer);
    assert_eq!(importer.set_real("friction.pulley", 0.08), Ok);
    assert_eq!(importer.step(0.004, 0.009), Ok);
    assert_eq!(
        importer.set_real("friction.ring", 0.04),
        Ok,
        "set, but not yet in force"
    );
    assert_eq!(importer.set_derivative("primary.torque", 3e3), Ok);
    let late = serialized(&importer);
    for (bytes, from) in [(early, 0.004), (late, 0.013)] {
        let (one, other) = (Importer::new(c"one"), Importer::running(c"other"));
        assert_eq!(other.step(0.0, 0.007), Ok);
        let go_on = |importer: &Importer| -> Vec<_> {
            assert_eq!(continue_from(importer, &bytes), Ok, "{}", importer.last());
            assert_eq!(serialized(importer), bytes, "a state at rest is itself");
            let step = |k: u32| {
                assert_eq!(
                    importer.step(from + f64::from(k) * 1e-3, 1e-3),
                    Ok,
                    "{:?}",
                    importer.record
                );
                (importer.readings(), importer.derivatives())
            };
            (0..12).map(step).collect()
        };
        let expected = go_on(&importer);
        assert_eq!(go_on(&one), expected);
        assert_eq!(go_on(&other), expected);
    }
}

#[test]
fn a_state_before_the_start_can_be_serialized() {
    let importer = Importer::new(c"before");
    importer.make_cheap();
    assert_eq!(importer.set_real("friction.pulley", 0.08), Ok);
    let bytes = serialized(&importer);
    importer.start();
    let expected = importer.run();
    let other = Importer::new(c"after");
    assert_eq!(continue_from(&other, &bytes), Ok);
    other.start();
    assert_eq!(other.run(), expected);
}

#[test]
fn wrong_bytes_are_refused_and_change_nothing() {
    let importer = Importer::running(c"wrong");
    let bytes = serialized(&importer);
    let refuses = |bytes: &[u8], words: &str| {
        assert_eq!(continue_from(&importer, bytes), Error);
        assert!(importer.last().contains(words), "{}", importer.last());
    };
    refuses(&[], "too early");
    refuses(
        b"a file of some other kind, long enough to have a head and a checksum",
        "not a stored state",
    );
    refuses(&bytes[..bytes.len() / 2], "incomplete");
    refuses(&[&bytes[..], b"x"].concat(), "followed");
    let damaged = |at: usize| {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x10;
        damaged
    };
    refuses(&damaged(8), "version");
    refuses(&damaged(12), "GUID");
    refuses(&damaged(bytes.len() / 2), "checksum");
    refuses(&damaged(bytes.len() - 1), "checksum");
    // SAFETY: the functions accept null.
    unsafe {
        let (c, mut size) = (importer.c, 0);
        assert_eq!(fmi2SerializedFMUstateSize(c, null_mut(), &mut size), Error);
        assert_eq!(fmi2SerializeFMUstate(c, null_mut(), null_mut(), 0), Error);
        assert_eq!(fmi2DeSerializeFMUstate(c, null(), 9, &mut null_mut()), Error);
        assert_eq!(
            fmi2DeSerializeFMUstate(c, bytes.as_ptr().cast(), bytes.len(), null_mut()),
            Error
        );
    }
    assert_eq!(importer.step(0.0, 0.001), Ok, "and harms nothing");
}

/// Replaces the checksum of deliberately changed bytes: FNV-1a with 128 bits over words of eight bytes.
fn reseal(bytes: &mut [u8]) {
    let (body, checksum) = bytes.split_last_chunk_mut::<16>().expect("a checksum");
    let mut hash = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128;
    let (words, rest) = body.as_chunks::<8>();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    for word in words.iter().chain([&last]) {
        hash = (hash ^ u128::from(u64::from_le_bytes(*word))).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
    }
    *checksum = hash.to_le_bytes();
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
        let importer = Importer::running(c"writer");
        assert_eq!(importer.step(0.0, 0.003), Ok);
        serialized(&importer)
    };
    let mut resealed = bytes.clone();
    reseal(&mut resealed);
    assert_eq!(resealed, bytes, "the checksum of this test is that of the unit");
    let importer = Importer::running(c"stranger");
    let harm = prop_oneof![
        (0_u8..8).prop_map(Harm::Flip),
        proptest::sample::select(vec![
            f64::NAN.to_bits(),
            f64::INFINITY.to_bits(),
            f64::MAX.to_bits(),
            (-1e300_f64).to_bits(),
            u64::MAX,
            1 << 40,
        ])
        .prop_map(Harm::Word),
        any::<u64>().prop_map(Harm::Word),
    ];
    // The head and the settings are short compared with the matrices: half of the changes are there.
    let head = 52..2000.min(bytes.len() - 16);
    let place = prop_oneof![head, 52..bytes.len() - 24];
    let cases = pushbelt_lab::shared_library::count("PUSHBELT_STRANGERS", 400);
    let mut runner = TestRunner::new_with_rng(
        Config {
            cases,
            failure_persistence: None,
            ..Config::default()
        },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    );
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
            if continue_from(&importer, &bytes) == Ok {
                taken.set(taken.get() + 1);
                importer.step(0.003, 0.001);
                importer.step(0.004, 0.001);
            }
        });
        assert!(allocated.bytes_max < 256 << 20, "{} bytes at once", allocated.bytes_max);
        let record = importer.record.0.borrow();
        if let Some(panic) = record.iter().find(|message| message.3.contains("internal error")) {
            panic!("{}", panic.3);
        }
        Result::Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
    assert!(
        (cases / 10..cases).contains(&taken.get()),
        "{} of {cases} were taken",
        taken.get()
    );
    // The instance itself still works.
    assert_eq!(continue_from(&importer, &resealed), Ok);
    assert_eq!(importer.step(0.003, 0.001), Ok);
}

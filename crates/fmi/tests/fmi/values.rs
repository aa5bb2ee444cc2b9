//! Reading and writing of variables, in both versions.

use pushbelt_fmi::Version::{Three, Two};
use pushbelt_fmi::log::Status::{Discard, Error, Ok};
use pushbelt_fmi::table::{REALS, SCALARS};

use crate::importer::{BOTH, TIME, experiment};
use crate::run::running;
use crate::tank::*;

#[test]
fn every_type_is_written_and_read_back() {
    for version in BOTH {
        let importer = Importer::new(version);
        assert_eq!(importer.set_reals(&[START, INFLOW], &[7.0, 8.0]), Ok);
        assert_eq!(importer.set_number(FLOORS, 3), Ok);
        assert_eq!(importer.set_number(SHAPE, 2), Ok);
        assert_eq!(importer.set_number(LOCKED, 5), Ok, "all but 0 is true");
        assert_eq!(importer.enter(experiment(0.0, None)), Ok);
        importer.assert_reals(&[START, INFLOW, GAIN], &[7.0, 8.0, 1.0]);
        let numbers = [FLOORS, SHAPE, LOCKED, FULL].map(|of| importer.number(of));
        assert_eq!(numbers, [3, 2, 1, 0].map(Result::Ok));
        importer.assert_reals(&[], &[]);
        importer.assert_reals(&[SCALARS + DEPTH + 2, REALS + FULL, START], &[7.0, 0.0, 7.0]);
        if version == Two {
            importer.assert_reals(&[DEPTH + 2, DEPTH], &[7.0, 0.0]);
        }
    }
}

#[test]
fn a_bad_value_is_discarded_and_nothing_changes() {
    for version in BOTH {
        for (reference, bad, why) in [
            (INFLOW, f64::NAN, "inflow = NaN is not a finite number"),
            (INFLOW, -1001.0, "inflow = -1001 is out of range: at least -1000"),
            (GAIN, 11.0, "gain = 11 is out of range: -1000 to 10"),
            (GAIN, 0.5, "gain = 0.5 does not fit"),
        ] {
            let importer = running(version);
            importer.assert(importer.set_reals(&[BRIM, reference], &[5.0, bad]), Discard, why);
            let message = importer.record.messages.borrow().last().expect("a message").clone();
            assert_eq!((message.status, &*message.category), (2, "logStatusDiscard"));
            importer.assert_reals(&[BRIM, INFLOW, GAIN], &[1e9, 2.0, 1.0]);
            assert_eq!(importer.step(0.0, 1.0).status, Ok, "the run goes on");
            assert_eq!(importer.real(LEVEL), 3.0);
        }
        let importer = Importer::new(version);
        assert_eq!([1, 9].map(|limit| importer.set_number(FLOORS, limit)), [Ok; 2]);
        for (reference, bad, why) in [
            (FLOORS, 10, "floors = 10 is out of range: 1 to 9"),
            (FLOORS, i32::MIN, "floors = -2147483648 is out of range"),
            (SHAPE, 3, "shape = 3 is out of range: 1 Round, 2 Square"),
        ] {
            importer.assert(importer.set_number(reference, bad), Discard, why);
        }
    }
}

#[test]
fn an_input_beyond_a_limit_by_rounding_is_the_limit() {
    for version in BOTH {
        let importer = running(version);
        assert_eq!(importer.set(INFLOW, -1_000.000_000_9), Ok);
        assert_eq!(importer.real(INFLOW), -1000.0);
        assert_eq!(importer.set(INFLOW, -1_000.000_002), Discard);
        assert_eq!(importer.set(GAIN, 10.000_000_1), Discard, "a parameter");
    }
}

#[test]
fn a_bad_reference_is_an_error_that_names_it() {
    for version in BOTH {
        let importer = running(version);
        for (reference, why) in [
            (LEVEL, "level is calculated and can't be set"),
            (START, "start is fixed once the run has started"),
            (NONE, "no variable has the value reference 99"),
            (
                TIME,
                "time (value reference 0) is the independent variable: it can't be set",
            ),
            (OLD, "old (value reference 98) was removed: use start"),
            (SCALARS + DEPTH, "depth[1] is calculated"),
            (SCALARS + LEVEL, "no variable has the value reference 1000005"),
            (REALS + FULL, "full is calculated"),
            (REALS + LOCKED, "no variable has the value reference 2000019"),
            (FLOORS, "floors (value reference 7) has another type"),
        ] {
            importer.assert(importer.set_reals(&[INFLOW, reference], &[3.0, 1.0]), Error, why);
        }
        assert_eq!(importer.real(INFLOW), 2.0, "all values are set or none");
        assert_eq!(importer.set_number(FULL, 1), Error);
        assert_eq!(
            [NONE, FULL].map(|wrong| importer.reals(&[wrong], 1)),
            [Err(Error), Err(Error)]
        );
        assert_eq!(importer.number(LEVEL), Err(Error));
        importer.assert(importer.number(TIME), Err(Error), "only fmi3GetFloat64 reads it");
        assert_eq!(importer.reals(&[TIME], 1).is_ok(), version == Three);
        assert_eq!(importer.set(GAIN, 3.0), Ok, "a tunable parameter");
        assert_eq!(importer.step(0.0, 1.0).status, Ok);
        assert_eq!(importer.real(LEVEL), 7.0);
    }
}

//! Times and steps of hosts.

use pushbelt_fmi::Version::{self, Three, Two};
use pushbelt_fmi::log::Status::{Error, Ok};

use crate::importer::{BOTH, Handles};
use crate::run::{ended, running};
use crate::tank::*;

/// Seconds since 1970, some day in 2023.
const TODAY: f64 = 1.7e9;

fn running_from(version: Version, start: f64) -> Importer {
    let importer = Importer::new(version);
    importer.start_at(start);
    importer
}

/// Hosts reach one point by different sums: a step that is rounding alone changes nothing but the
/// point at which the next one begins.
#[test]
fn a_step_that_is_rounding_alone_is_done_and_changes_nothing() {
    for version in BOTH {
        for (start, steps) in [(0.0, [1e-300, 1e-18, 3e-17]), (TODAY, [1e-300, 1e-7, 5e-7])] {
            let importer = running_from(version, start);
            assert_eq!(importer.step(start, 0.1).status, Ok);
            let (mut time, level) = (start + 0.1, importer.real(LEVEL));
            assert_eq!(importer.set(INFLOW, 9.0), Ok);
            for size in steps {
                if version == Two {
                    assert_eq!(importer.set_derivative(INFLOW, 1, 9.0), Ok, "for this step alone");
                }
                assert_eq!(importer.step(time, size), ended(false, false, time + size), "{size}");
                assert_eq!(importer.real(LEVEL), level, "{size}");
                time += size;
            }
            assert_eq!(importer.set(INFLOW, 2.0), Ok);
            assert_eq!(importer.step(time, 0.1).status, Ok);
            assert!((importer.real(LEVEL) - level - 0.2).abs() < 3e-6);
            for size in [0.0, -1e-300] {
                assert_eq!(importer.step(time + 0.1, size).status, Error, "{size}");
            }
        }
    }
    // A thousandth of the step is taken for rounding, at any time.
    let late = running_from(Three, TODAY);
    assert_eq!([2e-4, 5e-5].map(|by| late.step(TODAY + by, 0.1).status), [Error, Ok]);
    // As is the rounding of the number, which is more than that of a short step.
    assert_eq!(running_from(Three, TODAY).step(TODAY + 2.4e-7, 1e-4).status, Ok);
    // Steps of less than the rounding add up.
    let importer = running_from(Two, TODAY);
    let mut time = TODAY;
    for _ in 0..1000 {
        assert_eq!(importer.step(time, 1e-6).status, Ok, "{}", importer.last());
        time += 1e-6;
    }
    assert!((importer.real(LEVEL) - 1.0 - 2e-3).abs() < 2e-5);
}

#[test]
fn sums_and_products_of_steps_give_the_same_times() {
    for size in [1e-3, 1e-2 / 3.0, 0.25, 7e-6] {
        let [sums, products] = [Two, Three].map(running);
        let mut time = 0.0;
        for k in 0..1000 {
            assert_eq!(sums.step(time, size).status, Ok, "{size}, {k}");
            let product = f64::from(k) * size;
            assert_eq!(products.step(product, f64::from(k + 1) * size - product).status, Ok);
            let reached = [sums.real(LEVEL), products.real(LEVEL)];
            assert_eq!(reached[0].to_bits(), reached[1].to_bits(), "{size}, {k}");
            assert!((reached[0] - 1.0 - 2.0 * (product + size)).abs() < 1e-5 * size + 1e-9);
            time += size;
        }
    }
}

#[test]
fn a_short_step_can_follow_a_long_one() {
    let importer = running(Two);
    let mut time = 0.0;
    for size in [0.123_456_789_123, 1e-5, 1e-8, 1.0 / 3.0, 1e-10, 1e-7] {
        assert_eq!(importer.step(time, size), ended(false, false, time + size), "{size}");
        time += size;
    }
    assert!((importer.real(LEVEL) - 1.0 - 2.0 * time).abs() < 1e-6);
}

/// An importer with callback has its own times in the updates, in an early return and in messages.
#[test]
fn intermediate_updates_have_the_importers_times() {
    let importer = Importer::handling(Three, Handles::updates(&[LEVEL]));
    importer.start_at(TODAY);
    importer.assert_logged("start at 1700000000 s");
    importer.answer(|update| (update.time == TODAY + 0.25).then_some(TODAY + 0.375));
    assert_eq!(importer.step(TODAY, 1.0), ended(false, true, TODAY + 0.375));
    let updates = importer.record.updates.borrow().clone();
    assert!(
        updates
            .iter()
            .map(|update| update.time)
            .eq([TODAY + 0.25, TODAY + 0.375])
    );
    assert_eq!(importer.step(TODAY + 0.375, 0.5).status, Ok);
}

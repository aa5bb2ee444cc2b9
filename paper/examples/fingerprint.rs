//! A hash of every output bit of the manoeuvre, for each of the paper's belts.
//!
//! `cargo run --release --package pushbelt-paper --example fingerprint`; see the example of the
//! same name of `pushbelt`.

use std::error::Error;
use std::sync::Arc;

use pushbelt::variator::Variator;
use pushbelt::variator::ring_models::{Ale, Ale0, BeltRing};
use pushbelt::variator::settings::Parameters;
use pushbelt_paper::belts::{EvenMesh, Rotated, Travels};
use pushbelt_paper::ring::ancf::AncfElement;
use pushbelt_paper::ring::rcm::RcmElement;
use pushbelt_support::fingerprint::{Report, STEP};
use pushbelt_support::manoeuvre::Manoeuvre;

fn main() -> Result<(), Box<dyn Error>> {
    let trace = Manoeuvre::read().trace(STEP);
    let mut report = Report::of_arguments()?;
    let cases: [(&str, Arc<dyn BeltRing>, usize); 5] = [
        ("ALE in directions of the curve", Arc::new(Rotated::<2>), 500),
        ("ALE on even elements", Arc::new(EvenMesh(Ale::<2>)), 500),
        ("ALE0 on even elements", Arc::new(EvenMesh(Ale0)), 500),
        ("RCM", Arc::new(Travels::<RcmElement>::new(0)), 30),
        ("ANCF", Arc::new(Travels::<AncfElement>::new(0)), 30),
    ];
    for (name, ring, steps) in cases {
        report.run(name, Variator::with_ring(Parameters::default(), ring)?, &trace, steps)?;
    }
    report.finish()
}

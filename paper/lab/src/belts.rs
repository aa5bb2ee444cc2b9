//! The travelling rings, with their default numbers of elements.

use std::sync::Arc;

use pushbelt::variator::ring_models::BeltRing;
use pushbelt_paper::belts::Travels;
use pushbelt_paper::ring::ancf::AncfElement;
use pushbelt_paper::ring::rcm::RcmElement;

pub fn rcm() -> Arc<dyn BeltRing> {
    Arc::new(Travels::<RcmElement>::new(0))
}

pub fn ancf() -> Arc<dyn BeltRing> {
    Arc::new(Travels::<AncfElement>::new(0))
}

/// Both.
pub fn travelling() -> [Arc<dyn BeltRing>; 2] {
    [rcm(), ancf()]
}

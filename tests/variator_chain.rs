//! The pull chain.

use std::sync::Arc;

use pushbelt::reference_curve::{Displaced, TwoPulley};
use pushbelt::variator::belt_ring::{Ale, Ale0, BeltRing, deflecting_derivative_error, guided_derivative_error};
use pushbelt::variator::settings::{BeltKind, Parameters, RingModel};
use pushbelt_lab::disturbed::{DerivativeError, assert_derivatives_by_hand, assert_jacobian, disturbed, small};

fn small_chain(model: RingModel) -> Parameters {
    Parameters {
        kind: BeltKind::PullChain,
        ..small(model)
    }
}

#[test]
fn hand_written_derivatives_are_those_of_forward_differentiation() {
    let of = |parameters: Parameters, ring: Arc<dyn BeltRing>, error: DerivativeError| {
        assert_derivatives_by_hand(&parameters, &ring, error);
    };
    let in_space = Parameters {
        spatial: true,
        ..small_chain(RingModel::Ale)
    };
    of(
        small_chain(RingModel::Ale),
        Arc::new(Ale::<2>),
        deflecting_derivative_error::<2, TwoPulley>,
    );
    of(
        in_space,
        Arc::new(Ale::<3>),
        deflecting_derivative_error::<3, TwoPulley>,
    );
    of(
        small_chain(RingModel::Ale0),
        Arc::new(Ale0),
        guided_derivative_error::<Displaced>,
    );
}

#[test]
fn jacobian_is_that_of_differences() {
    for model in [RingModel::Ale, RingModel::Ale0] {
        assert_jacobian(disturbed(&small_chain(model), 200.0), 1e-2);
    }
}

//! A ring model of one's own: bands that stiffen as they stretch.
//!
//! The layers of a ring set are not equally long. The shorter ones are loaded first and the others
//! later, so the set gets stiffer with its strain γ. This ring has the simplest such law on top of
//! the beam of `ALE`,
//!
//! T = EA γ (1 + c γ), V = ∫ EA (½ γ² + ⅓ c γ³) dξ.
//!
//! `cargo run --release --example own_ring` prints thrust ratio and largest ring tension of three
//! load cases for `ALE`, for this ring with c = 0, which must have the same results, and with
//! stiffening. A shift checks the energy balance.
//!
//! It implements three traits of `pushbelt::variator::ring_models`: [`CellRing`] for
//! [`StiffeningRing`], the ring inside one cell, [`RingKind`] and [`BeltRing`] for [`Stiffening`],
//! its parameters. Residual, Jacobian, outputs, energy balance and steady states follow from these.

use std::sync::Arc;

use pushbelt::ring::kinematics::{LineLoad, RingPoint};
use pushbelt::scalar::Real;
use pushbelt::variator::ring_models::{
    Ale, Assembly, Belt, BeltMesh, BeltRing, CellRing, Deflecting, Layout, RingDensity, RingForces,
    RingInput, RingKind, StateComponent, StationLoad, eulerian_equations, nodes,
};
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::run::Run;
use pushbelt_support::steady::load_case_with;
use pushbelt_support::variators::{inputs, variator};

/// The ring between two nodes: that of `ALE` with the additional force of the law.
struct StiffeningRing<'a, T: Real> {
    ale: Deflecting<'a, T>,
    /// EA c, N.
    stiffening: f64,
}

impl<T: Real> StiffeningRing<'_, T> {
    /// Energy beyond that of `ALE`, ⅓ EA c γ³, J/m.
    fn energy(&self, point: &RingPoint<T>) -> T {
        let strain = point.strain();
        strain * strain * strain * (self.stiffening / 3.0)
    }
}

impl<T: Real> CellRing<T> for StiffeningRing<'_, T> {
    type Forces = RingForces<T>;

    fn point(&self, at: usize) -> RingPoint<T> {
        self.ale.point(at)
    }

    /// Adds δV = ∫ EA c γ² δγ dξ + energy of the length dξ that Θ adds, with δγ = t·δr'.
    fn own_load(&self, at: usize, point: &RingPoint<T>, load: &mut LineLoad<T>) -> T {
        let tension = point.strain() * point.strain() * self.stiffening;
        load.slope += point.t * tension;
        load.theta += self.energy(point) * self.ale.dilation;
        self.ale.own_load(at, point, load) + tension
    }

    fn apply(&mut self, at: usize, point: &RingPoint<T>, station_load: &StationLoad<T>) {
        self.ale.apply(at, point, station_load);
    }

    fn density(&self, point: &RingPoint<T>) -> RingDensity<T> {
        let mut density = self.ale.density(point);
        density.membrane += self.energy(point);
        density
    }

    fn forces(&self) -> RingForces<T> {
        self.ale.forces()
    }
}

/// A ring with T = EA γ (1 + c γ), which deflects in the plane.
#[derive(Clone, Copy, Debug)]
struct Stiffening {
    /// c.
    factor: f64,
}

impl RingKind<2> for Stiffening {
    type Ring<'a, T: Real> = StiffeningRing<'a, T>;

    fn ring<'a, T: Real>(
        &self,
        given: RingInput<'a, T>,
        unknown: impl Fn(StateComponent, usize) -> T,
    ) -> StiffeningRing<'a, T> {
        StiffeningRing {
            ale: Deflecting::new(given, &nodes(unknown)),
            stiffening: given.ring.axial_stiffness * self.factor,
        }
    }
}

impl BeltRing for Stiffening {
    fn name(&self) -> &'static str {
        "stiffening"
    }

    fn layout(&self, _parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        Layout::deflecting(2, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        eulerian_equations(*self, belt, false)
    }
}

/// Tangent stiffness grows by 60 % over a strain of 1e-3.
const FACTOR: f64 = 300.0;

fn main() {
    steady_states();
    shift();
}

/// Thrust ratio and largest ring tension of three load cases.
fn steady_states() {
    let parameters = variator(RingModel::Ale);
    println!(
        "            thrust ratio: ALE, c = 0, c = {FACTOR}; largest tension, N: ALE, c = 0, c = {FACTOR}"
    );
    for case in LoadCase::three(&parameters, 50.0) {
        let rings: [Arc<dyn BeltRing>; 3] = [
            Arc::new(Ale::<2>),
            Arc::new(Stiffening { factor: 0.0 }),
            Arc::new(Stiffening { factor: FACTOR }),
        ];
        let states = rings.map(|ring| load_case_with(&parameters, ring, &case).outputs);
        let thrust = states.each_ref().map(|state| state.thrust_ratio);
        let tension = states.each_ref().map(|state| state.ring_tension_max);
        let [ale, off, on] = thrust;
        println!(
            "{:<10}  {ale:.6} {off:.6} {on:.6}  {:.0} {:.0} {:.0}",
            case.name, tension[0], tension[1], tension[2],
        );
        assert!(
            (off / ale - 1.0).abs() < 1e-6,
            "without stiffening it is not ALE: {off} {ale}"
        );
        assert!((on / ale - 1.0).abs() > 1e-5, "stiffening has no effect: {on} {ale}");
    }
}

/// Energy balance of a shift, in which Θ moves: the forces of the law are the gradient of its
/// energy.
fn shift() {
    let ring = Arc::new(Stiffening { factor: FACTOR });
    let mut run = Run::with_ring(variator(RingModel::Ale), ring, inputs((20.0, 12e3), (-20.0, 10e3)));
    run.inputs.primary.clamping_force = 16e3;
    let outputs = run.go(0.05, 1e-3);
    println!(
        "shift to ratio {:.4}: energy residual {:.1e} of what is allowed",
        outputs.ratio_geometric, run.residual
    );
    run.assert_balances();
}

//! `ALE0` as the paper has it (5.1, 5.4): arcs about the axes of the pulleys. Of the curve's
//! coordinates Θ alone is left.

use pushbelt::archive::Archive;
use pushbelt::pulley::PerPulley;
use pushbelt::scalar::Lanes;
use pushbelt::solver::Factors;
use pushbelt::solver::View;
use pushbelt::solver::arrow::Arrow;
use pushbelt::variator::ring_models::{
    Ale0, Assembly, Belt, BeltMesh, BeltRing, CONSTRAINT_SCALE, InForce, Layout, PulleyLoad,
    ResultantDerivatives, RingEnergy, Sample,
};
use pushbelt::variator::settings::{Mesh, Parameters};
use std::ops::Range;

/// `ALE0` without coordinates of the arcs' centres.
#[derive(Clone, Copy, Debug)]
pub struct Centred;

impl BeltRing for Centred {
    fn name(&self) -> &'static str {
        "ALE0 about the axes"
    }

    fn mesh(&self, sizes: &Mesh) -> BeltMesh {
        Ale0.mesh(sizes)
    }

    fn layout(&self, parameters: &Parameters, mesh: &BeltMesh) -> Layout {
        Ale0.layout(parameters, mesh)
    }

    fn equations(&self, belt: &Belt) -> Box<dyn Assembly> {
        Box::new(HeldCentres {
            free: Ale0.equations(belt),
            centres: belt.layout.centres(),
        })
    }
}

/// The equations of `ALE0`, with the rates of the centres' coordinates held at zero.
#[derive(Clone, Debug)]
struct HeldCentres {
    free: Box<dyn Assembly>,
    centres: Range<usize>,
}

impl Assembly for HeldCentres {
    fn boxed(&self) -> Box<dyn Assembly> {
        Box::new(self.clone())
    }

    fn residual(&mut self, acting: InForce<'_>, view: View<'_>, out: &mut [f64]) -> PerPulley<PulleyLoad> {
        let loads = self.free.residual(acting, view, out);
        for centre in self.centres.clone() {
            out[centre] = CONSTRAINT_SCALE * view.y[centre];
        }
        loads
    }

    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        matrix: &mut Arrow,
        resultants: &mut ResultantDerivatives,
    ) -> PerPulley<PulleyLoad> {
        let loads = self.free.jacobian(acting, view, factors, matrix, resultants);
        for centre in self.centres.clone() {
            matrix.set_unit_row(centre, CONSTRAINT_SCALE);
        }
        loads
    }

    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) -> RingEnergy {
        self.free.sample(acting, view, out)
    }

    fn forget_derivatives(&mut self) {
        self.free.forget_derivatives();
    }

    fn serialize_derivatives(&mut self, acting: InForce<'_>, archive: &mut Archive<'_>) {
        self.free.serialize_derivatives(acting, archive);
    }

    fn differentiations(&self) -> u64 {
        self.free.differentiations()
    }
}

//! Checks of parameters and inputs: each value has a range, in the [`table`](super::table), and
//! values must fit each other (the belt around the pulleys, the stops, the wedge above the friction
//! angle).

use super::parameters::{Parameters, RingModel};
use super::signals::{INPUTS, Inputs};
use super::table::{Setting, inputs, parameters};
use super::{BEYOND_STOP, STEEL_SCATTER};
use crate::pulley::PerPulley;
use crate::reference_curve::TwoPulley;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// A value out of its range.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{variable} = {value} is out of range: {range}")]
pub struct ParameterError {
    /// Name of the variable in the interface, e.g. `geometry.wedgeAngle`.
    pub variable: String,
    /// The value that was set.
    pub value: String,
    /// The allowed range in words.
    pub range: String,
}

impl ParameterError {
    /// The error of a value that is out of its `range`, in words.
    pub fn new(variable: impl Into<String>, value: impl ToString, range: impl Into<String>) -> Self {
        Self {
            variable: variable.into(),
            value: value.to_string(),
            range: range.into(),
        }
    }
}

/// Young's modulus, Pa, and density, kg/m³, of a ring's steel.
#[derive(Debug, PartialEq)]
pub(crate) struct Steel {
    pub modulus: f64,
    pub density: f64,
}

impl Parameters {
    /// Checks every parameter against its range, and all against each other.
    ///
    /// # Errors
    /// The first parameter that is out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        parameters::<_, ()>().try_for_each(|parameter| parameter.check(self))?;
        self.validate_wedge()?;
        let elements = self.mesh.secondary_arc;
        require(elements % 2 == 0, "mesh.secondaryArc", elements, || {
            "an even number, since ξ = 0 divides this arc in two".to_owned()
        })?;
        let ramp = self.solver.input_ramp;
        require(ramp >= 0.0 || ramp == -1.0, "inputs.ramp", ramp, || {
            "0 to 10, or -1 for the whole communication step".to_owned()
        })?;
        for (pulley, name) in [
            (&self.primary, "primary.tiltClearance"),
            (&self.secondary, "secondary.tiltClearance"),
        ] {
            let clearance = pulley.tilt.clearance;
            // The square of a hundredth of it is above the least number.
            require(clearance == 0.0 || clearance >= 1e-9, name, clearance, || {
                "1e-9 to 0.1, or 0: less moves a flank by less than an atom, and rounding takes it".to_owned()
            })?;
        }
        // Only the deflecting ring leaves the plane.
        let spatial = !self.spatial || self.ring_model == RingModel::Ale;
        require(spatial, "ring.spatial", true, || {
            "false, unless ring.model is ALE".to_owned()
        })?;
        self.validate_belt()?;
        self.validate_stops()
    }

    /// Checks the two coefficients that may change in a run.
    ///
    /// # Errors
    /// A coefficient that is out of its range.
    pub fn validate_friction(&self) -> Result<(), ParameterError> {
        let mut tunable = parameters::<_, ()>().filter(Setting::is_tunable);
        tunable.try_for_each(|parameter| parameter.check(self))?;
        self.validate_wedge().map_err(|_| {
            let highest = self.geometry.wedge_angle.tan();
            let range = format!(
                "below {highest}, the tangent of geometry.wedgeAngle; at that value and above the sheaves jam"
            );
            ParameterError::new("friction.pulley", self.friction.pulley, range)
        })
    }

    /// The ring's steel as it follows from the layers, if modulus and density are both larger or
    /// both smaller than those of the default ring: stiffness and mass then belong to other layers.
    pub(crate) fn steel_of_other_layers(&self) -> Option<Steel> {
        let steel = |of: &Self| {
            let area = 2.0 * f64::from(of.layers.count) * of.layers.width * of.layers.thickness;
            Steel {
                modulus: of.ring.axial_stiffness / area,
                density: of.ring.mass_per_length / area,
            }
        };
        let (own, usual) = (steel(self), steel(&Self::default()));
        let (stiff, heavy) = (own.modulus / usual.modulus, own.density / usual.density);
        let differs = stiff.max(heavy) < 1.0 - STEEL_SCATTER || stiff.min(heavy) > 1.0 + STEEL_SCATTER;
        (own.modulus.is_finite() && differs).then_some(own)
    }

    /// Below the friction angle a sheave clamps the elements and never releases them.
    fn validate_wedge(&self) -> Result<(), ParameterError> {
        let (wedge_angle, friction) = (self.geometry.wedge_angle, self.friction.pulley);
        let friction_angle = friction.atan();
        require(wedge_angle > friction_angle, "geometry.wedgeAngle", wedge_angle, || {
            format!(
                "above {friction_angle}, the friction angle of friction.pulley = {friction}; below it the sheaves jam"
            )
        })
    }

    /// Checks that at ratio 1 the belt reaches around both pulleys, that these do not touch, and
    /// that the end play is small.
    ///
    /// # Errors
    /// `geometry.beltLength` or `belt.play`.
    pub fn validate_belt(&self) -> Result<(), ParameterError> {
        let distance = self.geometry.center_distance;
        let length = self.geometry.belt_length;
        let offset = self.pitch_offset();
        let shortest = 2.0 * distance + 2.0 * PI * offset;
        let longest = (2.0 + PI) * distance;
        let reaches = length > shortest && length < longest;
        require(reaches, "geometry.beltLength", length, || {
            format!(
                "between {shortest} and {longest}, so that at ratio 1 the belt reaches around both pulleys and \
                 these do not touch (geometry.centerDistance = {distance}, belt.pitchOffset = {offset})"
            )
        })?;
        let (play, most) = (self.belt.play, 0.1 * (length - 2.0 * PI * offset));
        require(self.is_pull_chain() || play <= most, "belt.play", play, || {
            format!("0 to {most}, a tenth of the belt")
        })
    }

    /// The stops leave a range of ratios, and the initial ratio lies in it.
    fn validate_stops(&self) -> Result<(), ParameterError> {
        for (pulley, min, max) in [
            (&self.primary, "primary.minRadius", "primary.maxRadius"),
            (&self.secondary, "secondary.minRadius", "secondary.maxRadius"),
        ] {
            let (least, most) = (pulley.min_radius, pulley.max_radius);
            require(least < most, min, least, || format!("below {max} = {most}"))?;
        }
        let ratio = self.initial.ratio;
        let (lowest, highest) = self.ratio_range().into_inner();
        let fits = lowest < highest && (lowest / BEYOND_STOP..=highest * BEYOND_STOP).contains(&ratio);
        require(fits, "initial.ratio", ratio, || {
            if lowest < highest {
                format!("{lowest:.6} to {highest:.6}, where the sheaves reach their stops")
            } else {
                "none, since no belt of this length fits between the stops".to_owned()
            }
        })
    }

    /// Ratios of the unloaded belt between the end stops.
    #[must_use]
    pub fn ratio_range(&self) -> RangeInclusive<f64> {
        let (p, s) = (&self.primary, &self.secondary);
        // A ratio at which no belt closes is an extreme one.
        let is_too_low = |ratio: f64| match self.pitch_radii(ratio) {
            Some(radii) => radii.primary > p.max_radius || radii.secondary < s.min_radius,
            None => ratio <= 1.0,
        };
        let is_not_too_high = |ratio: f64| match self.pitch_radii(ratio) {
            Some(radii) => radii.primary >= p.min_radius && radii.secondary <= s.max_radius,
            None => ratio < 1.0,
        };
        let boundary = |is_below: &dyn Fn(f64) -> bool| {
            bisected(0.01_f64.ln()..=100.0_f64.ln(), |log_ratio| is_below(log_ratio.exp())).exp()
        };
        boundary(&is_too_low)..=boundary(&is_not_too_high)
    }

    /// Pitch radii at a ratio, m, if the belt closes there.
    #[must_use]
    pub fn pitch_radii(&self, ratio: f64) -> Option<PerPulley<f64>> {
        let curve = TwoPulley::new(self.geometry.center_distance, self.geometry.belt_length);
        let radii = curve.radii(ratio).ok()?;
        Some(radii.map(|radius| radius - self.pitch_offset()))
    }
}

/// The error of a value against a rule.
fn require(
    holds: bool,
    variable: &'static str,
    value: impl ToString,
    range: impl FnOnce() -> String,
) -> Result<(), ParameterError> {
    let error = || ParameterError::new(variable, value, range());
    if holds { Ok(()) } else { Err(error()) }
}

/// The value in a range up to which `is_below` holds, by bisection.
pub fn bisected(range: RangeInclusive<f64>, mut is_below: impl FnMut(f64) -> bool) -> f64 {
    let (mut low, mut high) = range.into_inner();
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if is_below(middle) { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

impl Inputs {
    /// Checks every input against its range.
    ///
    /// # Errors
    /// The first input that is out of its range.
    pub fn validate(&self) -> Result<(), ParameterError> {
        inputs::<_, ()>().try_for_each(|input| input.check(self))
    }

    pub(crate) fn validate_rates(&self) -> Result<(), ParameterError> {
        let mut rates = INPUTS.into_iter().zip(self.values());
        let Some((input, rate)) = rates.find(|(_, rate)| !rate.is_finite()) else {
            return Ok(());
        };
        Err(ParameterError::new(
            format!("the derivative of {}", input.name),
            rate,
            "a finite number",
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::Parameters;

    #[test]
    fn layers_alone_leave_stiffness_and_mass_of_another_ring() {
        let mut parameters = Parameters::default();
        assert_eq!(parameters.steel_of_other_layers(), None);
        parameters.layers.count = 10;
        let steel = parameters.steel_of_other_layers().expect("a layer more");
        assert!((steel.modulus - 1.672e11).abs() < 1e9 && (steel.density - 7207.0).abs() < 1.0);
        parameters.ring.axial_stiffness *= 10.0 / 9.0;
        parameters.ring.mass_per_length *= 10.0 / 9.0;
        assert_eq!(parameters.steel_of_other_layers(), None);
        // A limit case of theory: a stiff ring.
        parameters.ring.axial_stiffness *= 1e3;
        assert_eq!(parameters.steel_of_other_layers(), None);
    }
}

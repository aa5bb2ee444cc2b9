//! Constants of the laws, from the parameters of the FMU.

use crate::stack::Oil;
use pushbelt::contact::{Contact, Friction};
use pushbelt::variator::settings::{ParameterError, Parameters};

/// What this model has beside the FMU's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Oil in the gaps.
    pub oil: Oil,
    /// Lever of the ring's friction, m: distance from the rocking edge out to the middle of the innermost layer; `None`:
    /// e − (n − 1) t/2 of the layers.
    pub lever: Option<f64>,
    /// Contact force of ring and element up to which it has no friction, N: what the strand's vibration rectifies is below 2 N.
    pub contact_threshold: f64,
    /// Damping time of the ring's curvature, s.
    pub curvature_damping: f64,
    /// Time step, s; `None`: 2e-6 s at 200 rad/s of the primary shaft and in proportion to 1/ω, at most 4e-6 s.
    pub step: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            oil: Oil::default(),
            lever: None,
            contact_threshold: 0.0,
            curvature_damping: 2.0e-5,
            step: None,
        }
    }
}

/// Constants of the ring.
#[derive(Clone, Debug)]
pub struct RingLaw {
    /// Unstretched length L, m.
    pub length: f64,
    /// EA, N.
    pub axial_stiffness: f64,
    /// Damping time of the strain, s.
    pub damping: f64,
    /// EI, N·m².
    pub bending_stiffness: f64,
    /// Damping time of the curvature, s.
    pub curvature_damping: f64,
    /// Mass per length, kg/m.
    pub mass_per_length: f64,
    /// Distance e of the centre line from the rocking edge, m.
    pub offset: f64,
    /// Lever e_1 of the friction, m.
    pub lever: f64,
    /// Contact force up to which there is no friction, N_0, N.
    pub contact_threshold: f64,
}

/// Constants of all laws. Pulleys are in the order secondary, primary.
#[derive(Clone, Debug)]
pub struct Law {
    /// Number N of elements.
    pub count: usize,
    /// Thickness h of an element, m.
    pub thickness: f64,
    /// Mass of an element, kg.
    pub mass: f64,
    /// Contact stiffness between neighbours k_e/h, N/m.
    pub push_stiffness: f64,
    /// Damping time of that contact, s.
    pub push_damping: f64,
    /// Roughness of the faces, m.
    pub roughness: f64,
    /// Oil in the gaps.
    pub oil: Oil,
    /// The ring.
    pub ring: RingLaw,
    /// Contact of the flanks.
    pub contact: Contact,
    /// The same with a damping time of 1 s: its damping force is that of unit closing.
    pub unit_damped: Contact,
    /// Friction of flanks and ring.
    pub friction: Friction,
    /// sin β, cos β, tan β.
    pub wedge: [f64; 3],
    /// Pitch radius of unloaded contact at z = 0, m.
    pub r0: f64,
    /// Axes of the pulleys, x, m.
    pub axes: [f64; 2],
}

impl Law {
    /// The constants at these parameters.
    ///
    /// # Errors
    /// A parameter is out of its range, the belt is a chain, or the lever is negative.
    pub fn new(parameters: &Parameters, options: &Options) -> Result<Self, ParameterError> {
        parameters.validate()?;
        if parameters.is_chain() {
            return Err(ParameterError::new(
                "belt.kind",
                "PullChain",
                "PushBelt: a chain has no elements",
            ));
        }
        let (belt, geometry, layers) = (&parameters.belt, &parameters.geometry, &parameters.layers);
        let lever = options
            .lever
            .unwrap_or(belt.pitch_offset - 0.5 * f64::from(layers.count - 1) * layers.thickness);
        if lever.is_nan() || lever < 0.0 {
            return Err(ParameterError::new(
                "lever",
                lever,
                "at least 0: the saddle lies outside the rocking edge",
            ));
        }
        let pitch_length = geometry.belt_length - std::f64::consts::TAU * belt.pitch_offset;
        let count = ((pitch_length - belt.play) / belt.element_thickness).round();
        if !(50.0..=1e5).contains(&count) {
            return Err(ParameterError::new(
                "belt.elementThickness",
                belt.element_thickness,
                "50 to 100000 elements in the belt",
            ));
        }
        // The stack is as long as it shall be; the thickness gives way by less than h/2N.
        let thickness = (pitch_length - belt.play) / count;
        let beta = geometry.wedge_angle;
        let no_belt = || {
            ParameterError::new(
                "geometry.beltLength",
                geometry.belt_length,
                "a belt that closes at ratio 1",
            )
        };
        Ok(Self {
            count: count as usize,
            thickness,
            mass: belt.mass_per_length * thickness,
            push_stiffness: belt.push_stiffness / thickness,
            push_damping: belt.damping,
            roughness: belt.roughness,
            oil: options.oil,
            ring: RingLaw {
                length: geometry.belt_length,
                axial_stiffness: parameters.ring.axial_stiffness,
                damping: parameters.ring.damping,
                bending_stiffness: parameters.ring.bending_stiffness,
                curvature_damping: options.curvature_damping,
                mass_per_length: parameters.ring.mass_per_length,
                offset: belt.pitch_offset,
                lever,
                contact_threshold: options.contact_threshold,
            },
            contact: parameters.contact.clone(),
            unit_damped: Contact {
                damping: 1.0,
                ..parameters.contact.clone()
            },
            friction: parameters.friction.clone(),
            wedge: [beta.sin(), beta.cos(), beta.tan()],
            r0: parameters.pitch_radii(1.0).ok_or_else(no_belt)?.0,
            axes: [0.0, geometry.center_distance],
        })
    }
}

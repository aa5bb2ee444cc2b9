//! Constants of the laws, from the parameters of the FMU.

use crate::oil::Oil;
use pushbelt::contact::Contact;
use pushbelt::pulley::Wedge;
use pushbelt::variator::settings::{ParameterError, Parameters, PulleyParameters};

/// A type of options of the program: with a default and a range, or neither.
macro_rules! options {
    ($(#[$of:meta])* $name:ident {
        $($(#[$doc:meta])* $option:ident: $type:ty $(= $default:literal, $least:literal to $most:literal)?;)*
    }) => {
        $(#[$of])*
        pub struct $name {
            $($(#[$doc])* #[arg(long $(, default_value_t = $default)?)] pub $option: $type,)*
        }

        impl $name {
            /// Names and values, with the least and the largest.
            pub fn ranges(&self) -> Vec<(&'static str, f64, [f64; 2])> {
                vec![$($((stringify!($option), self.$option, [$least, $most]),)?)*]
            }
        }
    };
}

options! {
    /// What this model has beside the FMU's parameters, and the loads of a case.
    #[derive(Clone, Debug, PartialEq, clap::Parser)]
    Options {
        /// Closing force of the secondary pulley, N
        force: f64 = 15.0e3, 100.0 to 2.0e5;
        /// Speed of the primary pulley, rad/s
        speed: f64 = 209.0, 1.0 to 2.0e3;
        /// Step of ln F_P after the held state; the result is the speed of the ratio 60 to 120 ms after it
        #[arg(allow_negative_numbers = true)]
        shift: Option<f64>;
        /// Ratio at the start [default: that of the case]
        start_ratio: Option<f64>;
        /// Duration, s, without that of a shift; its last quarter is the result [default: 0.3, at both
        /// end ratios or below 100 rad/s 0.5]
        duration: Option<f64>;
        /// Time step, s [default: 2e-6 at a primary speed of 200 rad/s, in proportion to 1/speed, at
        /// most 4e-6]
        step: Option<f64>;
        /// Oil: distance of rough faces in contact, m
        film: f64 = 6.0e-6, 1.0e-9 to 1.0e-3;
        /// Oil: force per rate of strain at zero gap, N·s
        squeeze: f64 = 75.0, 0.0 to 1.0e5;
        /// Lever of the ring's friction, m [default: that of the innermost layer]
        lever: Option<f64>;
        /// Contact force of ring and element up to which it has no friction, N
        contact_threshold: f64 = 0.0, 0.0 to 1.0e3;
        /// Damping time of the ring's curvature, s
        curvature_damping: f64 = 2.0e-5, 0.0 to 1.0;
        /// Elements pitch by themselves, with heads, pegs, crowns and flanks that have a height
        pitch: bool;
        /// Pitch: height of the heads' contact above the rocking edge, m
        head: f64 = 5.0e-3, 1.0e-4 to 0.1;
        /// Pitch: height of the flanks below the rocking edge, m
        flank: f64 = 5.0e-3, 0.0 to 0.1;
        /// Pitch: radius of the saddle's crown along the belt, m
        crown: f64 = 1.0e-2, 0.0 to 1.0;
        /// Pitch: clearance of a peg in its hole, m
        clearance: f64 = 8.0e-5, 0.0 to 1.0e-3;
        /// The line of the result has amplitudes of forces and torques at orders of the elements
        tone: bool;
        /// Thickness: elements of 1 ± this share, in random order
        spread: f64 = 0.0, 0.0 to 0.2;
    }
}

impl Default for Options {
    fn default() -> Self {
        clap::Parser::parse_from([""])
    }
}

/// Constants of all laws. Pulleys are in the order secondary, primary.
#[derive(Clone, Debug)]
pub struct Law {
    /// Parameters of the FMU.
    pub parameters: Parameters,
    /// What this model has beside them.
    pub options: Options,
    /// Number N of elements.
    pub count: usize,
    /// Thickness h of an element, m.
    pub thickness: f64,
    /// Thickness of the element in front of each gap, m, with copies.
    pub thicknesses: Vec<f64>,
    /// Mass of an element, kg.
    pub mass: f64,
    /// Contact stiffness between neighbours k_e/h, N/m.
    pub push_stiffness: f64,
    /// Oil in the gaps.
    pub oil: Oil,
    /// Lever e_1 of the ring's friction, m.
    pub lever: f64,
    /// Lever R_c − e_1 of the saddle's crown, m; 0 without pitch.
    pub crown: f64,
    /// Contact of the flanks with a damping time of 1 s: its damping force is that of unit closing.
    pub unit_damped: Contact,
    /// Wedge of the sheaves.
    pub wedge: Wedge,
    /// Pitch radius of unloaded contact at z = 0, m.
    pub r0: f64,
    /// Axes of the pulleys, x, m.
    pub axes: [f64; 2],
    /// Heights at which a flank touches, from the rocking edge, m, and their shares.
    pub heights: Vec<(f64, f64)>,
}

impl Law {
    /// The constants at these parameters.
    ///
    /// # Errors
    /// A parameter is out of its range, the belt is a chain, or the lever is negative.
    pub fn new(parameters: &Parameters, options: &Options) -> Result<Self, ParameterError> {
        parameters.validate()?;
        let error = |name, value: f64, range| Err(ParameterError::new(name, value, range));
        if parameters.is_pull_chain() {
            let range = "PushBelt: a chain has no elements";
            return Err(ParameterError::new("belt.kind", "PullChain", range));
        }
        let (belt, geometry, layers) = (&parameters.belt, &parameters.geometry, &parameters.layers);
        // From the rocking edge out to the middle of the innermost layer.
        let innermost = belt.pitch_offset - 0.5 * f64::from(layers.count - 1) * layers.thickness;
        let lever = options.lever.unwrap_or(innermost);
        if lever.is_nan() || lever < 0.0 {
            return error("lever", lever, "at least 0: the saddle lies outside the rocking edge");
        }
        let pitch_length = geometry.belt_length - std::f64::consts::TAU * belt.pitch_offset;
        let (name, thickness) = ("belt.elementThickness", belt.element_thickness);
        let oil = Oil::of_squeeze(options.squeeze, options.film, thickness, belt.suction);
        let count = ((pitch_length - belt.play) / thickness).round();
        if !(50.0..=1e5).contains(&count) {
            return error(name, thickness, "50 to 100000 elements in the belt");
        }
        let Some(radii) = parameters.pitch_radii(1.0) else {
            let range = "a belt that closes at ratio 1";
            return error("geometry.beltLength", geometry.belt_length, range);
        };
        // The stack is as long as it shall be; the thickness gives way by less than h/2N.
        let thickness = (pitch_length - belt.play) / count;
        let (sin, cos) = (geometry.wedge_angle.sin(), geometry.wedge_angle.cos());
        let tan = geometry.wedge_angle.tan();
        let mut unit_damped = parameters.contact.clone();
        unit_damped.damping = 1.0;
        let gauss = [-1.0, 1.0].map(|side| (-options.flank * (0.5 + side / 12_f64.sqrt()), 0.5));
        let pitches = options.pitch;
        Ok(Self {
            options: options.clone(),
            count: count as usize,
            thickness,
            thicknesses: thicknesses(count as usize, thickness, options.spread),
            mass: belt.mass_per_length * thickness,
            push_stiffness: belt.push_stiffness / thickness,
            oil,
            lever,
            crown: if pitches { options.crown - lever } else { 0.0 },
            unit_damped,
            wedge: Wedge { sin, cos, tan },
            r0: radii.primary,
            axes: [0.0, geometry.center_distance],
            heights: if pitches { gauss.to_vec() } else { vec![(0.0, 1.0)] },
            parameters: parameters.clone(),
        })
    }

    /// Parameters of the pulleys.
    pub fn pulleys(&self) -> [&PulleyParameters; 2] {
        [&self.parameters.secondary, &self.parameters.primary]
    }

    /// (Δt + η_κ) EI/h³, the slope of the ring's bending in a step of `dt`, N·s/m.
    pub fn bending_slope(&self, dt: f64) -> f64 {
        let stiffness = self.parameters.ring.bending_stiffness;
        (dt + self.options.curvature_damping) * stiffness / self.thickness.powi(3)
    }
}

/// Thicknesses of 1 ± `spread` times their mean, m, in an order of chance that is the same each time.
fn thicknesses(count: usize, mean: f64, spread: f64) -> Vec<f64> {
    let mut state = 1_u32;
    let mut shares: Vec<_> = (0..count)
        .map(|_| {
            // Numerical Recipes' generator; its upper bit.
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 31 == 0 { 1.0 - spread } else { 1.0 + spread }
        })
        .collect();
    shares.extend([shares[0], shares[1]]);
    let scale = count as f64 / shares[..count].iter().sum::<f64>();
    shares.into_iter().map(|share| mean * (share * scale)).collect()
}

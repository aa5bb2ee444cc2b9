//! Loads as in drivetrains: jumps, ripple, noise, each with a vehicle on the secondary shaft and a
//! controller of the ratio by the primary force.

use crate::load_cases::clamping;
use crate::noise;
use crate::run::started;
use crate::variators::{SPEED, inputs};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Inputs, Outputs, Parameters};
use std::f64::consts::TAU;

/// Load on the variator as a function of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadHistory {
    /// Torque that oscillates slowly.
    Smooth,
    /// 80 ± 30 N·m at 70 Hz on the primary shaft: an engine's firing.
    Firing,
    /// Both clamping forces ± 5 % at 100 Hz.
    Ripple,
    /// White noise of 30 N (rms) on both clamping forces.
    Noise,
    /// From 50 to 150 N·m into macro-slip and back, each second.
    Slam,
    /// Launch from standstill through a clutch that slips, braking to standstill, and again.
    Launch,
    /// A torque of ± 50 N·m that changes its sign every 10 ms.
    Flips,
    /// Forces quantised in steps of 200 N, with a noise of 150 N (rms) before the quantisation.
    Stairs,
    /// `Firing` about 20 N·m with `Noise`, in underdrive.
    FiringAndNoise,
    /// A hunting clutch at low speed: its torque changes sign with the difference of speeds every
    /// 10 ms.
    Hunting,
}

/// All loads, in the order of their letters.
pub const LOADS: [LoadHistory; 10] = [
    LoadHistory::Smooth,
    LoadHistory::Firing,
    LoadHistory::Ripple,
    LoadHistory::Noise,
    LoadHistory::Slam,
    LoadHistory::Launch,
    LoadHistory::Flips,
    LoadHistory::Stairs,
    LoadHistory::FiringAndNoise,
    LoadHistory::Hunting,
];

/// Geometric ratios at which they are run.
pub const RATIOS: [f64; 3] = [2.2, 1.0, 0.5];

impl LoadHistory {
    pub fn letter(self) -> char {
        let at = LOADS.iter().position(|&load| load == self).expect("listed");
        char::from(b'a' + at as u8)
    }

    /// Communication step, s, mean torque on the primary shaft and largest torque that the
    /// secondary clamping force transmits, N·m, and speed of the primary shaft at the start, rad/s.
    fn figures(self) -> [f64; 4] {
        match self {
            Self::Smooth => [1e-3, 50.0, 1.3 * 80.0, SPEED],
            Self::Firing => [1e-3, 80.0, 1.3 * 110.0, SPEED],
            Self::Ripple | Self::Noise | Self::Stairs => [1e-3, 50.0, 1.3 * 60.0, SPEED],
            Self::Slam => [1e-3, 50.0, 100.0, SPEED],
            Self::Launch => [1e-3, 0.0, 1.3 * 80.0, 0.0],
            Self::Flips => [10e-3, 0.0, 1.3 * 60.0, SPEED],
            Self::FiringAndNoise => [1e-3, 20.0, 1.3 * 60.0, SPEED],
            Self::Hunting => [10e-3, 0.0, 1.3 * 60.0, 20.0],
        }
    }

    /// Communication step, s.
    pub fn step(self) -> f64 {
        self.figures()[0]
    }

    /// Ratios at which it is run.
    pub fn ratios(self) -> &'static [f64] {
        match self {
            Self::FiringAndNoise => &RATIOS[..1],
            _ => &RATIOS,
        }
    }
}

/// White noise of unit variance from numbers within ± 0.5, √12.
const UNIT: f64 = 3.464_101_615_137_754_6;

/// Gains of the controllers: of the ratio, N and N/s; of the vehicle's speed, N·m·s/rad.
const PROPORTIONAL: f64 = 2.0e4;
const INTEGRAL: f64 = 1.0e4;
const OF_SPEED: f64 = 2.0;

#[derive(Debug)]
pub struct Driven {
    pub variator: Variator,
    load: LoadHistory,
    ratio: f64,
    /// Mean clamping forces, N: S, and P when the controller is at rest.
    middle: [f64; 2],
    /// Set point of the vehicle's speed, rad/s.
    cruise: f64,
    integral: f64,
    steps: u32,
    seed: u64,
}

impl Driven {
    /// A variator in its start state, with a vehicle on its secondary shaft.
    pub fn new(load: LoadHistory, mut parameters: Parameters, ratio: f64) -> Self {
        parameters.secondary.inertia = 4.0;
        parameters.initial.ratio = ratio;
        let [_, torque, capacity, speed] = load.figures();
        parameters.initial.primary_speed = speed;
        let clamping = clamping(&parameters, ratio, capacity);
        let started = |primary: f64| {
            let start = inputs((torque, primary), (-torque * ratio, clamping));
            started(parameters.clone(), &start)
        };
        // The start holds the ratio. The run begins with the force that holds the belt there, to
        // avoid a jump.
        let primary = started(clamping).outputs().primary.axial_force;
        let variator = started(primary);
        Self {
            variator,
            load,
            ratio,
            middle: [clamping, primary],
            cruise: speed / ratio,
            integral: 0.0,
            steps: 0,
            seed: 1,
        }
    }

    /// Inputs for the next communication step.
    pub fn inputs(&mut self) -> Inputs {
        let time = f64::from(self.steps) * self.load.step();
        let outputs = self.variator.outputs().clone();
        let torques = self.torques(time, &outputs);
        let [secondary, primary] = self.clamping_forces(time, &outputs);
        self.steps += 1;
        inputs((torques[0], primary), (torques[1], secondary))
    }

    pub fn step(&mut self) {
        let inputs = self.inputs();
        self.variator.advance(self.until(), &inputs).expect("a step");
    }

    /// Torques on P and S, N·m.
    fn torques(&self, time: f64, outputs: &Outputs) -> [f64; 2] {
        let (p, s) = (outputs.primary.speed, outputs.secondary.speed);
        let mean = self.load.figures()[1];
        let cruising = |torque: f64| -torque * self.ratio - OF_SPEED * (s - self.cruise);
        let sign = if self.steps.is_multiple_of(2) { 1.0 } else { -1.0 };
        match self.load {
            LoadHistory::Smooth => {
                let torque = mean + 30.0 * (TAU * 0.2 * time).sin();
                [torque, cruising(torque)]
            }
            LoadHistory::Firing | LoadHistory::FiringAndNoise => {
                [mean + 30.0 * (TAU * 70.0 * time).sin(), cruising(mean)]
            }
            LoadHistory::Ripple | LoadHistory::Noise | LoadHistory::Stairs => [mean, cruising(mean)],
            LoadHistory::Slam => [if time % 1.0 < 0.15 { 150.0 } else { mean }, cruising(mean)],
            LoadHistory::Launch => match time % 10.0 {
                t if t < 6.0 => [60.0 * t.min(1.0) * ((150.0 - p) / 10.0).tanh(), -5.0],
                _ => [0.0, -100.0 * (s / 2.0).tanh()],
            },
            LoadHistory::Flips => [50.0 * sign, cruising(mean)],
            LoadHistory::Hunting => [if p < 22.0 { 60.0 } else { -60.0 }, cruising(mean)],
        }
    }

    /// Clamping forces of S and P, N.
    fn clamping_forces(&mut self, time: f64, outputs: &Outputs) -> [f64; 2] {
        let error = outputs.ratio_geometric - self.ratio;
        self.integral += self.load.step() * error;
        let most = 0.5 * self.middle[1];
        let control = (PROPORTIONAL * error + INTEGRAL * self.integral).clamp(-most, most);
        let forces = [self.middle[0], self.middle[1] + control];
        match self.load {
            LoadHistory::Ripple => forces.map(|force| force * (1.0 + 0.05 * (TAU * 100.0 * time).sin())),
            LoadHistory::Noise | LoadHistory::FiringAndNoise => {
                forces.map(|force| force + 30.0 * self.normal())
            }
            LoadHistory::Stairs => {
                forces.map(|force| 200.0 * ((force + 150.0 * self.normal()) / 200.0).round())
            }
            _ => forces,
        }
    }

    /// A number of a distribution of unit variance.
    fn normal(&mut self) -> f64 {
        self.seed += 1;
        let mut next = noise(self.seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        next();
        UNIT * next()
    }

    /// Time at the end of the step of the latest inputs, s.
    pub fn until(&self) -> f64 {
        f64::from(self.steps) * self.load.step()
    }
}

//! A pushbelt CVT variator around an Arbitrary-Lagrangian-Eulerian ring, as a library and as a
//! co-simulation unit of FMI 2.0 and FMI 3.0.
//!
//! Inputs are pulley torques and clamping forces; outputs are thrust ratio, belt speed and what a
//! drivetrain model needs. The mesh is fixed along the belt and the material flows through it, so a
//! run has true steady states.
//!
//! | module | content |
//! |---|---|
//! | [`reference_curve`] | the belt's closed curve r(ξ, Θ) and its derivatives |
//! | [`ring`] | beam kinematics, elastic energy, inertia |
//! | `stack`, [`contact`], [`pulley`], [`tilt`], [`shaft`] | push elements, flank contact with friction, sheaves and their tilt, drag of shafts: laws without state |
//! | [`variator`] | parameters, mesh, residual, steady states, outputs, energy balance; start at [`variator::run::Variator`] |
//! | [`solver`] | Newton, time integration, continuation, the arrow matrix; independent of the belt |
//! | [`scalar`] | what every law is generic over: numbers, packs of them, either with derivatives |
//! | [`archive`] | values to bytes and back, for stored states |
//! | [`mod@unit`] | the variator as an FMU: its variable table and the model behind the C functions |
//! | [`fmi`] | FMI state machine and C functions for any model; independent of the physics |
//!
//! ```
//! use pushbelt::variator::{Variator, settings::{Inputs, Parameters}};
//!
//! let mut variator = Variator::new(Parameters::default())?;
//! let inputs = Inputs::default();
//! variator.initialise(0.0, &inputs)?; // the steady state at ratio 1, 2000 rpm
//! variator.advance(0.01, &inputs)?;
//! let out = variator.outputs();
//! println!("thrust ratio {:.3}, belt at {:.2} m/s", out.thrust_ratio, out.belt_speed);
//! assert!(out.belt_speed > 10.0 && out.efficiency > 0.95);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A clone is a snapshot. There is no global state and no thread: any number of variators can run,
//! each in one thread.
//!
//! **Build it fast.** Without optimisation a second of belt motion takes minutes: set `opt-level =
//! 3` in `[profile.dev]` and `codegen-units = 1` in `[profile.release]`. Allow AVX2 in your
//! `.cargo/config.toml` (`rustflags = ["-C", "target-feature=+avx2"]`): cells are evaluated in
//! packs as wide as a register.
//!
//! **A ring of your own.** [`variator::Variator::with_ring`] takes any
//! [`variator::ring_models::BeltRing`], as in `examples/own_ring.rs`. To pack another model as an
//! FMU use the crate `pushbelt-fmi` alone.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

// A wrong number is worse than a slow one: docs/notebook/experiments.md, "eight lanes with
// AVX-512".
#[cfg(target_feature = "avx512f")]
compile_error!(
    "rustc 1.95, the pinned toolchain, miscompiles loops for AVX-512: compile for a processor without it, for example \
     with RUSTFLAGS=\"-C target-cpu=x86-64-v3\", or without RUSTFLAGS"
);

pub mod contact;
pub mod cylinder;
pub mod pulley;
pub mod reference_curve;
pub mod ring;
pub mod shaft;
#[doc(hidden)]
pub mod stack;
pub mod tilt;
pub mod unit;
pub mod variator;

pub use pushbelt_archive as archive;
pub use pushbelt_fmi as fmi;
pub use pushbelt_solver as solver;
pub use pushbelt_solver::scalar;

//! Floating-point environments of hosts, on x86-64: `MXCSR` of SSE and the control word of the x87.

#![allow(unsafe_code, reason = "it reads and sets registers")]

use std::arch::asm;

/// An environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Environment {
    pub mxcsr: u32,
    pub x87: u16,
}

/// Without traps, flushing, or flags; rounding to nearest.
pub const DEFAULT: Environment = Environment {
    mxcsr: 0x1f80,
    x87: 0x037f,
};
/// Invalid operations, divisions by zero and overflows are trapped.
pub const TRAPS: Environment = Environment {
    mxcsr: 0x1900,
    x87: 0x0372,
};
/// Subnormal numbers are taken and given as zero.
pub const FLUSHES: Environment = Environment {
    mxcsr: 0x9fc0,
    x87: 0x037f,
};
/// Rounding upward; the x87 in double precision.
pub const ROUNDS_UPWARD: Environment = Environment {
    mxcsr: 0x5f80,
    x87: 0x0a7f,
};
/// Flags of earlier operations: invalid, inexact.
pub const HAS_FLAGS: Environment = Environment {
    mxcsr: 0x1fa1,
    x87: 0x037f,
};

/// What hosts do.
pub const HOSTS: [Environment; 4] = [TRAPS, FLUSHES, ROUNDS_UPWARD, HAS_FLAGS];

/// The present environment.
#[must_use]
pub fn present() -> Environment {
    let mut found = Environment { mxcsr: 0, x87: 0 };
    // SAFETY: the instructions write to `found`.
    unsafe {
        asm!(
            "stmxcsr [{}]", "fnstcw [{}]",
            in(reg) &raw mut found.mxcsr, in(reg) &raw mut found.x87, options(nostack, preserves_flags)
        );
    }
    found
}

fn set(environment: Environment) {
    // SAFETY: the instructions read `environment`. What runs until the former one is set again are calls of C functions.
    unsafe {
        asm!(
            "ldmxcsr [{}]", "fldcw [{}]",
            in(reg) &raw const environment.mxcsr, in(reg) &raw const environment.x87, options(nostack, preserves_flags)
        );
    }
}

/// Runs calls of a host in its environment, and checks that they leave it as it is. `calls` computes nothing itself.
pub fn within<T>(host: Environment, calls: impl FnOnce() -> T) -> T {
    /// Sets the default again, after a panic too.
    struct Reset;
    impl Drop for Reset {
        fn drop(&mut self) {
            set(DEFAULT);
        }
    }
    let reset = Reset;
    set(host);
    let result = not_inlined(calls);
    let after = present();
    drop(reset);
    assert_eq!(after, host, "the environment after the calls");
    result
}

/// A function of its own, so that no arithmetic moves out of it.
#[inline(never)]
fn not_inlined<T>(body: impl FnOnce() -> T) -> T {
    body()
}

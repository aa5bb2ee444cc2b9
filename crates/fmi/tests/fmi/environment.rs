//! Floating-point environments of hosts, on x86-64: `MXCSR` of SSE, control word and flags of the x87.

#![allow(unsafe_code, reason = "it reads and sets registers")]

use std::arch::asm;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Environment {
    pub mxcsr: u32,
    pub x87: u16,
    pub flags: u16,
}

impl Environment {
    const fn of(mxcsr: u32, x87: u16, flags: u16) -> Self {
        Self { mxcsr, x87, flags }
    }
}

/// Without traps, flushing, or flags; rounding to nearest.
pub const DEFAULT: Environment = Environment::of(0x1f80, 0x037f, 0);

/// Of hosts that trap invalid operations, divisions by zero and overflows; that take subnormal numbers as zero; that round upward, on the x87
/// in double precision; that have flags of earlier operations.
pub const HOSTS: [Environment; 4] = [
    Environment::of(0x1900, 0x0372, 0),
    Environment::of(0x9fc0, 0x037f, 0),
    Environment::of(0x5f80, 0x0a7f, 0),
    Environment::of(0x1fa1, 0x037f, 0x21),
];

#[must_use]
pub fn present() -> Environment {
    let mut found = Environment::of(0, 0, 0);
    // SAFETY: the instructions write to `found`.
    unsafe {
        asm!(
            "stmxcsr [{}]", "fnstcw [{}]", "fnstsw [{}]",
            in(reg) &raw mut found.mxcsr, in(reg) &raw mut found.x87, in(reg) &raw mut found.flags,
            options(nostack, preserves_flags)
        );
    }
    found.flags &= 0xff;
    found
}

/// The present environment is the default one, but for flags of calculations.
pub fn assert_default() {
    let found = present();
    assert_eq!(
        (found.mxcsr & !0x3f, found.x87, found.flags),
        (DEFAULT.mxcsr, DEFAULT.x87, 0)
    );
}

pub fn set(environment: Environment) {
    let mut x87 = [0_u32; 7];
    // SAFETY: the instructions read and write what is given. What runs until the former environment is set again are calls of C functions.
    unsafe {
        asm!("fnstenv [{}]", in(reg) &raw mut x87, options(nostack, preserves_flags));
        (x87[0], x87[1]) = (environment.x87.into(), environment.flags.into());
        asm!(
            "ldmxcsr [{}]", "fldenv [{}]",
            in(reg) &raw const environment.mxcsr, in(reg) &raw const x87, options(nostack, preserves_flags)
        );
    }
}

/// Runs calls of a host in its environment, and checks that they leave it as it is. `calls` computes nothing itself.
pub fn within<T>(host: Environment, calls: impl FnOnce() -> T) -> T {
    set(host);
    let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| not_inlined(calls)));
    let after = present();
    set(DEFAULT);
    assert_eq!(after, host, "the environment after the calls");
    result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// A function of its own, so that no arithmetic moves out of it.
#[inline(never)]
fn not_inlined<T>(body: impl FnOnce() -> T) -> T {
    body()
}

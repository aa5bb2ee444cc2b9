//! Floating-point environments of hosts, on x86-64: `MXCSR` of SSE, control word and flags of the
//! x87.

#![allow(unsafe_code, reason = "it reads and sets registers")]

use std::arch::asm;

/// `MXCSR`, control word, flags.
pub type Environment = (u32, u16, u16);

/// Without traps, flushing, or flags; rounding to nearest.
pub const DEFAULT: Environment = (0x1f80, 0x037f, 0);

/// Of hosts that trap invalid operations, divisions by zero and overflows; that take subnormal
/// numbers as zero; that round upward, on the x87 in double precision; that have flags of earlier
/// operations.
pub const HOSTS: [Environment; 4] = [
    (0x1900, 0x0372, 0),
    (0x9fc0, 0x037f, 0),
    (0x5f80, 0x0a7f, 0),
    (0x1fa1, 0x037f, 0x21),
];

#[must_use]
pub fn present() -> Environment {
    let (mut mxcsr, mut control, mut status) = (0, 0, 0);
    // SAFETY: the instructions write to the three variables.
    unsafe {
        asm!(
            "stmxcsr [{}]", "fnstcw [{}]", "fnstsw [{}]",
            in(reg) &raw mut mxcsr, in(reg) &raw mut control, in(reg) &raw mut status,
            options(nostack, preserves_flags)
        );
    }
    (mxcsr, control, status & 0xff)
}

/// The present environment is the default one, but for flags of calculations.
pub fn assert_default() {
    let (mxcsr, control, flags) = present();
    assert_eq!((mxcsr & !0x3f, control, flags), DEFAULT);
}

pub fn set((mxcsr, control, flags): Environment) {
    let mut x87 = [0_u32; 7];
    // SAFETY: the instructions read and write what is given. What runs until the former environment
    // is set again are calls of C functions.
    unsafe {
        asm!("fnstenv [{}]", in(reg) &raw mut x87, options(nostack, preserves_flags));
        (x87[0], x87[1]) = (control.into(), flags.into());
        asm!(
            "ldmxcsr [{}]", "fldenv [{}]",
            in(reg) &raw const mxcsr, in(reg) &raw const x87, options(nostack, preserves_flags)
        );
    }
}

/// Runs calls of a host in its environment, and checks that they leave it as it is. `calls`
/// computes nothing itself.
pub fn call_in<T>(host: Environment, calls: impl FnOnce() -> T) -> T {
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

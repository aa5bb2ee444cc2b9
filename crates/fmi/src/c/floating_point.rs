//! The floating-point environment: rounding, flushing of subnormal numbers, traps and flags, which belong to the thread.
//!
//! Rust code requires the default environment, and the calling convention makes its caller provide it. Many hosts don't: some
//! trap invalid operations, some flush subnormal numbers. So every C function runs in the default environment, whatever the
//! host's is, and returns in the host's environment, flags included. Callbacks of the host run in the host's environment.

use std::cell::Cell;

#[cfg(target_arch = "aarch64")]
use aarch64::Registers;
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
use other::Registers;
#[cfg(target_arch = "x86_64")]
use x86_64::Registers;

thread_local! {
    /// The host's environment, while a C function runs on this thread.
    static HOST: Cell<Option<Registers>> = const { Cell::new(None) };
}

/// Runs `body` in the default environment, and restores the host's afterwards.
pub(crate) fn in_default<T>(body: impl FnOnce() -> T) -> T {
    let _host = Host::leave();
    apart(body)
}

/// Runs a callback of the host in the host's environment. What it changes there is the host's.
pub(crate) fn in_hosts<T>(callback: impl FnOnce() -> T) -> T {
    let Some(host) = HOST.get() else {
        return callback();
    };
    host.load();
    let result = apart(callback);
    HOST.set(Some(Registers::hold()));
    result
}

/// Runs `body` as a function of its own: the compiler moves no arithmetic of it across a change of the environment.
#[inline(never)]
fn apart<T>(body: impl FnOnce() -> T) -> T {
    body()
}

/// Restores the host's environment when it is dropped. C functions nest: a callback may call another one.
struct Host {
    outer: Option<Registers>,
}

impl Host {
    fn leave() -> Self {
        Self {
            outer: HOST.replace(Some(Registers::hold())),
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        if let Some(host) = HOST.replace(self.outer) {
            host.load();
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86_64 {
    use std::arch::asm;

    /// Control and status of SSE and of the x87, which libraries of C use for some functions.
    #[derive(Clone, Copy)]
    pub struct Registers {
        mxcsr: u32,
        x87: [u32; 7],
    }

    /// Traps masked, rounding to nearest, subnormal numbers kept, no flags.
    static MXCSR: u32 = 0x1f80;
    /// Traps masked, rounding to nearest, extended precision.
    static X87: u16 = 0x037f;

    impl Registers {
        /// The present environment, after which the default one is set.
        pub fn hold() -> Self {
            let mut held = Self { mxcsr: 0, x87: [0; 7] };
            // SAFETY: the instructions write to `held` and read the constants. The default environment is the one that the
            // compiler presumes. The x87's registers are empty at a call, and clearing its flags leaves them so.
            unsafe {
                asm!(
                    "stmxcsr [{held_mxcsr}]",
                    "fnstenv [{held_x87}]",
                    "fnclex",
                    "fldcw [{x87}]",
                    "ldmxcsr [{mxcsr}]",
                    held_mxcsr = in(reg) &raw mut held.mxcsr,
                    held_x87 = in(reg) &raw mut held.x87,
                    mxcsr = in(reg) &raw const MXCSR,
                    x87 = in(reg) &raw const X87,
                    options(nostack, preserves_flags),
                );
            }
            held
        }

        /// Sets this environment.
        pub fn load(&self) {
            // SAFETY: the instructions read what `hold` has written. The host's code, or the caller's, follows.
            unsafe {
                asm!(
                    "fldenv [{x87}]",
                    "ldmxcsr [{mxcsr}]",
                    x87 = in(reg) &raw const self.x87,
                    mxcsr = in(reg) &raw const self.mxcsr,
                    options(nostack, preserves_flags, readonly),
                );
            }
        }
    }
}

#[cfg(target_arch = "aarch64")]
mod aarch64 {
    use std::arch::asm;

    /// Control and status registers.
    #[derive(Clone, Copy)]
    pub struct Registers {
        fpcr: u64,
        fpsr: u64,
    }

    impl Registers {
        /// The present environment, after which the default one is set.
        pub fn hold() -> Self {
            let [fpcr, fpsr]: [u64; 2];
            // SAFETY: zero is the default environment, which the compiler presumes: no traps, rounding to nearest, subnormal
            // numbers kept, no flags.
            unsafe {
                asm!(
                    "mrs {fpcr}, fpcr",
                    "mrs {fpsr}, fpsr",
                    "msr fpcr, xzr",
                    "msr fpsr, xzr",
                    fpcr = out(reg) fpcr,
                    fpsr = out(reg) fpsr,
                    options(nostack, preserves_flags),
                );
            }
            Self { fpcr, fpsr }
        }

        /// Sets this environment.
        pub fn load(&self) {
            // SAFETY: the values are those that `hold` has read. The host's code, or the caller's, follows.
            unsafe {
                asm!(
                    "msr fpcr, {fpcr}",
                    "msr fpsr, {fpsr}",
                    fpcr = in(reg) self.fpcr,
                    fpsr = in(reg) self.fpsr,
                    options(nostack, preserves_flags),
                );
            }
        }
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod other {
    /// Nothing: on this architecture the host has to provide the default environment.
    #[derive(Clone, Copy)]
    pub struct Registers;

    impl Registers {
        pub fn hold() -> Self {
            Self
        }

        pub fn load(&self) {}
    }
}

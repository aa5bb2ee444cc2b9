//! The floating-point environment: rounding, flushing of subnormal numbers, traps and flags, which belong to the thread.
//!
//! Rust code requires the default environment, and the calling convention makes its caller provide it. Many hosts don't: some
//! trap invalid operations, some flush subnormal numbers. So every C function runs in the default environment, whatever the
//! host's is, and returns in the host's environment, flags included. Callbacks of the host run in the host's environment.

use std::cell::Cell;

use registers::Registers;

thread_local! {
    /// The host's environment, while code of this library runs in the default one on this thread.
    static HOST: Cell<Option<Registers>> = const { Cell::new(None) };
}

/// Runs `body` in the default environment, and restores the host's afterwards.
pub(crate) fn in_default<T>(body: impl FnOnce() -> T) -> T {
    if HOST.get().is_some() {
        return body();
    }
    HOST.set(Some(Registers::hold()));
    let _host = Restore;
    not_inlined(body)
}

/// Runs a callback of the host in the host's environment. What it changes there is the host's.
pub(crate) fn in_hosts<T>(callback: impl FnOnce() -> T) -> T {
    let Some(host) = HOST.take() else {
        return callback();
    };
    host.load();
    let result = not_inlined(callback);
    HOST.set(Some(Registers::hold()));
    result
}

/// Runs `body` as a function of its own: the compiler moves no arithmetic of it across a change of the environment.
#[inline(never)]
fn not_inlined<T>(body: impl FnOnce() -> T) -> T {
    body()
}

/// Restores the host's environment when it is dropped.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        if let Some(host) = HOST.take() {
            host.load();
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod registers {
    use std::arch::asm;

    /// Traps masked, rounding to nearest, subnormal numbers kept, no flags.
    static MXCSR: u32 = 0x1f80;
    /// Traps masked, rounding to nearest, extended precision.
    static X87: u16 = 0x037f;

    /// Control and status of SSE, and the environment of the x87, which libraries of C use for some functions.
    #[derive(Clone, Copy)]
    pub struct Registers {
        mxcsr: u32,
        x87: [u32; 7],
    }

    impl Registers {
        /// The present environment, after which the default one is set.
        pub fn hold() -> Self {
            let (mut mxcsr, mut x87) = (0, [0; 7]);
            // SAFETY: the instructions write to the two variables and set the default environment, which the compiler presumes. The
            // registers of the x87 stay as they are. Its flags are cleared first: a trap that is pending would happen here.
            unsafe {
                asm!(
                    "stmxcsr [{}]", "ldmxcsr [{}]", "fnstenv [{}]", "fnclex", "fldcw [{}]",
                    in(reg) &raw mut mxcsr, in(reg) &raw const MXCSR, in(reg) &raw mut x87, in(reg) &raw const X87,
                    options(nostack, preserves_flags)
                );
            }
            Self { mxcsr, x87 }
        }

        /// Sets this environment.
        pub fn load(&self) {
            // SAFETY: the values are those that `hold` has read. The host's code, or the caller's, follows.
            unsafe {
                asm!(
                    "fldenv [{}]", "ldmxcsr [{}]",
                    in(reg) &raw const self.x87, in(reg) &raw const self.mxcsr, options(nostack, preserves_flags, readonly)
                );
            }
        }
    }
}

#[cfg(target_arch = "aarch64")]
mod registers {
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
                    "mrs {}, fpcr", "mrs {}, fpsr", "msr fpcr, xzr", "msr fpsr, xzr",
                    out(reg) fpcr, out(reg) fpsr, options(nostack, preserves_flags)
                );
            }
            Self { fpcr, fpsr }
        }

        /// Sets this environment.
        pub fn load(&self) {
            let Self { fpcr, fpsr } = *self;
            // SAFETY: the values are those that `hold` has read. The host's code, or the caller's, follows.
            unsafe {
                asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) fpcr, in(reg) fpsr, options(nostack, preserves_flags));
            }
        }
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod registers {
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

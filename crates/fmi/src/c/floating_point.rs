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
mod x86_64 {
    use std::arch::asm;

    /// Control and status of SSE and of the x87, which libraries of C use for some functions.
    #[derive(Clone, Copy)]
    pub struct Registers {
        mxcsr: u32,
        x87: X87,
    }

    /// Control and status word.
    #[derive(Clone, Copy)]
    struct X87 {
        control: u16,
        status: u16,
    }

    /// Traps masked, rounding to nearest, subnormal numbers kept, no flags.
    static MXCSR: u32 = 0x1f80;
    /// Traps masked, rounding to nearest, extended precision.
    static CONTROL: u16 = 0x037f;
    /// The flags in the status word.
    const FLAGS: u16 = 0x00ff;

    impl Registers {
        /// The present environment, after which the default one is set.
        pub fn hold() -> Self {
            let (x87, mut mxcsr) = (X87::present(), 0);
            if x87.control != CONTROL {
                // SAFETY: the default environment is the one that the compiler presumes. The x87's registers are empty at a call,
                // and stay so. The flags are cleared first: a trap that is pending would happen here.
                unsafe { asm!("fnclex", "fldcw [{}]", in(reg) &raw const CONTROL, options(nostack, preserves_flags)) };
            }
            // SAFETY: the instructions write to `mxcsr` and set the default.
            unsafe {
                asm!(
                    "stmxcsr [{}]", "ldmxcsr [{}]",
                    in(reg) &raw mut mxcsr, in(reg) &raw const MXCSR, options(nostack, preserves_flags)
                );
            }
            Self { mxcsr, x87 }
        }

        /// Sets this environment.
        pub fn load(&self) {
            self.x87.load();
            // SAFETY: the value is one that `hold` has read. The host's code, or the caller's, follows.
            unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const self.mxcsr, options(nostack, preserves_flags, readonly)) };
        }
    }

    impl X87 {
        fn present() -> Self {
            let mut found = Self { control: 0, status: 0 };
            // SAFETY: the instructions write to `found`.
            unsafe {
                asm!(
                    "fnstcw [{}]", "fnstsw [{}]",
                    in(reg) &raw mut found.control, in(reg) &raw mut found.status, options(nostack, preserves_flags)
                );
            }
            found
        }

        /// Sets these words. Only `fldenv` sets flags; it is slow, and seldom needed.
        fn load(self) {
            let Self { control, status } = self;
            if (Self::present().status ^ status) & FLAGS != 0 {
                let mut environment = [0_u32; 7];
                // SAFETY: the instruction writes to `environment`, which has its size in this mode.
                unsafe { asm!("fnstenv [{}]", in(reg) &raw mut environment, options(nostack, preserves_flags)) };
                environment[0] = control.into();
                environment[1] = environment[1] & !u32::from(FLAGS) | u32::from(status & FLAGS);
                // SAFETY: what the instruction above has written, with the words of the host.
                unsafe { asm!("fldenv [{}]", in(reg) &raw const environment, options(nostack, preserves_flags)) };
            } else if control != CONTROL {
                // SAFETY: the value is one that `hold` has read.
                unsafe { asm!("fldcw [{}]", in(reg) &raw const control, options(nostack, preserves_flags, readonly)) };
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

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use std::arch::asm;

    use super::{in_default, in_hosts};

    /// Status word of the x87.
    fn status() -> u16 {
        let mut status = 0_u16;
        // SAFETY: the instruction writes to `status`.
        unsafe { asm!("fnstsw [{}]", in(reg) &raw mut status, options(nostack, preserves_flags)) };
        status & 0xff
    }

    /// Divides by zero on the x87, which raises a flag.
    fn divide_by_zero() {
        // SAFETY: the register that is used is free at the end.
        unsafe { asm!("fld1", "fldz", "fdivp", "fstp st(0)", out("st(0)") _, out("st(1)") _, options(nostack)) };
    }

    /// Clears the flags of the x87.
    fn clear() {
        // SAFETY: flags are not read by compiled code.
        unsafe { asm!("fnclex", options(nostack, preserves_flags)) };
    }

    #[test]
    fn flags_of_the_x87_that_are_raised_within_do_not_stay() {
        clear();
        in_default(divide_by_zero);
        assert_eq!(status(), 0);
    }

    #[test]
    fn flags_of_the_host_stay() {
        clear();
        divide_by_zero();
        let raised = status();
        assert_ne!(raised, 0);
        in_default(clear);
        assert_eq!(status(), raised);
        clear();
        in_default(|| {
            in_hosts(divide_by_zero);
            clear();
        });
        assert_eq!(status(), raised, "raised in a callback");
        clear();
    }
}

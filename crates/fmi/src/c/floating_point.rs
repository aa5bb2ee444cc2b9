//! The floating-point environment: rounding, flushing of subnormal numbers, traps and flags, which
//! belong to the thread.
//!
//! Rust code requires the default environment, and many hosts have another. So every C function
//! runs in the default environment and returns in the host's, flags included; callbacks of the host
//! run in the host's.

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

/// Runs `body` as a function of its own: the compiler moves no arithmetic of it across a change of
/// the environment.
#[inline(never)]
fn not_inlined<T>(body: impl FnOnce() -> T) -> T {
    body()
}

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
    /// Traps masked, rounding to nearest, extended precision; no flags.
    const X87: [u16; 2] = [0x037f, 0];
    /// The flags in the status word of the x87.
    const FLAGS: u16 = 0x00ff;

    /// Control and status of SSE; control word and flags of the x87, which libraries of C use for
    /// some functions.
    #[derive(Clone, Copy)]
    pub struct Registers {
        mxcsr: u32,
        x87: [u16; 2],
    }

    impl Registers {
        /// The present environment, after which the default one is set.
        pub fn hold() -> Self {
            let (mut mxcsr, x87) = (0, x87());
            set_x87(x87, X87);
            // SAFETY: the instructions write to `mxcsr` and set the default, which the compiler
            // presumes.
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
            set_x87(x87(), self.x87);
            // SAFETY: the value is one that `hold` has read. The host's code, or the caller's,
            // follows.
            unsafe {
                asm!(
                    "ldmxcsr [{}]",
                    in(reg) &raw const self.mxcsr, options(nostack, preserves_flags, readonly)
                );
            }
        }
    }

    fn x87() -> [u16; 2] {
        let mut words = [0; 2];
        let [control, status] = words.each_mut().map(std::ptr::from_mut);
        // SAFETY: the instructions write to the two words.
        unsafe {
            asm!(
                "fnstcw [{}]", "fnstsw [{}]",
                in(reg) control, in(reg) status, options(nostack, preserves_flags)
            );
        };
        [words[0], words[1] & FLAGS]
    }

    /// Only `fldenv` sets flags; it is slow, and seldom needed.
    fn set_x87(present: [u16; 2], wanted: [u16; 2]) {
        if present == wanted {
            return;
        }
        let ([control, flags], mut environment) = (wanted.map(u32::from), [0_u32; 7]);
        // SAFETY: the instruction writes to `environment`, which has its size in this mode.
        unsafe { asm!("fnstenv [{}]", in(reg) &raw mut environment, options(nostack, preserves_flags)) };
        (environment[0], environment[1]) = (control, environment[1] & !u32::from(FLAGS) | flags);
        // SAFETY: what the instruction above has written, with other words. The registers of the
        // x87 stay as they are.
        unsafe { asm!("fldenv [{}]", in(reg) &raw const environment, options(nostack, preserves_flags)) };
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
            // SAFETY: zero is the default environment, which the compiler presumes: no traps,
            // rounding to nearest, subnormal numbers kept, no flags.
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
            // SAFETY: the values are those that `hold` has read. The host's code, or the caller's,
            // follows.
            unsafe {
                asm!(
                    "msr fpcr, {}", "msr fpsr, {}",
                    in(reg) fpcr, in(reg) fpsr, options(nostack, preserves_flags)
                );
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

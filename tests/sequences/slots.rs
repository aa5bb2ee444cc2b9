//! Stored states of an instance in the master, for both versions: store, restore, free, serialize.

use std::ffi::{c_int, c_void};
use std::ptr::null_mut;

use pushbelt_lab::shared_library::{ERROR, OK};

use crate::calls::Keeping;

/// An instance, or a state of one.
type Pointer = *mut c_void;

/// The functions for stored states.
///
/// # Safety
/// Of each: an instance, and null or a state that has not been freed.
pub trait StateCalls {
    unsafe fn get_state(&self, c: Pointer, state: &mut Pointer) -> c_int;
    unsafe fn set_state(&self, c: Pointer, state: Pointer) -> c_int;
    unsafe fn free_state(&self, c: Pointer, state: &mut Pointer) -> c_int;
    unsafe fn state_size(&self, c: Pointer, state: Pointer, size: &mut usize) -> c_int;
    unsafe fn state_to_bytes(&self, c: Pointer, state: Pointer, bytes: &mut [u8]) -> c_int;
    unsafe fn state_from_bytes(&self, c: Pointer, bytes: &[u8], state: &mut Pointer) -> c_int;
}

/// A stored state with its model.
struct Slot<M> {
    state: Pointer,
    model: M,
}

/// The stored states of an instance.
pub struct Slots<M>([Option<Slot<M>>; 3]);

impl<M: Copy> Slots<M> {
    pub fn empty() -> Self {
        Self([None, None, None])
    }

    /// Makes a call with stored states. Returns the model of the instance after it; `model` is that before it.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn keep(&mut self, f: &impl StateCalls, c: Pointer, call: Keeping, model: M) -> M {
        // SAFETY: as the caller grants.
        let known = unsafe {
            match call {
                Keeping::Store { slot } => {
                    self.store(f, c, slot, model);
                    None
                }
                Keeping::Restore { slot } => self.restore(f, c, slot),
                Keeping::Drop { slot } => {
                    self.free(f, c, slot);
                    None
                }
                Keeping::ThroughBytes { slot, damage, cut } => self.through_bytes(f, c, slot, (damage, cut)),
            }
        };
        known.unwrap_or(model)
    }

    /// # Safety
    /// `c` is an instance that has not been freed.
    unsafe fn store(&mut self, f: &impl StateCalls, c: Pointer, slot: usize, model: M) {
        let kept = &mut self.0[slot];
        let mut state = kept.as_ref().map_or(null_mut(), |slot| slot.state);
        let before = state;
        // SAFETY: an instance, and null or a state that has not been freed.
        assert_eq!(unsafe { f.get_state(c, &mut state) }, OK);
        assert!(
            before.is_null() || state == before,
            "a state that is not null is used again"
        );
        *kept = Some(Slot { state, model });
    }

    /// Restores a state; its model, if there is one.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    unsafe fn restore(&self, f: &impl StateCalls, c: Pointer, slot: usize) -> Option<M> {
        let kept = self.0[slot].as_ref();
        let state = kept.map_or(null_mut(), |slot| slot.state);
        // SAFETY: an instance, and null or a state that has not been freed.
        let status = unsafe { f.set_state(c, state) };
        assert_eq!(status, if kept.is_some() { OK } else { ERROR });
        kept.map(|slot| slot.model)
    }

    /// # Safety
    /// `c` is an instance that has not been freed.
    unsafe fn free(&mut self, f: &impl StateCalls, c: Pointer, slot: usize) {
        if let Some(Slot { mut state, .. }) = self.0[slot].take() {
            // SAFETY: a state that has not been freed.
            unsafe {
                assert_eq!(f.free_state(c, &mut state), OK);
                assert!(state.is_null());
                assert_eq!(f.free_state(c, &mut state), OK, "null is legal");
            }
        }
    }

    /// # Safety
    /// `c` is an instance that has not been freed.
    pub unsafe fn free_all(&mut self, f: &impl StateCalls, c: Pointer) {
        for slot in 0..self.0.len() {
            // SAFETY: as the caller grants.
            unsafe { self.free(f, c, slot) };
        }
    }

    /// Serializes and deserializes; damaged or cut bytes must be refused. Returns the model of the state if it was restored.
    ///
    /// # Safety
    /// `c` is an instance that has not been freed.
    unsafe fn through_bytes(
        &self,
        f: &impl StateCalls,
        c: Pointer,
        slot: usize,
        (damage, cut): (Option<(f64, u8)>, f64),
    ) -> Option<M> {
        let Some(Slot { state, model }) = &self.0[slot] else {
            // SAFETY: the function accepts null.
            unsafe { assert_eq!(f.state_size(c, null_mut(), &mut 0), ERROR) };
            return None;
        };
        let mut size = 0;
        // SAFETY: an instance, a state that has not been freed, and as many bytes as its size.
        unsafe {
            assert_eq!(f.state_size(c, *state, &mut size), OK);
            let mut bytes = vec![0_u8; size];
            assert_eq!(f.state_to_bytes(c, *state, &mut bytes), OK);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                clippy::cast_precision_loss,
                reason = "a place among some thousand bytes"
            )]
            let place = |share: f64| (share * size as f64) as usize;
            if let Some((at, mask)) = damage {
                bytes[place(at)] ^= mask;
            }
            bytes.resize(place(cut), 0);
            let mut found = null_mut();
            let status = f.state_from_bytes(c, &bytes, &mut found);
            let whole = damage.is_none_or(|(at, _)| place(at) >= bytes.len()) && bytes.len() == size;
            assert_eq!(status, if whole { OK } else { ERROR });
            assert_eq!(found.is_null(), !whole);
            if whole {
                assert_eq!(f.set_state(c, found), OK);
                assert_eq!(f.free_state(c, &mut found), OK);
            }
            whole.then_some(*model)
        }
    }
}

macro_rules! state_calls {
    ($functions:ty: $get:ident, $set:ident, $free:ident, $size:ident, $to:ident, $from:ident) => {
        // SAFETY of each: as its caller grants; the number of bytes is that of the slice.
        impl StateCalls for $functions {
            unsafe fn get_state(&self, c: Pointer, state: &mut Pointer) -> c_int {
                unsafe { (self.$get)(c, state) }
            }
            unsafe fn set_state(&self, c: Pointer, state: Pointer) -> c_int {
                unsafe { (self.$set)(c, state) }
            }
            unsafe fn free_state(&self, c: Pointer, state: &mut Pointer) -> c_int {
                unsafe { (self.$free)(c, state) }
            }
            unsafe fn state_size(&self, c: Pointer, state: Pointer, size: &mut usize) -> c_int {
                unsafe { (self.$size)(c, state, size) }
            }
            unsafe fn state_to_bytes(&self, c: Pointer, state: Pointer, bytes: &mut [u8]) -> c_int {
                unsafe { (self.$to)(c, state, bytes.as_mut_ptr().cast(), bytes.len()) }
            }
            unsafe fn state_from_bytes(&self, c: Pointer, bytes: &[u8], state: &mut Pointer) -> c_int {
                unsafe { (self.$from)(c, bytes.as_ptr().cast(), bytes.len(), state) }
            }
        }
    };
}

state_calls! {
    pushbelt_lab::shared_library::Functions:
    fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate, fmi2SerializedFMUstateSize, fmi2SerializeFMUstate,
    fmi2DeSerializeFMUstate
}

state_calls! {
    pushbelt_lab::shared_library3::Functions3:
    fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState, fmi3SerializedFMUStateSize, fmi3SerializeFMUState,
    fmi3DeserializeFMUState
}

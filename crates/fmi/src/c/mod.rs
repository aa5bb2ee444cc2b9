//! What the C functions of both versions share. With these functions it is the only place with `unsafe`.
//!
//! | file | what it holds |
//! |---|---|
//! | `pointers` | pointers to references, slices and strings; panics to answers |
//! | `stored` | stored states as an importer holds them |

pub(super) mod pointers;
pub(super) mod stored;

//! The part of the public zenoh-c API that the safety gate uses, on the `zenoh` crate.
//!
//! Source-compatible, not binary-compatible: the gate compiles and behaves the same against
//! the official library. `include/zenoh.h` documents each call.
//!
//! Rules that hold for every exported function:
//! - Owned values are one boxed pointer, null once dropped or moved out; dropping twice is a
//!   no-op. Only `z_owned_bytes_t` and `z_view_keyexpr_t` live in place.
//! - Loaned values are plain pointers to the Rust value.
//! - A panic becomes `Z_EGENERIC` (or nothing, for void functions); it never unwinds into C++.
//! - Enums arrive as integers and are checked; options this file does not know must be null.

mod boundary;
mod bytes;
mod closure;
mod keyexpr;
mod publisher;
mod queryable;
mod session;
mod subscriber;

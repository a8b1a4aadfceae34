//! The MAVLink messages that the board and the ground speak: fifteen of the dialect `common`, as `board.xml` has them, and
//! MAVLink itself. The whole dialect takes a minute to compile.
//!
//! `cargo xtask messages` writes `board.rs` from `board.xml`.

#![cfg_attr(not(feature = "std"), no_std)]

#[allow(missing_docs, non_camel_case_types, non_snake_case, unused_qualifications, clippy::all)]
#[rustfmt::skip]
pub mod board;

pub use mavlink_core::*;

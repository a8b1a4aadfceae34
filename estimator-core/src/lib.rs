#![no_std]
#![forbid(unsafe_code)]
//! The core that flies.

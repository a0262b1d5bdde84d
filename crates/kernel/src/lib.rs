//! Ray/triangle intersection in packets. *Trace in f32. Answer in f64. Or exactly.*
#![cfg_attr(not(feature = "std"), no_std)]

mod data;
pub mod lanes;

pub use data::{Hit, Ray, Triangle};

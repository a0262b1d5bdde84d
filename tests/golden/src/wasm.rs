//! The report for the host that runs this WebAssembly module, as text in the module's memory.

// Exported functions need `#[unsafe(no_mangle)]`.
#![allow(unsafe_code)]

use std::sync::{Mutex, PoisonError};

use crate::report;

static TEXT: Mutex<String> = Mutex::new(String::new());

/// Computes the report. Returns 1 if every answer equals the committed one, and 0 otherwise.
#[unsafe(no_mangle)]
pub extern "C" fn golden_report() -> u32 {
    let (text, same) = report();
    *TEXT.lock().unwrap_or_else(PoisonError::into_inner) = text;
    u32::from(same)
}

/// Returns the address of the last report.
#[unsafe(no_mangle)]
pub extern "C" fn golden_text() -> *const u8 {
    TEXT.lock().unwrap_or_else(PoisonError::into_inner).as_ptr()
}

/// Returns the length of the last report in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn golden_text_len() -> usize {
    TEXT.lock().unwrap_or_else(PoisonError::into_inner).len()
}

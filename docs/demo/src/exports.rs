//! The functions that the page calls. The page writes its input to [`buffer`], calls a function,
//! and reads the result from [`output`].

// Exported functions need `#[unsafe(no_mangle)]`.
#![allow(unsafe_code)]

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::fan::{CLASSES, Fan};
use crate::methods::METHODS;
use crate::model::Model;

/// The state that the module keeps between calls.
struct State {
    input: Vec<u8>,
    output: Vec<u8>,
    fan: Option<Fan>,
    model: Option<Model>,
}

static STATE: Mutex<State> =
    Mutex::new(State { input: vec![], output: vec![], fan: None, model: None });

fn state() -> MutexGuard<'static, State> {
    STATE.lock().unwrap_or_else(PoisonError::into_inner)
}

impl State {
    /// Decodes the input as little-endian f64 numbers.
    fn numbers(&self) -> Vec<f64> {
        let number = |bytes: &[u8]| {
            f64::from_le_bytes(bytes.try_into().expect("each chunk has eight bytes"))
        };
        self.input.chunks_exact(8).map(number).collect()
    }

    /// Outputs the number of pixels in each class, then one byte for each pixel.
    fn put(&mut self, counts: [u32; CLASSES], pixels: &[u8]) {
        self.output.clear();
        for count in counts {
            self.output.extend(count.to_le_bytes());
        }
        self.output.extend(pixels);
    }

    /// Stores a model and returns its number of triangles. On error, outputs the message and
    /// returns 0.
    fn take(&mut self, model: Result<Model, String>) -> u32 {
        match model {
            Ok(model) => {
                let triangles = model.len() as u32;
                self.model = Some(model);
                triangles
            }
            Err(e) => {
                self.output = e.into_bytes();
                0
            }
        }
    }
}

/// Resizes the input buffer to `len` bytes and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn buffer(len: usize) -> *mut u8 {
    let input = &mut state().input;
    input.clear();
    input.resize(len, 0);
    input.as_mut_ptr()
}

/// Returns the address of the last output.
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    state().output.as_ptr()
}

/// Returns the length of the last output in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn output_len() -> usize {
    state().output.len()
}

/// Outputs the golden report. Returns 1 if all hashes equal the committed ones.
#[unsafe(no_mangle)]
pub extern "C" fn golden() -> u32 {
    let (text, same) = intertri_golden::report();
    state().output = text.into_bytes();
    same.into()
}

/// Outputs the names of the methods, one per line.
#[unsafe(no_mangle)]
pub extern "C" fn method_names() {
    let names = METHODS.map(|method| method.name).join("\n");
    state().output = names.into_bytes();
}

/// Sets the fan from the numbers in the input buffer. Returns 1 if they describe a valid fan, and 0
/// otherwise.
#[unsafe(no_mangle)]
pub extern "C" fn fan_set() -> u32 {
    let mut state = state();
    state.fan = Fan::new(&state.numbers());
    state.fan.is_some().into()
}

/// Outputs a method's counts and pixels for the fan. Returns 0 if there is no fan or the method
/// does not exist.
#[unsafe(no_mangle)]
pub extern "C" fn fan_picture(method: usize) -> u32 {
    let mut state = state();
    let Some(fan) = state.fan.as_ref().filter(|_| method < METHODS.len()) else { return 0 };
    let (counts, pixels) = fan.picture(method);
    state.put(counts, &pixels);
    1
}

/// Loads a model from the input buffer, which holds a file name of `name_len` bytes followed by the
/// file's contents. Returns the number of triangles. On error, outputs the message and returns 0.
#[unsafe(no_mangle)]
pub extern "C" fn model_load(name_len: usize) -> u32 {
    let mut state = state();
    let input = std::mem::take(&mut state.input);
    let (name, bytes) = input.split_at(name_len.min(input.len()));
    let model = Model::from_file(&String::from_utf8_lossy(name), bytes);
    state.take(model)
}

/// Loads the built-in scene and returns its number of triangles.
#[unsafe(no_mangle)]
pub extern "C" fn model_built_in() -> u32 {
    state().take(Model::built_in())
}

/// Sets the view of the model from the numbers in the input buffer. Returns 1 if they describe a
/// valid view, and 0 otherwise.
#[unsafe(no_mangle)]
pub extern "C" fn model_look() -> u32 {
    let mut state = state();
    let numbers = state.numbers();
    state.model.as_mut().is_some_and(|model| model.look(&numbers)).into()
}

/// Traces the rows `first..end` of the image and outputs one byte per pixel.
#[unsafe(no_mangle)]
pub extern "C" fn model_trace(first: usize, end: usize) {
    let mut state = state();
    let Some(model) = &mut state.model else { return };
    state.output = model.trace(first..end);
}

/// Compares a method with the traced image in the tile rows `first..end`. Outputs the counts and
/// one byte per pixel. Returns 0 if there is no model or the method does not exist.
#[unsafe(no_mangle)]
pub extern "C" fn model_compare(method: usize, first: usize, end: usize) -> u32 {
    let mut state = state();
    let Some(model) = state.model.as_mut().filter(|_| method < METHODS.len()) else { return 0 };
    let (counts, classes) = model.compare(method, first..end);
    state.put(counts, &classes);
    1
}

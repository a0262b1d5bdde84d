//! What the page calls. It writes numbers and bytes to [`buffer`], calls, and reads from [`output`].

// The names are what the outside calls.
#![allow(unsafe_code)]

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::fan::{CLASSES, Fan};
use crate::methods::METHODS;
use crate::model::Model;

/// What lasts from call to call.
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
    /// What was written, as numbers.
    fn numbers(&self) -> Vec<f64> {
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight"));
        self.input.chunks_exact(8).map(number).collect()
    }

    /// Counts, then a byte a pixel.
    fn put(&mut self, counts: [u32; CLASSES], pixels: &[u8]) {
        self.output.clear();
        for count in counts {
            self.output.extend(count.to_le_bytes());
        }
        self.output.extend(pixels);
    }

    /// A model, or why there is none.
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

/// Room for so many bytes of input.
#[unsafe(no_mangle)]
pub extern "C" fn buffer(len: usize) -> *mut u8 {
    let input = &mut state().input;
    input.clear();
    input.resize(len, 0);
    input.as_mut_ptr()
}

/// Where the last output begins.
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    state().output.as_ptr()
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn output_len() -> usize {
    state().output.len()
}

/// Outputs the report of the golden answers; 1 where every answer is the committed one.
#[unsafe(no_mangle)]
pub extern "C" fn golden() -> u32 {
    let (text, same) = intertri_golden::report();
    state().output = text.into_bytes();
    same.into()
}

/// Outputs the names of the methods, a line each.
#[unsafe(no_mangle)]
pub extern "C" fn method_names() {
    let names = METHODS.map(|method| method.name).join("\n");
    state().output = names.into_bytes();
}

/// Takes the numbers of a fan; 1 where they are one.
#[unsafe(no_mangle)]
pub extern "C" fn fan_set() -> u32 {
    let mut state = state();
    state.fan = Fan::new(&state.numbers());
    state.fan.is_some().into()
}

/// Outputs counts and pixels of the fan by a method; 1 where there is such a thing.
#[unsafe(no_mangle)]
pub extern "C" fn fan_picture(method: usize) -> u32 {
    let mut state = state();
    let Some(fan) = state.fan.as_ref().filter(|_| method < METHODS.len()) else { return 0 };
    let (counts, pixels) = fan.picture(method);
    state.put(counts, &pixels);
    1
}

/// Takes a model from the input: a name of so many bytes, then the file. How many triangles it has; 0 with a
/// message as output where it is none.
#[unsafe(no_mangle)]
pub extern "C" fn model_load(name_len: usize) -> u32 {
    let mut state = state();
    let input = std::mem::take(&mut state.input);
    let (name, bytes) = input.split_at(name_len.min(input.len()));
    let model = Model::from_file(&String::from_utf8_lossy(name), bytes);
    state.take(model)
}

/// Takes the scene that comes with the library. How many triangles it has.
#[unsafe(no_mangle)]
pub extern "C" fn model_built_in() -> u32 {
    state().take(Model::built_in())
}

/// Looks at the model by the numbers of the input; 1 where they are a view.
#[unsafe(no_mangle)]
pub extern "C" fn model_look() -> u32 {
    let mut state = state();
    let numbers = state.numbers();
    state.model.as_mut().is_some_and(|model| model.look(&numbers)).into()
}

/// Traces rows of the picture; outputs a byte a pixel.
#[unsafe(no_mangle)]
pub extern "C" fn model_trace(first: usize, end: usize) {
    let mut state = state();
    let Some(model) = &mut state.model else { return };
    state.output = model.trace(first..end);
}

/// Compares rows of tiles by a method; outputs counts and a byte a pixel. 1 where there is such a method.
#[unsafe(no_mangle)]
pub extern "C" fn model_compare(method: usize, first: usize, end: usize) -> u32 {
    let mut state = state();
    let Some(model) = state.model.as_mut().filter(|_| method < METHODS.len()) else { return 0 };
    let (counts, classes) = model.compare(method, first..end);
    state.put(counts, &classes);
    1
}

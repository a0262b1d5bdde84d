//! Shows progress bars, and adds up the time that each step takes.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// A progress bar, or a spinner if the amount of work is unknown. It is shown only if standard
/// error is a terminal, and disappears when dropped.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Creates a bar named `what`, which [`Progress::add`] or [`Progress::set`] advances.
    pub(crate) fn new(what: &'static str, total: Option<u64>) -> Self {
        let (bar, template) = match total {
            Some(total) => {
                (ProgressBar::new(total), "{msg:>8} [{bar:40}] {percent:>3} %  {eta} left")
            }
            None => (ProgressBar::new_spinner(), "{msg:>8} {spinner} {human_pos}"),
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what);
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Self(bar)
    }

    /// Advances the bar by `more` steps.
    pub(crate) fn add(&self, more: usize) {
        self.0.inc(more as u64);
    }

    /// Moves the bar to `done` of `total`.
    pub(crate) fn set(&self, done: usize, total: usize) {
        self.0.set_length(total as u64);
        self.0.set_position(done as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Runs `work`, and adds its time to `seconds`.
pub(crate) fn timed<T>(seconds: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *seconds += start.elapsed().as_secs_f64();
    done
}

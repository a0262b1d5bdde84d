//! Cleans up if a signal ends the run.

use crate::error::{Error, Result};

/// Sets up signal handling: if a watched signal ends the run, unfinished files are removed first.
/// If an allocation fails and its caller does not handle the failure, the run ends with exit code
/// 1, and an unfinished file may remain.
#[cfg(unix)]
pub(crate) fn watch() -> Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::thread;

    use intertri_scene::PartialFile;
    use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGXFSZ};
    use signal_hook::iterator::Signals;
    use signal_hook::{flag, low_level};

    // If memory runs out, the standard library prints one line and aborts.
    let always = Arc::new(AtomicBool::new(true));
    let failed = |cause| Error::at("signals", format!("cannot be watched: {cause}"));
    flag::register_conditional_shutdown(SIGABRT, 1, always).map_err(failed)?;
    // With a handler, this signal does not end the program, and writing beyond the file size limit
    // becomes an ordinary error.
    flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))).map_err(failed)?;

    let ignored = ignored();
    let watched = [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU].into_iter();
    let watched = watched.filter(|signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = Signals::new(watched).map_err(failed)?;
    let wait = move || {
        for signal in signals.forever() {
            PartialFile::abandon_all();
            // The parent process must see that the signal ended the program.
            let _ = low_level::emulate_default_handler(signal);
        }
    };
    // The thread needs very little memory.
    let thread = thread::Builder::new().name("signals".to_owned()).stack_size(1 << 16);
    thread.spawn(wait).map_err(Error::no_thread)?;
    Ok(())
}

/// Returns the signals that were ignored when the program started, with bit 0 for signal 1. These
/// signals stay ignored, because `nohup` and the background jobs of shells rely on that.
#[cfg(target_os = "linux")]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or_default()
}

#[cfg(all(unix, not(target_os = "linux")))]
fn ignored() -> u64 {
    0
}

#[cfg(not(unix))]
pub(crate) fn watch() -> Result<()> {
    Ok(())
}

//! Cleans up when a signal ends the run.

use crate::error::{Error, Result};

/// From now on, a run that a signal ends leaves no unfinished file, and one that runs out of memory ends with
/// exit code 1, unless its caller handles that.
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
    // With a handler, it does not end the program: writing beyond the limit on file sizes becomes an ordinary
    // error.
    flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false))).map_err(failed)?;

    let ignored = ignored();
    let watched = [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU].into_iter();
    let watched = watched.filter(|signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = Signals::new(watched).map_err(failed)?;
    let wait = move || {
        for signal in signals.forever() {
            PartialFile::abandon_all();
            // The sender sees that the signal ended the program.
            let _ = low_level::emulate_default_handler(signal);
        }
    };
    // It needs almost no memory.
    let thread = thread::Builder::new().name("signals".to_owned()).stack_size(1 << 16);
    thread.spawn(wait).map_err(Error::no_thread)?;
    Ok(())
}

/// The signals that were ignored when the program started, one bit each from 1 on: `nohup` ignores some, and
/// shells do so for background jobs. They stay ignored.
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

//! Writes files that get their final name only once they are complete.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{mem, process};

/// The hidden files of this process that do not have their final names yet.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file that is written under another name next to its final path, and renamed once it is
/// complete.
///
/// The bytes go to a hidden file, `.NAME.PID.partial` in the same folder, so that renaming stays
/// within one file system. If the `PartialFile` is dropped before [`PartialFile::finish`], the
/// hidden file is removed, and an older file is unchanged. If the file replaces an older file, it
/// keeps the older file's permissions.
///
/// ```
/// use std::io::Write;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.txt");
/// let mut file = intertri_scene::PartialFile::create(&path)?;
/// file.write_all(b"all of it")?;
/// assert!(!path.exists());
/// file.finish()?;
/// assert_eq!(std::fs::read(&path)?, b"all of it");
/// # Ok::<_, std::io::Error>(())
/// ```
pub struct PartialFile {
    file: File,
    hidden: PathBuf,
    path: PathBuf,
}

impl PartialFile {
    /// Creates a file that will be at `path` once it is finished. If `path` is a link, the link
    /// stays, and its target is replaced.
    ///
    /// # Errors
    /// Returns any error from the file system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let hidden = path.with_file_name(format!(".{name}.{}.partial", process::id()));
        let mut unfinished = unfinished();
        let file = File::create(&hidden)?;
        unfinished.push(hidden.clone());
        drop(unfinished);

        // Set the permissions before the file contains anything that others should not read.
        let partial = Self { file, hidden, path };
        if let Ok(old) = fs::metadata(&partial.path)
            && old.permissions() != partial.file.metadata()?.permissions()
        {
            partial.file.set_permissions(old.permissions())?;
        }
        Ok(partial)
    }

    /// Waits until the bytes are on the disk. Without this call, a power cut could leave an
    /// incomplete file under the final name.
    ///
    /// # Errors
    /// Returns any error from the file system.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    /// Renames the file to its final name.
    ///
    /// # Errors
    /// Returns any error from the file system. In that case, the new file is removed.
    pub fn finish(self) -> io::Result<()> {
        // If renaming fails, `this` is dropped after the list is unlocked, which removes the file.
        let this = self;
        let mut unfinished = unfinished();
        fs::rename(&this.hidden, &this.path)?;
        unfinished.retain(|hidden| *hidden != this.hidden);
        Ok(())
    }

    /// Removes all unfinished hidden files, for a process that is about to end. Any thread that
    /// then tries to create or finish a file waits forever.
    pub fn abandon_all() {
        let unfinished = unfinished();
        for hidden in &*unfinished {
            // The process is ending, so there is nowhere to report an error.
            let _ = fs::remove_file(hidden);
        }
        mem::forget(unfinished);
    }
}

impl Write for PartialFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        let mut unfinished = unfinished();
        if unfinished.contains(&self.hidden) {
            unfinished.retain(|hidden| *hidden != self.hidden);
            // The error that caused this drop has already been reported.
            let _ = fs::remove_file(&self.hidden);
        }
    }
}

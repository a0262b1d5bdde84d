//! Files that take their names only once they are whole.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{mem, process};

/// The hidden files of this process that have not got their names yet.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file that is written under another name beside its final path, and renamed once it is complete.
///
/// The bytes go to a hidden file, `.NAME.PID.partial` in the same folder, so that renaming stays within
/// one file system. Where it is dropped before [`PartialFile::finish`], the hidden file is removed and
/// an older file stays as it was. A file that replaces an older one has its permissions.
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
    /// Begins a file that will be at `path`. Where a link is, it stays, and the file that it leads to
    /// will be replaced.
    ///
    /// # Errors
    /// Whatever the file system objects to.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let hidden = path.with_file_name(format!(".{name}.{}.partial", process::id()));
        let mut unfinished = unfinished();
        let file = File::create(&hidden)?;
        unfinished.push(hidden.clone());
        drop(unfinished);

        // Before there is a byte in it that others should not read.
        let partial = Self { file, hidden, path };
        if let Ok(old) = fs::metadata(&partial.path)
            && old.permissions() != partial.file.metadata()?.permissions()
        {
            partial.file.set_permissions(old.permissions())?;
        }
        Ok(partial)
    }

    /// Waits until the bytes are on the disk: else a power cut could leave the name without them.
    ///
    /// # Errors
    /// Whatever the file system objects to.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    /// Renames the file to its final name.
    ///
    /// # Errors
    /// Any error of the file system; then there is no file.
    pub fn finish(self) -> io::Result<()> {
        // Dropped, and so removed, after the list is free again.
        let this = self;
        let mut unfinished = unfinished();
        fs::rename(&this.hidden, &this.path)?;
        unfinished.retain(|hidden| *hidden != this.hidden);
        Ok(())
    }

    /// Removes the hidden files of everything unfinished, for a process that is about to end. A thread that begins or
    /// finishes a file from now on waits forever.
    pub fn abandon_all() {
        let unfinished = unfinished();
        for hidden in &*unfinished {
            // The process ends, so there is no one left to report an error to.
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
            // The error that led here has been reported.
            let _ = fs::remove_file(&self.hidden);
        }
    }
}

//! Runs the compiled binary in a temporary folder.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A folder that is deleted when the test ends.
pub(crate) struct TestFolder(TempDir);

impl TestFolder {
    pub(crate) fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub(crate) fn put(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Self {
        fs::write(self.path(name), bytes).unwrap();
        self
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// Returns the names of all files in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Creates a command that runs `intertri`, with arguments separated by spaces.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_intertri"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command
    }

    pub(crate) fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs a command that must succeed and print nothing on standard error. Returns its standard
    /// output.
    pub(crate) fn ok(&self, arguments: &str) -> Vec<u8> {
        done(arguments, self.run(arguments))
    }

    /// Like [`Self::ok`], but passes `input` on standard input.
    pub(crate) fn ok_with_input(&self, arguments: &str, input: &[u8]) -> Vec<u8> {
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        std::thread::scope(|scope| {
            scope.spawn(move || stdin.write_all(input).unwrap());
            done(arguments, child.wait_with_output().unwrap())
        })
    }

    /// Runs a command that must fail with `code`, print nothing on standard output, and print one
    /// line on standard error that contains all of `words`.
    pub(crate) fn fails(&self, arguments: &str, code: i32, words: &[&str]) {
        let output = self.run(arguments);
        assert_eq!(String::from_utf8_lossy(&output.stdout), "", "{arguments}");
        one_line(arguments, &output, code, words);
    }
}

fn done(arguments: &str, output: Output) -> Vec<u8> {
    assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{arguments}");
    assert_eq!(output.status.code(), Some(0), "{arguments}");
    output.stdout
}

/// Checks the exit code, and that standard error is one line that contains all of `words`.
pub(crate) fn one_line(arguments: &str, output: &Output, code: i32, words: &[&str]) {
    let error = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments}: {error}");
    assert!(error.starts_with("intertri: ") && error.ends_with('\n'), "{arguments}: {error}");
    assert_eq!(error.lines().count(), 1, "{arguments}: {error}");
    for word in words {
        assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
    }
}

/// The system's message for a missing file.
pub(crate) const NO_SUCH_FILE: &str = if cfg!(windows) { "cannot find" } else { "No such file" };

/// Two triangles and a quad in front of a camera at the origin that looks along z.
pub(crate) const MODEL: &str = "\
v 0 0 5
v 1 0 5
v 0 1 5
v 0 0 7
v 1 0 7
v 0 1 7
f 1 2 3
f 4 5 6
v -9 -9 9
v 9 -9 9
v 9 9 9
v -9 9 9
f -4 -3 -2 -1
";

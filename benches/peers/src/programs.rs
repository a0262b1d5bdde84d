//! Tracers that run as separate programs. `programs/build` builds them, and `programs/tracer.h`
//! describes what they read and write.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Error, Result, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use intertri::{Ray64, Triangle64};

use crate::engine::{Answer, Engine, Question};

/// A program and the scene that it traces.
pub struct Program {
    name: String,
    path: PathBuf,
    triangles: Vec<Triangle64>,
    running: Option<Mutex<Running>>,
}

/// A running program that has read its scene and rays.
struct Running {
    child: Child,
    /// Closing this pipe ends the program.
    requests: Option<ChildStdin>,
    replies: BufReader<ChildStdout>,
    file: PathBuf,
    any: bool,
}

impl Program {
    pub fn new(name: &str, triangles: &[Triangle64]) -> std::result::Result<Self, String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/programs").join(name);
        if !path.exists() {
            return Err("not built; run benches/peers/programs/build".into());
        }
        Ok(Self { name: name.into(), path, triangles: triangles.to_vec(), running: None })
    }

    /// Returns the value of a result. Panics on an error, which would make all figures wrong.
    fn must<T>(&self, result: Result<T>) -> T {
        result.unwrap_or_else(|error| panic!("{}: {error}", self.path.display()))
    }
}

impl Running {
    fn start(program: &Program, rays: &[Ray64], question: Question) -> Result<Self> {
        let name = format!("intertri-peers-{}-{}", std::process::id(), program.name);
        let file = std::env::temp_dir().join(name);
        write(&file, &program.triangles, rays, question)?;
        let mut command = Command::new(&program.path);
        command.arg(&file).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn()?;
        let requests = child.stdin.take();
        let replies = child.stdout.take().ok_or(Error::other("no output"))?;
        let replies = BufReader::new(replies);
        let mut running = Self { child, requests, replies, file, any: question.any };
        running.wait("ready")?;
        Ok(running)
    }

    fn request(&mut self, line: &str) -> Result<()> {
        let requests = self.requests.as_mut().ok_or(Error::other("ended"))?;
        writeln!(requests, "{line}")?;
        requests.flush()?;
        self.wait("done")
    }

    fn wait(&mut self, word: &str) -> Result<()> {
        let mut line = String::new();
        self.replies.read_line(&mut line)?;
        let line = line.trim();
        if line == word {
            Ok(())
        } else {
            Err(Error::other(format!("{line:?} instead of {word:?}")))
        }
    }

    /// Returns the path to the file that the program writes its answers to.
    fn written(&self) -> PathBuf {
        let mut path = self.file.clone().into_os_string();
        path.push(".answers");
        path.into()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.requests = None;
        // The program has ended or will end, and the files are temporary, so an error here does not
        // affect any figure.
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.file);
        let _ = std::fs::remove_file(self.written());
    }
}

fn write(path: &Path, triangles: &[Triangle64], rays: &[Ray64], question: Question) -> Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    let numbers = |out: &mut BufWriter<File>, numbers: &[f64]| {
        numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
    };
    out.write_all(&(triangles.len() as u64).to_le_bytes())?;
    for triangle in triangles {
        numbers(&mut out, triangle.0.as_flattened())?;
    }
    out.write_all(&u64::from(question.any).to_le_bytes())?;
    out.write_all(&(rays.len() as u64).to_le_bytes())?;
    for ray in rays {
        numbers(&mut out, &ray.origin)?;
        numbers(&mut out, &ray.dir)?;
        numbers(&mut out, &[ray.t_max])?;
    }
    out.flush()
}

impl Engine<Ray64> for Program {
    fn load(&mut self, rays: &[Ray64], question: Question) {
        // The file of the previous rays has the same name, so first end the program that traces
        // them.
        self.running = None;
        let running = self.must(Running::start(self, rays, question));
        self.running = Some(Mutex::new(running));
    }

    fn trace(&mut self, part: Range<usize>) {
        let line = format!("{} {}", part.start, part.end);
        let request = |running: &Mutex<Running>| lock(running).request(&line);
        self.must(self.running.as_ref().map_or(Ok(()), request));
    }

    fn answers(&self) -> Vec<Answer> {
        let Some(running) = &self.running else { return Vec::new() };
        let mut running = lock(running);
        self.must(running.request("answers"));
        let bytes = self.must(std::fs::read(running.written()));
        let answer = |bytes: &[u8; 4]| match u32::from_le_bytes(*bytes) {
            u32::MAX => Answer::MISS,
            _ if running.any => Answer::ANY,
            triangle => Answer { triangle, t: f64::NAN },
        };
        bytes.as_chunks().0.iter().map(answer).collect()
    }
}

fn lock(running: &Mutex<Running>) -> MutexGuard<'_, Running> {
    running.lock().unwrap_or_else(PoisonError::into_inner)
}

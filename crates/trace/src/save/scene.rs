//! The file format of a saved scene, apart from its meshes. All values are little-endian.
//!
//! ```text
//!   header    as for a hierarchy, except
//!             16 instances: u64   24 meshes: u64   32 zero   40 end of the sections: u64
//!   table     as for a hierarchy
//!   sections  scalar type of each mesh; instances; free numbers   each aligned to 64 bytes
//!   meshes    saved hierarchies                                   each aligned to 64 bytes
//!   checksum  of the checksums in all headers, the scene's first  aligned to 64 bytes
//! ```
//!
//! The checksum in the header of a mesh covers the whole mesh, so the last checksum covers the
//! whole file. It also ensures that no mesh was replaced by a mesh from another file.

use std::io::{self, Write};

use super::checksum::checksum;
use super::error::LoadError;
use super::format::{
    self, ALIGN, ENTRY, Entry, HEADER, SECTIONS, SUM, check_sum, entries, front_of, u32_at, u64_at,
};
use super::input::Input;
use super::load::{in_batches, room};
use super::scene_error::SceneLoadError;
use super::store::{Section, entries_of, no_memory, write_sections};
use crate::tree::LEAF;
use crate::util::memory::{NoMemory, filled};
use crate::util::threads;

/// The first bytes of a saved scene.
///
/// ```
/// use intertri_trace::{SAVED_SCENE_MAGIC, Scene};
/// assert!(Scene::new().to_bytes().starts_with(&SAVED_SCENE_MAGIC));
/// ```
pub const SAVED_SCENE_MAGIC: [u8; 8] = *b"\x89ITSC\r\n\x1a";

const VERSION: u32 = 1;

// The section kinds. The size of each kind's records follows it.

/// The section that records the scalar type of each mesh.
const MESHES: u32 = 1;
/// The section of instances.
const INSTANCES: u32 = 2;
const INSTANCE: usize = 104;
/// The section of free instance numbers.
const FREE: u32 = 3;
const NUMBER: usize = 4;

/// The mesh index stored for an unused instance number.
const NO_MESH: u32 = u32::MAX;

/// An instance, or an unused instance number if `mesh` is `None`.
#[derive(Clone, Copy)]
pub(crate) struct InstanceRecord {
    pub(crate) matrix: [f64; 12],
    pub(crate) mesh: Option<u32>,
    pub(crate) mask: u32,
}

/// A mesh to be saved with a scene.
pub(crate) trait SavedMesh: Sync {
    fn is_f64(&self) -> bool;
    fn write(&self, output: &mut dyn Write) -> io::Result<()>;
}

/// Writes a scene: its instances in order of their numbers, the free numbers, and its meshes.
pub(crate) fn write_scene(
    (count, instance): (usize, &(dyn Fn(usize) -> InstanceRecord + Sync)),
    free: &[u32],
    meshes: &[&dyn SavedMesh],
    output: &mut dyn Write,
) -> io::Result<()> {
    let write_scalar = |i: usize, to: &mut [u8]| {
        to.copy_from_slice(&u32::from(meshes[i].is_f64()).to_le_bytes());
    };
    let write_instance = |i: usize, to: &mut [u8]| write_record(&instance(i), to);
    let write_free = |i: usize, to: &mut [u8]| to.copy_from_slice(&free[i].to_le_bytes());
    let sections = [
        Section { kind: MESHES, record: NUMBER, count: meshes.len(), write: &write_scalar },
        Section { kind: INSTANCES, record: INSTANCE, count, write: &write_instance },
        Section { kind: FREE, record: NUMBER, count: free.len(), write: &write_free },
    ];
    let (entries, end) = entries_of(&sections).map_err(no_memory)?;
    let numbers = [count as u64, meshes.len() as u64, 0, end as u64];
    let front = front_of((SAVED_SCENE_MAGIC, VERSION), numbers, &entries);
    let mut sums = front[SUM..HEADER].to_vec();
    write_sections(front, &sections, &entries, output)?;

    let mut at = end as u64;
    for mesh in meshes {
        pad(at, output)?;
        let mut written = Written { output, count: 0, header: [0; HEADER] };
        mesh.write(&mut written)?;
        at = at.next_multiple_of(ALIGN as u64) + written.count;
        sums.try_reserve(8).map_err(|error| no_memory(error.into()))?;
        sums.extend(&written.header[SUM..]);
    }
    pad(at, output)?;
    output.write_all(&checksum(&sums).to_le_bytes())
}

/// Pads the output with zeros from offset `at` to the next multiple of [`ALIGN`].
fn pad(at: u64, output: &mut dyn Write) -> io::Result<()> {
    output.write_all(&[0; ALIGN][..gap(at)])
}

/// Returns the number of bytes from offset `at` to the next multiple of [`ALIGN`].
fn gap(at: u64) -> usize {
    (at.wrapping_neg() % ALIGN as u64) as usize
}

/// Counts the bytes written to an output, and keeps a copy of the header.
struct Written<'a> {
    output: &'a mut dyn Write,
    count: u64,
    header: [u8; HEADER],
}

impl Write for Written<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.output.write(bytes)?;
        keep(&mut self.header, self.count, &bytes[..written]);
        self.count += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.flush()
    }
}

/// Copies the part of a chunk that belongs to the header. The chunk begins at offset `at`.
fn keep(header: &mut [u8; HEADER], at: u64, bytes: &[u8]) {
    if at < HEADER as u64 {
        let rest = &mut header[at as usize..];
        let count = rest.len().min(bytes.len());
        rest[..count].copy_from_slice(&bytes[..count]);
    }
}

fn write_record(instance: &InstanceRecord, to: &mut [u8]) {
    let InstanceRecord { matrix, mesh, mask } = instance;
    for (to, x) in to.chunks_exact_mut(8).zip(matrix) {
        to.copy_from_slice(&x.to_bits().to_le_bytes());
    }
    to[96..100].copy_from_slice(&mesh.unwrap_or(NO_MESH).to_le_bytes());
    to[100..].copy_from_slice(&mask.to_le_bytes());
}

fn read_record(bytes: &[u8]) -> InstanceRecord {
    let mesh = u32_at(bytes, 96);
    InstanceRecord {
        matrix: std::array::from_fn(|i| f64::from_bits(u64_at(bytes, 8 * i))),
        mesh: (mesh != NO_MESH).then_some(mesh),
        mask: u32_at(bytes, 100),
    }
}

/// The sections of a saved scene, checked for consistency.
pub(crate) struct SceneFront {
    pub(crate) instances: Vec<InstanceRecord>,
    pub(crate) free: Vec<u32>,
    /// Whether each mesh has f64 coordinates.
    pub(crate) meshes: Vec<bool>,
}

/// Reads a saved scene: first its sections, then its meshes one by one, then the checksum.
pub(crate) struct SceneReader<'a> {
    input: &'a mut dyn Input,
    at: u64,
    sums: Vec<u8>,
}

impl<'a> SceneReader<'a> {
    /// Reads the sections.
    pub(crate) fn new(input: &'a mut dyn Input) -> Result<(Self, SceneFront), SceneLoadError> {
        let mut header = [0; HEADER];
        // A file that is too short for a header is probably not a saved scene.
        header.copy_from_slice(input.take(HEADER).map_err(|error| match error {
            LoadError::CutOff => SceneLoadError::NotSaved,
            error => error.into(),
        })?);
        let mut front = header.to_vec();
        front.extend(input.take(table_size(&header)?)?);
        check_sum(&front)?;
        let (entries, end) = entries(&front, |kind, record, _| match kind {
            MESHES | FREE => Some(record == NUMBER as u32),
            INSTANCES => Some(record == INSTANCE as u32),
            _ => None,
        })?;
        let mut sections = Sections::default();
        let mut at = front.len() as u64;
        for entry in &entries {
            take_zeros(input, (entry.place - at) as usize)?;
            sections.read(input, entry)?;
            at = entry.place + entry.size;
        }
        let front = sections.front()?;
        let counts = [front.instances.len() as u64, front.meshes.len() as u64, 0, end];
        if [16, 24, 32, 40].map(|at| u64_at(&header, at)) != counts {
            return SceneLoadError::damaged("the header is invalid");
        }
        Ok((Self { input, at, sums: header[SUM..].to_vec() }, front))
    }

    /// Reads the next mesh.
    pub(crate) fn mesh<T>(
        &mut self,
        index: usize,
        read: impl FnOnce(&mut dyn Input) -> Result<T, LoadError>,
    ) -> Result<T, SceneLoadError> {
        take_zeros(self.input, gap(self.at))?;
        let mut taken = CountedInput { input: self.input, count: 0, header: [0; HEADER] };
        let mesh = read(&mut taken).map_err(|error| SceneLoadError::of_mesh(index, error))?;
        let CountedInput { count, header, .. } = taken;
        self.at = self.at.next_multiple_of(ALIGN as u64) + count;
        self.sums.try_reserve(8).map_err(NoMemory::from)?;
        self.sums.extend(&header[SUM..]);
        Ok(mesh)
    }

    /// Reads and verifies the checksum that follows the meshes.
    pub(crate) fn end(self) -> Result<(), SceneLoadError> {
        take_zeros(self.input, gap(self.at))?;
        if u64_at(self.input.take(8)?, 0) == checksum(&self.sums) {
            Ok(())
        } else {
            SceneLoadError::damaged("its meshes do not belong together")
        }
    }
}

/// Reads padding. No checksum covers it, so all its bytes must be zero.
fn take_zeros(input: &mut dyn Input, count: usize) -> Result<(), SceneLoadError> {
    if input.take(count)?.iter().all(|&byte| byte == 0) {
        Ok(())
    } else {
        SceneLoadError::damaged("there are bytes between its sections")
    }
}

/// Checks the header, and returns the size of the table that follows it.
fn table_size(header: &[u8; HEADER]) -> Result<usize, SceneLoadError> {
    let (version, sections) = (u32_at(header, 8), u32_at(header, 12));
    if header[..8] != SAVED_SCENE_MAGIC {
        return Err(SceneLoadError::NotSaved);
    }
    if version > VERSION {
        return Err(SceneLoadError::Newer { what: format!("version {version}") });
    }
    if version == 0 || sections > SECTIONS {
        return SceneLoadError::damaged("the header is invalid");
    }
    Ok(sections as usize * ENTRY)
}

/// Counts the bytes read from an input, and keeps a copy of the header.
struct CountedInput<'a> {
    input: &'a mut dyn Input,
    count: u64,
    header: [u8; HEADER],
}

impl Input for CountedInput<'_> {
    fn take(&mut self, count: usize) -> Result<&[u8], LoadError> {
        let bytes = self.input.take(count)?;
        keep(&mut self.header, self.count, bytes);
        self.count += count as u64;
        Ok(bytes)
    }

    fn known(&self) -> usize {
        self.input.known()
    }
}

/// The sections that have been read so far.
#[derive(Default)]
struct Sections {
    meshes: Option<Vec<u32>>,
    instances: Option<Vec<InstanceRecord>>,
    free: Option<Vec<u32>>,
}

impl Sections {
    fn read(&mut self, input: &mut dyn Input, entry: &Entry) -> Result<(), SceneLoadError> {
        let again = match entry.kind {
            MESHES => self.meshes.replace(numbers(input, entry)?).is_some(),
            FREE => self.free.replace(numbers(input, entry)?).is_some(),
            INSTANCES => {
                let mut instances = room(input, entry)?;
                in_batches(input, entry, |batch| {
                    instances.try_reserve(batch.len() / INSTANCE).map_err(NoMemory::from)?;
                    instances.extend(batch.chunks_exact(INSTANCE).map(read_record));
                    Ok(())
                })?;
                self.instances.replace(instances).is_some()
            }
            _ => {
                in_batches(input, entry, |_| Ok(()))?;
                false
            }
        };
        if again { SceneLoadError::damaged("it has the same section twice") } else { Ok(()) }
    }

    /// Returns the sections if they are consistent with each other.
    fn front(self) -> Result<SceneFront, SceneLoadError> {
        let (Some(meshes), Some(instances)) = (self.meshes, self.instances) else {
            return SceneLoadError::damaged("it has no meshes or no instances");
        };
        let free = self.free.unwrap_or_default();
        if meshes.iter().any(|&scalar| scalar > 1) || instances.len() > LEAF as usize {
            return SceneLoadError::damaged("its meshes or instances are invalid");
        }
        let mut is_used: Vec<bool> = filled(meshes.len(), false)?;
        for InstanceRecord { matrix, mesh, mask } in &instances {
            let is_sound = match mesh {
                Some(mesh) => {
                    let is_used = is_used.get_mut(*mesh as usize);
                    is_used.is_some_and(|is_used| {
                        *is_used = true;
                        matrix.iter().all(|x| x.is_finite())
                    })
                }
                None => matrix.iter().all(|x| x.to_bits() == 0) && *mask == 0,
            };
            if !is_sound {
                return SceneLoadError::damaged("an instance is invalid");
            }
        }
        if is_used.contains(&false) {
            return SceneLoadError::damaged("a mesh has no instance");
        }
        // The list of free numbers must contain each number without an instance exactly once.
        let mut is_free: Vec<bool> = filled(instances.len(), false)?;
        for &number in &free {
            let known = instances.get(number as usize).is_some_and(|record| record.mesh.is_none());
            if !known || std::mem::replace(&mut is_free[number as usize], true) {
                return SceneLoadError::damaged("its free numbers are invalid");
            }
        }
        if instances.iter().filter(|record| record.mesh.is_none()).count() != free.len() {
            return SceneLoadError::damaged("its free numbers are invalid");
        }
        let meshes = meshes.into_iter().map(|scalar| scalar == 1).collect();
        Ok(SceneFront { instances, free, meshes })
    }
}

fn numbers(input: &mut dyn Input, entry: &Entry) -> Result<Vec<u32>, SceneLoadError> {
    let mut numbers = room(input, entry)?;
    in_batches(input, entry, |batch| {
        let number = |i: usize| u32_at(batch, i * NUMBER);
        Ok(threads::extend(&mut numbers, batch.len() / NUMBER, 1024, number)?)
    })?;
    Ok(numbers)
}

/// Recomputes the checksums of a saved scene if it is intact enough to locate them. The checksums
/// inside its meshes must already be correct.
pub(super) fn seal(bytes: &mut [u8]) {
    format::seal(bytes);
    if bytes.len() < HEADER {
        return;
    }
    let (mut sums, mut at) = (bytes[SUM..HEADER].to_vec(), u64_at(bytes, 40) as usize);
    for _ in 0..u64_at(bytes, 24) {
        at = at.saturating_add(gap(at as u64));
        let Some(header) = bytes.get(at..).and_then(|mesh| mesh.get(..HEADER)) else { return };
        sums.extend(&header[SUM..]);
        at = at.saturating_add(u64_at(header, 40) as usize);
    }
    at = at.saturating_add(gap(at.min(bytes.len()) as u64));
    if let Some(sum) = bytes.get_mut(at..).and_then(|end| end.get_mut(..8)) {
        sum.copy_from_slice(&checksum(&sums).to_le_bytes());
    }
}

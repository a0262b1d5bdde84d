//! Builds a mesh and performs the checks that all formats share.

use super::cut::{Cut, Cutter};
use super::error::{Fault, fault};
use super::notes::Notes;
use crate::coordinate::Coordinate;
use crate::mesh::{Mesh, double};

/// Appends an entry to a table, or returns an error if memory runs out. This is used for tables
/// whose size depends on the file.
pub(super) fn push<T>(table: &mut Vec<T>, entry: T) -> Result<(), Fault> {
    table.try_reserve(1)?;
    table.push(entry);
    Ok(())
}

/// The placeholder for the texture coordinates of a corner that has no valid ones.
pub(super) const NO_UV: u32 = u32::MAX;

/// Returns the triangles of a strip, as indices into its corners: each corner from the third on
/// forms a triangle with the two corners before it. Every other triangle is flipped, so that all
/// have the same winding. Triangles that repeat a vertex serve only to join parts of the strip and
/// are skipped.
pub(super) fn strip(corners: &[u32]) -> impl Iterator<Item = [usize; 3]> {
    let triangle = |last| [last - 2 + last % 2, last - 1 - last % 2, last];
    (2..corners.len()).map(triangle).filter(|places| {
        let [a, b, c] = places.map(|place| corners[place]);
        a != b && b != c && c != a
    })
}

/// The note about faces that are skipped because they have too few corners.
const SHORT: &str = "faces with fewer than three corners, skipped";
/// The note about faces that cannot be cut reliably.
const UNCLEAR: &str =
    "concave faces that cross themselves or have more than 16384 corners, filled as fans";
/// The note about faces that lose their texture coordinates.
const NO_UVS: &str = "faces whose texture coordinates are missing or not finite, read without them";

/// A mesh under construction.
pub(super) struct MeshBuilder<S> {
    mesh: Mesh<S>,
    /// The texture coordinates that faces refer to.
    uvs: Vec<[f32; 2]>,
    pub(super) notes: Notes,
    /// The current line, if the file is text.
    pub(super) line: Option<u64>,
    /// The number of the first vertex in this format, used in error messages.
    numbered_from: u64,
    waiting: WaitingFaces,
    unusable: Vec<UnusableVertex>,
    cutter: Cutter,
    /// The texture coordinates of the current face, kept here to avoid allocations.
    face_uvs: Vec<[f32; 2]>,
}

/// Faces that wait for a vertex or texture coordinate later in the file. Once one face is waiting,
/// all later faces wait too.
#[derive(Default)]
struct WaitingFaces {
    /// The vertices of all waiting faces.
    corners: Vec<u32>,
    /// The texture coordinates of all waiting faces.
    uvs: Vec<u32>,
    /// For each face, its line and where its entries in `corners` and `uvs` end.
    faces: Vec<(Option<u64>, usize, usize)>,
}

/// A vertex that no triangle may use.
struct UnusableVertex {
    index: u32,
    line: Option<u64>,
    /// The reason, unless it is evident from the position.
    cause: Option<String>,
}

impl<S: Coordinate> MeshBuilder<S> {
    /// Creates a builder for a file that numbers its vertices from `first`.
    pub(super) fn numbered_from(first: u64) -> Self {
        Self {
            mesh: Mesh::default(),
            uvs: vec![],
            notes: Notes::default(),
            line: None,
            numbered_from: first,
            waiting: WaitingFaces::default(),
            unusable: vec![],
            cutter: Cutter::default(),
            face_uvs: vec![],
        }
    }

    /// Returns the number of vertices.
    pub(super) fn vertices(&self) -> usize {
        self.mesh.positions.len()
    }

    /// Returns the number of texture coordinates.
    pub(super) fn uvs(&self) -> usize {
        self.uvs.len()
    }

    /// Adds the position of a vertex. If the position is not finite, no triangle may use the
    /// vertex.
    pub(super) fn position(&mut self, position: [S; 3]) -> Result<(), Fault> {
        if self.vertices() >= u32::MAX as usize {
            return fault("more than 4294967295 vertices; cut the model into parts");
        }
        if position.iter().any(|x| !x.is_finite()) {
            self.add_unusable(None)?;
        }
        push(&mut self.mesh.positions, position)
    }

    /// Adds a vertex with invalid coordinates, which is an error only if a triangle uses it.
    pub(super) fn broken_position(&mut self, cause: String) -> Result<(), Fault> {
        self.add_unusable(Some(cause))?;
        push(&mut self.mesh.positions, [S::nearest(f64::NAN); 3])
    }

    fn add_unusable(&mut self, cause: Option<String>) -> Result<(), Fault> {
        let index = self.vertices() as u32;
        push(&mut self.unusable, UnusableVertex { index, line: self.line, cause })
    }

    /// Adds a texture coordinate. If any texture coordinate of a face is not finite, the face is
    /// read without texture coordinates.
    pub(super) fn uv(&mut self, uv: [f32; 2]) -> Result<(), Fault> {
        push(&mut self.uvs, uv)
    }

    /// Adds a face with these vertices and, if `uvs` is not empty, these texture coordinates, some
    /// of which may be [`NO_UV`]. Vertices and texture coordinates may come later in the file.
    pub(super) fn polygon(&mut self, corners: &[u32], uvs: &[u32]) -> Result<(), Fault> {
        let is_there = corners.iter().all(|&corner| (corner as usize) < self.vertices())
            && uvs.iter().all(|&uv| uv == NO_UV || (uv as usize) < self.uvs());
        if self.waiting.faces.is_empty() && is_there {
            return self.add(corners, uvs);
        }
        let waiting = &mut self.waiting;
        waiting.corners.try_reserve(corners.len())?;
        waiting.corners.extend_from_slice(corners);
        waiting.uvs.try_reserve(uvs.len())?;
        waiting.uvs.extend_from_slice(uvs);
        let ends = (self.line, waiting.corners.len(), waiting.uvs.len());
        push(&mut waiting.faces, ends)
    }

    /// Adds a face, or returns an error if one of its vertices is missing.
    fn add(&mut self, corners: &[u32], uvs: &[u32]) -> Result<(), Fault> {
        let count = self.vertices();
        if let Some(&corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            let (number, from) = (u64::from(corner) + self.numbered_from, self.numbered_from);
            return fault(format!(
                "a face refers to vertex {number}, but there are {count}, numbered from {from}"
            ));
        }
        if corners.len() < 3 {
            self.notes.add(SHORT, 1, self.line);
            return Ok(());
        }
        let first = self.mesh.triangles.len();
        self.mesh.triangles.try_reserve(corners.len() - 2)?;
        let positions = &self.mesh.positions;
        let cut = if corners.len() == 3 {
            Cut::Fan
        } else {
            self.cutter.cut(corners.iter().map(|&corner| double(positions[corner as usize])))?
        };
        if matches!(cut, Cut::Unclear) {
            self.notes.add(UNCLEAR, 1, self.line);
        }
        self.mesh.triangles.extend(cut.triangles(corners));
        if self.mesh.triangles.len() > u32::MAX as usize {
            return fault("more than 4294967295 triangles; cut the model into parts");
        }

        self.face_uvs.clear();
        self.face_uvs.try_reserve(uvs.len())?;
        let found = uvs.iter().filter_map(|&uv| self.uvs.get(uv as usize));
        self.face_uvs.extend(found.filter(|uv| uv.iter().all(|x| x.is_finite())));
        if self.face_uvs.len() < uvs.len() {
            self.notes.add(NO_UVS, 1, self.line);
            self.face_uvs.clear();
        }
        // Texture coordinates are stored from the first face that has them; earlier faces get
        // zeros.
        if !self.face_uvs.is_empty() || self.mesh.corner_uvs.is_some() {
            let kept = self.mesh.corner_uvs.get_or_insert_with(Vec::new);
            kept.try_reserve(self.mesh.triangles.len() - kept.len())?;
            kept.resize(first, [[0.0; 2]; 3]);
            if !self.face_uvs.is_empty() {
                kept.extend(cut.triangles(&self.face_uvs));
            }
            kept.resize(self.mesh.triangles.len(), [[0.0; 2]; 3]);
        }
        Ok(())
    }

    /// Adds the triangles of a [`strip`].
    pub(super) fn strip(&mut self, corners: &[u32], uvs: &[u32]) -> Result<(), Fault> {
        strip(corners).try_for_each(|places| {
            let uvs = if uvs.is_empty() { &[] } else { &places.map(|i| uvs[i])[..] };
            self.polygon(&places.map(|i| corners[i]), uvs)
        })
    }

    /// Returns the mesh and the notes, once the whole file has been read.
    pub(super) fn finish(mut self) -> Result<(Mesh<S>, Notes), Fault> {
        let waiting = std::mem::take(&mut self.waiting);
        let (mut corners, mut uvs) = (0, 0);
        for &(line, corners_end, uvs_end) in &waiting.faces {
            self.line = line;
            self.add(&waiting.corners[corners..corners_end], &waiting.uvs[uvs..uvs_end])
                .map_err(|fault| Fault { line, ..fault })?;
            (corners, uvs) = (corners_end, uvs_end);
        }
        self.check_vertices()?;
        Ok((self.mesh, self.notes))
    }

    /// Rejects triangles with a vertex that is not finite.
    fn check_vertices(&mut self) -> Result<(), Fault> {
        if self.unusable.is_empty() {
            return Ok(());
        }
        let Self { mesh: Mesh { positions, triangles, .. }, unusable, .. } = self;
        let is_broken = |&&corner: &&u32| positions[corner as usize].iter().any(|x| !x.is_finite());
        let Some(&first) = triangles.as_flattened().iter().filter(is_broken).min() else {
            return Ok(());
        };
        // The entries are sorted by vertex index, because they are added in that order.
        let Ok(place) = unusable.binary_search_by_key(&first, |vertex| vertex.index) else {
            return Ok(());
        };
        let UnusableVertex { line, ref mut cause, .. } = unusable[place];
        let cause = cause.take().unwrap_or_else(|| not_finite(positions[first as usize]));
        Err(Fault { line, cause })
    }
}

/// Returns the error message for a vertex that is not finite.
pub(super) fn not_finite<S: Coordinate>([x, y, z]: [S; 3]) -> String {
    format!(
        "the vertex ({x}, {y}, {z}) is not finite in {}; repair the model or scale it down",
        S::NAME
    )
}

impl Cut<'_> {
    /// Converts one value per corner of a polygon to one triple per triangle.
    fn triangles<T: Copy>(&self, corners: &[T]) -> impl Iterator<Item = [T; 3]> {
        let ears = match self {
            Self::Ears(ears) => ears.as_chunks::<3>().0,
            _ => &[],
        };
        let fan = if ears.is_empty() { corners.len() } else { 0 };
        let fan = (2..fan).map(|i| [0, i as u32 - 1, i as u32]);
        fan.chain(ears.iter().copied()).map(|places| places.map(|place| corners[place as usize]))
    }
}

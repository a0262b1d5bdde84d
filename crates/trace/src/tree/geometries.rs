//! Several meshes in one hierarchy: the geometry of each triangle, and the masks of geometries.
//!
//! ```text
//!   overall position        0 1 2 3 4 5 6 7 8        stored in leaves; breaks ties
//!   geometry                0 0 0 1 1 2 2 2 2        a hit reports these two numbers
//!   triangle                0 1 2 0 1 0 1 2 3
//! ```

use bytemuck::{Pod, Zeroable};
use intertri::{Hit, Hit32, TriangleId};

use crate::util::memory::{NoMemory, copied, room};

/// The triangle of a hit: its index and its geometry, in 8 bytes.
///
/// ```
/// use intertri_trace::MeshTriangle;
/// assert!(MeshTriangle { triangle: 7, geometry: 2 }.is_hit() && !MeshTriangle::MISS.is_hit());
/// ```
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct MeshTriangle {
    /// The triangle's index in its mesh, as in [`Hit::triangle`], or [`Hit::NO_TRIANGLE`] for a
    /// miss.
    pub triangle: u32,
    /// The index of the mesh, as in [`Hit::geometry`].
    pub geometry: u32,
}

impl MeshTriangle {
    /// The result for a ray that hits nothing.
    pub const MISS: Self = Self { triangle: Hit::NO_TRIANGLE, geometry: 0 };

    /// Returns whether this is a hit.
    #[inline]
    pub fn is_hit(self) -> bool {
        self.triangle != Hit::NO_TRIANGLE
    }
}

/// A result that identifies a triangle by its position in all meshes until `rename` is called.
pub(crate) trait NamesTriangle {
    /// Returns the fields for the triangle's index and geometry.
    fn name_mut(&mut self) -> (&mut u32, &mut u32);
}

macro_rules! names_triangle {
    ($($record:ty),*) => {$(
        impl NamesTriangle for $record {
            #[inline(always)]
            fn name_mut(&mut self) -> (&mut u32, &mut u32) {
                (&mut self.triangle, &mut self.geometry)
            }
        }
    )*};
}

names_triangle!(Hit, Hit32, MeshTriangle);

/// The geometries of a hierarchy. A single mesh does not need tables.
#[derive(Clone, Debug)]
pub(crate) struct Geometries {
    /// The position of each geometry's first triangle; empty for a single mesh.
    firsts: Vec<u32>,
    /// The geometry of each triangle, indexed by position; empty for a single mesh.
    of: Vec<u32>,
    /// The mask of each geometry.
    masks: Vec<u32>,
    /// The bits that are set in all masks.
    common: u32,
}

impl Geometries {
    /// Returns the number of geometries.
    pub(crate) fn count(&self) -> usize {
        self.masks.len()
    }

    /// Sets the mask of one geometry.
    pub(crate) fn set_mask(&mut self, geometry: usize, mask: u32) {
        self.masks[geometry] = mask;
        // If a query's mask shares a bit with `common`, no geometry needs to be filtered out.
        self.common = self.masks.iter().fold(u32::MAX, |all, mask| all & mask);
    }

    /// Sets the masks of all geometries.
    pub(crate) fn set_masks(&mut self, masks: impl ExactSizeIterator<Item = u32>) {
        for (geometry, mask) in masks.enumerate() {
            self.masks[geometry] = mask;
        }
        self.common = self.masks.iter().fold(u32::MAX, |all, mask| all & mask);
    }

    /// Returns the number of triangles and the mask of each geometry, given the total number of
    /// triangles.
    pub(crate) fn counts_and_masks(&self, all: usize) -> impl Iterator<Item = (u32, u32)> {
        let ends = self.firsts.iter().skip(1).copied().chain([all as u32]);
        let firsts = self.firsts.iter().copied().chain(self.firsts.is_empty().then_some(0));
        let counts = firsts.zip(ends).map(|(first, end)| end - first);
        counts.zip(self.masks.iter().copied())
    }

    /// Returns whether there is only a single mesh, with all bits set in its mask.
    pub(crate) fn is_plain(&self) -> bool {
        !self.are_told() && self.masks == [u32::MAX]
    }

    /// Creates the geometries of a single mesh.
    pub(crate) fn one() -> Self {
        Self { firsts: Vec::new(), of: Vec::new(), masks: vec![u32::MAX], common: u32::MAX }
    }

    /// Creates the geometries of several meshes with the given numbers of triangles.
    pub(crate) fn of(
        counts: impl ExactSizeIterator<Item = usize> + Clone,
    ) -> Result<Self, NoMemory> {
        if counts.len() == 1 {
            return Ok(Self::one());
        }
        let (mut firsts, mut masks) = (room(counts.len())?, room(counts.len())?);
        let mut of = room(counts.clone().sum())?;
        for (geometry, count) in counts.enumerate() {
            firsts.push(of.len() as u32);
            masks.push(u32::MAX);
            of.resize(of.len() + count, geometry as u32);
        }
        Ok(Self { firsts, of, masks, common: u32::MAX })
    }

    /// Returns a copy, or an error if memory runs out.
    pub(crate) fn try_clone(&self) -> Result<Self, NoMemory> {
        let Self { firsts, of, masks, common } = self;
        let (firsts, of, masks) = (copied(firsts)?, copied(of)?, copied(masks)?);
        Ok(Self { firsts, of, masks, common: *common })
    }

    /// Returns whether hits must be renamed, which is the case if there are several meshes.
    #[inline(always)]
    fn are_told(&self) -> bool {
        !self.of.is_empty()
    }

    /// Returns the geometry of the triangle at a position, and the triangle's index within that
    /// geometry.
    #[inline(always)]
    pub(crate) fn name(&self, TriangleId(position): TriangleId) -> MeshTriangle {
        match self.of.get(position as usize) {
            Some(&geometry) => {
                MeshTriangle { triangle: position - self.firsts[geometry as usize], geometry }
            }
            None => MeshTriangle { triangle: position, geometry: 0 },
        }
    }

    /// Returns the position of a triangle among all triangles, if it exists.
    pub(crate) fn position(&self, name: MeshTriangle, all: usize) -> Option<TriangleId> {
        let MeshTriangle { triangle, geometry } = name;
        // Sum the counts of the geometries before this one; `Err` ends the loop with the result.
        let (first, _) = self
            .counts_and_masks(all)
            .try_fold((0, 0), |(first, at), (count, _)| {
                if at == geometry { Err((first, count)) } else { Ok((first + count, at + 1)) }
            })
            .err()
            .filter(|&(_, count)| triangle < count)?;
        Some(TriangleId(first + triangle))
    }

    /// Returns the mask of a triangle's geometry.
    #[inline(always)]
    pub(crate) fn mask_of(&self, TriangleId(position): TriangleId) -> u32 {
        let geometry = self.of.get(position as usize).map_or(0, |&geometry| geometry);
        self.masks[geometry as usize]
    }

    /// Returns whether every geometry is known to share a bit with a mask. The result may be
    /// `false` even if every geometry shares a bit with it.
    #[inline(always)]
    pub(crate) fn all_have(&self, mask: u32) -> bool {
        self.common & mask != 0
    }

    /// Replaces each hit's overall position with a geometry and an index within that geometry.
    #[inline(always)]
    pub(crate) fn rename<'h, H: NamesTriangle + 'h>(
        &self,
        hits: impl IntoIterator<Item = &'h mut H>,
    ) {
        if self.are_told() {
            let names = hits.into_iter().map(NamesTriangle::name_mut);
            for (triangle, geometry) in names.filter(|(name, _)| **name != Hit::NO_TRIANGLE) {
                let name = self.name(TriangleId(*triangle));
                (*triangle, *geometry) = (name.triangle, name.geometry);
            }
        }
    }
}

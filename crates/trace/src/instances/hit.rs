//! The numbers of instances, and hits with them.

use intertri::Hit;

/// The number of an instance in its scene. The number of a removed instance is reused for one added later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId(pub(super) u32);

impl InstanceId {
    /// The number as an index into your own tables; numbers start at 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The instance with a given number.
    #[inline]
    pub fn from_index(index: u32) -> Self {
        Self(index)
    }
}

/// Where a ray meets an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// The hit; its triangle and geometry refer to the mesh.
    pub hit: Hit,
    /// The instance; arbitrary if the hit is a miss.
    pub instance: InstanceId,
    /// Whether the ray runs with the normal of the triangle in world space, and so leaves a closed mesh. A
    /// matrix that mirrors a mesh flips its triangles.
    pub leaves: bool,
}

impl SceneHit {
    /// The answer for a ray that hits nothing, in a batch.
    pub const MISS: Self = Self { hit: Hit::MISS, instance: InstanceId(u32::MAX), leaves: false };

    /// Whether there is a hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.hit.is_hit()
    }
}

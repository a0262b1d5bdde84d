//! Instances by number, and hits of them.

use intertri::Hit;

/// The number of an instance in its scene. A removed instance's number goes to one that is added later.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId(pub(super) u32);

impl InstanceId {
    /// The number: from 0 up, so that it fits as an index into tables of yours.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The instance of a number.
    #[inline]
    pub fn from_index(index: u32) -> Self {
        Self(index)
    }
}

/// Where a ray meets an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// The hit; its triangle and geometry are those of the mesh.
    pub hit: Hit,
    /// The instance. If the hit is a miss, any.
    pub instance: InstanceId,
    /// Whether the ray runs with the normal of the triangle in the world, and so leaves a closed mesh. A matrix that
    /// mirrors a mesh turns its triangles.
    pub leaves: bool,
}

impl SceneHit {
    /// The answer of a ray that hits nothing, in a batch.
    pub const MISS: Self = Self { hit: Hit::MISS, instance: InstanceId(u32::MAX), leaves: false };

    /// Whether there is a hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.hit.is_hit()
    }
}

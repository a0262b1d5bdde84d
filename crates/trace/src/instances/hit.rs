//! The numbers of instances, and hits with them.

use intertri::Hit;

use crate::nearest::ClosestPoint;

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
    /// Whether the ray runs in the direction of the triangle's normal in world space, and so leaves a closed
    /// mesh. A matrix that mirrors a mesh flips its triangles.
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

/// The point of a scene that is closest to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneClosestPoint {
    /// The point; its triangle and geometry are those of the mesh.
    pub closest: ClosestPoint,
    /// The instance; arbitrary for [`SceneClosestPoint::NONE`].
    pub instance: InstanceId,
}

impl SceneClosestPoint {
    /// The result for a point without an answer, in a batch.
    pub const NONE: Self = Self { closest: ClosestPoint::NONE, instance: InstanceId(u32::MAX) };

    /// Itself, or `None` for [`SceneClosestPoint::NONE`].
    pub fn some(self) -> Option<Self> {
        self.closest.some().map(|_| self)
    }
}

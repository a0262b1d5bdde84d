//! Instance numbers and hits on instances.

use intertri::Hit;

use crate::nearest::ClosestPoint;

/// The number of an instance in its scene. After an instance is removed, its number may be reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId(pub(super) u32);

impl InstanceId {
    /// Returns the number, for use as an index into your own tables. Numbers start at 0.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns the ID of the instance with the given number.
    #[inline]
    pub fn from_index(index: u32) -> Self {
        Self(index)
    }
}

/// A hit on an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// The hit. Its triangle and geometry refer to the instance's mesh.
    pub hit: Hit,
    /// The instance that was hit; arbitrary for a miss.
    pub instance: InstanceId,
    /// Whether the ray points in the direction of the triangle's world-space normal, and thus
    /// leaves a closed mesh at this hit. A mirroring matrix reverses the orientation of the
    /// triangles.
    pub leaves: bool,
}

impl SceneHit {
    /// The batch result of a ray that hits nothing.
    pub const MISS: Self = Self { hit: Hit::MISS, instance: InstanceId(u32::MAX), leaves: false };

    /// Returns whether this is a hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.hit.is_hit()
    }
}

/// The point on a scene's instances that is closest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneClosestPoint {
    /// The point. Its triangle and geometry refer to the instance's mesh.
    pub closest: ClosestPoint,
    /// The instance to which the triangle belongs; arbitrary for [`SceneClosestPoint::NONE`].
    pub instance: InstanceId,
}

impl SceneClosestPoint {
    /// The batch result of a point that has no closest point.
    pub const NONE: Self = Self { closest: ClosestPoint::NONE, instance: InstanceId(u32::MAX) };

    /// Returns `self`, or `None` for [`SceneClosestPoint::NONE`].
    pub fn some(self) -> Option<Self> {
        self.closest.some().map(|_| self)
    }
}

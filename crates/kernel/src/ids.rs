//! Defines the ids of rays and triangles, and of the slots in which triangles are stored.

/// The id of a ray among the rays that are traced together.
///
/// ```
/// use intertri::RayId;
/// assert!(RayId(3) < RayId(4));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct RayId(pub u32);

/// The index of a triangle in the caller's order. If two hits have the same t, the lower index
/// wins.
///
/// ```
/// use intertri::TriangleId;
/// assert!(TriangleId(7) != TriangleId::NONE);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct TriangleId(pub u32);

impl TriangleId {
    /// The id that stands for no triangle.
    ///
    /// ```
    /// assert_eq!(intertri::TriangleId::NONE.0, intertri::Hit::NO_TRIANGLE);
    /// ```
    pub const NONE: Self = Self(u32::MAX);
}

/// The position at which the caller of a query stores a triangle, such as a lane of a leaf. Queries
/// pass the slot back to the caller, who looks up the triangle.
///
/// ```
/// use intertri::LeafSlot;
/// // Lane 5 of the third leaf, with eight lanes per leaf.
/// let slot = LeafSlot(8 * 2 + 5);
/// assert_eq!((slot.0 / 8, slot.0 % 8), (2, 5));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(transparent)]
pub struct LeafSlot(pub u32);

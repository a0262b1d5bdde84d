//! The result of testing whether a point lies inside a mesh.

/// Whether a point lies inside, outside, or on the surface of a mesh, as returned by
/// [`Solid::classify`](crate::Solid::classify).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Containment {
    /// The mesh does not wind around the point.
    #[default]
    Outside,
    /// The mesh winds around the point this many times. The count is 1 for a plain solid whose
    /// corners run counter-clockwise as seen from outside, higher where parts overlap, and negative
    /// where parts are inside out.
    Inside(i32),
    /// The point lies on a triangle.
    Surface,
}

impl Containment {
    /// Returns whether the mesh winds around the point an odd number of times. The result is also
    /// true on the surface. For a solid from [`Solid::assume_closed`](crate::Solid::assume_closed),
    /// the result is the parity: whether a ray from the point crosses an odd number of triangles,
    /// whatever their winding.
    ///
    /// ```
    /// use intertri_trace::{Solid, intertri::Triangle};
    /// let [o, x, y, z] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    /// // Two of the faces are flipped, so the winding number is 1 in some directions and 0 or -1 in others.
    /// let faces = [[o, x, y], [o, z, x], [o, z, y], [x, y, z]].map(|[a, b, c]| Triangle::new(a, b, c));
    /// let solid = Solid::assume_closed(&faces)?;
    /// let points = [[1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [-1.0, -0.5, -1.0]];
    /// assert_eq!(points.map(|point| solid.classify(point).is_odd()), [true, false, false]);
    /// # Ok::<(), intertri_trace::BuildError>(())
    /// ```
    pub fn is_odd(self) -> bool {
        match self {
            Self::Outside => false,
            Self::Inside(times) => times % 2 != 0,
            Self::Surface => true,
        }
    }

    /// Returns the result after the ray from the point crosses the mesh once more.
    pub(crate) fn crossed(self, leaves: bool) -> Self {
        self.wound(if leaves { 1 } else { -1 })
    }

    /// Returns the result after several crossings. `leave` is the number of crossings that leave
    /// the mesh minus the number that enter it.
    pub(crate) fn wound(self, leave: i32) -> Self {
        let times = match self {
            Self::Outside => 0,
            Self::Inside(times) => times,
            // On the surface, crossings do not change the result.
            Self::Surface => return self,
        };
        match times + leave {
            0 => Self::Outside,
            times => Self::Inside(times),
        }
    }
}

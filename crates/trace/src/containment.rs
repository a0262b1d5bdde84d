//! Whether a point lies inside, outside or on the surface.

/// Whether a point lies inside, outside or on the surface, as [`Solid::classify`](crate::Solid::classify) returns it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Containment {
    /// The mesh does not wind around it.
    #[default]
    Outside,
    /// The mesh winds around it, this many times: once, if its corners run counter-clockwise as seen from outside;
    /// more where parts overlap, less than 0 where they are inside out.
    Inside(i32),
    /// It lies on a triangle.
    Surface,
}

impl Containment {
    /// After one more crossing of a ray from the point.
    pub(crate) fn crossed(self, leaves: bool) -> Self {
        self.wound(if leaves { 1 } else { -1 })
    }

    /// After several crossings: `leave` is how many more of them leave the mesh than enter it.
    pub(crate) fn wound(self, leave: i32) -> Self {
        let times = match self {
            Self::Outside => 0,
            Self::Inside(times) => times,
            // A point on the surface stays there, whatever is crossed farther on.
            Self::Surface => return self,
        };
        match times + leave {
            0 => Self::Outside,
            times => Self::Inside(times),
        }
    }
}

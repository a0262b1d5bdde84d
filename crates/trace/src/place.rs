//! Where a point lies.

/// Where a point lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// The mesh does not wind around it.
    #[default]
    Outside,
    /// The mesh winds around it so often: once, counter-clockwise as seen from outside, where its corners run
    /// so; more where parts overlap, below 0 where they are turned inside out.
    Inside(i32),
    /// It lies on a triangle.
    Surface,
}

impl Place {
    /// After one more crossing of a ray from there.
    pub(crate) fn crossed(self, leaves: bool) -> Self {
        self.wound(if leaves { 1 } else { -1 })
    }

    /// After more crossings, so many more of which leave than enter.
    pub(crate) fn wound(self, leave: i32) -> Self {
        let times = match self {
            Self::Outside => 0,
            Self::Inside(times) => times,
            Self::Surface => return self,
        };
        match times + leave {
            0 => Self::Outside,
            times => Self::Inside(times),
        }
    }
}

//! Who settles what the bound leaves open of a bundle.

use crate::resolve::{Resolver, SharedOrigin};
use crate::{Ray, Triangle};

/// What is asked about the rays and triangles of a bundle, both known by the caller's numbers.
///
/// ```
/// use intertri::internal::{Resolver, Settle};
/// use intertri::{Ray, Triangle};
/// let triangles = [3.0, 5.0].map(|z| Triangle::new([0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]));
/// let rays = [Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0])];
/// let (find, index) = (|number| triangles[number as usize], |number| number);
/// let settle =
///     Settle { resolver: Resolver::Document(0.0), rays: &rays, first: 0, find, index, reversed: false };
/// assert_eq!((settle.hit(0, 0), settle.hit(1, 0)), (Some(3.0), Some(5.0)));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Settle<'a, T, I> {
    /// What answers.
    pub resolver: Resolver<'a>,
    /// The rays by number.
    pub rays: &'a [Ray],
    /// The number of the first for who knows them by others.
    pub first: u32,
    /// A triangle by its number.
    pub find: T,
    /// The triangle's index.
    pub index: I,
    /// Whether the bundle holds the rays in reverse, from their common end: then it is known only whether
    /// they hit, and every t is 0.
    pub reversed: bool,
}

impl<'a, T: Fn(u32) -> Triangle, I: Fn(u32) -> u32> Settle<'a, T, I> {
    #[inline(always)]
    fn number(&self, ray: usize) -> u32 {
        self.first + ray as u32
    }

    /// t of a ray, if it hits the triangle within its interval.
    #[inline(always)]
    pub fn hit(&self, triangle: u32, ray: usize) -> Option<f64> {
        let numbers = (self.number(ray), triangle);
        let t = self.resolver.hit(&self.rays[ray], &(self.find)(triangle), numbers);
        if self.reversed { t.map(|_| 0.0) } else { t }
    }

    /// Whether two triangles touch where a ray meets them, if it hits both.
    #[inline(always)]
    pub(super) fn touch(&self, ray: usize, one: u32, other: u32) -> bool {
        let pair = || (self.rays[ray], [(self.find)(one), (self.find)(other)]);
        self.resolver.touch(pair, (self.number(ray), one, other))
    }

    /// Whether a ray hits one triangle before another, both of which it is known to hit. What was seen of
    /// both is kept for other rays.
    #[inline(always)]
    pub(super) fn is_before(
        &self,
        ray: usize,
        one: u32,
        other: u32,
        [kept_one, kept_other]: &mut [Kept<'a>; 2],
    ) -> bool {
        if self.reversed {
            return false;
        }
        let (number, ray) = (self.number(ray), &self.rays[ray]);
        let (one_seen, other_seen) = (self.seen(one, kept_one), self.seen(other, kept_other));
        let order = one_seen.order(other_seen, ray, number);
        order.then((self.index)(one).cmp(&(self.index)(other))).is_lt()
    }

    /// A triangle from where the rays start.
    #[inline(always)]
    fn seen<'k>(&self, triangle: u32, kept: &'k mut Kept<'a>) -> &'k SharedOrigin<'a> {
        if kept.is_none_or(|(number, _)| number != triangle) {
            *kept = None;
        }
        let (_, seen) = kept.get_or_insert_with(|| {
            let (origin, numbers) = (self.rays[0].origin, (self.first, triangle));
            (triangle, self.resolver.shared_origin(&(self.find)(triangle), origin, numbers))
        });
        seen
    }
}

/// The triangle that was seen last.
pub(super) type Kept<'a> = Option<(u32, SharedOrigin<'a>)>;

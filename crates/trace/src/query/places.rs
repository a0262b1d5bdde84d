//! Where points lie: inside a mesh, outside, or on it.

use intertri::internal::exact::is_on;
use intertri::internal::prefetch;
use intertri::{Counts, Exact, RayOf};

use super::{batch, one};
use crate::answers::Answers;
use crate::beam::order;
use crate::bvh::Bvh;
use crate::given::{Given, ModeFor};
use crate::memory::{NoMemory, filled};
use crate::place::Place;
use crate::select::Select;
use crate::single::is_held;

/// The way in which winding numbers are counted: any is as good as another. Of the common ones it is none, so
/// that few edges are met exactly.
const DIR: [f32; 3] = [0.537_21, 0.351_37, 0.766_91];

/// Points that are put in order at a time, and rays of them that are made at a time.
const SLAB: usize = 1 << 21;
const PIECE: usize = 1 << 12;

/// So many points are prefetched before they are copied.
const AHEAD: usize = 16;

impl<S: Given> Bvh<S>
where
    Exact: ModeFor<S>,
{
    /// Where a point lies.
    pub(crate) fn place(&self, mode: Exact, point: [S; 3]) -> Place {
        let seen = S::point(&self.originals, point);
        if is_held(&self.tree, seen, |place| is_on(&self.triangle(place), point)) {
            return Place::Surface;
        }
        self.ask_one(&mode, &RayOf::new(point, DIR.map(S::from)), |tree, which, ray| {
            one::winding(tree, which, ray)
        })
    }

    /// Where points lie, told by a function of that.
    pub(crate) fn places<A: Copy + Send>(
        &self,
        mode: Exact,
        points: &[[S; 3]],
        answers: &mut [A],
        answer: impl Fn(Place) -> A + Sync,
    ) {
        assert_eq!(points.len(), answers.len(), "one answer a point");
        for (points, answers) in points.chunks(SLAB).zip(answers.chunks_mut(SLAB)) {
            self.slab(mode, points, answers, &answer);
        }
    }

    /// The same of some, by halves where there is too little memory for all.
    fn slab<A: Copy + Send>(
        &self,
        mode: Exact,
        points: &[[S; 3]],
        answers: &mut [A],
        answer: &(impl Fn(Place) -> A + Sync),
    ) {
        let is_done = self.try_slab(mode, points, answers, answer).is_ok();
        if is_done {
            return;
        }
        if let ([point], [to]) = (points, &mut *answers) {
            *to = answer(self.place(mode, *point));
            return;
        }
        let half = points.len() / 2;
        let (answers, others) = answers.split_at_mut(half);
        self.slab(mode, &points[..half], answers, answer);
        self.slab(mode, &points[half..], others, answer);
    }

    fn try_slab<A: Copy + Send>(
        &self,
        mode: Exact,
        points: &[[S; 3]],
        answers: &mut [A],
        answer: &(impl Fn(Place) -> A + Sync),
    ) -> Result<(), NoMemory> {
        let order = order(points, DIR.map(f64::from))?;
        let mut in_order = filled(points.len(), answer(Place::Outside))?;
        batch::chunks(&order, &mut in_order, |order, answers| {
            let (mut rays, mut places) = (Vec::new(), Vec::new());
            let mut counts = Counts::default();
            for (order, answers) in order.chunks(PIECE).zip(answers.chunks_mut(PIECE)) {
                gather(points, order, &mut rays);
                places.clear();
                places.resize(rays.len(), Place::Outside);
                let asked = Answers::Places(&mut places);
                counts += self.only(&Select::ALL).on_this_thread(&mode, &rays, asked);
                for (answer_of, &place) in answers.iter_mut().zip(&places) {
                    *answer_of = answer(place);
                }
            }
            counts
        });
        for (&i, &answer) in order.iter().zip(&in_order) {
            answers[i as usize] = answer;
        }
        Ok(())
    }
}

/// Rays from points of these numbers.
fn gather<S: Given>(points: &[[S; 3]], numbers: &[u32], rays: &mut Vec<RayOf<S>>) {
    rays.clear();
    let ray = |(i, &number): (usize, &u32)| {
        if let Some(&later) = numbers.get(i + AHEAD) {
            prefetch(&points[later as usize..][..1]);
        }
        RayOf::new(points[number as usize], DIR.map(S::from))
    };
    rays.extend(numbers.iter().enumerate().map(ray));
}

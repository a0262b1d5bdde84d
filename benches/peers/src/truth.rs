//! Holds the true answers, and tests whether other answers are equally correct.

use intertri::{Mode, RayOf, SliceScalar, TriangleOf};

use crate::engine::Answer;

/// The true answers for an engine.
pub struct Truth<'a> {
    answers: &'a [Answer],
    /// Whether a ray hits both triangles at the same exact t.
    tied: Box<dyn Fn(usize, [u32; 2]) -> bool + 'a>,
}

impl<'a> Truth<'a> {
    /// Creates the truth for an engine. If two triangles are hit at the same exact t, either is
    /// correct. Only our engines must return the triangle with the lower index, because they
    /// guarantee that.
    pub fn new<S: SliceScalar>(
        engine: &str,
        answers: &'a [Answer],
        triangles: &'a [TriangleOf<S>],
        rays: &'a [RayOf<S>],
    ) -> Self {
        if ["certified", "exact", "f64"].iter().any(|ours| engine.starts_with(ours)) {
            return Self::without_ties(answers);
        }
        Self { answers, tied: Box::new(|ray, pair| tied(triangles, &rays[ray], pair)) }
    }

    /// Creates a truth that accepts only the given answers, even if a ray hits two triangles at the
    /// same t.
    pub fn without_ties(answers: &'a [Answer]) -> Self {
        Self { answers, tied: Box::new(|_, _| false) }
    }

    /// Counts the rays with a hit reported as a miss or vice versa, and those with a hit on a wrong
    /// triangle. If every bit is guaranteed, another t counts as a wrong triangle.
    pub fn wrong(&self, answers: &[Answer], every_bit: bool) -> [usize; 2] {
        assert_eq!(answers.len(), self.answers.len(), "the number of answers must match");
        let (mut hits, mut triangles) = (0, 0);
        for (ray, (answer, truth)) in answers.iter().zip(self.answers).enumerate() {
            let pair = [answer.triangle, truth.triangle];
            if answer.is_hit() != truth.is_hit() {
                hits += 1;
            } else if pair[0] != pair[1] && !(self.tied)(ray, pair)
                || every_bit && answer.t != truth.t
            {
                triangles += 1;
            }
        }
        [hits, triangles]
    }
}

/// Returns whether a ray hits both triangles at the same exact t.
fn tied<S: SliceScalar>(triangles: &[TriangleOf<S>], ray: &RayOf<S>, [a, b]: [u32; 2]) -> bool {
    let [Some(&a), Some(&b)] = [a, b].map(|index| triangles.get(index as usize)) else {
        return false;
    };
    // If two triangles are hit at the same t, the query returns the first. There is therefore a tie
    // if each triangle is returned when it comes first.
    let is_first_closest = |pair: [TriangleOf<S>; 2]| {
        Mode::exact().closest(&pair, ray).is_some_and(|hit| hit.triangle == 0)
    };
    is_first_closest([a, b]) && is_first_closest([b, a])
}

#[cfg(test)]
mod tests {
    use intertri::{Ray, Ray64, Triangle, Triangle64};

    use super::*;

    /// Returns a ray along the z axis.
    fn ray() -> Ray {
        Ray::new([0.0; 3], [0.0, 0.0, 1.0])
    }

    /// Returns a triangle around the z axis, at a given height.
    fn around(z: f32) -> Triangle {
        TriangleOf([[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]])
    }

    /// Returns the counts of wrong answers if the truth is triangle 0 at t = 1 and an engine
    /// returns `answer`.
    fn wrong(engine: &str, triangles: &[Triangle], answer: Answer) -> [usize; 2] {
        let truth = [Answer { triangle: 0, t: 1.0 }];
        Truth::new(engine, &truth, triangles, &[ray()]).wrong(&[answer], false)
    }

    #[test]
    fn another_triangle_at_the_same_t_is_right_and_one_ulp_further_is_wrong() {
        // The triangles overlap, so the ray hits the interior of both.
        let larger = |z: f32| TriangleOf([[-2.0, -2.0, z], [2.0, -2.0, z], [0.0, 2.0, z]]);
        let answer = Answer { triangle: 1, t: 1.0 };
        assert_eq!(wrong("embree", &[around(1.0), larger(1.0)], answer), [0, 0]);
        let further = larger(1.0_f32.next_up());
        assert_eq!(wrong("embree", &[around(1.0), further], answer), [0, 1]);
    }

    #[test]
    fn the_claimed_t_of_a_tie_does_not_matter() {
        let triangles = [around(1.0), around(1.0)];
        assert_eq!(wrong("embree", &triangles, Answer { triangle: 1, t: f64::NAN }), [0, 0]);
        let further = [around(1.0), around(2.0)];
        assert_eq!(wrong("embree", &further, Answer { triangle: 1, t: 1.0 }), [0, 1]);
    }

    #[test]
    fn t_that_are_equal_only_when_rounded_to_f64_are_no_tie() {
        // The ray hits this triangle at a t that is 1 / (2^40 + 1) of an f32 ulp above 1.
        let far = (1_u64 << 40) as f32;
        let slanted =
            TriangleOf([[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [far, 0.0, 1.0_f32.next_up()]]);
        assert_eq!(Mode::exact().closest(&[slanted], &ray()).map(|hit| hit.t), Some(1.0));
        let answer = Answer { triangle: 1, t: 1.0 };
        assert_eq!(wrong("embree", &[around(1.0), slanted], answer), [0, 1]);
    }

    #[test]
    fn a_triangle_that_is_not_hit_or_does_not_exist_is_wrong() {
        let beside = TriangleOf(around(1.0).0.map(|[x, y, z]| [x + 5.0, y, z]));
        let triangles = [around(1.0), beside];
        for triangle in [1, 2, u32::MAX - 1] {
            assert_eq!(wrong("embree", &triangles, Answer { triangle, t: 1.0 }), [0, 1]);
        }
    }

    #[test]
    fn our_engines_must_name_the_lower_index() {
        let triangles = [around(1.0), around(1.0)];
        for engine in ["exact", "exact-query", "certified", "f64-moved"] {
            assert_eq!(wrong(engine, &triangles, Answer { triangle: 1, t: 1.0 }), [0, 1]);
            assert_eq!(wrong(engine, &triangles, Answer { triangle: 0, t: 1.0 }), [0, 0]);
        }
    }

    #[test]
    fn ties_in_f64_are_found_where_f32_could_not_tell() {
        let (near, far) = (4.5e6, 4.5e6_f64.next_up());
        let at = |z: f64| TriangleOf([[-1.0, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]]);
        let triangles: [Triangle64; 3] = [at(near), at(near), at(far)];
        let rays = [Ray64::new([0.0; 3], [0.0, 0.0, 1.0])];
        let truth = [Answer { triangle: 0, t: near }];
        let truth = Truth::new("parry-f64", &truth, &triangles, &rays);
        assert_eq!(truth.wrong(&[Answer { triangle: 1, t: near }], false), [0, 0]);
        assert_eq!(truth.wrong(&[Answer { triangle: 2, t: near }], false), [0, 1]);
    }

    #[test]
    fn a_miss_is_wrong_where_there_is_a_hit_and_a_hit_where_there_is_none() {
        let triangles = [around(1.0), around(1.0)];
        let hit = Answer { triangle: 0, t: 1.0 };
        let truth = [hit, Answer::MISS, hit, Answer::MISS];
        let rays = [ray(), Ray::new([0.0; 3], [0.0, 0.0, -1.0]), ray(), ray()];
        let truth = Truth::new("embree", &truth, &triangles, &rays);
        let all_missed = [Answer::MISS; 4];
        assert_eq!(truth.wrong(&all_missed, false), [2, 0]);
        let all_hit = [hit; 4];
        assert_eq!(truth.wrong(&all_hit, false), [2, 0]);
    }

    #[test]
    fn every_bit_of_t_counts_where_it_is_promised() {
        let truth = [Answer { triangle: 0, t: 1.0 }];
        let truth = Truth::without_ties(&truth);
        let off = [Answer { triangle: 0, t: 1.0_f64.next_up() }];
        assert_eq!(truth.wrong(&off, true), [0, 1]);
        assert_eq!(truth.wrong(&off, false), [0, 0]);
    }

    #[test]
    #[should_panic(expected = "the number of answers must match")]
    fn too_few_answers_are_not_taken_as_right() {
        Truth::without_ties(&[Answer::MISS; 2]).wrong(&[Answer::MISS], false);
    }
}

//! Compares the media that queries find along rays with media computed in rational arithmetic. The
//! solids are convex, have integer coordinates, and may be nested, touch or overlap. Rays go toward
//! corners and edges or run along walls. Some rays start at a corner, on an edge or on a wall.

mod convex;

use intertri::{RayOf, Scalar, TriangleOf};
use intertri_lab::rng::Rng;
use intertri_trace::internal::WINDING_DIR;
use intertri_trace::{BvhScalar, Media, MediaError, Segment, SolidError};

use convex::{Convex, Point, Rational};

/// Solids of one or two parts, and the media inside them. Where solids overlap, the later one wins.
struct Scene {
    solids: Vec<(u32, Vec<Convex>)>,
}

impl Scene {
    fn new(rng: &mut Rng) -> Self {
        let solid = |rng: &mut Rng| {
            let parts = if rng.one_in(4) { 2 } else { 1 };
            (10 + rng.below(3) as u32, (0..parts).map(|_| Convex::any(rng)).collect())
        };
        Self { solids: (0..=rng.below(6)).map(|_| solid(rng)).collect() }
    }

    /// Returns the scene as [`Media`] over either scalar type, moved by an offset.
    fn media<S: BvhScalar>(&self, offset: Point) -> Media<S> {
        let triangle = |corners: [Point; 3], is_turned: bool| {
            let [a, b, c] = corners.map(|corner| number(corner, offset));
            TriangleOf(if is_turned { [a, c, b] } else { [a, b, c] })
        };
        let meshes: Vec<(u32, Vec<TriangleOf<S>>)> = self
            .solids
            .iter()
            .map(|(medium, parts)| {
                let each = parts
                    .iter()
                    .flat_map(|part| part.triangles.iter().map(|t| triangle(*t, part.is_turned)));
                (*medium, each.collect())
            })
            .collect();
        let meshes: Vec<_> = meshes.iter().map(|(medium, mesh)| (*medium, &mesh[..])).collect();
        Media::new(&meshes).unwrap()
    }

    /// Returns the medium at a point, given the parts that wind around the point.
    fn medium(&self, winds: impl Fn(&Convex) -> bool) -> Option<u32> {
        let times = |part: &Convex| match (winds(part), part.is_turned) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => -1,
        };
        let deciding = |(_, parts): &&(u32, Vec<Convex>)| parts.iter().map(times).sum::<i32>() != 0;
        self.solids.iter().rev().find(deciding).map(|(medium, _)| *medium)
    }

    /// Returns the segments of a ray between two values of t, each with its start, end and medium.
    fn segments(
        &self,
        origin: Point,
        dir: Point,
        [start, end]: [Rational; 2],
    ) -> Vec<(f64, f64, Option<u32>)> {
        let parts = self.solids.iter().flat_map(|(_, parts)| parts);
        let mut ends: Vec<Rational> = parts
            .filter_map(|part| part.inside(origin, dir))
            .flatten()
            .chain([start, end])
            .collect();
        ends.retain(|t| t.cmp(start).is_ge() && t.cmp(end).is_le());
        ends.sort_by(|a, b| a.cmp(*b));
        let mut segments: Vec<(f64, f64, Option<u32>)> = Vec::new();
        for pair in ends.windows(2).filter(|pair| pair[0].cmp(pair[1]).is_lt()) {
            let is_inside = |part: &Convex| {
                part.inside(origin, dir)
                    .is_some_and(|[from, to]| from.cmp(pair[0]).is_le() && to.cmp(pair[1]).is_ge())
            };
            let (medium, [from, to]) =
                (self.medium(is_inside), [pair[0], pair[1]].map(Rational::to_f64));
            match segments.last_mut() {
                Some((_, end, last)) if *last == medium => *end = to,
                _ => segments.push((from, to, medium)),
            }
        }
        segments
    }
}

fn number<S: Scalar>(point: Point, offset: Point) -> [S; 3] {
    [0, 1, 2].map(|k| S::nearest((point[k] + offset[k]) as f64))
}

/// Checks all queries of media for several rays. Returns the numbers of crossings, of rays that
/// start inside a solid, and of crossings between two media.
fn check<S: BvhScalar>(
    scene: &Scene,
    offset: Point,
    rays: &[(Point, Point, [i128; 2])],
) -> [usize; 3] {
    let media = scene.media::<S>(offset);
    let all: Vec<RayOf<S>> = rays
        .iter()
        .map(|(origin, dir, [start, end])| {
            let ray = RayOf::new(number::<S>(*origin, offset), number::<S>(*dir, [0; 3]));
            // The ends are in units of one half.
            let end = if *end == 0 { f64::INFINITY } else { 0.5 * *end as f64 };
            ray.between(S::nearest(0.5 * *start as f64), S::nearest(end))
        })
        .collect();
    let (lists, next) =
        (media.segments_batch(&all).unwrap(), media.next_crossing_batch(&all).unwrap());
    let mut seen = [0; 3];
    for (i, (ray, &(origin, dir, [start, end]))) in all.iter().zip(rays).enumerate() {
        let far = if end == 0 { Rational(1 << 40, 1) } else { Rational(end, 2) };
        let mut want = scene.segments(origin, dir, [Rational(start, 2), far]);
        if let (0, Some(last)) = (end, want.last_mut()) {
            last.1 = f64::INFINITY;
        }
        let at = || format!("{ray:?}\n{:?}", scene.solids);
        let segments = media.segments(ray);
        let found: Vec<_> = segments.iter().map(|s| (s.start, s.end, s.medium)).collect();
        assert_eq!(found, want, "{}", at());
        assert_eq!(lists.of(i), segments, "{}", at());
        check_walls(&media, ray, &segments);

        let crossing = media.next_crossing(ray);
        assert_eq!(next[i], crossing, "{}", at());
        let crossing = crossing.map(|c| (c.hit.t, c.left, c.entered));
        let ends = segments.first().zip(segments.get(1));
        assert_eq!(crossing, ends.map(|(a, b)| (a.end, a.medium, b.medium)), "{}", at());
        seen[0] += segments.len().saturating_sub(1);
        seen[1] += usize::from(segments.first().is_some_and(|s| s.medium.is_some()));
        seen[2] +=
            segments.windows(2).filter(|s| s[0].medium.is_some() && s[1].medium.is_some()).count();
    }
    seen
}

/// Checks that each segment ends on a wall of a mesh filled with one of the two adjacent media.
fn check_walls<S: BvhScalar>(media: &Media<S>, ray: &RayOf<S>, segments: &[Segment]) {
    let hits = media.bvh().crossings(&RayOf { t_max: S::INFINITY, ..*ray });
    for pair in segments.windows(2) {
        let wall = pair[0].wall;
        assert!(
            hits.iter().any(|crossing| crossing.hit == wall) && wall.t == pair[0].end,
            "{ray:?}"
        );
        let filled = Some(media.media()[wall.geometry as usize]);
        assert!(filled == pair[0].medium || filled == pair[1].medium, "{ray:?}: {pair:?}");
    }
    assert!(segments.last().is_none_or(|segment| !segment.wall.is_hit()), "{ray:?}");
}

#[test]
fn media_along_rays_are_exact() {
    let mut rng = Rng::new(57);
    let mut seen = [0; 3];
    for _ in 0..400 {
        let scene = Scene::new(&mut rng);
        let mut at = || [0; 3].map(|_| rng.below(13) as i128 - 1);
        // The rays go from one point of a small grid to another, so most of them run along walls,
        // or meet edges and corners.
        let ends: Vec<[Point; 2]> = (0..60).map(|_| [at(), at()]).filter(|[a, b]| a != b).collect();
        let mut ray = |&[a, b]: &[Point; 2]| {
            let part =
                if rng.one_in(2) { [0, 0] } else { [rng.below(4) as i128, rng.below(6) as i128] };
            (a, [0, 1, 2].map(|k| b[k] - a[k]), part)
        };
        let rays: Vec<_> = ends.iter().map(&mut ray).collect();
        for found in [
            check::<f32>(&scene, [0; 3], &rays),
            check::<f32>(&scene, [1 << 20, -(1 << 19), 77], &rays),
            check::<f64>(&scene, [500_000, 4_600_000, 120], &rays),
        ] {
            (0..3).for_each(|k| seen[k] += found[k]);
        }
    }
    // There must be enough crossings, enough starts inside solids, and enough crossings between
    // solids that touch or overlap.
    assert!(seen[0] > 40_000 && seen[1] > 5000 && seen[2] > 2500, "{seen:?}");
}

#[test]
fn each_point_has_one_medium() {
    // The direction that decides ties for points on walls, as integers: each component times
    // `2^26`.
    let dir = WINDING_DIR.map(|x| (f64::from(x) * f64::from(1 << 26)) as i128);
    let mut rng = Rng::new(91);
    let mut inside = 0;
    for _ in 0..60 {
        let scene = Scene::new(&mut rng);
        let points: Vec<Point> =
            (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|x| x as i128)).collect();
        for offset in [[0; 3], [500_000, 4_600_000, 120]] {
            let media = scene.media::<f64>(offset);
            let all: Vec<[f64; 3]> = points.iter().map(|point| number(*point, offset)).collect();
            let batch = media.medium_at_batch(&all).unwrap();
            for ((point, number), found) in points.iter().zip(&all).zip(batch) {
                let want = scene.medium(|part| part.holds(*point, dir));
                assert_eq!(
                    (found, media.medium_at(*number)),
                    (want, want),
                    "{point:?}\n{:?}",
                    scene.solids
                );
                inside += usize::from(want.is_some());
            }
        }
    }
    assert!(inside > 10_000, "{inside}");
    let media = Scene::new(&mut rng).media::<f32>([0; 3]);
    assert_eq!(media.medium_at([f32::NAN, 1.0, 1.0]), None);
    assert_eq!(Media::<f32>::new(&[]).unwrap().medium_at([1.0; 3]), None);
}

/// An error must name the open mesh. A ray without a valid direction must yield a single segment
/// outside all media, and a ray with an invalid interval must yield no segments.
#[test]
fn bad_input_is_refused_or_outside() {
    let mut rng = Rng::new(3);
    let closed: Vec<TriangleOf<f32>> = Convex::any(&mut rng)
        .triangles
        .iter()
        .map(|corners| TriangleOf(corners.map(|corner| number(corner, [0; 3]))))
        .collect();
    let error = Media::new(&[(1, &closed[..]), (2, &closed[1..])]).unwrap_err();
    assert!(matches!(error, MediaError::Mesh { mesh: 1, error: SolidError::Open(_) }), "{error:?}");
    assert!(
        error.to_string().starts_with("mesh 1 is not a solid: the mesh is not closed: 3 edges")
    );

    let media = Media::new(&[(1, &closed[..])]).unwrap();
    let from = closed[0].0[0];
    let whole = |dir: [f32; 3]| media.segments(&RayOf::new(from, dir));
    for dir in [[0.0; 3], [f32::NAN, 0.0, 0.0]] {
        assert!(matches!(
            whole(dir)[..],
            [Segment { start: 0.0, end: f64::INFINITY, medium: None, .. }]
        ));
    }
    for (start, end) in [(2.0, 1.0), (1.0, 1.0), (f32::NAN, 1.0), (0.0, f32::NAN)] {
        assert_eq!(media.segments(&RayOf::new(from, [1.0; 3]).between(start, end)), []);
    }
}

//! Compares the `fixed` mode with the scalar reference, on the same snapped triangles and rays.
//! Every answer is verified.
//!
//! The `fixed` mode computes t as an exact ratio. The reference implementation receives the same
//! integers, converted to f32 without rounding, and must find the same triangles. All exact
//! contenders must find the same numerators and denominators as the scalar test in i128.

use criterion::{Criterion, criterion_group, criterion_main};
use intertri::fixed::{
    Best, Bits, Block, Grid, IntWidth, Packet, Prepared, Ray, RayLanes, SeenTriangle, Triangle,
    scalar,
};
use intertri::simd::{Lane, Level, Simd, WithSimd};
use intertri_benches::{Answer, Contender, Workload, compare};
use intertri_reference as reference;

/// Adds the closest crossing of a ray: its triangle, and the numerator and denominator of t.
#[inline(always)]
fn add(answer: &mut Answer, best: &Best) {
    if let Some((crossing, triangle)) = best.get() {
        answer.add(u64::from(triangle), f64::from_bits(crossing.t.num() as u64 ^ crossing.t.den()));
    }
}

/// Tests packets of N rays against one triangle at a time.
struct Packets<'a, const N: usize, const FILTER: bool> {
    packets: &'a [Packet<N>],
    triangles: &'a [Prepared],
}

impl<const N: usize, const FILTER: bool> WithSimd for Packets<'_, N, FILTER>
where
    Lane<N>: IntWidth,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let mut answer = Answer::default();
        for packet in self.packets {
            let mut bests = [Best::default(); N];
            for (triangle, index) in self.triangles.iter().zip(0..) {
                packet.crossings_in::<S, FILTER>(triangle, packet.live(), |lane, crossing| {
                    bests[lane].offer(crossing, index);
                });
            }
            for best in &bests {
                add(&mut answer, best);
            }
        }
        answer
    }
}

/// Tests packets of rays that share an origin against triangles prepared for that origin.
struct Shared<'a, const N: usize, const FILTER: bool> {
    packets: &'a [Packet<N>],
    triangles: &'a [Triangle],
}

impl<const N: usize, const FILTER: bool> WithSimd for Shared<'_, N, FILTER>
where
    Lane<N>: IntWidth,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let mut answer = Answer::default();
        let origin = self.packets[0].rays()[0].origin();
        let seen: Vec<(SeenTriangle, u32)> = (self.triangles.iter().zip(0..))
            .filter_map(|(triangle, index)| Some((SeenTriangle::new(triangle, origin)?, index)))
            .collect();
        for packet in self.packets {
            let mut bests = [Best::default(); N];
            for (seen, index) in &seen {
                seen.crossings_in::<S, FILTER, N>(packet, packet.live(), |lane, crossing| {
                    bests[lane].offer(crossing, *index);
                });
            }
            for best in &bests {
                add(&mut answer, best);
            }
        }
        answer
    }
}

/// Tests one ray at a time against all blocks of N triangles.
struct Blocks<'a, const N: usize, const FILTER: bool> {
    rays: &'a [Ray],
    blocks: &'a [Block<N>],
}

impl<const N: usize, const FILTER: bool> WithSimd for Blocks<'_, N, FILTER>
where
    Lane<N>: IntWidth,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let mut answer = Answer::default();
        for ray in self.rays {
            let mut best = Best::default();
            let ray = RayLanes::<S, N>::new(ray);
            for block in self.blocks {
                block
                    .crossings_in::<S, FILTER>(&ray, |crossing, index| best.offer(crossing, index));
            }
            add(&mut answer, &best);
        }
        answer
    }
}

/// A workload on the fine grid, with the answers of the scalar test in i128.
struct Data {
    rays: Vec<Ray>,
    triangles: Vec<Triangle>,
    prepared: Vec<Prepared>,
    packets4: Vec<Packet<4>>,
    packets8: Vec<Packet<8>>,
    blocks4: Vec<Block<4>>,
    blocks8: Vec<Block<8>>,
    scene: reference::Scene,
    lines: Vec<reference::Ray>,
    truth: Answer,
    /// The sum of the triangle indices over all closest crossings.
    nearest: u64,
}

impl Data {
    fn new(shared: bool) -> Self {
        let workload = Workload::view(512, 128, shared);
        let corners = workload.triangles.iter().flat_map(|t| t.0);
        let points = corners.chain(workload.rays.iter().map(|ray| ray.origin));
        let grid = Grid::around(points, Bits::FINE).expect("the points are finite");
        let triangle = |t| grid.triangle(t).expect("the triangle is on the grid");
        let triangles: Vec<Triangle> = workload.triangles.iter().map(triangle).collect();
        let ray = |ray| grid.ray(ray).expect("the ray is on the grid");
        let rays: Vec<Ray> = workload.rays.iter().map(ray).collect();
        let (mut truth, mut nearest) = (Answer::default(), 0_u64);
        for ray in &rays {
            let mut best = Best::default();
            for (triangle, index) in triangles.iter().zip(0..) {
                if let Some(crossing) = scalar::crossing(ray, triangle) {
                    best.offer(crossing, index);
                }
            }
            add(&mut truth, &best);
            nearest = nearest.wrapping_add(best.get().map_or(0, |(_, index)| u64::from(index)));
        }
        let indexed: Vec<_> = triangles.iter().copied().zip(0..).collect();
        Self {
            packets4: rays.chunks(4).map(Packet::new).collect(),
            packets8: rays.chunks(8).map(Packet::new).collect(),
            blocks4: indexed.chunks(4).map(|c| Block::new(c.iter().copied())).collect(),
            blocks8: indexed.chunks(8).map(|c| Block::new(c.iter().copied())).collect(),
            scene: reference::Scene::from_triangles(triangles.iter().map(|t| t.to_f32().0)),
            lines: rays
                .iter()
                .map(|ray| {
                    let ray = ray.to_f32();
                    reference::Ray::new(ray.origin, ray.dir)
                })
                .collect(),
            prepared: triangles.iter().map(Prepared::new).collect(),
            rays,
            triangles,
            truth,
            nearest,
        }
    }

    /// Traces the rays with the scalar f64 reference, which must find the same triangles.
    fn scalar(&self) -> Answer {
        let mut answer = Answer::default();
        for line in &self.lines {
            if let Some((triangle, t)) = self.scene.closest(line, 0.0, f64::INFINITY) {
                std::hint::black_box(t);
                answer.add(triangle as u64, 0.0);
            }
        }
        answer
    }

    /// Returns a contender that must find the same crossings as the scalar test in i128.
    fn exact<'a>(&'a self, name: String, run: impl Fn() -> Answer + 'a) -> Contender<'a> {
        let run = move || {
            assert_eq!(run(), self.truth);
            Answer { mixed: self.nearest, ..self.truth }
        };
        Contender { name, run: Box::new(run), exact: true }
    }

    fn contenders(&self, shared: bool) -> Vec<Contender<'_>> {
        let run = Box::new(|| self.scalar());
        let mut all = vec![Contender { name: "scalar f64 reference".into(), run, exact: true }];
        for level in Level::all() {
            let named = |what: &str| format!("{what}, {}", level.name());
            let (triangles, rays) = (&self.triangles[..], &self.rays[..]);
            let prepared = &self.prepared[..];
            macro_rules! form {
                ($name:literal, $work:expr) => {
                    all.push(self.exact(named($name), move || level.run($work)));
                };
            }
            if shared {
                form!("seen x8", Shared::<8, true> { packets: &self.packets8, triangles });
                form!(
                    "seen x8, no filter",
                    Shared::<8, false> { packets: &self.packets8, triangles }
                );
            } else {
                form!(
                    "packet x8",
                    Packets::<8, true> { packets: &self.packets8, triangles: prepared }
                );
                form!(
                    "packet x8, no filter",
                    Packets::<8, false> { packets: &self.packets8, triangles: prepared }
                );
                form!(
                    "packet x4",
                    Packets::<4, true> { packets: &self.packets4, triangles: prepared }
                );
                form!("block x8", Blocks::<8, true> { rays, blocks: &self.blocks8 });
                form!("block x8, no filter", Blocks::<8, false> { rays, blocks: &self.blocks8 });
                form!("block x4", Blocks::<4, true> { rays, blocks: &self.blocks4 });
            }
        }
        all
    }
}

fn bench(criterion: &mut Criterion) {
    // `cargo test` runs every benchmark once, and one turn is enough to check the answers.
    let turns = if std::env::args().any(|arg| arg == "--bench") { 100 } else { 1 };
    for (form, shared) in [("fixed", false), ("fixed, shared origin", true)] {
        let data = Data::new(shared);
        let tests = data.rays.len() * data.triangles.len();
        compare(form, tests, turns, &mut data.contenders(shared));
        let mut group = criterion.benchmark_group(form);
        group.throughput(criterion::Throughput::Elements(tests as u64));
        for mut contender in data.contenders(shared) {
            group.bench_function(&contender.name, |b| b.iter(|| (contender.run)()));
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);

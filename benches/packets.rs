//! Scalar against lanes: packets of rays against one triangle after another, one ray against blocks.
//!
//! `cargo bench -p intertri-benches --bench packets` first prints, for each form, a table of all
//! contenders measured in alternation, every answer held against the scalar reference's; then
//! criterion measures each by itself.

use criterion::{Criterion, criterion_group, criterion_main};
use intertri::internal::{Filter, Lanes64};
use intertri::simd::{Lane, Level, Simd, Width, WithSimd};
use intertri::{
    Blocks, Certified, ClosestHit, ClosestHits, Counts, Double, Exact, LaneQueries, Mode, Prepared,
    PreparedPacket, Ray, RayPacket, Triangle, TriangleBlock,
};
use intertri_benches::moller_trumbore::{MollerTrumbore, edges, scalar_any, scalar_closest};
use intertri_benches::{Answer, Contender, Workload, compare};
use intertri_reference as reference;

/// The scalar f64 reference's plain loop.
fn scalar(scene: &reference::Scene, rays: &[Ray]) -> Answer {
    let mut answer = Answer::default();
    for ray in rays {
        let line = reference::Ray::new(ray.origin, ray.dir);
        if let Some((obj, t)) = scene.closest(&line, ray.t_min.into(), ray.t_max.into()) {
            answer.add(obj as u64, t);
        }
    }
    answer
}

/// Packets of N rays against one triangle after another.
struct Packets<'a, T: LaneQueries, const N: usize> {
    test: T,
    data: &'a Data,
    packets: &'a [RayPacket<N>],
    triangles: &'a [Prepared<T>],
}

impl<T: LaneQueries, const N: usize> WithSimd for Packets<'_, T, N>
where
    Lane<N>: Width,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let Self { test, data, packets, triangles } = self;
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        for packet in packets {
            let rays = test.prepare_packet_in::<S, N>(packet);
            let mut closest = ClosestHits::new(&packet.t_max);
            let (live, find) = (packet.live(), |place| data.triangle(place));
            test.packet_closest_of_in(&rays, triangles, 0, find, live, &mut closest, &mut counts);
            data.add(&test, &rays, &closest, &mut answer);
        }
        answer
    }
}

/// Packets of N rays that share their origin against one block after another as seen from there, what
/// depends on the origin computed anew.
struct SharedOrigin<'a, const N: usize> {
    test: Filter<'a>,
    data: &'a Data,
    packets: &'a [RayPacket<N>],
}

impl<const N: usize> WithSimd for SharedOrigin<'_, N>
where
    Lane<N>: Width,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let Self { test, data, packets } = self;
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        let origin = data.rays[0].origin;
        let mut blocks = Vec::with_capacity(data.blocks.len());
        for block in &data.blocks {
            blocks.push(test.shared_origin_in::<S>(block, origin));
        }
        for packet in packets {
            let rays = test.prepare_packet_in::<S, N>(packet);
            let mut closest = ClosestHits::new(&packet.t_max);
            let (live, find) = (packet.live(), |place| data.triangle(place));
            test.shared_origin_closest_in(&rays, &blocks, 0, find, live, &mut closest, &mut counts);
            data.add(&test, &rays, &closest, &mut answer);
        }
        answer
    }
}

/// One ray after another against blocks of eight triangles.
struct BlockLoop<'a, T> {
    test: T,
    data: &'a Data,
}

impl<T: LaneQueries> WithSimd for BlockLoop<'_, T> {
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let Self { test, data } = self;
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        for ray in &data.rays {
            let prepared = test.prepare_ray(ray);
            let mut closest = ClosestHit::new(ray.t_max);
            for (k, block) in (0..).zip(&data.blocks) {
                let indices = std::array::from_fn(|i| 8 * k + i as u32);
                let find = |place| data.triangle(place);
                test.closest_in::<S>(
                    &prepared,
                    block,
                    &indices,
                    8 * k,
                    find,
                    &mut closest,
                    &mut counts,
                );
            }
            if let Some(hit) = test.hit(ray, &closest, |place| data.triangle(place)) {
                answer.add(hit.triangle.into(), hit.t);
            }
        }
        answer
    }
}

/// All that the contenders run over.
struct Data {
    scene: reference::Scene,
    rays: Vec<Ray>,
    triangles: Vec<Triangle>,
    packets4: Vec<RayPacket<4>>,
    packets: Vec<RayPacket<8>>,
    packets16: Vec<RayPacket<16>>,
    blocks: Vec<TriangleBlock<8>>,
    prepared: Blocks,
    double: Vec<Prepared<Lanes64>>,
    certified: Vec<Prepared<Filter<'static>>>,
    plain: Vec<[[f32; 3]; 3]>,
    shared: bool,
}

impl Data {
    fn new(Workload { rays, triangles }: Workload, shared: bool) -> Self {
        let (double, certified) = (Double::default(), Certified::default());
        Self {
            scene: reference::Scene::from_triangles(triangles.iter().map(|t| t.0)),
            packets4: rays.chunks(4).map(RayPacket::new).collect(),
            packets: rays.chunks(8).map(RayPacket::new).collect(),
            packets16: rays.chunks(16).map(RayPacket::new).collect(),
            blocks: triangles.chunks(8).map(TriangleBlock::new).collect(),
            prepared: Blocks::new(&triangles),
            double: triangles.iter().map(|t| double.prepare(t)).collect(),
            certified: triangles.iter().map(|t| certified.prepare(t)).collect(),
            plain: triangles.iter().map(edges).collect(),
            rays,
            triangles,
            shared,
        }
    }

    #[inline(always)]
    fn triangle(&self, place: u32) -> Triangle {
        self.triangles[place as usize]
    }

    /// Adds the hits of a packet.
    #[inline(always)]
    fn add<T: LaneQueries, S: Simd, const N: usize>(
        &self,
        test: &T,
        rays: &PreparedPacket<'_, T, S, N>,
        closest: &ClosestHits<<Lane<N> as Width>::F<S>, N>,
        answer: &mut Answer,
    ) where
        Lane<N>: Width,
    {
        let hits = test.hits_in(rays, closest, |place| self.triangle(place));
        for lane in 0..N {
            if let Some((triangle, _)) = closest.lane(lane).triangle() {
                answer.add(triangle.into(), hits.t[lane]);
            }
        }
    }

    /// Packets of rays against one triangle after another.
    fn packets(&self) -> Vec<Contender<'_>> {
        let mut all = vec![exact("scalar f64 reference", || scalar(&self.scene, &self.rays))];
        for level in Level::all() {
            let named = |what: &str| format!("{what}, {}", level.name());
            let (d, c) =
                (Double::default().at(level).test(), Certified::default().at(level).test());
            all.push(exact(named("double x4"), move || {
                let (packets, triangles) = (&self.packets4[..], &self.double[..]);
                level.run(Packets { test: d, data: self, packets, triangles })
            }));
            all.push(exact(named("double x8"), move || {
                let (packets, triangles) = (&self.packets[..], &self.double[..]);
                level.run(Packets { test: d, data: self, packets, triangles })
            }));
            all.push(exact(named("certified x4"), move || {
                let (packets, triangles) = (&self.packets4[..], &self.certified[..]);
                level.run(Packets { test: c, data: self, packets, triangles })
            }));
            all.push(exact(named("certified x8"), move || {
                let (packets, triangles) = (&self.packets[..], &self.certified[..]);
                level.run(Packets { test: c, data: self, packets, triangles })
            }));
            all.push(exact(named("certified x16"), move || {
                let (packets, triangles) = (&self.packets16[..], &self.certified[..]);
                level.run(Packets { test: c, data: self, packets, triangles })
            }));
            if self.shared {
                all.push(exact(named("certified x8, shared origin"), move || {
                    level.run(SharedOrigin { test: c, data: self, packets: &self.packets })
                }));
                all.push(exact(named("certified x16, shared origin"), move || {
                    level.run(SharedOrigin { test: c, data: self, packets: &self.packets16 })
                }));
            }
            let run = move || {
                level.run(MollerTrumbore { packets: &self.packets, triangles: &self.plain })
            };
            let name = named("plain f32 Moller-Trumbore x8");
            all.push(Contender { name, run: Box::new(run), exact: false });
            let run = move || {
                level.run(MollerTrumbore { packets: &self.packets16, triangles: &self.plain })
            };
            let name = named("plain f32 Moller-Trumbore x16");
            all.push(Contender { name, run: Box::new(run), exact: false });
        }
        all
    }

    /// One ray against blocks of triangles.
    fn blocks(&self) -> Vec<Contender<'_>> {
        let mut all = vec![exact("scalar f64 reference", || scalar(&self.scene, &self.rays))];
        for level in Level::all() {
            let named = |what: &str| format!("{what}, {}", level.name());
            let (d, c) =
                (Double::default().at(level).test(), Certified::default().at(level).test());
            all.push(exact(named("double x8"), move || {
                level.run(BlockLoop { test: d, data: self })
            }));
            all.push(exact(named("certified x8"), move || {
                level.run(BlockLoop { test: c, data: self })
            }));
        }
        all
    }
}

/// Queries over a slice, a ray a call, each contender beside a plain loop in f32: first closest hits, then any.
fn slices(data: &Data) -> [Vec<Contender<'_>>; 2] {
    let (rays, triangles) = (&data.rays[..], &data.triangles[..]);
    let plain = |run: fn(&[Ray], &[Triangle]) -> Answer| Contender {
        name: "scalar f32 Moller-Trumbore".into(),
        run: Box::new(move || run(rays, triangles)),
        exact: false,
    };
    let (mut closest, mut any) = (vec![plain(scalar_closest)], vec![plain(scalar_any)]);
    for level in Level::all() {
        for blocks in [None, Some(&data.prepared)] {
            let named = |mode: &str| {
                let what = if blocks.is_some() { "blocks" } else { "slice" };
                format!("{mode}, {what}, {}", level.name())
            };
            queries(&Exact::at(level), data, blocks, named("exact"), (&mut closest, &mut any));
            let certified = Certified::default().at(level);
            queries(&certified, data, blocks, named("certified"), (&mut closest, &mut any));
        }
    }
    [closest, any]
}

/// Adds the queries of a mode over the slice, or over blocks made of it before.
fn queries<'a, M: Mode + 'a>(
    mode: &M,
    data: &'a Data,
    blocks: Option<&'a Blocks>,
    name: String,
    (closest, any): (&mut Vec<Contender<'a>>, &mut Vec<Contender<'a>>),
) {
    let (mode, rays, triangles) = (*mode, &data.rays[..], &data.triangles[..]);
    let run = move || {
        let mut answer = Answer::default();
        for ray in rays {
            let hit = match blocks {
                Some(blocks) => blocks.closest(&mode, ray),
                None => mode.closest(triangles, ray),
            };
            if let Some(hit) = hit {
                answer.add(hit.triangle.into(), hit.t);
            }
        }
        answer
    };
    closest.push(Contender { name: name.clone(), run: Box::new(run), exact: false });
    let hits = move |ray: &&Ray| match blocks {
        Some(blocks) => blocks.any(&mode, ray),
        None => mode.any(triangles, ray),
    };
    let run = move || Answer { hits: rays.iter().filter(hits).count() as u64, mixed: 0 };
    any.push(Contender { name, run: Box::new(run), exact: false });
}

/// A contender whose answer must be the reference's.
fn exact<'a>(name: impl Into<String>, run: impl FnMut() -> Answer + 'a) -> Contender<'a> {
    Contender { name: name.into(), run: Box::new(run), exact: true }
}

fn bench(criterion: &mut Criterion) {
    let strewn = Data::new(Workload::strewn(2048, 256), false);
    let each = Data::new(Workload::view(2048, 256, false), false);
    let one = Data::new(Workload::view(2048, 256, true), true);
    let tests = each.rays.len() * each.triangles.len();
    // `cargo test` runs every benchmark once: then one turn suffices to check the answers.
    let turns = if std::env::args().any(|arg| arg == "--bench") { 60 } else { 1 };
    compare("packets of rays in all directions", tests, turns, &mut strewn.packets());
    compare("packets, alike, each ray its own origin", tests, turns, &mut each.packets());
    compare("packets, a camera's: one origin", tests, turns, &mut one.packets());
    compare("one ray against blocks of triangles", tests, turns, &mut strewn.blocks());
    let [mut closest, mut any] = slices(&strewn);
    compare("closest of a slice, a ray a call", tests, turns, &mut closest);
    compare("any of a slice, a ray a call", tests, turns, &mut any);

    let forms = [
        ("packets in all directions", strewn.packets()),
        ("packets alike", each.packets()),
        ("packets of one origin", one.packets()),
        ("blocks", strewn.blocks()),
        ("closest of a slice", closest),
        ("any of a slice", any),
    ];
    for (form, contenders) in forms {
        let mut group = criterion.benchmark_group(form);
        group.throughput(criterion::Throughput::Elements(tests as u64));
        for mut contender in contenders {
            group.bench_function(&contender.name, |b| b.iter(|| (contender.run)()));
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);

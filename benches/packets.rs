//! Compares scalar code with SIMD lanes, for packets of rays against single triangles and for
//! single rays against blocks of triangles.
//!
//! `cargo bench -p intertri-benches --bench packets` compares the answers of the packet and block
//! queries in `certified` with the scalar reference's. For each kind of query, the contenders take
//! turns and are listed in a table; then criterion measures each contender alone.

use criterion::{Criterion, criterion_group, criterion_main};
use intertri::simd::{Lane, Level, Simd, Width, WithSimd};
use intertri::{
    Blocks, ClosestHit, ClosestHits, Counts, Filter, LeafSlot, Mode, PreparedPacket,
    PreparedTriangle, Ray, RayPacket, Triangle, TriangleBlock, TriangleId,
};
use intertri_benches::moller_trumbore::{MollerTrumbore, edges, scalar_any, scalar_closest};
use intertri_benches::{Answer, Contender, Workload, compare};
use intertri_reference as reference;

/// Traces the rays with the scalar f64 reference in a plain loop.
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

/// Tests packets of N rays against one triangle at a time.
struct Packets<'a, const N: usize> {
    filter: Filter<'a>,
    data: &'a Data,
    packets: &'a [RayPacket<N>],
}

impl<const N: usize> WithSimd for Packets<'_, N>
where
    Lane<N>: Width,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let Self { filter, data, packets } = self;
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        for packet in packets {
            let rays = filter.prepare_packet_in::<S, N>(packet);
            let mut closest = ClosestHits::new(&packet.t_max);
            let live = packet.live();
            filter.packet_closest_of_in(&rays, &data.prepared, live, &mut closest, &mut counts);
            data.add(&filter, &rays, &closest, &mut answer);
        }
        answer
    }
}

/// Tests one ray at a time against all blocks of eight triangles.
struct BlockLoop<'a> {
    filter: Filter<'a>,
    data: &'a Data,
}

impl WithSimd for BlockLoop<'_> {
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let Self { filter, data } = self;
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        let find = |slot| data.triangle(slot);
        for ray in &data.rays {
            let prepared = filter.prepare_ray(ray);
            let mut closest = ClosestHit::new(ray.t_max);
            for (k, block) in (0..).zip(&data.blocks) {
                let indices = std::array::from_fn(|i| 8 * k + i as u32);
                filter.closest_in::<S>(
                    &prepared,
                    block,
                    &indices,
                    LeafSlot(8 * k),
                    find,
                    &mut closest,
                    &mut counts,
                );
            }
            if let Some(hit) = filter.hit(ray, &closest, find) {
                answer.add(hit.triangle.into(), hit.t);
            }
        }
        answer
    }
}

/// The inputs of all contenders.
struct Data {
    scene: reference::Scene,
    rays: Vec<Ray>,
    triangles: Vec<Triangle>,
    packets4: Vec<RayPacket<4>>,
    packets: Vec<RayPacket<8>>,
    packets16: Vec<RayPacket<16>>,
    blocks: Vec<TriangleBlock<8>>,
    prepared: Vec<PreparedTriangle>,
    prepared_blocks: Blocks,
    plain: Vec<[[f32; 3]; 3]>,
}

impl Data {
    fn new(Workload { rays, triangles }: Workload) -> Self {
        Self {
            scene: reference::Scene::from_triangles(triangles.iter().map(|t| t.0)),
            packets4: rays.chunks(4).map(RayPacket::new).collect(),
            packets: rays.chunks(8).map(RayPacket::new).collect(),
            packets16: rays.chunks(16).map(RayPacket::new).collect(),
            blocks: triangles.chunks(8).map(TriangleBlock::new).collect(),
            prepared: triangles.iter().map(PreparedTriangle::new).collect(),
            prepared_blocks: Blocks::new(&triangles),
            plain: triangles.iter().map(edges).collect(),
            rays,
            triangles,
        }
    }

    #[inline(always)]
    fn triangle(&self, LeafSlot(slot): LeafSlot) -> Triangle {
        self.triangles[slot as usize]
    }

    /// Adds the hits of a packet.
    #[inline(always)]
    fn add<S: Simd, const N: usize>(
        &self,
        filter: &Filter<'_>,
        rays: &PreparedPacket<'_, S, N>,
        closest: &ClosestHits<<Lane<N> as Width>::F<S>, N>,
        answer: &mut Answer,
    ) where
        Lane<N>: Width,
    {
        let hits = filter.hits_in(rays, closest, |slot| self.triangle(slot));
        for lane in 0..N {
            if let Some((TriangleId(triangle), _)) = closest.lane(lane).triangle() {
                answer.add(triangle.into(), hits.t[lane]);
            }
        }
    }

    /// Returns the contenders that test packets of rays against one triangle at a time.
    fn packets(&self) -> Vec<Contender<'_>> {
        let mut all = vec![exact("scalar f64 reference", || scalar(&self.scene, &self.rays))];
        for level in Level::all() {
            let named = |what: &str| format!("{what}, {}", level.name());
            let filter = Mode::certified().at(level).filter();
            all.push(exact(named("certified x4"), move || {
                level.run(Packets { filter, data: self, packets: &self.packets4 })
            }));
            all.push(exact(named("certified x8"), move || {
                level.run(Packets { filter, data: self, packets: &self.packets })
            }));
            all.push(exact(named("certified x16"), move || {
                level.run(Packets { filter, data: self, packets: &self.packets16 })
            }));
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

    /// Returns the contenders that test one ray against blocks of triangles.
    fn blocks(&self) -> Vec<Contender<'_>> {
        let mut all = vec![exact("scalar f64 reference", || scalar(&self.scene, &self.rays))];
        for level in Level::all() {
            let named = |what: &str| format!("{what}, {}", level.name());
            let filter = Mode::certified().at(level).filter();
            all.push(exact(named("certified x8"), move || {
                level.run(BlockLoop { filter, data: self })
            }));
        }
        all
    }
}

/// Returns the contenders that query a slice, one ray per call, along with a plain f32 loop. The
/// first list is for closest-hit queries, and the second for any-hit queries.
fn slices(data: &Data) -> [Vec<Contender<'_>>; 2] {
    let (rays, triangles) = (&data.rays[..], &data.triangles[..]);
    let plain = |run: fn(&[Ray], &[Triangle]) -> Answer| Contender {
        name: "scalar f32 Moller-Trumbore".into(),
        run: Box::new(move || run(rays, triangles)),
        exact: false,
    };
    let (mut closest, mut any) = (vec![plain(scalar_closest)], vec![plain(scalar_any)]);
    for level in Level::all() {
        for blocks in [None, Some(&data.prepared_blocks)] {
            let named = |mode: &str| {
                let what = if blocks.is_some() { "blocks" } else { "slice" };
                format!("{mode}, {what}, {}", level.name())
            };
            for (name, mode) in [("exact", Mode::exact()), ("certified", Mode::certified())] {
                let to = (&mut closest, &mut any);
                queries(mode.at(level), data, blocks, named(name), to);
            }
        }
    }
    [closest, any]
}

/// Adds a mode's queries over the slice, or over blocks that were built from it beforehand.
fn queries<'a>(
    mode: Mode,
    data: &'a Data,
    blocks: Option<&'a Blocks>,
    name: String,
    (closest, any): (&mut Vec<Contender<'a>>, &mut Vec<Contender<'a>>),
) {
    let (rays, triangles) = (&data.rays[..], &data.triangles[..]);
    let run = move || {
        let mut answer = Answer::default();
        for ray in rays {
            let hit = match blocks {
                Some(blocks) => blocks.closest(mode, ray),
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
        Some(blocks) => blocks.any(mode, ray),
        None => mode.any(triangles, ray),
    };
    let run = move || Answer { hits: rays.iter().filter(hits).count() as u64, mixed: 0 };
    any.push(Contender { name, run: Box::new(run), exact: false });
}

/// Returns a contender whose answers must equal the reference's.
fn exact<'a>(name: impl Into<String>, run: impl FnMut() -> Answer + 'a) -> Contender<'a> {
    Contender { name: name.into(), run: Box::new(run), exact: true }
}

fn bench(criterion: &mut Criterion) {
    let strewn = Data::new(Workload::strewn(2048, 256));
    let each = Data::new(Workload::view(2048, 256, false));
    let one = Data::new(Workload::view(2048, 256, true));
    let tests = each.rays.len() * each.triangles.len();
    // `cargo test` runs every benchmark once, and one turn is enough to check the answers.
    let turns = if std::env::args().any(|arg| arg == "--bench") { 60 } else { 1 };
    compare("packets of rays in all directions", tests, turns, &mut strewn.packets());
    compare("packets of similar rays, each with its own origin", tests, turns, &mut each.packets());
    compare("packets of camera rays with one origin", tests, turns, &mut one.packets());
    compare("one ray against blocks of triangles", tests, turns, &mut strewn.blocks());
    let [mut closest, mut any] = slices(&strewn);
    compare("closest of a slice, one ray per call", tests, turns, &mut closest);
    compare("any of a slice, one ray per call", tests, turns, &mut any);

    let forms = [
        ("packets in all directions", strewn.packets()),
        ("packets of similar rays", each.packets()),
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

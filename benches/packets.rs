//! Scalar against lanes: packets of rays against one triangle after another, one ray against packs.
//!
//! `cargo bench -p intertri-benches --bench packets` first prints, for each form, a table of all
//! contenders measured in alternation, every answer held against the scalar reference's; then
//! criterion measures each by itself.

use criterion::{Criterion, criterion_group, criterion_main};
use intertri::lanes::{Level, Simd, WithSimd};
use intertri::{
    Certified, Counts, Double, Lane, Mode, Prepared, Ray, RayPacket, TrianglePack, Width,
};
use intertri_benches::moller_trumbore::{MollerTrumbore, edges};
use intertri_benches::{Answer, Contender, Workload, compare};
use intertri_reference as reference;

/// The scalar f64 reference, test by test.
fn scalar(scene: &reference::Scene, rays: &[Ray]) -> Answer {
    let mut answer = Answer::default();
    for ray in rays {
        let line = reference::Ray::new(ray.origin, ray.dir);
        for obj in 0..scene.trian.len() {
            if let Some(t) = scene.hit(obj, &line, ray.t_min.into(), ray.t_max.into()) {
                answer.add(t);
            }
        }
    }
    answer
}

/// Packets of N rays against one triangle after another.
struct Packets<'a, M: Mode, const N: usize> {
    mode: M,
    packets: &'a [RayPacket<N>],
    triangles: &'a [Prepared<M>],
}

impl<M: Mode, const N: usize> WithSimd for Packets<'_, M, N>
where
    Lane<N>: Width,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        for packet in self.packets {
            let rays = self.mode.prepare_packet_in::<S, N>(packet);
            for triangle in self.triangles {
                let hits = self.mode.packet_in(&rays, triangle, &mut counts);
                for lane in (0..N).filter(|lane| hits.bits >> lane & 1 != 0) {
                    answer.add(hits.t[lane]);
                }
            }
        }
        answer
    }
}

/// One ray after another against packs of N triangles.
struct Packs<'a, M, const N: usize> {
    mode: M,
    rays: &'a [Ray],
    packs: &'a [TrianglePack<N>],
}

impl<M: Mode, const N: usize> WithSimd for Packs<'_, M, N>
where
    Lane<N>: Width,
{
    type Output = Answer;
    #[inline(always)]
    fn run<S: Simd>(self) -> Answer {
        let (mut answer, mut counts) = (Answer::default(), Counts::default());
        for ray in self.rays {
            for pack in self.packs {
                let hits = self.mode.pack_in::<S, N>(ray, pack, &mut counts);
                for lane in (0..N).filter(|lane| hits.bits >> lane & 1 != 0) {
                    answer.add(hits.t[lane]);
                }
            }
        }
        answer
    }
}

/// All that the contenders run over.
struct Data {
    scene: reference::Scene,
    rays: Vec<Ray>,
    packets4: Vec<RayPacket<4>>,
    packets8: Vec<RayPacket<8>>,
    packets16: Vec<RayPacket<16>>,
    packs4: Vec<TrianglePack<4>>,
    packs8: Vec<TrianglePack<8>>,
    double: Vec<Prepared<Double>>,
    certified: Vec<Prepared<Certified>>,
    plain: Vec<[[f32; 3]; 3]>,
}

impl Data {
    fn new(shared: bool) -> Self {
        let Workload { rays, triangles } = Workload::random(512, 128, shared);
        let (double, certified) = (Double::default(), Certified::default());
        Self {
            scene: reference::Scene::from_triangles(triangles.iter().map(|t| t.0)),
            packets4: rays.chunks(4).map(RayPacket::new).collect(),
            packets8: rays.chunks(8).map(RayPacket::new).collect(),
            packets16: rays.chunks(16).map(RayPacket::new).collect(),
            packs4: triangles.chunks(4).map(TrianglePack::new).collect(),
            packs8: triangles.chunks(8).map(TrianglePack::new).collect(),
            double: triangles.iter().map(|t| double.prepare(t)).collect(),
            certified: triangles.iter().map(|t| certified.prepare(t)).collect(),
            plain: triangles.iter().map(edges).collect(),
            rays,
        }
    }

    /// Packets of rays against a triangle.
    fn packets(&self) -> Vec<Contender<'_>> {
        let mut all = vec![exact("scalar f64 reference", || scalar(&self.scene, &self.rays))];
        for level in Level::all().skip(1) {
            let named = |what: &str| format!("{what}, {}", level.name());
            let (d, c) = (Double::default().at(level), Certified::default().at(level));
            let (double, certified, plain) = (&self.double, &self.certified, &self.plain);
            all.push(exact(named("double x4"), move || {
                level.run(Packets { mode: d, packets: &self.packets4, triangles: double })
            }));
            all.push(exact(named("double x8"), move || {
                level.run(Packets { mode: d, packets: &self.packets8, triangles: double })
            }));
            all.push(exact(named("certified x4"), move || {
                level.run(Packets { mode: c, packets: &self.packets4, triangles: certified })
            }));
            all.push(exact(named("certified x8"), move || {
                level.run(Packets { mode: c, packets: &self.packets8, triangles: certified })
            }));
            all.push(exact(named("certified x16"), move || {
                level.run(Packets { mode: c, packets: &self.packets16, triangles: certified })
            }));
            let run = move || level.run(MollerTrumbore { packets: &self.packets8, triangles: plain });
            let name = named("plain f32 Moller-Trumbore x8");
            all.push(Contender { name, run: Box::new(run), exact: false });
            let run =
                move || level.run(MollerTrumbore { packets: &self.packets16, triangles: plain });
            let name = named("plain f32 Moller-Trumbore x16");
            all.push(Contender { name, run: Box::new(run), exact: false });
        }
        all
    }

    /// One ray against packs of triangles.
    fn packs(&self) -> Vec<Contender<'_>> {
        let mut all = vec![exact("scalar f64 reference", || scalar(&self.scene, &self.rays))];
        for level in Level::all().skip(1) {
            let named = |what: &str| format!("{what}, {}", level.name());
            let (d, c) = (Double::default().at(level), Certified::default().at(level));
            let (rays, packs4, packs8) = (&self.rays, &self.packs4, &self.packs8);
            all.push(exact(named("double x4"), move || {
                level.run(Packs { mode: d, rays, packs: packs4 })
            }));
            all.push(exact(named("double x8"), move || {
                level.run(Packs { mode: d, rays, packs: packs8 })
            }));
            all.push(exact(named("certified x4"), move || {
                level.run(Packs { mode: c, rays, packs: packs4 })
            }));
            all.push(exact(named("certified x8"), move || {
                level.run(Packs { mode: c, rays, packs: packs8 })
            }));
        }
        all
    }
}

/// A contender whose answer must be the reference's.
fn exact<'a>(name: impl Into<String>, run: impl FnMut() -> Answer + 'a) -> Contender<'a> {
    Contender { name: name.into(), run: Box::new(run), exact: true }
}

fn bench(criterion: &mut Criterion) {
    let data = Data::new(false);
    let tests = data.rays.len() * data.scene.trian.len();
    // `cargo test` runs every benchmark once: then a few turns suffice to check the answers.
    let turns = if std::env::args().any(|arg| arg == "--bench") { 300 } else { 1 };
    compare("packets of rays against a triangle", tests, turns, &mut data.packets());
    compare("one ray against packs of triangles", tests, turns, &mut data.packs());

    for (form, contenders) in [("packets", data.packets()), ("packs", data.packs())] {
        let mut group = criterion.benchmark_group(form);
        group.throughput(criterion::Throughput::Elements(tests as u64));
        for mut contender in contenders {
            group.bench_function(&contender.name, |b| b.iter(|| (contender.run)()));
        }
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);

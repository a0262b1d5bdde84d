//! Rays of one model in f32 and in f64, moved or not: `speed64 model.obj [moved]`. One thread.

use std::hint::black_box;
use std::time::Instant;

use intertri_trace::Bvh;
use intertri_trace::intertri::{Exact, Hit, Ray, Ray64, Triangle, Triangle64};

fn load(path: &str) -> Vec<[[f32; 3]; 3]> {
    let text = std::fs::read_to_string(path).unwrap();
    let (mut v, mut t) = (vec![], vec![]);
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f32> = words.take(3).map(|x| x.parse().unwrap()).collect();
                v.push([p[0], p[1], p[2]]);
            }
            Some("f") => {
                let f: Vec<usize> = words
                    .map(|w| w.split('/').next().unwrap().parse::<usize>().unwrap() - 1)
                    .collect();
                for i in 1..f.len() - 1 {
                    t.push([v[f[0]], v[f[i]], v[f[i + 1]]]);
                }
            }
            _ => {}
        }
    }
    t
}

struct Rng(u64);
impl Rng {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
    fn dir(&mut self) -> [f32; 3] {
        loop {
            let v = [0; 3].map(|_| 2.0 * self.unit() - 1.0);
            let s: f32 = v.iter().map(|x| x * x).sum();
            if s < 1.0 && s > 0.01 {
                return v.map(|x| x / s.sqrt());
            }
        }
    }
}

fn morton(i: usize) -> (usize, usize) {
    let mut p = (0, 0);
    for b in 0..10 {
        p.0 |= (i >> (2 * b) & 1) << b;
        p.1 |= (i >> (2 * b + 1) & 1) << b;
    }
    p
}

fn time(f: &mut dyn FnMut()) -> f64 {
    f();
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        f();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let moved: f64 = args.get(2).map_or(0.0, |x| x.parse().unwrap());
    let corners = load(&args[1]);
    let tris: Vec<Triangle> = corners.iter().map(|&c| Triangle(c)).collect();
    let up = |v: [f32; 3]| v.map(|x| f64::from(x) + moved);
    let tris64: Vec<Triangle64> = corners.iter().map(|c| Triangle64(c.map(up))).collect();
    let build32 = time(&mut || drop(black_box(Bvh::new(&tris).unwrap())));
    let build64 = time(&mut || drop(black_box(Bvh::new(&tris64).unwrap())));
    let (bvh, bvh64) = (Bvh::new(&tris).unwrap(), Bvh::new(&tris64).unwrap());
    println!(
        "{} triangles, build {:.1} ms, f64 {:.1} ms: {:.2}",
        tris.len(),
        build32 * 1e3,
        build64 * 1e3,
        build64 / build32
    );
    let [lo, hi] = bvh.bounds().unwrap();
    let mid = [0, 1, 2].map(|k| 0.5 * (lo[k] + hi[k]));
    let size = (0..3).map(|k| hi[k] - lo[k]).fold(0.0, f32::max);
    let eye = [mid[0] + 0.3 * size, mid[1] + 0.4 * size, mid[2] + 1.3 * size];
    let mode = Exact::default();

    // Primary.
    let look = [0, 1, 2].map(|k| mid[k] - eye[k]);
    let n = 1 << 20;
    let right = [look[2], 0.0, -look[0]];
    let rl = right.iter().map(|x| x * x).sum::<f32>().sqrt();
    let ll = look.iter().map(|x| x * x).sum::<f32>().sqrt();
    let right = right.map(|x| x / rl * ll);
    let upv = [0, 1, 2].map(|k| {
        let (a, b) = ((k + 1) % 3, (k + 2) % 3);
        (right[a] * look[b] - right[b] * look[a]) / ll
    });
    let primary: Vec<Ray> = (0..n)
        .map(|i| {
            let (x, y) = morton(i);
            let (x, y) = ((x as f32 - 511.5) / 1400.0, (y as f32 - 511.5) / 1400.0);
            Ray::new(eye, [0, 1, 2].map(|k| look[k] + x * right[k] + y * upv[k]))
        })
        .collect();
    let mut hits = vec![Hit::MISS; n];
    bvh.closest_batch(&mode, &primary, &mut hits);
    let light = [mid[0] - 0.9 * size, mid[1] + 1.5 * size, mid[2] + 0.8 * size];
    let mut rng = Rng(7);
    let (mut shadow, mut diffuse) = (vec![], vec![]);
    for (ray, hit) in primary.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        let p = hit.point(ray);
        let nrm = tris[hit.triangle as usize].normal();
        let l = nrm.iter().map(|x| x * x).sum::<f64>().sqrt();
        let side = if (0..3).map(|k| nrm[k] * f64::from(ray.dir[k])).sum::<f64>() > 0.0 {
            -1.0
        } else {
            1.0
        };
        let o = [0, 1, 2].map(|k| (p[k] + side * nrm[k] / l * f64::from(size) * 1e-4) as f32);
        shadow.push(Ray::new(o, [0, 1, 2].map(|k| light[k] - o[k])).between(0.0, 1.0));
        let d = rng.dir();
        diffuse.push(Ray::new(o, [0, 1, 2].map(|k| (side * nrm[k] / l) as f32 * 1.01 + d[k])));
    }
    let to64 = |rays: &[Ray]| -> Vec<Ray64> {
        rays.iter()
            .map(|r| Ray64 {
                origin: up(r.origin),
                t_min: r.t_min.into(),
                dir: r.dir.map(f64::from),
                t_max: r.t_max.into(),
            })
            .collect()
    };
    for (name, rays, any) in
        [("primary", &primary, false), ("shadow", &shadow, true), ("diffuse", &diffuse, false)]
    {
        let rays64 = to64(rays);
        let n = rays.len();
        let (mut h, mut h64) = (vec![Hit::MISS; n], vec![Hit::MISS; n]);
        let (mut a, mut a64) = (vec![false; n], vec![false; n]);
        let (mut t, mut t64) = (vec![0; n], vec![0; n]);
        let mut u = (0, 0);
        if any {
            let x = time(&mut || u.0 = bvh.any_batch(&mode, rays, &mut a).undecided);
            let y = time(&mut || u.1 = bvh64.any_batch(&mode, &rays64, &mut a64).undecided);
            let differ = a.iter().zip(&a64).filter(|(a, b)| a != b).count();
            println!(
                "{name}: {:.2} M/s, f64 {:.2}: {:.3}  differ {differ}  undecided/ray {:.4} {:.4}",
                n as f64 / x / 1e6,
                n as f64 / y / 1e6,
                x / y,
                u.0 as f64 / n as f64,
                u.1 as f64 / n as f64
            );
        } else {
            let x = time(&mut || u.0 = bvh.closest_batch(&mode, rays, &mut h).undecided);
            let y = time(&mut || u.1 = bvh64.closest_batch(&mode, &rays64, &mut h64).undecided);
            let differ = h
                .iter()
                .zip(&h64)
                .filter(|(a, b)| a.triangle != b.triangle || moved == 0.0 && a != b)
                .count();
            println!(
                "{name}: {:.2} M/s, f64 {:.2}: {:.3}  differ {differ}  undecided/ray {:.4} {:.4}",
                n as f64 / x / 1e6,
                n as f64 / y / 1e6,
                x / y,
                u.0 as f64 / n as f64,
                u.1 as f64 / n as f64
            );
            let x = time(&mut || {
                bvh.triangles_batch(&mode, rays, &mut t);
            });
            let y = time(&mut || {
                bvh64.triangles_batch(&mode, &rays64, &mut t64);
            });
            println!(
                "{name} triangles: {:.2} M/s, f64 {:.2}: {:.3}",
                n as f64 / x / 1e6,
                n as f64 / y / 1e6,
                x / y
            );
        }
    }
}

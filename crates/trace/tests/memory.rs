//! Tests that the library never aborts the process when memory runs out. Calls that can return an
//! error must do so, and all other calls must still return correct results. Each call is repeated,
//! and a different allocation fails each time.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::process::Command;
use std::ptr::null_mut;

use intertri_trace::internal::on_this_thread;
use intertri_trace::intertri::{Hit, Ray, Ray64, Triangle, Triangle64};
use intertri_trace::{Bvh, ClosestPoint, Containment, Media, Solid};

/// Allocations of at least this many bytes can fail. Smaller allocations always succeed. They
/// include each thread's scratch memory, whose size is fixed.
const LEAST: usize = 1 << 19;

/// The system allocator, with a switch that makes one of a thread's allocations fail.
struct Failing;

std::thread_local! {
    /// The number of large allocations that succeed before one fails. If it is negative, all
    /// allocations succeed.
    static LEFT: Cell<i64> = const { Cell::new(-1) };
    static HAS_FAILED: Cell<bool> = const { Cell::new(false) };
}

/// Returns whether an allocation of `size` bytes must fail, and counts the allocation if it is
/// large.
fn fails(size: usize) -> bool {
    if size < LEAST || LEFT.get() < 0 {
        return false;
    }
    LEFT.set(LEFT.get() - 1);
    let fails = LEFT.get() < 0;
    HAS_FAILED.set(HAS_FAILED.get() || fails);
    fails
}

// SAFETY: each method forwards to the system allocator or returns null, which reports failure.
unsafe impl GlobalAlloc for Failing {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller upholds the same contract.
        if fails(layout.size()) { null_mut() } else { unsafe { System.alloc(layout) } }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller upholds the same contract.
        if fails(layout.size()) { null_mut() } else { unsafe { System.alloc_zeroed(layout) } }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller upholds the same contract.
        if fails(size) { null_mut() } else { unsafe { System.realloc(memory, layout, size) } }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller upholds the same contract.
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Failing = Failing;

/// Repeats a call, failing its first allocation, then its second, and so on, until the call makes
/// no more allocations that could fail. Returns the number of allocations that were made to fail.
/// `call` must return true if the result is correct, and false if it is an error.
fn exhaust(name: &str, mut call: impl FnMut() -> bool) -> usize {
    for allocation in 0.. {
        // If the program aborts, this line is the last one printed.
        println!("{name}: allocation {allocation} fails");
        LEFT.set(allocation);
        HAS_FAILED.set(false);
        let is_done = on_this_thread(&mut call);
        LEFT.set(-1);
        if !HAS_FAILED.get() {
            assert!(is_done, "{name} fails although no allocation failed");
            return allocation as usize;
        }
    }
    unreachable!("a call never stops allocating memory")
}

/// Returns a closed, bumpy ball of `rings` rings. The triangles at its poles are needles or have
/// zero area.
fn ball(rings: usize) -> Vec<Triangle64> {
    let point = |i: usize, j: usize| {
        let (a, b) = (i as f64 / rings as f64, (j % (2 * rings)) as f64 / rings as f64);
        let (a, b) = (a * std::f64::consts::PI, b * std::f64::consts::PI);
        let size = 1.0 + 0.1 * (5.0 * a).sin() * (4.0 * b).cos();
        match i {
            0 => [0.0, 0.0, 1.0],
            _ if i == rings => [0.0, 0.0, -1.0],
            _ => [size * a.sin() * b.cos(), size * a.sin() * b.sin(), size * a.cos()],
        }
    };
    let squares = (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j)));
    let halves = |(i, j): (usize, usize)| {
        let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
        [Triangle64([a, b, c]), Triangle64([a, c, d])]
    };
    squares.flat_map(halves).collect()
}

fn in_f32(triangles: &[Triangle64]) -> Vec<Triangle> {
    triangles.iter().map(|t| Triangle(t.0.map(|corner| corner.map(|x| x as f32)))).collect()
}

/// Checks the calls that allocate a lot of memory: each must return either an error or the same
/// result as when no allocation fails.
macro_rules! calls {
    ($scalar:ty, $ray:ident, $triangles:expr) => {{
        let triangles = $triangles;
        let moved: Vec<_> = triangles.iter().rev().copied().collect();
        let bvh = Bvh::new(&triangles).unwrap();
        let saved = bvh.to_bytes();
        let rays: Vec<_> = (0..200_000)
            .map(|i| {
                let (x, y) =
                    ((i % 200) as $scalar / 100.0 - 1.0, (i / 200) as $scalar / 500.0 - 1.0);
                $ray::new([x, y, 3.0], [0.01, 0.02, -1.0])
            })
            .collect();
        let points: Vec<[$scalar; 3]> =
            rays.iter().map(|ray| [ray.origin[0], ray.origin[1], 0.1]).collect();
        let is_same = |made: &Bvh<$scalar>| {
            let probes = rays.iter().step_by(777);
            probes.clone().all(|ray| made.closest(ray) == bvh.closest(ray))
        };
        let positions: Vec<[$scalar; 3]> = triangles.iter().flat_map(|t| t.0).collect();
        let faces: Vec<[u32; 3]> =
            (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let solid = Solid::assume_closed_bvh(bvh.clone());
        let mut some = 0;
        let mut check = |name: &str, call: &mut dyn FnMut() -> bool| {
            let failed = exhaust(&format!("{name} of {}", stringify!($scalar)), call);
            some += usize::from(failed > 0);
        };
        let without = |work: &mut dyn FnMut() -> bool| {
            // Allocations made by the check itself must not fail.
            let left = LEFT.replace(-1);
            let holds = work();
            LEFT.set(left);
            holds
        };
        let is_right = |made: Result<Bvh<$scalar>, _>| match made {
            Ok(made) => without(&mut || {
                assert!(is_same(&made));
                true
            }),
            Err::<_, Box<dyn std::error::Error>>(error) => without(&mut || {
                let text = error.to_string();
                assert!(text.contains("memory"), "{text}");
                false
            }),
        };
        check("new", &mut || is_right(Bvh::new(&triangles).map_err(Into::into)));
        check("from_meshes", &mut || {
            is_right(Bvh::from_meshes(&[&triangles]).map(Bvh::into_one_mesh).map_err(Into::into))
        });
        check("from_indexed", &mut || {
            is_right(Bvh::from_indexed(&positions, &faces).map_err(Into::into))
        });
        check("try_clone", &mut || is_right(bvh.try_clone().map_err(Into::into)));
        check("from_bytes", &mut || is_right(Bvh::from_bytes(&saved).map_err(Into::into)));
        check("read_from", &mut || is_right(Bvh::read_from(&saved[..]).map_err(Into::into)));
        let file = std::env::temp_dir().join(format!("intertri-memory-{}", std::process::id()));
        std::fs::write(&file, &saved).unwrap();
        check("load", &mut || is_right(Bvh::load(&file).map_err(Into::into)));
        std::fs::remove_file(&file).unwrap();
        check("refit", &mut || {
            let mut other = without_failing(|| bvh.clone());
            let refit = other.refit(&moved).and_then(|_| other.refit(&triangles));
            match refit {
                Ok(_) => is_right(Ok(other)),
                Err(error) => is_right(Err(error.into())),
            }
        });
        check("write_to", &mut || {
            let mut bytes = without_failing(|| Vec::with_capacity(saved.len()));
            bvh.write_to(&mut bytes).map(|()| assert_eq!(bytes.len(), saved.len())).is_ok()
        });
        check("all_batch", &mut || match bvh.all_batch(&rays) {
            Ok(lists) => without(&mut || {
                let probes = (0..rays.len()).step_by(777);
                probes.clone().all(|i| *lists.of(i) == bvh.all(&rays[i])[..])
            }),
            Err(_) => false,
        });
        check("crossings_batch", &mut || match bvh.crossings_batch(&rays) {
            Ok(lists) => without(&mut || {
                let probes = (0..rays.len()).step_by(777);
                probes.clone().all(|i| *lists.of(i) == bvh.crossings(&rays[i])[..])
            }),
            Err(_) => false,
        });
        check("check_closed", &mut || {
            let closed = Solid::check_closed(&triangles);
            closed
                .map_err(|error| without_failing(|| assert!(error.to_string().contains("memory"))))
                .is_ok()
        });
        check("from_soup", &mut || {
            is_right(Solid::from_soup(&triangles).map(Solid::into_bvh).map_err(Into::into))
        });
        check("inspect", &mut || match Solid::inspect(&triangles[1..]) {
            Ok(report) => without(&mut || !report.is_closed()),
            Err(error) => without(&mut || {
                assert!(error.to_string().contains("memory"));
                false
            }),
        });
        check("Solid::new", &mut || {
            is_right(Solid::new(&triangles).map(Solid::into_bvh).map_err(Into::into))
        });

        check("Media::new", &mut || {
            let made = Media::new(&[(7, &triangles[..])]);
            let made = made.map(|media| without_failing(|| media.bvh().clone().into_one_mesh()));
            is_right(made.map_err(Into::into))
        });
        let media = Media::new(&[(7, &triangles[..])]).unwrap();
        check("segments_batch", &mut || match media.segments_batch(&rays) {
            Ok(lists) => without_failing(|| {
                (0..rays.len()).step_by(777).all(|i| *lists.of(i) == media.segments(&rays[i])[..])
            }),
            Err(_) => false,
        });
        check("next_crossing_batch", &mut || match media.next_crossing_batch(&rays) {
            Ok(next) => without_failing(|| {
                (0..rays.len()).step_by(777).all(|i| next[i] == media.next_crossing(&rays[i]))
            }),
            Err(_) => false,
        });
        check("medium_at_batch", &mut || match media.medium_at_batch(&points) {
            Ok(found) => without_failing(|| {
                (0..points.len()).step_by(777).all(|i| found[i] == media.medium_at(points[i]))
            }),
            Err(_) => false,
        });

        // These calls cannot return an error; if memory runs out, they make do with less.
        check("classify_batch_into", &mut || {
            let mut all = without_failing(|| vec![Containment::Outside; points.len()]);
            solid.classify_batch_into(&points, &mut all);
            without_failing(|| {
                let probes = (0..points.len()).step_by(777);
                probes.clone().all(|i| all[i] == solid.classify(points[i]))
            })
        });
        check("classify_grid_into", &mut || {
            let axis: Vec<$scalar> = (0..60).map(|i| i as $scalar / 25.0 - 1.2).collect();
            let mut all = without_failing(|| vec![Containment::Outside; 60 * 60 * 60]);
            solid.classify_grid_into([&axis, &axis, &axis], &mut all);
            without_failing(|| {
                let point = |i: usize| [axis[i / 3600], axis[i / 60 % 60], axis[i % 60]];
                (0..all.len()).step_by(777).all(|i| all[i] == solid.classify(point(i)))
            })
        });
        check("signed_distance_batch", &mut || {
            let (points, mut far) = (&points[..20_000], without_failing(|| vec![0.0; 20_000]));
            solid.signed_distance_batch_into(points, &mut far);
            without_failing(|| {
                (0..20_000).step_by(777).all(|i| far[i] == solid.signed_distance(points[i]))
            })
        });
        check("closest_point_batch", &mut || {
            let (points, mut near) =
                (&points[..20_000], without_failing(|| vec![ClosestPoint::NONE; 20_000]));
            bvh.closest_point_batch_into(points, f64::INFINITY, &mut near);
            near.iter().all(|near| near.distance.is_finite())
        });
        check("closest_batch", &mut || {
            let mut hits = without_failing(|| vec![Hit::MISS; rays.len()]);
            bvh.query().closest_batch_into(&rays, &mut hits);
            hits.iter().any(|hit| hit.is_hit())
        });
        assert!(some >= 19, "only {some} calls had an allocation that could fail");
    }};
}

/// Runs part of the check without making any allocation fail.
fn without_failing<T>(work: impl FnOnce() -> T) -> T {
    let left = LEFT.replace(-1);
    let made = work();
    LEFT.set(left);
    made
}

/// [`no_allocation_that_fails_aborts`] runs this test in a child process, which can abort without
/// ending the other tests.
#[test]
#[ignore = "run in a child process by no_allocation_that_fails_aborts"]
fn all_calls() {
    let triangles = ball(200);
    calls!(f32, Ray, in_f32(&triangles));
    calls!(f64, Ray64, triangles);
}

#[test]
fn no_allocation_that_fails_aborts() {
    let mut child = Command::new(std::env::current_exe().unwrap());
    let output = child.args(["--exact", "all_calls", "--ignored", "--nocapture"]).output().unwrap();
    let (told, error) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let last: Vec<&str> = told.lines().filter(|line| line.contains("allocation")).collect();
    assert!(output.status.success(), "{:?}\n{error}", last.last());
    assert!(last.len() > 100, "only {} allocations failed", last.len());
}

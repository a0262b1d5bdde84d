//! Tests which types are `Send` and `Sync`, and on which threads batches run.

use std::sync::mpsc::channel;
use std::sync::{Arc, Barrier};
use std::time::Duration;

use intertri::{Ray, Triangle};
use intertri_lab::rng::Rng;
use intertri_trace::{Bvh, ClosestPoint, CrossingLists, HitLists, Query, Solid};

/// Compiles only if hierarchies can be shared between threads and queries can be sent to other
/// threads.
#[test]
fn types_can_be_sent_and_shared() {
    fn shared<T: Send + Sync + 'static>() {}
    fn sent<T: Send>() {}
    shared::<Bvh<f32>>();
    shared::<Bvh<f64>>();
    shared::<Solid<f32>>();
    shared::<Solid<f64>>();
    shared::<HitLists>();
    shared::<CrossingLists>();
    shared::<ClosestPoint>();
    sent::<Query<'_, f32>>();
    sent::<Query<'_, f64>>();
}

/// Returns a mesh and rays toward it: some from random points, and a bundle from one point.
fn scene() -> (Vec<Triangle>, Vec<Ray>) {
    let mut rng = Rng::new(1);
    let f32s = |v: [f64; 3]| v.map(|x| x as f32);
    let triangle = |_| {
        let at = rng.cube();
        let mut corner = || {
            let off = rng.cube();
            f32s([0, 1, 2].map(|k| at[k] + 0.1 * off[k]))
        };
        Triangle([corner(), corner(), corner()])
    };
    let triangles: Vec<Triangle> = (0..3000).map(triangle).collect();
    let mut rays: Vec<Ray> =
        (0..4000).map(|_| Ray::new(f32s(rng.cube()), f32s(rng.cube()))).collect();
    rays.extend((0..4000).map(|i| {
        let [x, y] = [i % 64, i / 64].map(|k| k as f32 / 64.0 - 0.5);
        Ray::new([0.0, 0.0, -3.0], [x, y, 1.0])
    }));
    (triangles, rays)
}

/// Checks that all batches of a query return the same results as on a single thread.
fn batches_agree(query: &Query<'_>, alone: &Query<'_>, rays: &[Ray]) {
    assert_eq!(query.closest_batch(rays), alone.closest_batch(rays));
    assert_eq!(query.any_batch(rays), alone.any_batch(rays));
    assert_eq!(query.closest_triangle_batch(rays), alone.closest_triangle_batch(rays));
    assert_eq!(query.count_crossings_batch(rays), alone.count_crossings_batch(rays));
    let [hits, of_one] = [query, alone].map(|query| query.all_batch(rays, Some(3)).unwrap());
    assert_eq!((hits.offsets, hits.items), (of_one.offsets, of_one.items));
    let [crossings, of_one] =
        [query, alone].map(|query| query.crossings_batch(rays, None).unwrap());
    assert_eq!((crossings.offsets, crossings.items), (of_one.offsets, of_one.items));
    let segments: Vec<[[f32; 3]; 2]> = rays.iter().map(|ray| [ray.origin, ray.dir]).collect();
    assert_eq!(query.visible_batch(&segments), alone.visible_batch(&segments));
}

#[test]
fn answers_do_not_depend_on_threads() {
    let (triangles, rays) = scene();
    let bvh = Bvh::new(&triangles).unwrap();
    let alone = bvh.query().on_this_thread();
    batches_agree(&bvh.query(), &alone, &rays);
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| batches_agree(&bvh.query(), &alone, &rays));
        // A hierarchy built in the pool must also be the same.
        let built = pool.install(|| Bvh::new(&triangles).unwrap());
        assert!(built.to_bytes() == bvh.to_bytes());
    }
    // Send a query to another thread.
    let mut query = bvh.query();
    let want: Vec<_> = rays.iter().map(|ray| bvh.closest(ray)).collect();
    let found = std::thread::scope(|scope| {
        let trace = move || rays.iter().map(|ray| query.closest(ray)).collect::<Vec<_>>();
        scope.spawn(trace).join().unwrap()
    });
    assert!(found == want);
}

/// While all threads of the global pool are busy, a batch on the calling thread must complete, and
/// so must a batch in the caller's own pool. Neither may wait for the global pool.
#[test]
fn batches_run_where_they_are_told_to() {
    let (triangles, rays) = scene();
    let bvh = Bvh::new(&triangles).unwrap();
    let want = bvh.closest_batch(&rays);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();

    // Every thread of the global pool reaches the first barrier, and then waits until the test
    // releases it.
    let all_are_busy = Arc::new(Barrier::new(rayon::current_num_threads() + 1));
    let released = Arc::new(Barrier::new(rayon::current_num_threads() + 1));
    let (busy, end) = (all_are_busy.clone(), released.clone());
    rayon::spawn_broadcast(move |_| {
        busy.wait();
        end.wait();
    });
    all_are_busy.wait();

    let (to, answers) = channel();
    std::thread::scope(|scope| {
        let (bvh, rays, pool) = (&bvh, &rays, &pool);
        scope.spawn(move || {
            to.send(bvh.query().on_this_thread().closest_batch(rays)).unwrap();
            to.send(pool.install(|| bvh.closest_batch(rays))).unwrap();
        });
        let [alone, in_pool] = [(); 2].map(|()| answers.recv_timeout(Duration::from_secs(100)));
        released.wait();
        assert!(alone.expect("the batch does not wait for the pool") == want);
        assert!(in_pool.expect("the batch does not wait for the global pool") == want);
    });
}

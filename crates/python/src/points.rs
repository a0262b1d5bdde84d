//! Runs queries for many points in the order of a space-filling curve, so that points close to each
//! other are queried one after another.

use std::collections::TryReserveError;

use bytemuck::Pod;
use intertri_trace::{Containment, Solid};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::mesh::Mesh;
use crate::output::{Bytes, FEW as FEW_COORDINATES, Threads, rows};
use crate::pool::{Workers, chunks, is_caller};
use crate::run::{Stop, pieces, run};
use crate::scalar::{Scalar, no_memory, wrong};

/// The number of points that a thread takes at a time.
const CHUNK: usize = 4096;

/// The number of points in a slab; see [`by_slabs`].
const SLAB: usize = 1 << 20;

/// The minimum number of points to sort. Fewer points are queried in the given order.
const FEW: usize = 512;

/// The number of points that are sorted together.
const MANY: usize = 1 << 22;

/// The winding number that marks a point on the mesh.
pub(crate) const SURFACE: i32 = i32::MIN;

/// Runs a query with one answer per point. `none` is an arbitrary initial value. Answers do not
/// depend on the order of the points.
pub(crate) fn of_points<S: Scalar, A: Copy + Send + Sync>(
    py: Python<'_>,
    workers: &Workers,
    points: &[S],
    (answers, none): (&mut [A], A),
    ask: impl Fn(&[[S; 3]], &mut [A]) + Sync,
) -> PyResult<()> {
    let points: &[[S; 3]] = bytemuck::cast_slice(points);
    run(py, workers, |stop| {
        for (points, answers) in points.chunks(MANY).zip(answers.chunks_mut(MANY)) {
            by_halves(points, (answers, none), &ask, stop);
        }
    })
}

/// Answers all points together. If there is not enough memory, answers each half separately.
fn by_halves<S: Scalar, A: Copy + Send + Sync>(
    points: &[[S; 3]],
    (answers, none): (&mut [A], A),
    ask: &(impl Fn(&[[S; 3]], &mut [A]) + Sync),
    stop: &Stop,
) {
    if points.len() < FEW {
        pieces(points.len(), stop, |range| ask(&points[range.clone()], &mut answers[range]));
    } else if in_order(points, (answers, none), ask, stop).is_err() {
        let half = points.len() / 2;
        let (answers, others) = answers.split_at_mut(half);
        by_halves(&points[..half], (answers, none), ask, stop);
        by_halves(&points[half..], (others, none), ask, stop);
    }
}

/// Answers points in the order of the curve.
fn in_order<S: Scalar, A: Copy + Send + Sync>(
    points: &[[S; 3]],
    (answers, none): (&mut [A], A),
    ask: &(impl Fn(&[[S; 3]], &mut [A]) + Sync),
    stop: &Stop,
) -> Result<(), TryReserveError> {
    let order = order(points)?;
    let mut found = room(points.len())?;
    found.resize(points.len(), none);
    chunks(&mut found, CHUNK, Vec::new, |gathered, number, found| {
        let order = &order[number * CHUNK..][..found.len()];
        gathered.clear();
        gathered.extend(order.iter().map(|&(_, i)| points[i as usize]));
        pieces(found.len(), stop, |range| ask(&gathered[range.clone()], &mut found[range]));
    });
    for (&(_, i), found) in order.iter().zip(found) {
        answers[i as usize] = found;
    }
    Ok(())
}

/// Answers points with a function that orders them itself, in slabs small enough that Ctrl-C takes
/// effect soon.
fn by_slabs<S: Scalar, A: Send>(
    py: Python<'_>,
    workers: &Workers,
    points: &[S],
    answers: &mut [A],
    mut ask: impl FnMut(&[[S; 3]], &mut [A]) + Send,
) -> PyResult<()> {
    let points: &[[S; 3]] = bytemuck::cast_slice(points);
    run(py, workers, |stop| {
        for (points, answers) in points.chunks(SLAB).zip(answers.chunks_mut(SLAB)) {
            if !stop.is_set() {
                ask(points, answers);
            }
        }
    })
}

/// Fills `out` with converted answers, as many at a time as memory allows.
fn answer<S: Scalar, A: Clone, O>(
    points: &[[S; 3]],
    (all, none): (&mut Vec<A>, A),
    out: &mut [O],
    ask: impl Fn(&[[S; 3]], &mut [A]),
    meaning: impl Fn(&A) -> O,
) {
    let mut size = points.len().max(1);
    all.clear();
    while size > 1 && all.try_reserve_exact(size).is_err() {
        size /= 2;
    }
    all.resize(size, none);
    for (points, out) in points.chunks(size).zip(out.chunks_mut(size)) {
        let some = &mut all[..points.len()];
        ask(points, some);
        out.iter_mut().zip(some).for_each(|(out, one)| *out = meaning(one));
    }
}

/// Queries a mesh as a solid and fills `out` with the converted answers.
pub(crate) fn of_solid<S: Scalar, A: Clone + Send + Sync, O: Pod + Send>(
    py: Python<'_>,
    (mesh, assume_closed): (&Mesh<S>, bool),
    threads: Threads,
    (points, out): (&PyReadonlyArray1<'_, S>, &mut Bytes<'_>),
    none: A,
    ask: impl Fn(&Solid<S>, &[[S; 3]], &mut [A]) + Send + Sync,
    meaning: impl Fn(&A) -> O + Send + Sync,
) -> PyResult<()> {
    let points = points.as_slice()?;
    let out: &mut [O] = rows(out, points.len() / 3)?;
    let workers = Workers::new(threads, points.len() < FEW_COORDINATES)?;
    let solid = run(py, &workers, |_| mesh.solid(assume_closed))??;
    let mut all = Vec::new();
    by_slabs(py, &workers, points, out, |points, out| {
        let ask = |points: &[_], all: &mut [_]| ask(solid, points, all);
        answer(points, (&mut all, none.clone()), out, ask, &meaning);
    })
}

/// Returns the winding number of a mesh around a point, or `SURFACE` on the mesh.
pub(crate) fn winding(containment: Containment) -> i32 {
    match containment {
        Containment::Outside => 0,
        Containment::Inside(times) => times,
        Containment::Surface => SURFACE,
    }
}

/// The number of grid points that are classified at a time.
const CELLS: usize = 1 << 24;

/// Classifies the points of a grid as 0 (outside), 1 (inside), or 2 (on the mesh). Points along the
/// last axis are contiguous.
pub(crate) fn grid<S: Scalar>(
    solid: &Solid<S>,
    [x, y, z]: [&[S]; 3],
    out: &mut [u8],
) -> PyResult<()> {
    let count = x.len().checked_mul(y.len()).and_then(|count| count.checked_mul(z.len()));
    if count != Some(out.len()) {
        return Err(wrong("out has the wrong length"));
    }
    if out.is_empty() {
        return Ok(());
    }
    let row = z.len();
    let (slab, band) = ((CELLS / (y.len() * row)).max(1), (CELLS / row).clamp(1, y.len()));
    let mut all: Vec<Containment> = Vec::new();
    for (x, out) in x.chunks(slab).zip(out.chunks_mut(slab * y.len() * row)) {
        for (y, out) in y.chunks(band).zip(out.chunks_mut(x.len() * band * row)) {
            all.clear();
            all.try_reserve_exact(out.len()).map_err(no_memory)?;
            all.resize(out.len(), Containment::Outside);
            solid.classify_grid_into([x, y, z], &mut all);
            for (out, containment) in out.iter_mut().zip(&all) {
                *out = match containment {
                    Containment::Outside => 0,
                    Containment::Inside(_) => 1,
                    Containment::Surface => 2,
                };
            }
        }
    }
    Ok(())
}

/// Returns each point's position on the curve and its index, sorted by position.
fn order<S: Scalar>(points: &[[S; 3]]) -> Result<Vec<(u32, u32)>, TryReserveError> {
    let (mut lo, mut hi) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for k in 0..3 {
            let x: f64 = point[k].into();
            if x.is_finite() {
                (lo[k], hi[k]) = (lo[k].min(x), hi[k].max(x));
            }
        }
    }
    // A position has ten bits per axis. Coordinates that are not finite become 0 or the largest
    // value.
    let steps = [0, 1, 2].map(|k| 1023.0 / (hi[k] - lo[k]).max(f64::MIN_POSITIVE));
    let place = |(i, point): (usize, &[S; 3])| {
        let along = |k: usize| {
            let x: f64 = point[k].into();
            spread(((x - lo[k]) * steps[k]) as u32)
        };
        (along(0) << 2 | along(1) << 1 | along(2), i as u32)
    };
    let mut order = room(points.len())?;
    if is_caller() {
        order.extend(points.iter().enumerate().map(place));
        order.sort_unstable();
    } else {
        points.par_iter().enumerate().map(place).collect_into_vec(&mut order);
        order.par_sort_unstable();
    }
    Ok(order)
}

/// Creates an empty vector with capacity for `count` items.
fn room<T>(count: usize) -> Result<Vec<T>, TryReserveError> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(count)?;
    Ok(vector)
}

/// Spreads ten bits so that two zeros separate neighbouring bits.
fn spread(x: u32) -> u32 {
    let x = x.min(1023);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

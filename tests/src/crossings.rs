//! Compares the SIMD kernels of the `fixed` mode with the scalar i128 reference: packets and
//! blocks, at every width and every SIMD level.

use intertri::fixed::{
    Block, Crossing, IntWidth, Packet, Prepared, Ray, RayLanes, SeenTriangle, Triangle, scalar,
};
use intertri::simd::Lane;
use intertri::simd::{Level, Simd, WithSimd};

/// Eight rays, eight triangles, and the scalar reference's result for each pair.
struct Pairs<'a> {
    rays: &'a [Ray; 8],
    triangles: &'a [Triangle; 8],
    answers: [[Option<Crossing>; 8]; 8],
}

/// Compares the result for every ray and triangle, including the numerator and denominator of t.
/// Returns the number of pairs in which the ray crosses the triangle.
///
/// # Errors
/// Returns an error that describes the first difference.
pub fn check_crossings(rays: &[Ray; 8], triangles: &[Triangle; 8]) -> Result<usize, String> {
    let answers = rays.map(|ray| triangles.map(|triangle| scalar::crossing(&ray, &triangle)));
    let pairs = Pairs { rays, triangles, answers };
    Level::all().try_for_each(|level| level.run(&pairs))?;
    Ok(answers.as_flattened().iter().flatten().count())
}

impl WithSimd for &Pairs<'_> {
    type Output = Result<(), String>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Self::Output {
        self.blocks::<S, true, 8>()?;
        self.blocks::<S, false, 8>()?;
        self.blocks::<S, true, 4>()?;
        self.blocks::<S, false, 4>()?;
        self.packets::<S, true, 8>()?;
        self.packets::<S, false, 8>()?;
        self.packets::<S, true, 4>()?;
        self.packets::<S, false, 4>()
    }
}

impl Pairs<'_> {
    /// Tests each ray against blocks of N triangles.
    #[inline(always)]
    fn blocks<S: Simd, const FILTER: bool, const N: usize>(&self) -> Result<(), String>
    where
        Lane<N>: IntWidth,
    {
        for first in (0..8).step_by(N) {
            let chunk = self.triangles[first..first + N].iter().copied();
            let block = Block::<N>::new(chunk.zip(first as u32..));
            for (ray, answers) in self.rays.iter().zip(&self.answers) {
                let mut found = [None; 8];
                let mut twice = false;
                block.crossings_in::<S, FILTER>(&RayLanes::new(ray), |crossing, index| {
                    twice |= found[index as usize].replace(crossing).is_some();
                });
                same(&found[first..first + N], &answers[first..first + N], twice).map_err(
                    |why| {
                        let level = S::LEVEL.name();
                        format!("block {N} {FILTER} {level}: {why}\n{ray:?}\n{:?}", self.triangles)
                    },
                )?;
            }
        }
        Ok(())
    }

    /// Tests packets of N rays against each triangle. If all rays share an origin, also tests them
    /// against the [`SeenTriangle`]s from that origin.
    #[inline(always)]
    fn packets<S: Simd, const FILTER: bool, const N: usize>(&self) -> Result<(), String>
    where
        Lane<N>: IntWidth,
    {
        let origin = self.rays[0].origin();
        let shared = self.rays.iter().all(|ray| ray.origin() == origin);
        for first in (0..8).step_by(N) {
            let packet = Packet::<N>::new(&self.rays[first..]);
            for (t, triangle) in self.triangles.iter().enumerate() {
                let answers: [_; N] = core::array::from_fn(|lane| self.answers[first + lane][t]);
                let of = |form: &str, why: String| {
                    let level = S::LEVEL.name();
                    format!("{form} {N} {FILTER} {level}: {why}\n{packet:?}\n{triangle:?}")
                };
                let prepared = Prepared::new(triangle);
                let (mut found, mut twice) = ([None; N], false);
                packet.crossings_in::<S, FILTER>(&prepared, packet.live(), |lane, crossing| {
                    twice |= found[lane].replace(crossing).is_some();
                });
                same(&found, &answers, twice).map_err(|why| of("packet", why))?;
                if !shared {
                    continue;
                }
                let (mut found, mut twice) = ([None; N], false);
                if let Some(seen) = SeenTriangle::new(triangle, origin) {
                    let live = packet.live();
                    seen.crossings_in::<S, FILTER, N>(&packet, live, |lane, crossing| {
                        twice |= found[lane].replace(crossing).is_some();
                    });
                }
                same(&found, &answers, twice).map_err(|why| of("seen", why))?;
            }
        }
        Ok(())
    }
}

/// Compares the crossings that a kernel found with the scalar reference's. Each crossing must be
/// reported exactly once; `twice` is set if the kernel reported one more than once.
fn same(
    found: &[Option<Crossing>],
    answers: &[Option<Crossing>],
    twice: bool,
) -> Result<(), String> {
    let numbers = |c: &Option<Crossing>| c.map(|c| (c.t.num(), c.t.den(), c.v, c.w, c.leaves));
    if !twice && found.iter().map(numbers).eq(answers.iter().map(numbers)) {
        return Ok(());
    }
    let twice = if twice { ", one of them twice" } else { "" };
    Err(format!("found {found:?}{twice}\n scalar {answers:?}"))
}

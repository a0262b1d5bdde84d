//! Scans all pixels of an image, testing at each pixel the triangles that may affect the answer.
//!
//! The scan divides the image into bands of rows, which it processes on all threads. A band visits
//! the triangles whose footprint in the image, widened by the largest error, overlaps the band, and
//! tests each triangle only at the pixels that its footprint covers.

use intertri::{Hit, Triangle};
use rayon::prelude::*;

use super::arithmetic::Arithmetic;
use super::band::Band;
use super::camera::PinholeCamera;
use super::footprint::{Footprint, ScanInput};
use super::scan_result::ScanResult;
use super::vector::Vec3d;

/// The number of rows in a band.
const BAND: u32 = 16;

/// Finds the doubtful pixels of an image and the exact answers for every `every`-th pixel. If
/// `every` is 0, only the first pixel is sampled.
///
/// `seen` contains the hits of the pixels, row by row, computed in the reference's arithmetic with
/// a threshold of 0. If a pixel has several possible answers, `seen` may contain any of them. At
/// most 32 arithmetics can be compared.
///
/// # Panics
/// Panics if there are more than 32 arithmetics, or if `seen` does not have one entry per pixel.
pub fn scan(
    triangles: &[Triangle],
    camera: &PinholeCamera<'_>,
    seen: &[Hit],
    arithmetics: &[Arithmetic],
    every: usize,
    progress: &(dyn Fn(usize) + Sync),
) -> ScanResult {
    let (width, height) = camera.size;
    assert!(arithmetics.len() <= 32 && seen.len() == width as usize * height as usize);
    let input = ScanInput { triangles, camera, arithmetics, forward: Vec3d::splat(camera.axes[2]) };
    let footprints: Vec<Footprint> =
        (0..triangles.len()).into_par_iter().map(|i| input.footprint(&input.facet(i))).collect();

    let bands: Vec<u32> = (0..height).step_by(BAND as usize).collect();
    let done = bands.par_iter().map(|&first| {
        let rows = first..(first + BAND).min(height);
        let mut band = Band::new(&input, rows.clone(), seen, every);
        for (index, footprint) in footprints.iter().enumerate() {
            if footprint.strip || footprint.rows.start < rows.end && rows.start < footprint.rows.end
            {
                band.visit(index as u32, footprint);
            }
        }
        progress(rows.len());
        band.finish()
    });
    let bands: Vec<ScanResult> = done.collect();

    let mut all = ScanResult {
        doubtful: vec![0; arithmetics.len()],
        doubtful_in_sample: vec![0; arithmetics.len()],
        shift: vec![0.0; arithmetics.len()],
        sample: vec![],
    };
    for band in bands {
        for k in 0..arithmetics.len() {
            all.doubtful[k] += band.doubtful[k];
            all.doubtful_in_sample[k] += band.doubtful_in_sample[k];
            all.shift[k] = all.shift[k].max(band.shift[k]);
        }
        all.sample.extend(band.sample);
    }
    all
}

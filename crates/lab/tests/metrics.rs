//! Tests the rows of metrics: promises kept, and errors counted once more by other means.

use intertri::simd::Level;

use intertri_lab::families::{Case, FAMILIES, find};
use intertri_lab::methods::{METHODS, OF_THE_REFERENCE};
use intertri_lab::metrics::metrics;
use intertri_lab::oracle::rational;
use intertri_lab::rng::Rng;
use intertri_lab::test_batch::Answer;

#[test]
fn the_kernel_is_the_reference_on_every_family() {
    for family in FAMILIES {
        let rows = metrics(family, 2, 500, &|_| ());
        assert_eq!(rows.len(), METHODS.len());
        for row in &rows {
            assert_eq!(row.not_oracle, row.false_misses + row.false_hits);
            if OF_THE_REFERENCE.contains(&row.method) {
                // Document A's t may be infinite, which the kernel's interval excludes.
                assert!(row.not_reference <= row.t_not_finite, "{row:?}");
            }
        }
    }
}

#[test]
fn a_row_is_what_one_counts_by_hand() {
    // Count the errors again, one case at a time, with the oracle's second implementation.
    let family = find("random").unwrap();
    let rows = metrics(family, 6, 1000, &|_| ());
    for row in rows.iter().filter(|row| row.method != "fixed") {
        let method = METHODS.iter().find(|method| method.name == row.method).unwrap();
        let (mut hits, mut misses, mut wrong) = (0, 0, 0);
        for piece in 0..2 {
            let mut rng = Rng::new(6 ^ piece << 8);
            for _ in 0..500 {
                let Case { triangle, ray, threshold } = family.case(&mut rng);
                let is_hit = rational::answer(&triangle, &ray).is_hit();
                let mut to = [Answer::default()];
                method.pairs(Level::best(), threshold, &[triangle], &[ray], &mut to);
                hits += u64::from(is_hit);
                misses += u64::from(is_hit && !to[0].hit);
                wrong += u64::from(!is_hit && to[0].hit);
            }
        }
        assert_eq!((row.trials, row.true_hits), (1000, hits), "{}", row.method);
        assert_eq!((row.false_misses, row.false_hits), (misses, wrong), "{}", row.method);
        // Every f32 method makes errors on this family.
        let single = method.bits == 24;
        assert!(!single || misses > 0 || wrong > 0, "{}", row.method);
    }
    let robust = rows.iter().find(|row| row.method == "Embree robust f32").unwrap();
    let plain = rows.iter().find(|row| row.method == "Möller–Trumbore f32").unwrap();
    assert!(robust.false_hits > 20 && plain.false_misses > 5, "{robust:?} {plain:?}");
}

#[test]
fn errors_are_of_the_size_of_the_precision() {
    let rows = metrics(find("uniform").unwrap(), 2, 4000, &|_| ());
    assert_eq!(rows, metrics(find("uniform").unwrap(), 2, 4000, &|_| ()));
    for row in rows.iter().filter(|row| row.method != "fixed") {
        let single = row.method.ends_with("f32");
        let typical = if single { 1e-9..1e-6 } else { 1e-18..1e-15 };
        assert!(typical.contains(&row.t_median), "{row:?}");
        assert!(row.t_trials > 100 && row.t_ulps_median < 8.0, "{row:?}");
        assert!(row.t_median <= row.t_p999 && row.t_p999 <= row.t_worst, "{row:?}");
    }
}

#[test]
fn closed_meshes_leak_where_they_should() {
    let rows = metrics(find("icosphere-exact").unwrap(), 2, 8000, &|_| ());
    let row = |name: &str| rows.iter().find(|row| row.method == name).unwrap();
    assert!(row("fixed").closed_trials > 200);
    assert_eq!((row("fixed").leaks, row("fixed").doubles), (0, 0));
    assert!(row("Möller–Trumbore f32").leaks > 0);
    assert!(row("Woop f32").leaks == 0 && row("Woop f32").doubles > 100);
}

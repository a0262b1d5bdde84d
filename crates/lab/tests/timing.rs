//! Tests that every method is timed.

use intertri::simd::Level;

use intertri_lab::methods::METHODS;
use intertri_lab::timing::{REFERENCE, measure};
use intertri_lab::workloads::{Model, Workload};

#[test]
fn every_method_is_timed_in_every_layout_that_it_has() {
    let mut steps = 0;
    let times = measure(Workload::Secondary, &Model::built_in(), 2, || steps += 1);
    assert_eq!(steps, 3);
    assert_eq!(times[0].method, REFERENCE);
    assert_eq!(times[0].times_faster, 1.0);
    for method in METHODS {
        let own = times.iter().filter(|time| time.method == method.name);
        // Most methods are timed in two forms, but those for one origin do not support this
        // workload. Layouts with 16 lanes are counted separately, because not every CPU
        // supports them.
        let layouts = match method.name {
            "certified, one origin" | "exact, one origin" => 0,
            "certified" | "exact" | "exact, once" | "fixed" => 4,
            _ => 6,
        };
        let narrow = own.clone().filter(|time| time.lanes < 16);
        assert_eq!(narrow.count(), layouts, "{}", method.name);
        let wide = Level::best().name() == "avx512" && method.name.ends_with("f32");
        let of_16 = own.clone().filter(|time| time.lanes == 16 && time.form == "packs");
        assert!(of_16.count() == usize::from(wide) || !wide, "{}", method.name);
        assert!(own.clone().all(|time| time.ns_per_test > 0.0 && time.times_faster.is_finite()));
    }
}

//! Tests the error counts of each workload.

use intertri_lab::accuracy::{ErrorCounts, ON_GRID, count_errors};
use intertri_lab::methods::{EXACT, OF_THE_REFERENCE};
use intertri_lab::workloads::{Model, Workload};

fn of<'a>(error_counts: &'a [ErrorCounts], method: &str) -> &'a ErrorCounts {
    error_counts.iter().find(|errors| errors.method == method).unwrap()
}

#[test]
fn a_seed_gives_the_same_counts_and_promises_are_kept() {
    let model = Model::built_in();
    for workload in Workload::ALL {
        let error_counts = count_errors(workload, &model, 4, 3000, &|_| ());
        assert_eq!(error_counts, count_errors(workload, &model, 4, 3000, &|_| ()));
        assert_ne!(error_counts, count_errors(workload, &model, 5, 3000, &|_| ()), "{workload:?}");
        assert!(error_counts.iter().all(|errors| errors.trials > 2900), "{error_counts:?}");
        for method in OF_THE_REFERENCE
            .iter()
            .filter(|method| error_counts.iter().any(|v| v.method == **method))
        {
            assert_eq!(of(&error_counts, method).not_reference, 0, "{workload:?} {method}");
        }
        assert_eq!(of(&error_counts, ON_GRID).wrong, 0, "{workload:?}");
        for method in EXACT {
            let Some(exact) = error_counts.iter().find(|v| v.method == method) else {
                continue;
            };
            // If a ray hits an edge, the closed rule counts both triangles that share it.
            let doubles = if method == "exact, once" { exact.doubles } else { 0 };
            let wrong = exact.wrong - exact.doubles + doubles;
            assert_eq!((wrong, exact.leaks), (0, 0), "{workload:?} {method}");
        }
        // Every f32 method gives some wrong answers, mostly at edges.
        let plain = of(&error_counts, "Möller–Trumbore f32");
        match workload {
            Workload::Edges => assert!(plain.leaks > 30 && plain.doubles > 1000, "{plain:?}"),
            Workload::Mix => assert!(plain.wrong > 100, "{plain:?}"),
            _ => assert!(plain.wrong < 10, "{plain:?}"),
        }
    }
}

//! Tests the shares of wrong answers far from the coordinate origin.

use intertri::internal::exact;
use intertri::{Ray64, Rule, Triangle64};

use intertri_lab::stress::{CONTENDERS, InputPrecision, OffsetErrors, sweep_offsets};

#[test]
fn rounding_is_wrong_far_from_zero_and_exact_answers_never() {
    let exact = |triangles: &[Triangle64], rays: &[Ray64]| {
        let any =
            |ray: &Ray64| triangles.iter().any(|triangle| exact::hit(Rule::Closed, ray, triangle));
        rays.iter().map(any).collect()
    };
    let errors = sweep_offsets(5, 4, 2000, &exact);
    assert_eq!(errors, sweep_offsets(5, 4, 2000, &exact));
    assert_eq!(errors.len(), 4 * CONTENDERS.len());
    let of = |method, given| errors.iter().filter(move |e| e.method == method && e.given == given);
    for errors in of("exact", InputPrecision::AsGiven) {
        assert_eq!((errors.share(), errors.trials), (0.0, 2000));
    }
    // The distances range from a metre to a million kilometres, where the answers are little
    // better than chance.
    for (method, given) in CONTENDERS.iter().filter(|(_, given)| *given == InputPrecision::Rounded)
    {
        let shares: Vec<f64> = of(method, *given).map(OffsetErrors::share).collect();
        assert!(shares[0] < 0.25 && shares[3] > 0.3, "{method}: {shares:?}");
    }
    // Plain f64 leaks rays where the halves of a wall meet.
    assert!(of("Möller–Trumbore f64", InputPrecision::AsGiven).any(|errors| errors.share() > 0.0));
    // Both false misses and false hits occur.
    let told: Vec<_> = of("Embree robust f32", InputPrecision::Rounded).collect();
    assert!(told[3].false_misses > 100 && told[2].false_hits > 100, "{told:?}");
}

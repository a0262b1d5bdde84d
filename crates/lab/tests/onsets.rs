//! Tests where the methods begin to fail.

use intertri_lab::stress::{first, sweep_all};

#[test]
fn methods_fail_where_theory_says() {
    let onsets = sweep_all(8, 7, 600, &|| ());
    assert_eq!(onsets, sweep_all(8, 7, 600, &|| ()));
    let at = |sweep, method| first(&onsets, sweep, method);
    // A fixed epsilon suits only scenes of one scale. Products in f32 underflow at small scales
    // and overflow at large ones. A threshold on t rejects hits of rays with long directions.
    assert!(at("scale, down", "Möller–Trumbore ε f32").unwrap() > 1e-11);
    assert!(at("scale, down", "Möller–Trumbore f32").unwrap() < 1e-11);
    assert!(at("scale, up", "Möller–Trumbore f32").is_some());
    assert_eq!(at("scale, up", "Möller–Trumbore f64"), None);
    assert!(at("|dir|, long", "certified").is_some());
    assert_eq!(at("|dir|, long", "Möller–Trumbore f32"), None);
    // Constants computed in scene coordinates lose accuracy far from the coordinate origin;
    // differences of coordinates do not.
    assert!(at("offset, size 1", "Baldwin–Weber f32").is_some());
    assert_eq!(at("offset, size 1", "Embree fast f32"), None);
    // The kernel fails where the reference fails, and nowhere else.
    let certified = onsets.iter().filter(|onset| onset.method == "certified");
    assert!(certified.map(|onset| onset.not_reference).sum::<u64>() == 0);
}

//! Tests how the loops over all triangles handle ties, intervals, and the order of hits.

use intertri_reference::{Ray, Scene};

/// Returns triangles stacked at the given heights, along the line of `ray`.
fn layers(heights: &[f32]) -> Scene {
    Scene::from_triangles(heights.iter().map(|&z| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]]))
}

fn ray() -> Ray {
    Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 1.0])
}

const INF: f64 = f64::INFINITY;

#[test]
fn closest_is_the_smallest_t_and_the_lowest_number() {
    assert_eq!(layers(&[3.0, 2.0, 4.0]).closest(&ray(), 0.0, INF), Some((1, 2.0)));
    assert_eq!(layers(&[3.0, 2.0, 2.0]).closest(&ray(), 0.0, INF), Some((1, 2.0)));
    assert_eq!(layers(&[2.0, 2.0, 2.0]).closest(&ray(), 0.0, INF), Some((0, 2.0)));
    assert_eq!(layers(&[]).closest(&ray(), 0.0, INF), None);
    assert_eq!(layers(&[-1.0]).closest(&ray(), 0.0, INF), None);
}

#[test]
fn all_come_in_the_order_of_the_numbers() {
    let scene = layers(&[3.0, -2.0, 1.0, 3.0]);
    assert_eq!(scene.all(&ray(), 0.0, INF), [(0, 3.0), (2, 1.0), (3, 3.0)]);
}

#[test]
fn the_interval_is_closed_below_and_open_above() {
    let scene = layers(&[2.0, 3.0]);
    assert_eq!(scene.all(&ray(), 2.0, 3.0), [(0, 2.0)]);
    assert_eq!(scene.closest(&ray(), 2f64.next_up(), INF), Some((1, 3.0)));
    assert_eq!(scene.closest(&ray(), 0.0, 2.0), None);
    assert_eq!(scene.closest(&ray(), 0.0, 2f64.next_up()), Some((0, 2.0)));
    assert!(scene.any(&ray(), 3.0, 3f64.next_up()));
    assert!(!scene.any(&ray(), 3.0, 3.0));
    assert!(!scene.any(&ray(), 5.0, 1.0));
}

#[test]
fn nan_in_the_interval_refuses_everything() {
    let scene = layers(&[2.0]);
    for (t_min, t_max) in [(f64::NAN, INF), (0.0, f64::NAN)] {
        assert_eq!(scene.closest(&ray(), t_min, t_max), None);
        assert!(!scene.any(&ray(), t_min, t_max));
        assert!(scene.all(&ray(), t_min, t_max).is_empty());
    }
}

#[test]
fn the_threshold_still_holds_below_t_min() {
    let scene = layers(&[-1.0]);
    assert!(!scene.any(&ray(), -5.0, INF));
    assert!(scene.with_threshold(-2.0).any(&ray(), -5.0, INF));
}

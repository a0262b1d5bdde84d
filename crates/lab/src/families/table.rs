//! The table of all families and their adversarial mix.

use super::family::{Family, Param};
use super::scene::Case;
use super::{closed, limits, ranges, shapes};
use crate::rng::Rng;

/// Returns the family with a given name.
pub fn find(name: &str) -> Option<&'static Family> {
    FAMILIES.iter().find(|family| family.name == name)
}

/// Generates a case of the adversarial mix. Half of the cases are sensitive to rounding but
/// otherwise harmless; the others are drawn from all families with equal probability.
pub fn adversarial(rng: &mut Rng) -> Case {
    if rng.one_in(2) {
        let scene = shapes::random(rng, 1.0, 1, 1);
        return Case {
            triangle: scene.triangles[0],
            ray: scene.rays[0],
            threshold: scene.threshold,
        };
    }
    let family = rng.pick(FAMILIES);
    family.case(rng)
}

/// Every family, with the ordinary families first.
pub const FAMILIES: &[Family] = &[
    Family {
        name: "uniform",
        what: "random triangles, and random rays that are not aimed at them",
        param: None,
        make: shapes::uniform,
    },
    Family {
        name: "random",
        what: "random triangles with full mantissas; rays toward edges, vertices, and interiors",
        param: None,
        make: shapes::random,
    },
    Family {
        name: "edge-steps",
        what: "rays toward a point on an edge, moved by up to the given number of f32 steps",
        param: Some(Param { name: "steps", from: 1_048_576.0, to: 1.0 }),
        make: shapes::edge_steps,
    },
    Family {
        name: "icosphere",
        what: "a sphere, with rays very close to its edges and vertices",
        param: None,
        make: closed::icosphere,
    },
    Family {
        name: "torus",
        what: "a torus, with rays very close to its edges and vertices",
        param: None,
        make: closed::torus,
    },
    Family {
        name: "icosphere-exact",
        what: "a sphere on a grid with spacing 2^-18, with rays exactly at its edges and vertices",
        param: None,
        make: closed::icosphere_exact,
    },
    Family {
        name: "torus-exact",
        what: "a torus on a grid with spacing 2^-18, with rays exactly at its edges and vertices",
        param: None,
        make: closed::torus_exact,
    },
    Family {
        name: "cube-exact",
        what: "an integer cube, with rays exactly at its edges and vertices, many along an axis",
        param: None,
        make: closed::cube_exact,
    },
    Family {
        name: "needle",
        what: "two long sides and a short one",
        param: Some(Param { name: "ratio", from: 1.0, to: 1e-12 }),
        make: shapes::needle,
    },
    Family {
        name: "cap",
        what: "one corner almost at the middle of the opposite side",
        param: Some(Param { name: "ratio", from: 1.0, to: 1e-12 }),
        make: shapes::cap,
    },
    Family {
        name: "sliver",
        what: "one corner near the line through the opposite side",
        param: Some(Param { name: "ratio", from: 1.0, to: 1e-12 }),
        make: shapes::sliver,
    },
    Family {
        name: "zero-area",
        what: "collinear corners, or two or three corners that coincide",
        param: None,
        make: shapes::zero_area,
    },
    Family {
        name: "grazing",
        what: "rays at a small angle to the plane",
        param: Some(Param { name: "angle", from: 1.0, to: 1e-12 }),
        make: shapes::grazing,
    },
    Family {
        name: "coplanar",
        what: "rays in the plane of the triangle, exactly or up to rounding",
        param: None,
        make: shapes::coplanar,
    },
    Family {
        name: "far",
        what: "origins far away, in multiples of the triangle's size",
        param: Some(Param { name: "distance / size", from: 1.0, to: 1e9 }),
        make: shapes::far,
    },
    Family {
        name: "tiny",
        what: "small triangles at a distance of about 1 from the origin",
        param: Some(Param { name: "size", from: 1.0, to: 1e-7 }),
        make: shapes::tiny,
    },
    Family {
        name: "on-triangle",
        what: "rays that start on the triangle: inside, on an edge, at a vertex, or nearby",
        param: None,
        make: shapes::on_triangle,
    },
    Family {
        name: "stack",
        what: "copies of one triangle, identical or a few f32 steps apart",
        param: None,
        make: shapes::stack,
    },
    Family {
        name: "axis",
        what: "small-integer rays along axes, in coordinate planes, and through box faces",
        param: None,
        make: shapes::axis,
    },
    Family {
        name: "threshold-vd",
        what: "|nrm & dir| within a few f64 steps of the threshold",
        param: Some(Param { name: "threshold", from: 1e-15, to: 0.5 }),
        make: limits::threshold_vd,
    },
    Family {
        name: "threshold-t",
        what: "t within a few f64 steps of the threshold",
        param: Some(Param { name: "threshold", from: 1e-15, to: 1e3 }),
        make: limits::threshold_t,
    },
    Family {
        name: "threshold-default",
        what: "|nrm & dir| or t within a few f64 steps of 1e-9",
        param: None,
        make: limits::threshold_default,
    },
    Family {
        name: "threshold-met",
        what: "random rays, with the threshold within two f64 steps of |nrm & dir| or t",
        param: None,
        make: limits::threshold_met,
    },
    Family {
        name: "interval",
        what: "t_min or t_max within an f32 step of t; empty, reversed, NaN, or infinite intervals",
        param: None,
        make: limits::interval,
    },
    Family {
        name: "scale",
        what: "everything scaled except the direction",
        param: Some(Param { name: "scale", from: 1e-30, to: 1e30 }),
        make: ranges::scale,
    },
    Family {
        name: "offset",
        what: "everything moved away from the origin, with triangles of size 1",
        param: Some(Param { name: "offset", from: 1.0, to: 1e9 }),
        make: ranges::offset,
    },
    Family {
        name: "offset-large",
        what: "everything moved away, with triangles one ten-thousandth the size of the offset",
        param: Some(Param { name: "offset", from: 1.0, to: 1e9 }),
        make: ranges::offset_large,
    },
    Family {
        name: "direction",
        what: "short and long directions",
        param: Some(Param { name: "|dir|", from: 1e-30, to: 1e30 }),
        make: ranges::direction,
    },
    Family {
        name: "overflow",
        what: "coordinates near the largest f32",
        param: Some(Param { name: "size", from: 1e12, to: 3e38 }),
        make: ranges::overflow,
    },
    Family {
        name: "underflow",
        what: "coordinates near the smallest f32, subnormals included",
        param: Some(Param { name: "size", from: 1e-12, to: 1e-44 }),
        make: ranges::underflow,
    },
    Family {
        name: "zeros",
        what: "positive and negative zeros among a few other values",
        param: None,
        make: ranges::zeros,
    },
    Family { name: "bits", what: "arbitrary finite f32 inputs", param: None, make: ranges::bits },
    Family {
        name: "not-finite",
        what: "NaN and infinities in one to three of the 15 inputs, or in the interval",
        param: None,
        make: ranges::not_finite,
    },
];

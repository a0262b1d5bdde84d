//! Decides exactly, on a grid, whether points are inside a closed mesh:
//! `cargo run --example point_in_mesh`.

use intertri::Triangle;
use intertri::fixed::{Bits, Fixed, Grid, GridError, blocks};

fn main() -> Result<(), GridError> {
    // An octahedron of radius 3. Rays from lattice points run exactly through its edges and
    // corners. A test that counts an edge or a corner twice, or not at all, gives wrong answers.
    let mut faces = vec![];
    for x in [3.0, -3.0] {
        for y in [3.0, -3.0] {
            for z in [3.0, -3.0] {
                let (a, b, c) = ([x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]);
                // Order the corners counter-clockwise as seen from outside.
                let turned = x * y * z < 0.0;
                faces.push(if turned { Triangle([a, c, b]) } else { Triangle([a, b, c]) });
            }
        }
    }

    // Use 1024 grid steps per unit. `Grid::around` would find the finest grid that contains a set
    // of points.
    let grid = Grid::at(Bits::FINE, 10, [0; 3])?;
    let facets = faces.iter().map(|t| grid.triangle(t)).collect::<Result<Vec<_>, _>>()?;
    let solid = blocks(&facets);

    let mut inside = 0;
    for i in 0..729 {
        let point = [i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4].map(|k| k as f32);
        let contained = Fixed::default().contains(&solid, &grid, point)?;
        let from_middle: f32 = point.iter().map(|x| x.abs()).sum();
        // A point on the surface may count as inside or outside.
        assert!(from_middle == 3.0 || contained == (from_middle < 3.0), "{point:?}");
        inside += u32::from(contained);
    }
    println!("{inside} of 729 lattice points are inside");
    Ok(())
}

//! Reads and writes scenes as text. A failing test prints its scene in this format, so that you can
//! keep it as a fixture.
//!
//! ```text
//! # A comment.
//! threshold 0x3e112e0be826d695                     the bits of an f64
//! triangle 0x3f800000,0x00000000,...               nine f32: c1, c2, c3
//! ray 0x00000000,...                               eight f32: origin, t_min, dir, t_max
//! ```
//!
//! Numbers are written as hexadecimal bit patterns, because decimals cannot represent the bits of a
//! NaN.

use intertri::{Ray, Triangle};

use crate::Scene;

/// Writes a scene as text, preserving every bit, so that you can keep it as a fixture.
pub fn as_source(scene: &Scene) -> String {
    let bits = |x: &f32| format!("{:#010x}", x.to_bits());
    let list = |xs: Vec<String>| xs.join(",");
    let triangle = |t: &Triangle| list(t.0.iter().flatten().map(bits).collect());
    let ray = |r: &Ray| {
        let all = [&r.origin[..], &[r.t_min], &r.dir, &[r.t_max]].concat();
        list(all.iter().map(bits).collect())
    };
    let mut lines = vec![format!("threshold {:#018x}", scene.threshold.to_bits())];
    lines.extend(scene.triangles.iter().map(|t| format!("triangle {}", triangle(t))));
    lines.extend(scene.rays.iter().map(|r| format!("ray {}", ray(r))));
    lines.join("\n")
}

/// Reads a scene that [`as_source`] wrote. Skips empty lines and lines that begin with `#`.
///
/// # Errors
/// Returns an error if a line is invalid or the threshold is missing. The message contains the
/// number of the invalid line.
pub fn parse(text: &str) -> Result<Scene, String> {
    let (mut triangles, mut rays, mut threshold) = (Vec::new(), Vec::new(), None);
    for (number, line) in (1..).zip(text.lines().map(str::trim)) {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let wrong = |what: &str| format!("line {number}: {what}");
        let (word, values) = line.split_once(' ').ok_or_else(|| wrong("nothing after the word"))?;
        match word {
            "threshold" => threshold = Some(f64::from_bits(hex(values).map_err(|e| wrong(&e))?)),
            "triangle" => {
                let [a, b, c, d, e, f, g, h, i] = floats(values).map_err(|e| wrong(&e))?;
                triangles.push(Triangle([[a, b, c], [d, e, f], [g, h, i]]));
            }
            "ray" => {
                let [a, b, c, t_min, d, e, f, t_max] = floats(values).map_err(|e| wrong(&e))?;
                rays.push(Ray { origin: [a, b, c], t_min, dir: [d, e, f], t_max });
            }
            other => return Err(wrong(&format!("`{other}` is not threshold, triangle or ray"))),
        }
    }
    let threshold = threshold.ok_or("there is no threshold")?;
    Ok(Scene { triangles, rays, threshold })
}

fn hex(text: &str) -> Result<u64, String> {
    let digits = text.trim().strip_prefix("0x").unwrap_or("");
    u64::from_str_radix(digits, 16)
        .map_err(|_| format!("`{text}` is not hexadecimal like 0x3f800000"))
}

fn floats<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let float = |text: &str| {
        let bits = u32::try_from(hex(text)?).map_err(|_| format!("`{text}` is not 32 bits"))?;
        Ok(f32::from_bits(bits))
    };
    let all: Vec<f32> = text.split(',').map(float).collect::<Result<_, String>>()?;
    let count = all.len();
    all.try_into().map_err(|_| format!("expected {N} numbers, found {count}"))
}

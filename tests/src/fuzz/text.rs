//! Fuzzes ray files, the command line's number parsers, and the formatting of output numbers.

use intertri::Ray;
use intertri_scene::{LoadError, MAX_PIXELS, Rays, RaysFormat};

use super::input::Input;

// The command-line program is not a library, so include its source file directly. The file does not
// depend on the rest of the program.
#[path = "../../../crates/cli/src/io/numbers.rs"]
mod numbers;

/// Reads the bytes as a ray file in every format. The rays must not depend on the chunk size, and
/// must be unchanged after they are written and read again in each format. An error message must be
/// a single line.
pub fn rays(bytes: &[u8]) {
    let formats = [RaysFormat::Csv, RaysFormat::Raw, RaysFormat::Raw64].map(Some);
    for format in formats.into_iter().chain([None]) {
        let all = read(bytes, 1 << 30, None, format);
        assert_eq!(all, read(bytes, 1, None, format));
        assert_eq!(all, read(bytes, 7, None, format));
        // Passing the file size must not change the rays that are read, or whether the read fails.
        let sized = read(bytes, 100, Some(bytes.len() as u64), format);
        assert!(sized == all || sized.1.is_some() && all.1.is_some(), "{sized:?} {all:?}");
        let (rays, error) = all;
        assert!(rays.len() <= bytes.len());
        if let Some(error) = error {
            let text = error.to_string();
            assert!(text.starts_with("rays") && text.len() < 600, "{text}");
            assert!(!text.contains(char::is_control), "{text:?}");
        }
        written_again(&rays);
    }
}

/// Writes rays in every format, and checks that they read back unchanged.
fn written_again(rays: &[[u32; 8]]) {
    let raw: Vec<u8> = rays.iter().flatten().flat_map(|bits| bits.to_le_bytes()).collect();
    let again = read(&raw, 100, Some(raw.len() as u64), Some(RaysFormat::Raw));
    assert_eq!(again, (rays.to_vec(), None));

    // Neither text nor a conversion to f64 preserves the bits of a NaN.
    let bits = |x: f32| if x.is_nan() { 0 } else { x.to_bits() };
    let plain = |ray: &[u32; 8]| ray.map(f32::from_bits).map(bits);
    let wide = rays.iter().flatten().map(|&bits| f64::from(f32::from_bits(bits)));
    let raw64: Vec<u8> = wide.flat_map(f64::to_le_bytes).collect();
    let mut csv = String::from("\u{feff}\n t_max, \"dz\",dy,dx,t_min,oz,oy,ox\r\n");
    for ray in rays {
        // The decimal has enough digits that parsing it yields exactly the same number.
        let cells = ray.map(|bits| f64::from(f32::from_bits(bits)).to_string());
        csv += &cells.into_iter().rev().collect::<Vec<_>>().join(", ");
        csv += "\r\n";
    }
    for (bytes, format) in [(&raw64[..], Some(RaysFormat::Raw64)), (csv.as_bytes(), None)] {
        let (again, error) = read(bytes, 100, None, format);
        assert_eq!(error, None);
        assert!(again.iter().map(plain).eq(rays.iter().map(plain)));
    }
}

/// Returns the bits of all rays in raw-file order, or an error.
fn read(
    bytes: &[u8],
    count: usize,
    size: Option<u64>,
    format: Option<RaysFormat>,
) -> (Vec<[u32; 8]>, Option<LoadError>) {
    let mut file = match Rays::new("rays", bytes, size, format) {
        Ok(file) => file,
        Err(error) => return (Vec::new(), Some(error)),
    };
    let total = file.total();
    let (mut all, mut some) = (Vec::new(), Vec::new());
    let bits = |ray: &Ray| {
        let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.dir);
        [ox, oy, oz, ray.t_min, dx, dy, dz, ray.t_max].map(f32::to_bits)
    };
    loop {
        if let Err(error) = file.read(&mut some, count) {
            return (Vec::new(), Some(error));
        }
        if some.is_empty() {
            assert!(total.is_none_or(|total| total == all.len() as u64));
            return (all, None);
        }
        all.extend(some.iter().map(bits));
    }
}

/// Compares each of the command line's number parsers with a short model, and checks that decimals
/// in the output are short and read back to the same bits.
pub fn numbers(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let number = text.parse::<f64>().ok();
    let threshold = numbers::threshold(&text).ok().map(intertri::Threshold::get);
    assert_eq!(threshold, number.filter(|x| *x >= 0.0 && x.is_finite()), "{text:?}");

    let parts: Vec<&str> = text.split('x').collect();
    let size = match parts[..] {
        [width, height] => width.parse::<u32>().ok().zip(height.parse::<u32>().ok()),
        _ => None,
    };
    let good = |&(w, h): &(u32, u32)| w > 0 && h > 0 && u64::from(w) * u64::from(h) <= MAX_PIXELS;
    assert_eq!(numbers::size(&text).ok(), size.filter(good), "{text:?}");

    let bits = |p: [f32; 3]| p.map(f32::to_bits);
    let point = match text.split(',').map(str::trim).collect::<Vec<_>>()[..] {
        [x, y, z] => match [x, y, z].map(str::parse) {
            [Ok(x), Ok(y), Ok(z)] => Some([x, y, z]),
            _ => None,
        },
        _ => None,
    };
    assert_eq!(numbers::point(&text).ok().map(bits), point.map(bits), "{text:?}");
    for error in [
        numbers::threshold(&text).map(|_| ()).err(),
        numbers::size(&text).map(|_| ()).err(),
        numbers::point::<f32>(&text).map(|_| ()).err(),
    ] {
        assert!(error.is_none_or(|e| !e.contains(char::is_control) && e.len() < 200), "{text:?}");
    }

    let mut input = Input::new(bytes);
    for x in [number.unwrap_or(0.0), input.double(), f64::from(input.number())] {
        let text = numbers::Decimal(x).to_string();
        let back: f64 = text.parse().unwrap();
        assert!(back.to_bits() == x.to_bits() || x.is_nan() && back.is_nan(), "{x:e} {text}");
        assert!(text.len() <= 24, "{text}");
        let digits = text.split('e').next().unwrap_or_default().bytes().filter(u8::is_ascii_digit);
        assert!(digits.count() <= 22, "{text}");
    }
}

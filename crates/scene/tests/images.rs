//! Tests image sizes, reading and writing image files, and what a failed write leaves behind.

use std::fs;
#[cfg(unix)]
use std::io::Read;
use std::path::Path;

use intertri_scene::{Image, ImageError, MAX_PIXELS, check_output, check_size, difference};
use tempfile::TempDir;

fn picture() -> Image {
    let mut image = Image::new(5, 3).unwrap();
    for (i, pixel) in image.pixels_mut().iter_mut().enumerate() {
        *pixel = [i as u8, 255 - i as u8, 7];
    }
    image
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_png_reads_back_and_nothing_else_is_left() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.png");
    // Put an older file at the path.
    fs::write(&path, "old").unwrap();
    picture().write_png(&path).unwrap();
    assert_eq!(names(folder.path()), ["a.png"]);

    let read = ::image::open(&path).unwrap().into_rgb8();
    assert_eq!(read.dimensions(), (5, 3));
    assert_eq!(read.as_raw().as_slice(), picture().pixels().as_flattened());
}

#[cfg(unix)]
#[test]
fn an_older_picture_is_replaced_and_never_written_into() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, "old").unwrap();
    // A program that has the old file open can still read the whole old file, because only the name
    // refers to the new file.
    let mut old = fs::File::open(&path).unwrap();
    picture().write_png(&path).unwrap();
    let mut text = String::new();
    old.read_to_string(&mut text).unwrap();
    assert_eq!(text, "old");
}

#[test]
fn a_failure_leaves_neither_picture_nor_pieces() {
    let folder = TempDir::new().unwrap();
    // Use a name that is too long for any file system.
    let path = folder.path().join(format!("{}.png", "n".repeat(252)));
    assert!(matches!(picture().write_png(&path), Err(ImageError::Write { .. })));
    assert!(names(folder.path()).is_empty());
}

#[test]
fn hopeless_names_are_known_before_the_work() {
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("folder.png")).unwrap();
    let cases = [
        ("a.jpg", "give a name that ends in .png"),
        ("a", "give a name that ends in .png"),
        ("folder.png", "is a folder"),
        ("missing/a.png", "folder does not exist"),
    ];
    for (name, part) in cases {
        let path = folder.path().join(name);
        for error in [check_output(&path).unwrap_err(), picture().write_png(&path).unwrap_err()] {
            let message = error.to_string();
            assert!(message.contains(name) && message.contains(part), "{message}");
            assert!(!message.contains('\n'));
        }
    }
    assert!(check_output(&folder.path().join("A.PNG")).is_ok());
    assert!(check_output(Path::new("plain.png")).is_ok());
    assert_eq!(names(folder.path()), ["folder.png"]);
}

#[test]
fn sizes_are_checked_before_anything_is_allocated() {
    assert_eq!(check_size(1, 1).unwrap(), 1);
    assert_eq!(check_size(8192, 8192).unwrap() as u64, MAX_PIXELS);
    let sizes = [
        (0, 0),
        (0, 5),
        (5, 0),
        (8192, 8193),
        (100_000, 100_000),
        (u32::MAX, u32::MAX),
        (65536, 65536),
    ];
    for (width, height) in sizes {
        let message = Image::new(width, height).unwrap_err().to_string();
        assert!(message.contains(&format!("{width}x{height}")), "{message}");
        assert!(message.contains("67108864"), "{message}");
    }
}

#[test]
fn a_difference_picture_marks_what_differs() {
    let mut image = Image::new(11, 6).unwrap();
    image.pixels_mut().fill([80, 40, 255]);
    // Mark two adjacent pixels. Each is inside the other's frame, and the border of the image cuts
    // off both frames.
    let mut marks = vec![None; 66];
    marks[11 + 1] = Some([255, 32, 32]);
    marks[11 + 2] = Some([0, 0, 200]);
    let marked = difference(&image, &marks);
    for (i, &is) in marked.pixels().iter().enumerate() {
        let (x, y) = (i % 11, i / 11);
        let expected = match (x, y) {
            (1, 1) => [255, 32, 32],
            (2, 1) => [0, 0, 200],
            (6, 0..=5) | (0..=6, 5) => [0, 0, 100],
            (5, 0..=5) => [127, 16, 16],
            _ => [20, 10, 63],
        };
        assert_eq!(is, expected, "{x}, {y}");
    }
}

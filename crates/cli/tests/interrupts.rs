//! Tests that a killed run leaves either a complete image or none, and that an output that cannot
//! be written is an error.

use crate::common::{MODEL, TestFolder};
use std::path::Path;
use std::time::Duration;

#[test]
fn a_picture_is_whole_or_not_there_whenever_the_program_is_killed() {
    let place = TestFolder::new();
    let mut whole = 0;
    for pause in 0..24 {
        let _ = std::fs::remove_file(place.path("a.png"));
        let mut child = place.command("render --size 64x48 -o a.png").spawn().unwrap();
        std::thread::sleep(Duration::from_millis(pause * 4));
        // The program may have ended before the signal arrives.
        let _ = child.kill();
        child.wait().unwrap();
        if place.path("a.png").exists() {
            let bytes = place.read("a.png");
            assert!(bytes.starts_with(b"\x89PNG") && bytes.ends_with(b"IEND\xae\x42\x60\x82"));
            whole += 1;
        }
    }
    println!("{whole} of 24 pictures were complete");
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_takes_no_files() {
    // Not even root can create files here.
    let folder = Path::new("/sys/kernel");
    if !folder.is_dir() {
        println!("skipped: {} does not exist", folder.display());
        return;
    }
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0,0,0,0,0,1\n");
    place.fails("trace m.obj --rays rays.csv -o /sys/kernel/a.csv", 1, &["/sys/kernel/a.csv: "]);
    place.fails("render --size 8x6 -o /sys/kernel/a.png", 1, &["/sys/kernel/a.png: "]);
}

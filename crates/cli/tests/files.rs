//! Tests how the program writes files and streams: an existing file is either left unchanged or
//! replaced by a complete one.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::process::{Command, Stdio};

use crate::common::{MODEL, TestFolder, one_line};

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.put("m.obj", MODEL).put("rays.csv", "ox,oy,oz,dx,dy,dz\n0.25,0.25,0,0,0,1\n");
    place
}

const ANSWERS: &str = "ray,triangle,t,u,v\n0,0,5,0.25,0.25\n";

#[test]
#[cfg(unix)]
fn a_run_that_is_told_to_end_leaves_nothing() {
    use std::os::unix::process::ExitStatusExt;
    for (name, number) in [("INT", 2), ("TERM", 15), ("HUP", 1)] {
        if is_ignored(number) {
            println!("skipped SIG{name}: these tests run as under nohup, and so do their children");
            continue;
        }
        let place = place();
        place.put("out.csv", "old");
        let mut command = place.command("trace m.obj --rays - -o out.csv");
        let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut input = child.stdin.take().unwrap();
        input.write_all(&place.read("rays.csv")).unwrap();
        let partial = format!(".out.csv.{}.partial", child.id());
        while !place.path(&partial).exists() {
            std::thread::yield_now();
        }
        signal(name, child.id());
        let output = child.wait_with_output().unwrap();
        // The parent process sees that the signal ended the program.
        assert_eq!(output.status.signal(), Some(number), "{output:?}");
        assert_eq!(place.names(), ["m.obj", "out.csv", "rays.csv"]);
        assert_eq!(place.read("out.csv"), b"old");
        drop(input);
    }
}

/// Returns whether this process, and therefore its children, ignores a signal.
#[cfg(unix)]
fn is_ignored(number: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let bits = ignored.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(0);
    bits >> (number - 1) & 1 != 0
}

#[test]
#[cfg(unix)]
fn a_picture_that_is_told_to_end_leaves_nothing() {
    for _ in 0..8 {
        let place = place();
        let mut child = place.command("render --size 1024x768 -o a.png").spawn().unwrap();
        let partial = format!(".a.png.{}.partial", child.id());
        while !place.path(&partial).exists() && child.try_wait().unwrap().is_none() {
            std::thread::yield_now();
        }
        signal("TERM", child.id());
        child.wait().unwrap();
        assert!(!place.names().contains(&partial));
    }
}

/// `nohup` and the background jobs of a shell rely on ignored signals staying ignored.
#[test]
#[cfg(target_os = "linux")]
fn a_signal_that_was_ignored_at_the_start_is_ignored() {
    let place = place();
    let mut shell = Command::new("sh");
    shell.current_dir(place.path("")).arg("-c");
    shell.arg("trap '' HUP INT; exec \"$0\" trace m.obj --rays - -o out.csv");
    shell.arg(env!("CARGO_BIN_EXE_intertri")).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = shell.spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(b"ox,oy,oz,dx,dy,dz\n").unwrap();
    let partial = format!(".out.csv.{}.partial", child.id());
    while !place.path(&partial).exists() {
        std::thread::yield_now();
    }
    signal("HUP", child.id());
    signal("INT", child.id());
    input.write_all(b"0.25,0.25,0,0,0,1\n").unwrap();
    drop(input);
    assert_eq!(child.wait_with_output().unwrap().status.code(), Some(0));
    assert_eq!(place.read("out.csv"), ANSWERS.as_bytes());
}

#[cfg(unix)]
fn signal(name: &str, process: u32) {
    // The process may have ended before the signal arrives.
    let kill = ["-s", name, &process.to_string()].map(str::to_owned);
    Command::new("kill").args(kill).stderr(Stdio::null()).status().unwrap();
}

#[test]
#[cfg(unix)]
fn a_file_that_is_replaced_keeps_its_mode() {
    use std::os::unix::fs::PermissionsExt;
    let place = place();
    for (name, line) in
        [("a.csv", "trace m.obj --rays rays.csv -o a.csv"), ("a.png", "render --size 8x6 -o a.png")]
    {
        for mode in [0o600, 0o640, 0o666, 0o755] {
            place.put(name, "old");
            let path = place.path(name);
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            place.ok(line);
            assert_ne!(place.read(name), b"old");
            let now = fs::metadata(&path).unwrap().permissions().mode() & 0o7777;
            assert_eq!(now, mode, "{name}: {now:o}, not {mode:o}");
        }
    }
}

#[test]
fn nothing_is_written_onto_what_is_read() {
    let place = place();
    place.put("texture.png", "");
    let mut onto = vec!["m.obj", "./m.obj", "rays.csv"];
    // Test links only on Unix. On other systems, the program treats hard links as different files,
    // and creating links needs permissions.
    if cfg!(unix) {
        fs::hard_link(place.path("m.obj"), place.path("hard")).unwrap();
        fs::hard_link(place.path("rays.csv"), place.path("hard-rays")).unwrap();
        #[cfg(unix)]
        for (to, link) in [("m.obj", "soft"), ("soft", "softer"), ("rays.csv", "soft-rays")] {
            std::os::unix::fs::symlink(to, place.path(link)).unwrap();
        }
        onto.extend(["hard", "hard-rays", "soft", "softer", "soft-rays"]);
    }
    let names = place.names();
    for name in onto {
        let line = format!("trace m.obj --rays rays.csv -o {name}");
        let output = place.run(&line);
        one_line(&line, &output, 2, &[name, "another"]);
        assert_eq!(place.names(), names);
        assert_eq!(place.read("m.obj"), MODEL.as_bytes());
        assert_eq!(place.read("rays.csv"), b"ox,oy,oz,dx,dy,dz\n0.25,0.25,0,0,0,1\n");
    }
    // A file with the same name in another folder is a different file.
    fs::create_dir(place.path("folder")).unwrap();
    place.ok("trace m.obj --rays rays.csv -o folder/rays.csv");

    // The output cannot overwrite a file that the model refers to, either.
    let buffer: Vec<u8> = [0_f32, 0.0, 5.0, 1.0, 0.0, 5.0, 0.0, 1.0, 5.0]
        .into_iter()
        .flat_map(f32::to_le_bytes)
        .collect();
    place.put("m.bin", &buffer).put(
        "m.gltf",
        r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"m.bin","byteLength":36}]}"#,
    );
    place.fails("trace m.gltf --rays rays.csv -o m.bin", 2, &["m.bin", "another"]);
    assert_eq!(place.read("m.bin"), buffer);
    place.ok("trace m.gltf --rays rays.csv -o m.csv");
    assert_eq!(String::from_utf8(place.read("m.csv")).unwrap(), ANSWERS);

    place.put("model.png", MODEL);
    place.fails("render model.png --size 8x6 -o model.png", 2, &["model.png", "another"]);
    assert_eq!(place.read("model.png"), MODEL.as_bytes());
}

#[test]
#[cfg(unix)]
fn a_stream_onto_its_own_file_is_refused() {
    let place = place();
    let rays = place.read("rays.csv");
    let append = fs::File::options().append(true).open(place.path("rays.csv")).unwrap();
    let line = "trace m.obj --rays rays.csv";
    let output = place.command(line).stdout(append).output().unwrap();
    one_line(line, &output, 2, &["rays.csv", "another"]);
    assert_eq!(place.read("rays.csv"), rays);

    let input = fs::File::open(place.path("rays.csv")).unwrap();
    let line = "trace m.obj --rays - -o rays.csv";
    let output = place.command(line).stdin(input).output().unwrap();
    one_line(line, &output, 2, &["rays.csv", "another"]);
    assert_eq!(place.read("rays.csv"), rays);
}

#[test]
#[cfg(unix)]
fn a_closed_standard_output_is_an_error() {
    let place = place();
    for line in [
        "trace m.obj --rays rays.csv",
        "trace m.obj --rays rays.csv -o a.csv --json",
        "render --size 8x6",
        "trace --help",
        "--version",
    ] {
        let run = |redirection: &str| {
            let mut shell = Command::new("sh");
            shell.current_dir(place.path("")).arg("-c");
            shell.arg(format!("exec \"$0\" {line} {redirection}"));
            shell.arg(env!("CARGO_BIN_EXE_intertri")).output().unwrap()
        };
        one_line(line, &run(">&-"), 1, &["standard output", "closed"]);
        // Discarding the answers is allowed with any form of redirection.
        for away in [">/dev/null", "1<>/dev/null", ">&- >/dev/null"] {
            let output = run(away);
            assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]), "{line} {away}");
        }
    }
}

#[test]
fn answers_do_not_wait_for_the_next_rays() {
    let raw = [0.25_f32, 0.25, 0.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY].map(f32::to_le_bytes);
    let raw = raw.as_flattened();
    // Write each input in three pieces, each of which ends in the middle of a ray.
    let csv: [&[u8]; 3] =
        [b"\xef\xbb\xbf\nox,oy,oz,dx,dy,dz\n0.25,0.2", b"5,0,0,0,1\n0.25", b",0.25,0,0,0,1\n0"];
    let raw = [&raw[..5], &[&raw[5..], &raw[..9]].concat(), &[&raw[9..], &raw[..1]].concat()];
    for (option, pieces) in [("", csv), ("--rays-format raw", raw)] {
        let place = place();
        let mut command = place.command(&format!("trace m.obj --rays - {option}"));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut input = child.stdin.take().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        for (piece, answer) in
            pieces.into_iter().zip(["ray,triangle,t,u,v", "0,0,5,0.25,0.25", "1,0,5,0.25,0.25"])
        {
            input.write_all(piece).unwrap();
            assert_eq!(lines.next().unwrap().unwrap(), answer);
        }
        // An incomplete ray is an error.
        drop(input);
        assert_eq!(child.wait().unwrap().code(), Some(1));
    }
}

/// Returns the signals that this process and its children ignore, with bit 0 for signal 1.
#[cfg(target_os = "linux")]
fn ignored() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap()
}

/// A run that exceeds the file size limit fails with an error; one that exceeds the CPU time limit
/// ends with a signal.
#[test]
#[cfg(target_os = "linux")]
fn a_run_that_reaches_a_limit_leaves_nothing() {
    let place = place();
    let rays = "0.25,0.25,0,0,0,1\n".repeat(20_000);
    place.put("rays.csv", format!("ox,oy,oz,dx,dy,dz\n{rays}")).put("out.csv", "old");
    let names = place.names();
    let run = |line: &str| {
        let mut shell = Command::new("sh");
        shell.current_dir(place.path("")).arg("-c").arg(format!("ulimit -f 8; exec \"$0\" {line}"));
        shell.arg(env!("CARGO_BIN_EXE_intertri")).output().unwrap()
    };
    for line in ["trace m.obj --rays rays.csv -o out.csv", "render --size 640x480 -o out.csv.png"] {
        one_line(line, &run(line), 1, &["out.csv", "File too large"]);
        assert_eq!(place.names(), names);
        assert_eq!(place.read("out.csv"), b"old");
    }
    for (name, number) in [("QUIT", 3), ("XCPU", 24)] {
        use std::os::unix::process::ExitStatusExt;
        // If this test runs in a background job of a shell, the test and the program ignore
        // SIGQUIT.
        if ignored() & (1 << (number - 1)) != 0 {
            println!("skipped: {name} is ignored here");
            continue;
        }
        let mut command = place.command("trace m.obj --rays - -o out.csv");
        let mut child = command.stdin(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let partial = format!(".out.csv.{}.partial", child.id());
        // Keep the input open. Otherwise, the program could end before it receives the signal.
        let mut input = child.stdin.take().unwrap();
        input.write_all(b"ox,oy,oz,dx,dy,dz\n").unwrap();
        while !place.path(&partial).exists() {
            std::thread::yield_now();
        }
        signal(name, child.id());
        let status = child.wait_with_output().unwrap().status;
        drop(input);
        assert_eq!(status.signal(), Some(number));
        assert_eq!(place.names(), names);
    }
}

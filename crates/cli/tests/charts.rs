//! Tests `chart` and `stress` through the compiled binary: the files are valid, the reports confirm
//! what the kernel guarantees, and a seed reproduces its counts.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use crate::common::TestFolder;
use intertri_scene::Image;
use serde_json::Value;

/// Runs a command with `--quick --json`, checks every file that the report names, and returns the
/// report.
fn report(place: &TestFolder, arguments: &str, names: &[&str]) -> Value {
    let report: Value = serde_json::from_slice(&place.ok(arguments)).unwrap();
    let machine = &report["machine"];
    let date = machine["date"].as_str().unwrap();
    let rustc = machine["rustc"].as_str().unwrap();
    assert!(date.len() == 10 && date.starts_with("20") && rustc.starts_with("rustc 1."));
    assert!(!machine["cpu"].as_str().unwrap().is_empty());

    let files: Vec<_> =
        report["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap()).collect();
    for name in names {
        assert!(files.contains(&&*format!("out/{date}-{name}")), "{name}: {files:?}");
    }
    for file in files {
        let bytes = place.read(file);
        match file.rsplit_once('.').unwrap().1 {
            "png" => assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 10_000),
            "html" => {
                // The page contains all charts, supports light and dark mode, and loads nothing
                // from elsewhere.
                let text = String::from_utf8(bytes).unwrap();
                assert!(text.starts_with("<!DOCTYPE html>") && text.ends_with("</html>\n"));
                let pictures = names.iter().filter(|name| name.contains(".svg")).count();
                assert_eq!(text.matches("<svg").count(), pictures);
                assert!(text.contains("prefers-color-scheme: dark") && text.contains(date));
                for word in ["<script", "src=", "href=", "url(", "@import", "<link", "https:"] {
                    assert!(!text.contains(word), "{file}: {word}");
                }
            }
            "svg" => {
                assert!(bytes.starts_with(b"<svg") && bytes.trim_ascii_end().ends_with(b"</svg>"));
            }
            _ => {
                // The file has a caption that names the machine and the contents, followed by a
                // table.
                let text = String::from_utf8(bytes).unwrap();
                let (first, table) = text.split_once('\n').unwrap();
                assert!([date, rustc, "seed 7"].iter().all(|word| first.contains(word)), "{first}");
                let columns = |line: &str| line.split(',').count();
                let header = table.lines().next().unwrap();
                assert!(table.lines().count() > 50 && columns(header) > 5, "{file}");
            }
        }
    }
    report
}

/// For each method, returns the sum of a count over the rows of an array in a report.
fn sums<'a>(rows: &'a Value, count: &str) -> BTreeMap<&'a str, u64> {
    let mut sums = BTreeMap::new();
    for row in rows.as_array().unwrap() {
        *sums.entry(row["method"].as_str().unwrap()).or_default() += row[count].as_u64().unwrap();
    }
    sums
}

/// Renders a page in light and dark mode, if a browser is installed.
fn shown(place: &TestFolder, page: &str) {
    let there = |browser: &&&str| Command::new(browser).arg("--version").output().is_ok();
    let browsers = ["chromium", "chromium-browser", "google-chrome"];
    let Some(browser) = browsers.iter().find(there) else {
        println!("none of {browsers:?} is installed: {page} was not opened");
        return;
    };
    let path = place.path(page);
    let picture = |dark: bool| {
        let file = place.path(if dark { "dark.png" } else { "light.png" });
        let done = Command::new(browser)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1100,900"])
            .arg(format!("--user-data-dir={}", place.path("browser").display()))
            .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!dark)))
            .arg(format!("--screenshot={}", file.display()))
            .arg(format!("file://{}", path.display()))
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        Image::read(&file).unwrap()
    };

    // The corner shows the background. Most of the page is background, but not all of it.
    let (light, dark) = (picture(false), picture(true));
    for (image, ground) in [(&light, 200..=255), (&dark, 0..=60)] {
        let pixels = image.pixels();
        assert!(pixels[0].iter().all(|value| ground.contains(value)), "{:?}", pixels[0]);
        let ink = pixels.iter().filter(|&pixel| *pixel != pixels[0]).count();
        assert!(ink > pixels.len() / 100 && ink < pixels.len() / 2, "{ink} of {}", pixels.len());
    }
}

#[test]
fn a_quick_chart_is_whole_and_keeps_the_promises() {
    let place = TestFolder::new();
    let names =
        ["chart.svg", "chart.png", "times.csv", "verdicts.csv", "families.csv", "chart.html"];
    let report = report(&place, "chart --quick --seed 7 --json -o out", &names);

    let differ = sums(&report["verdicts"], "not_reference");
    for method in ["InterTri f64", "certified", "certified, one origin"] {
        assert_eq!(differ[method], 0, "{method}");
    }
    assert!(differ["Möller–Trumbore f32"] > 0);
    let verdicts = report["verdicts"].as_array().unwrap();
    for fixed in
        verdicts.iter().filter(|row| row["method"] == "fixed" && row["workload"] == "edges")
    {
        assert!(fixed["trials"].as_u64() >= Some(20_000) && fixed["wrong"] == 0, "{fixed}");
    }
    // All methods are timed, and the reference is the baseline.
    let times = report["times"].as_array().unwrap();
    assert!(times.iter().all(|time| time["ns_per_test"].as_f64() > Some(0.0)));
    let methods: BTreeSet<_> = times.iter().map(|time| time["method"].as_str().unwrap()).collect();
    assert!(differ.keys().all(|method| method.starts_with("fixed,") || methods.contains(method)));
    assert!(methods.contains("reference"));

    let mut files = report["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap());
    shown(&place, files.find(|file| file.ends_with("chart.html")).unwrap());
}

#[test]
fn a_quick_stress_is_whole_and_its_seed_gives_it_again() {
    let place = TestFolder::new();
    let names = [
        "onsets.svg",
        "onsets.png",
        "heat.svg",
        "heat.png",
        "offsets.svg",
        "offsets.png",
        "edge-maps.svg",
        "edge-maps.png",
        "onsets.csv",
        "offsets.csv",
        "stress.html",
    ];
    let report = report(&place, "stress --quick --seed 7 --json -o out", &names);
    assert_eq!(sums(&report["onsets"], "not_reference")["certified"], 0);
    assert!(sums(&report["onsets"], "false_misses")["Woop f32"] > 0);

    // Walls far from zero: exact arithmetic gives no wrong answers for the coordinates as given,
    // but many for rounded coordinates.
    let walls = report["offsets"].as_array().unwrap();
    let wrong = |given: &str| {
        let own = walls.iter().filter(|row| row["method"] == "exact" && row["given"] == given);
        let counts =
            own.map(|row| ["false_hits", "false_misses"].map(|k| row[k].as_u64().unwrap()));
        counts.flatten().sum::<u64>()
    };
    assert!(wrong("f64") == 0 && wrong("rounded to f32") > 1000);

    // The same seed gives the same counts, and a different seed gives different ones.
    let table = |seed: u32| {
        let run = format!("stress --quick --seed {seed} -o seed-{seed}");
        let text = String::from_utf8(place.ok(&run)).unwrap();
        let file = text.lines().find(|line| line.ends_with("onsets.csv")).unwrap();
        let text = String::from_utf8(place.read(file)).unwrap();
        text.split_once('\n').unwrap().1.to_owned()
    };
    let files = report["files"].as_array().unwrap();
    let mut first = files.iter().map(|file| file.as_str().unwrap());
    let first = first.find(|file| file.ends_with("onsets.csv")).unwrap();
    let first = String::from_utf8(place.read(first)).unwrap();
    assert_eq!(first.split_once('\n').unwrap().1, table(7));
    assert_ne!(first.split_once('\n').unwrap().1, table(8));
}

#[test]
fn a_folder_that_cannot_be_is_named_before_the_work() {
    let place = TestFolder::new();
    place.put("file", "");
    for command in ["chart", "stress"] {
        place.fails(&format!("{command} -o file/below"), 1, &["file/below", "folder"]);
    }
}

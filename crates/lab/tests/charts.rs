//! Checks that the text labels of every chart stay inside the chart and do not overlap, and that
//! the charts name each method.

use intertri_lab::accuracy::{ErrorCounts, ON_GRID};
use intertri_lab::draw::{Race, Section, Svg};
use intertri_lab::draw::{chart, crossover, edge_maps, heat, offsets, onsets, page, width};
use intertri_lab::methods::{METHODS, Method};
use intertri_lab::stress::{CONTENDERS, DISTANCES, InputPrecision, OffsetErrors, Onset, SWEEPS};
use intertri_lab::timing::Time;
use intertri_lab::workloads::Workload;

/// Returns whether a method is one of the kernel's modes.
fn is_kernel(method: &Method) -> bool {
    method.source.starts_with("the kernel")
}

/// A text label in a chart, and two opposite corners of the area that it covers.
struct Text {
    text: String,
    lo: [f64; 2],
    hi: [f64; 2],
}

impl Text {
    fn parse(line: &str) -> Option<Self> {
        let attribute = |name: &str| {
            let (_, rest) = line.split_once(&format!(" {name}=\""))?;
            Some(rest.split_once('"')?.0)
        };
        let number = |name| attribute(name)?.parse::<f64>().ok();
        let text = line.strip_prefix("<text")?.split_once('>')?.1.strip_suffix("</text>")?;
        let (x, y, size) = (number("x")?, number("y")?, number("font-size")?);
        // The width is a conservative estimate.
        let w = 0.93 * width(text, size);
        let from = match attribute("text-anchor")? {
            "start" => 0.0,
            "middle" => -w / 2.0,
            _ => -w,
        };
        let (up, down) = (0.7 * size, 0.1 * size);
        let (lo, hi) = if attribute("transform").is_some() {
            ([x - up, y - from - w], [x + down, y - from])
        } else {
            ([x + from, y - up], [x + from + w, y + down])
        };
        Some(Self { text: text.to_owned(), lo, hi })
    }

    fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.lo[k] < other.hi[k] && other.lo[k] < self.hi[k])
    }
}

/// Checks that the text labels of a chart stay inside the chart and do not overlap. Returns the
/// labels.
fn texts(name: &str, svg: &Svg) -> Vec<String> {
    let svg = svg.to_string();
    let (_, size) = svg.split_once("viewBox=\"0 0 ").unwrap();
    let size: Vec<f64> =
        size.split('"').next().unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    let texts: Vec<_> = svg.lines().filter_map(Text::parse).collect();
    for (i, a) in texts.iter().enumerate() {
        let inside = (0..2).all(|k| a.lo[k] >= 0.0 && a.hi[k] <= size[k]);
        assert!(inside, "{name}: {:?} extends beyond the image: {:?} {:?}", a.text, a.lo, a.hi);
        for b in &texts[..i] {
            assert!(!a.meets(b), "{name}: {:?} overlaps {:?}", a.text, b.text);
        }
    }
    texts.into_iter().map(|text| text.text).collect()
}

/// Returns made-up results of a run in which the f32 methods are fast but make errors, and the
/// other methods make none. If `crowded`, no method makes errors, and all have nearly the same
/// speed.
fn run(crowded: bool) -> (Vec<Time>, Vec<ErrorCounts>) {
    let (mut times, mut counts) = (Vec::new(), Vec::new());
    for workload in Workload::ALL.map(|workload| (workload.name(), workload.form().name())) {
        for (k, method) in METHODS.iter().map(|method| method.name).enumerate() {
            let single = method.ends_with("f32") && !crowded;
            let step = if crowded { 0.001 } else { 0.25 };
            let times_faster = if single { 13.0 } else { 5.0 } + step * k as f64;
            times.push(Time {
                workload: workload.0,
                method,
                form: workload.1,
                lanes: 8,
                ns_per_test: 1.0,
                times_faster,
                times_faster_p25: 0.98 * times_faster,
                times_faster_p75: 1.02 * times_faster,
            });
            let wrong = if single { 3 << k } else { 0 };
            counts.push(ErrorCounts {
                workload: workload.0,
                method,
                trials: 1_000_192,
                wrong,
                leaks: wrong,
                doubles: 900_000,
                not_reference: wrong,
            });
        }
        counts.push(ErrorCounts { method: ON_GRID, ..counts[counts.len() - 1].clone() });
    }
    (times, counts)
}

#[test]
fn the_chart_names_each_method_in_each_panel() {
    for crowded in [false, true] {
        let (times, counts) = run(crowded);
        let texts = texts("chart", &chart(&times, &counts, "one\ntwo"));
        for method in METHODS.iter().map(|method| method.name).chain([ON_GRID]) {
            let label = method.trim_end_matches(" f32");
            assert_eq!(texts.iter().filter(|text| *text == label).count(), 4, "{label}");
        }
    }
}

#[test]
fn the_rows_of_onsets_and_edge_maps_name_each_method() {
    let mut all = Vec::new();
    for sweep in SWEEPS {
        for method in METHODS {
            for (parameter, false_hits) in [(sweep.from, 0), (sweep.to, 300)] {
                let false_hits = if is_kernel(method) { 0 } else { false_hits };
                all.push(Onset {
                    sweep: sweep.name,
                    parameter,
                    method: method.name,
                    trials: 20_000,
                    false_misses: 0,
                    false_hits,
                    not_reference: 0,
                });
            }
        }
    }
    let bands = SWEEPS.len().div_ceil(9);
    let pictures = [
        ("onsets", onsets(&all, "one"), bands),
        ("heat", heat(&all, "one"), 1),
        ("edge maps", edge_maps("one"), 1),
    ];
    for (name, picture, times) in pictures {
        let texts = texts(name, &picture);
        for method in METHODS {
            let count = texts.iter().filter(|text| *text == method.name).count();
            assert_eq!(count, times, "{name}: {}", method.name);
        }
        let none = texts.iter().filter(|text| *text == "none").count();
        let modes = METHODS.iter().filter(|method| is_kernel(method)).count();
        assert!(none == if name == "edge maps" { 0 } else { modes * SWEEPS.len() }, "{name}");
    }
}

#[test]
fn walls_far_from_zero_have_a_row_for_each_method_and_what_it_was_given() {
    let mut all = Vec::new();
    for (method, given) in CONTENDERS {
        let wrong = if given == InputPrecision::AsGiven { [0; 3] } else { [1, 700, 2000] };
        for (distance, false_hits) in [DISTANCES[0], 500e3, DISTANCES[1]].into_iter().zip(wrong) {
            all.push(OffsetErrors {
                distance,
                method,
                given,
                trials: 4000,
                false_misses: 0,
                false_hits,
            });
        }
    }
    let texts = texts("offsets", &offsets(&all, "one\ntwo"));
    let count = |text: &str| texts.iter().filter(|found| *found == text).count();
    for (method, _) in CONTENDERS {
        let rows = CONTENDERS.iter().filter(|(name, _)| *name == method).count();
        assert_eq!(count(method), rows, "{method}");
    }
    // "none" appears at the curve and at the northing; 17.5 % is the share at 500 km.
    assert_eq!((count("none"), count("17.5 %")), (4, 6));
}

#[test]
fn a_page_needs_nothing_else() {
    let svg = Svg::new(40.0, 30.0);
    let sections = [Section { title: "a < b", text: "\"so\" & on", picture: &svg }];
    let page = page("Title", "one\ntwo", &sections);
    assert!(page.contains("<h2>a &lt; b</h2>\n<p>&quot;so&quot; &amp; on</p>"));
    assert!(page.contains("one<br>two") && page.contains("<td>Möller–Trumbore f32</td>"));
    assert_eq!(page.matches("<svg").count(), 1);
    for word in ["<script", "src=", "href=", "url(", "@import", "<link"] {
        assert!(!page.contains(word), "{word}");
    }
}

#[test]
fn a_ring_stands_where_the_lines_cross() {
    let race = |triangles, rays, raster| Race {
        task: Race::TASKS[1],
        triangles,
        width: 64,
        height: 48,
        rays,
        raster,
    };
    let circles = |races: &[Race]| crossover(races, "").to_string().matches("<circle").count();
    // One of the circles belongs to the legend.
    assert_eq!(circles(&[race(100, 0.02, 0.01), race(10_000, 0.03, 0.04)]), 2);
    assert_eq!(circles(&[race(100, 0.02, 0.01), race(10_000, 0.03, 0.02)]), 1);
    assert_eq!(circles(&[]), 1);
}

//! Compares the golden answers at every level of this CPU. The `intertri-golden` crate defines
//! them.

use intertri::simd::Level;
use intertri_golden::SECTIONS;

#[test]
fn the_answers_are_golden_at_every_level() {
    for section in SECTIONS {
        assert_ne!(section.golden().count(), 0, "{}", section.name);
        for level in Level::all() {
            let differences = section.differences(level);
            assert_eq!(differences, [], "{} at {}", section.name, level.name());
        }
    }
}

#[test]
fn one_wrong_bit_is_seen() {
    let section = &SECTIONS[0];
    let lines = section.answers(Level::best());
    let mut golden: Vec<String> = section.golden().map(str::to_owned).collect();
    let last = golden.pop().unwrap();
    let differ = |golden: &[String]| {
        intertri_golden::differences(&lines, golden.iter().map(String::as_str)).len()
    };
    assert_eq!(differ(&golden), 1, "a line that is missing");
    let (rest, digit) = last.split_at(last.len() - 1);
    let other = if digit == "0" { "1" } else { "0" };
    golden.push(format!("{rest}{other}"));
    assert_eq!(differ(&golden), 1, "a bit of a hash");
}

//! Passes the fuzzers' seeds and past findings to the entry points of the fuzz targets, without
//! running a fuzzer.

use std::path::{Path, PathBuf};

use intertri_tests::fuzz::{ENTRIES, Entry};

/// Returns all files in a folder, or an empty list if the folder does not exist.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn replay(name: &str, entry: Entry) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let seeds = files(&root.join("../fuzz/seeds").join(name));
    assert!(!seeds.is_empty(), "{name} has no seeds in fuzz/seeds");
    let found = files(&root.join("fixtures/found").join(name));
    println!("{name}: {} seeds, {} past findings", seeds.len(), found.len());
    for path in seeds.into_iter().chain(found) {
        println!("{}", path.display());
        entry(&std::fs::read(&path).unwrap());
    }
    // Also try an empty input, and inputs longer than any entry point reads.
    entry(&[]);
    for byte in [0, 1, 0x7f, 0x80, 0xff] {
        entry(&[byte; 1000]);
    }
}

#[test]
fn every_seed_and_every_finding_passes_its_entry() {
    for &(name, entry) in ENTRIES {
        replay(name, entry);
    }
}

#[test]
fn every_entry_is_a_target_of_the_fuzzers() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/fuzz_targets");
    let mut names: Vec<String> = ENTRIES.iter().map(|(name, _)| format!("{name}.rs")).collect();
    names.sort();
    let targets: Vec<String> =
        files(&folder).iter().map(|f| f.file_name().unwrap().to_str().unwrap().into()).collect();
    assert_eq!(targets, names);
}

//! Every public type, trait and function has an example that the doc tests run; a method has one of its
//! own or is called in another's.

use std::fs;
use std::path::Path;

/// What types must be public for the trait `Test` alone, and nobody can name.
const UNNAMED: [&str; 10] = [
    "pair.rs: Pair",
    "mode.rs: Found",
    "mode.rs: Test",
    "double.rs: Tri",
    "double.rs: Plane",
    "filter.rs: Triangles",
    "filter.rs: Rays",
    "look.rs: Constants",
    "look.rs: Look",
    "src/packet.rs: RayLanes",
];

#[test]
fn every_public_item_has_an_example() {
    let mut files = vec![];
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    let examples: String = files.iter().map(|(_, text)| examples_of(text)).collect();

    let (mut items, mut bare) = (0, vec![]);
    for (file, text) in &files {
        let of = |name: &str| format!("{file}: {name}");
        let unnamed = |name: &str| UNNAMED.iter().any(|end| of(name).ends_with(end));
        let (all, without) = items_of(text, &examples, unnamed);
        items += all;
        bare.extend(without.into_iter().map(of));
    }
    assert!(items > 200, "{items}");
    assert!(bare.is_empty(), "without an example: {bare:#?}");
}

/// The names and texts of all files of code.
fn read(folder: &Path, files: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            read(&path, files);
        } else if !path.ends_with("tests.rs") {
            files.push((path.display().to_string(), fs::read_to_string(&path).unwrap()));
        }
    }
}

/// What a file's examples say.
fn examples_of(text: &str) -> String {
    let (mut within, mut examples) = (false, String::new());
    for line in text.lines().filter_map(|line| line.trim().strip_prefix("///")) {
        if line.trim().starts_with("```") {
            within = !within;
        } else if within {
            examples += line;
        }
    }
    examples
}

/// How many public items a file has, and the names of those without an example.
fn items_of<'a>(
    text: &'a str,
    examples: &str,
    cannot_be_named: impl Fn(&str) -> bool,
) -> (usize, Vec<&'a str>) {
    let (mut count, mut bare) = (0, vec![]);
    let (mut has_example, mut in_trait, mut unnamed) = (false, false, false);
    for line in text.lines() {
        let code = line.trim();
        if code.starts_with("///") {
            has_example |= code.contains("```");
            continue;
        }
        if code.starts_with('#') || code.starts_with("//") {
            continue;
        }
        let top = !line.starts_with(char::is_whitespace);
        let public = code.strip_prefix("pub ");
        // All that a public trait has is public.
        let item = public.or((in_trait && !top).then_some(code)).unwrap_or_default();
        let item =
            item.strip_prefix("const ").filter(|rest| rest.starts_with("fn")).unwrap_or(item);
        let (kind, rest) = item.split_once(' ').unwrap_or_default();
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let name = &rest[..end];
        if top && !code.is_empty() && !code.starts_with('}') {
            in_trait = public.is_some() && kind == "trait";
        }
        if ["struct", "enum", "trait", "fn", "const"].contains(&kind) && !name.is_empty() {
            if top {
                unnamed = cannot_be_named(name);
            }
            let called =
                || [".", "::", " "].iter().any(|dot| examples.contains(&format!("{dot}{name}")));
            count += 1;
            if !unnamed && !has_example && (top || !called()) {
                bare.push(name);
            }
        }
        has_example = false;
    }
    (count, bare)
}

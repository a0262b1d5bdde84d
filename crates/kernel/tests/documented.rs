//! Checks that every public type, trait, and function has an example that runs as a doc test. For a
//! method, a call in another item's example is enough. Items in the hidden module `internal` are
//! exempt.

use std::fs;
use std::path::Path;

#[test]
fn every_public_item_has_an_example() {
    let mut files = vec![];
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    let examples: String = files.iter().map(|(_, text)| examples_of(text)).collect();

    let lib = files.iter().find(|(file, _)| file.ends_with("src/lib.rs")).unwrap();
    let (_, internal) = lib.1.split_once("pub mod internal {").unwrap();
    let internal: Vec<&str> = internal.split(|c: char| !c.is_alphanumeric() && c != '_').collect();

    let (mut items, mut bare) = (0, vec![]);
    for (file, text) in &files {
        let of = |name: &str| format!("{file}: {name}");
        let is_internal = |name: &str| internal.contains(&name);
        let (all, without) = items_of(text, &examples, is_internal);
        items += all;
        bare.extend(without.into_iter().map(of));
    }
    assert!(items > 200, "{items}");
    assert!(bare.is_empty(), "these items have no example: {bare:#?}");
}

/// Reads the paths and texts of all source files.
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

/// Returns the text of a file's examples.
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

/// Returns the number of public items in a file and the names of those without an example.
fn items_of<'a>(
    text: &'a str,
    examples: &str,
    is_internal: impl Fn(&str) -> bool,
) -> (usize, Vec<&'a str>) {
    let (mut count, mut bare) = (0, vec![]);
    let (mut has_example, mut in_trait, mut internal, mut hidden) = (false, false, false, false);
    for line in text.lines() {
        let code = line.trim();
        if code.starts_with("///") {
            has_example |= code.contains("```");
            continue;
        }
        if code.starts_with('#') || code.starts_with("//") {
            hidden |= code.contains("doc(hidden)");
            continue;
        }
        let top = !line.starts_with(char::is_whitespace);
        let public = code.strip_prefix("pub ");
        // All items of a public trait are public.
        let item = public.or((in_trait && !top).then_some(code)).unwrap_or_default();
        let item =
            item.strip_prefix("const ").filter(|rest| rest.starts_with("fn")).unwrap_or(item);
        let (kind, rest) = item.split_once(' ').unwrap_or_default();
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let name = &rest[..end];
        if top && !code.is_empty() && !code.starts_with('}') {
            in_trait = public.is_some() && kind == "trait";
        }
        if top && let Some(of) = implemented(code) {
            internal = is_internal(of);
        }
        if ["struct", "enum", "trait", "fn", "const"].contains(&kind) && !name.is_empty() {
            if top {
                internal = is_internal(name);
            }
            let called =
                || [".", "::", " "].iter().any(|dot| examples.contains(&format!("{dot}{name}")));
            count += 1;
            if !internal && !hidden && !has_example && (top || !called()) {
                bare.push(name);
            }
        }
        (has_example, hidden) = (false, false);
    }
    (count, bare)
}

/// Returns the type whose inherent methods follow, if the line is an `impl` line.
fn implemented(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("impl")?;
    let mut depth = 0;
    let ends = |c: char| {
        depth += i32::from(c == '<') - i32::from(c == '>');
        depth == 0 && c == ' '
    };
    let (_, of) = rest.split_once(ends)?;
    let end = of.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(of.len());
    (!of.contains(" for ")).then_some(&of[..end])
}

//! Circles of files: which file of a crate names what of which other, by their `use` items.
//!
//! A parent names its children, and they name what it holds: that is no circle. Tests at the end of
//! a file do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// A file by its path of modules: `["bus", "server"]`; empty for the crate's root.
type Module = Vec<String>;

/// The circles among the files under a crate's `src`, a line each; programs in `bin` do not count.
///
/// # Errors
/// A file cannot be read.
pub fn of_crate(src: &Path) -> Result<Vec<String>> {
    let mut files = BTreeMap::new();
    read(src, &Vec::new(), &mut files)?;
    Ok(among(&files))
}

/// Reads the files of a folder and of those in it.
fn read(folder: &Path, at: &Module, files: &mut BTreeMap<Module, String>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        let mut module = at.clone();
        if !matches!(stem, "lib" | "main" | "mod") {
            module.push(stem.to_owned());
        }
        if path.is_dir() && stem != "bin" {
            read(&path, &module, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.insert(module, fs::read_to_string(&path)?);
        }
    }
    Ok(())
}

/// The circles among files, each as the names of the files that can be reached from one another.
fn among(files: &BTreeMap<Module, String>) -> Vec<String> {
    let arrows: BTreeMap<&Module, BTreeSet<Module>> =
        files.iter().map(|(module, text)| (module, named(module, text, files))).collect();
    let reached = |from: &Module| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = open.pop() {
            let next = arrows.get(&module).into_iter().flatten();
            open.extend(next.filter(|next| seen.insert((*next).clone())).cloned());
        }
        seen
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> =
        files.keys().map(|module| (module, reached(module))).collect();
    let circle = |module: &Module| -> Vec<String> {
        let others = reached[module].iter().filter(|other| reached[other].contains(module));
        others.map(|other| other.join("::")).collect()
    };
    let circles: BTreeSet<Vec<String>> =
        files.keys().map(circle).filter(|circle| !circle.is_empty()).collect();
    circles.into_iter().map(|circle| circle.join(", ")).collect()
}

/// The files that one names, but for its parents and children.
fn named(module: &Module, text: &str, files: &BTreeMap<Module, String>) -> BTreeSet<Module> {
    let mut named = BTreeSet::new();
    for path in uses(text) {
        let mut at: Module = match path.first().map(String::as_str) {
            Some("self" | "super") => module.clone(),
            Some("crate") => Vec::new(),
            _ => continue,
        };
        for part in path {
            match part.as_str() {
                "super" => drop(at.pop()),
                "self" | "crate" => {}
                _ => at.push(part),
            }
        }
        // What is no file is an item of one.
        while !files.contains_key(&at) && !at.is_empty() {
            at.pop();
        }
        if !at.starts_with(module) && !module.starts_with(&at) {
            named.insert(at);
        }
    }
    named
}

/// The paths of all `use` items above the tests, with braces written out.
fn uses(text: &str) -> Vec<Vec<String>> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let code = code.collect::<Vec<_>>().join(" ");
    let mut paths = Vec::new();
    for item in code.split(';') {
        // An item stands behind whatever closed without a semicolon, attributes and `pub`.
        let Some(place) = item.rfind("use ") else { continue };
        let is_word = !item[..place].ends_with(|before: char| before.is_alphanumeric() || before == '_');
        if is_word {
            written_out("", &item[place + "use ".len()..], &mut paths);
        }
    }
    paths
}

/// A path with braces, `a::{b, c::{d, e}}`, as one path for each of its ends.
fn written_out(before: &str, rest: &str, paths: &mut Vec<Vec<String>>) {
    let Some((head, inner)) = rest.split_once('{') else {
        let path = format!("{before}{rest}");
        let path = path.split(" as ").next().unwrap_or_default();
        paths.push(path.split("::").map(|part| part.trim().to_owned()).collect());
        return;
    };
    let (before, mut depth, mut one) = (format!("{before}{}", head.trim()), 0, String::new());
    for letter in inner.chars() {
        match letter {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                if !one.trim().is_empty() {
                    written_out(&before, one.trim(), paths);
                }
                one.clear();
                continue;
            }
            _ => {}
        }
        one.push(letter);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(texts: &[(&str, &str)]) -> BTreeMap<Module, String> {
        let module =
            |name: &str| name.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
        texts.iter().map(|(name, text)| (module(name), (*text).to_owned())).collect()
    }

    #[test]
    fn a_circle_over_three_files_is_found_through_braces_and_pub() {
        let files = files(&[
            ("", "mod a;\nmod b;\nmod c;\nuse a::A;\n"),
            ("a", "//! A.\nuse std::fmt;\n\npub(crate) use crate::{b::{B, Other as One}, d::D};\n"),
            ("b", "fn f() {}\nuse super::c::{self,\n    C};\n"),
            ("b::inner", "use super::B;\nuse crate::a::A;\n"),
            ("c", "use crate::a::A;\n"),
            ("d", "pub struct D;\n"),
        ]);
        assert_eq!(among(&files), ["a, b, c"]);
    }

    #[test]
    fn parents_children_comments_and_tests_make_no_circle() {
        let files = files(&[
            ("", "mod a;\npub use a::A;\n"),
            ("a", "use crate::b::B; // use crate::c::C;\nmod inner;\nuse inner::In;\n"),
            ("a::inner", "use super::A;\nuse super::super::b::B;\n"),
            ("b", "pub struct B;\n\n#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}\n"),
        ]);
        assert_eq!(among(&files), [""; 0]);
    }
}

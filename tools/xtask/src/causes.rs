//! `cargo xtask causes`: a cause of the diagnosis is named in its own file alone, see
//! `host/diagnosis/src/causes`.
//!
//! Nothing else may have a cause's name as a text, or name its module. Tests may, and so may
//! comments.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};

use crate::run;

/// Where the causes have a file each.
const CAUSES: &str = "host/diagnosis/src/causes";
/// The folders that name none.
const FOLDERS: [&str; 2] = ["host/diagnosis/src", "host/mgpi/src"];
/// Files of them, and names of causes that are something else there.
const ALSO: [(&str, &[&str]); 1] = [
    // Axes that a residual is drawn over: recorded columns.
    ("host/diagnosis/src/anatomy/axis.rs", &["load", "temperature"]),
];

/// Looks for names of causes.
///
/// # Errors
/// A file names a cause, or has no cause where it should; a file cannot be read.
pub fn check() -> Result<()> {
    let mut files = Vec::new();
    for folder in FOLDERS {
        read(&run::root().join(folder), &mut files)?;
    }
    let own = run::root().join(CAUSES);
    let stems = files.iter().filter(|(path, _)| path.starts_with(&own)).filter_map(|(path, text)| {
        let stem = path.file_stem()?.to_str()?;
        text.contains(&format!("name: \"{stem}\",")).then_some(stem)
    });
    let causes: Vec<&str> = stems.collect();
    ensure!(!causes.is_empty(), "no file of {CAUSES} has a cause of its name");
    let mut wrong = Vec::new();
    for (path, text) in files.iter().filter(|(path, _)| !path.starts_with(&own)) {
        let path = path.strip_prefix(run::root())?;
        let also = ALSO.iter().filter(|(file, _)| Path::new(file) == path).flat_map(|(_, names)| *names);
        let also: Vec<&str> = also.copied().collect();
        let asked: Vec<&str> = causes.iter().copied().filter(|name| !also.contains(name)).collect();
        wrong.extend(named(text, &asked).into_iter().map(|found| format!("{}:{found}", path.display())));
    }
    ensure!(wrong.is_empty(), "causes that are named outside of {CAUSES}:\n  {}", wrong.join("\n  "));
    println!("{} causes, each named in its own file alone", causes.len());
    Ok(())
}

/// Reads the files of a folder and of those in it, but for tests.
fn read(folder: &Path, files: &mut Vec<(PathBuf, String)>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.file_stem().is_some_and(|stem| stem == "tests") {
            continue;
        }
        if path.is_dir() {
            read(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            files.push((path, text));
        }
    }
    Ok(())
}

/// Where a file names one of these causes above its tests, each with its line.
fn named(text: &str, causes: &[&str]) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut found = Vec::new();
    for (line, number) in code.lines().zip(1..) {
        let line = line.split("//").next().unwrap_or_default();
        let names = causes.iter().filter(|name| {
            let is_module = |(place, _): (usize, &str)| !line[..place].ends_with(is_part_of_name);
            line.contains(&format!("\"{name}\"")) || line.match_indices(&format!("{name}::")).any(is_module)
        });
        found.extend(names.map(|name| format!("{number}: {name}")));
    }
    found
}

fn is_part_of_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_found_by_its_name_and_by_its_module() {
        let text = "use crate::causes::{creep::Creep, Cause};\nlet one = Cause::of_name(\"load\");\n";
        assert_eq!(named(text, &["load", "creep"]), ["1: creep", "2: load"]);
    }

    #[test]
    fn fields_longer_names_comments_and_tests_name_no_cause() {
        let text = "// \"load\"\nlet load = all.load + offload::of(\"load_n\");\n#[cfg(test)]\nmod tests {\n    \"load\"\n";
        assert_eq!(named(text, &["load"]), [""; 0]);
    }
}

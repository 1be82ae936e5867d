//! `cargo xtask comments`: lines of comments that are too long, and phrases that are not plain
//! English.
//!
//! Tables and code in comments have the width that rustfmt gives to code.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::run;

/// The folders that are held to it.
const FOLDERS: [&str; 11] = [
    "model-core",
    "wire",
    "firmware",
    "rig",
    "host/recording",
    "host/identification",
    "host/board-client",
    "host/report",
    "host/mgpi",
    "host-tests/tests",
    "tools",
];
/// The longest line of a comment. Unit: columns.
const LONGEST: usize = 100;
/// Phrases that have a plain word: to avoid, again, output error, simulated, continued.
const PHRASES: [&str; 6] = [" lest ", " anew", "errs by", "runs free", "running free", "gone on"];

/// Looks at the comments of the folders.
///
/// # Errors
/// A line is too long, or has such a phrase; a file cannot be read.
pub fn check() -> Result<()> {
    let mut wrong = Vec::new();
    for folder in FOLDERS {
        read(&run::root().join(folder), &mut wrong)?;
    }
    ensure!(wrong.is_empty(), "comments to mend:\n  {}", wrong.join("\n  "));
    println!("comments of {} folders: at most {LONGEST} columns, in plain words", FOLDERS.len());
    Ok(())
}

/// Reads the files of a folder and of those in it.
fn read(folder: &Path, wrong: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.is_dir() && !path.ends_with("target") {
            read(&path, wrong)?;
        } else if path.is_file() && path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            wrong.extend(faults(&text).into_iter().map(|fault| format!("{}:{fault}", path.display())));
        }
    }
    Ok(())
}

/// What is wrong with the comments of a file, each with its line.
fn faults(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut is_code = false;
    for (line, number) in text.lines().zip(1..) {
        let Some(comment) = line.trim_start().strip_prefix("//") else {
            is_code = false;
            continue;
        };
        let comment = comment.trim_start_matches(['/', '!']).trim_start();
        if comment.starts_with("```") {
            is_code = !is_code;
        }
        if is_code || comment.starts_with('|') {
            continue;
        }
        let columns = line.chars().count();
        if columns > LONGEST {
            found.push(format!("{number}: {columns} columns"));
        }
        let phrases = PHRASES.iter().filter(|phrase| comment.contains(**phrase));
        found.extend(phrases.map(|phrase| format!("{number}: \"{}\"", phrase.trim())));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_and_odd_phrases_are_found_but_tables_and_code_may_be_wide() {
        let wide = "w".repeat(LONGEST);
        let text = format!(
            "/// {wide}\n/// | {wide} |\n/// ```\n/// {wide}\n/// ```\n    // Apart, lest it costs time.\nlet {wide} = 1;\n"
        );
        assert_eq!(faults(&text), ["1: 104 columns", "6: \"lest\""]);
    }
}

//! The commands of the book, run: every fenced block `sh` of every page that `docs/SUMMARY.md`
//! lists, in order.
//!
//! A page is one script in a folder of its own, in which there is nothing but, for pages that name
//! them, the repository's `examples` and `recordings`. Its `mgpi` is installed far from this
//! workspace, as users have it, with nothing else of ours on the search path. What it has started
//! goes with it. A block that is not to be run is no `sh` but `console`.

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use rustix::process::{Pid, Signal, kill_process_group};

use crate::{host, run};

/// Runs the book.
///
/// # Errors
/// A page is missing, or one of its commands fails.
pub fn book() -> Result<()> {
    let installed = std::env::temp_dir().join(format!("mgpi-book-{}", std::process::id()));
    let ran =
        host::install(Some(&installed), host::Build::Tests).and_then(|()| run_pages(&installed.join("bin")));
    // A folder of the system's for what is temporary.
    let _ = fs::remove_dir_all(&installed);
    ran
}

/// Runs every page with the programs of a folder.
fn run_pages(programs: &Path) -> Result<()> {
    let docs = run::root().join("docs");
    let summary = read(&docs.join("SUMMARY.md"))?;
    let scratch = run::target_dir().join("book");
    // What an earlier one has left would be in the way.
    let _ = fs::remove_dir_all(&scratch);
    let mut blocks = 0;
    for page in pages(&summary) {
        let script = script(&read(&docs.join(page))?);
        if script.is_empty() {
            continue;
        }
        blocks += script.len();
        let folder = scratch.join(page.replace('/', "-"));
        run::step(page, || perform(&script.join("\n"), &folder, programs))?;
    }
    println!("{blocks} blocks of commands ran");
    ensure!(blocks > 0, "the book has no command");
    Ok(())
}

fn read(file: &Path) -> Result<String> {
    fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))
}

/// The pages that a summary links, in order.
fn pages(summary: &str) -> impl Iterator<Item = &str> {
    let links = summary.lines().filter_map(|line| line.split_once("](")?.1.split_once(')'));
    links.map(|(page, _)| page.trim_start_matches("./"))
}

/// The blocks of a page that are to be run.
fn script(page: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while let Some(fence) = lines.find(|line| line.starts_with("```")) {
        let block: Vec<&str> = lines.by_ref().take_while(|line| !line.starts_with("```")).collect();
        if fence == "```sh" {
            blocks.push(block.join("\n"));
        }
    }
    blocks
}

/// Runs a script in a folder that is made for it, with the programs of another.
fn perform(script: &str, folder: &Path, programs: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    for shared in
        ["examples", "recordings"].into_iter().filter(|shared| script.contains(&format!("{shared}/")))
    {
        std::os::unix::fs::symlink(run::root().join(shared), folder.join(shared))?;
    }
    let mut command = Command::new("bash");
    command.args(["-euo", "pipefail", "-c", script]).current_dir(folder).process_group(0);
    let mut shell = host::with_installed(&mut command, programs)?.spawn().context("cannot run bash")?;
    let group = Pid::from_child(&shell);
    let status = shell.wait();
    // Fails where nothing is left of it.
    let _ = kill_process_group(group, Signal::TERM);
    let status = status?;
    ensure!(status.success(), "a command fails ({status}) in:\n{script}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_gives_its_pages_in_order() {
        let summary = "# Summary\n\n[First](README.md)\n- [Second](./a/b.md)\n  - [Third](c.md)\nno link\n";
        assert_eq!(pages(summary).collect::<Vec<_>>(), ["README.md", "a/b.md", "c.md"]);
    }

    #[test]
    fn blocks_of_commands_are_run_and_no_others() {
        let page = "text\n```sh\necho 1\necho 2\n```\n```console\nno\n```\n```toml\na = 1\n```\n```sh\necho 3\n```\n";
        assert_eq!(script(page), ["echo 1\necho 2", "echo 3"]);
    }
}

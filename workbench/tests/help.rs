//! Completions and manual page know every command and option.

mod common;

use common::Bench;

const COMMANDS: [&str; 4] = ["identify", "diagnose", "pil", "completions"];

#[test]
fn every_shell_gets_a_script_that_knows_the_commands() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = bench.succeeds(&format!("completions {shell}"));
        for word in COMMANDS.into_iter().chain(["feedforward-log"]) {
            assert!(script.contains(word), "{word} is missing for {shell}");
        }
    }
    assert!(bench.refuses("completions tcl").contains("possible values: bash"));
}

#[test]
fn the_manual_page_has_a_section_each_command_with_its_options() {
    let page = Bench::new().succeeds("man");
    for command in COMMANDS {
        let section = format!(".SH \"MGPI {}\"", command.to_uppercase());
        assert_eq!(page.matches(&section).count(), 1, "{section}");
    }
    assert!(page.contains("\\-\\-feedforward\\-log"), "{page}");
    let sections = page.matches("\n.SH ").count();
    assert_eq!(
        page.matches("\n.SS SYNOPSIS").count(),
        sections - 2,
        "all but name and version have a synopsis"
    );
}

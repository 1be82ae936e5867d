//! Completions and manual page know every command and option.

mod common;

use common::Bench;
use rig::effect::Effect;

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

#[test]
fn the_effects_of_the_built_in_plant_are_in_the_help_and_no_others_are_taken() {
    let bench = Bench::new();
    for command in ["pil", "emulate"] {
        let help = bench.succeeds(&format!("{command} --help"));
        for effect in Effect::ALL {
            assert!(help.contains(effect.name()), "{} is missing in {command}", effect.name());
        }
    }
    let message = bench.refuses("emulate --port board --plant rig:gravity");
    assert!(message.contains("no effect \"gravity\"; there are none, random"), "{message}");
    let page = bench.succeeds("man");
    assert!(page.contains(".SH \"MGPI RIG REFERENCE\"") && page.contains("friction_wander"), "{page}");
}

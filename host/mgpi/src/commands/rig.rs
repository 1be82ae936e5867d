//! `mgpi rig`: the simulated muscle's own commands, so that an installed `mgpi` brings it along.
//!
//! Nothing but this, `plant` and `fleet` knows the rig: what identifies a muscle must not know how
//! this one is made.

use ::rig::command::Command;

use crate::Error;

/// Does what the rig is asked for.
///
/// # Errors
/// The rig's own.
pub fn run(command: &Command) -> Result<(), Error> {
    command.run().map_err(|error| Error::Rig(format!("{error:#}")))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    /// All source files below a directory.
    fn sources(directory: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(directory).expect("readable").map(|entry| entry.expect("readable").path());
        entries.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).collect()
    }

    #[test]
    fn nothing_but_the_commands_for_it_knows_the_rig() {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src"));
        let names_it =
            |path: &PathBuf| fs::read_to_string(path).expect("readable").contains(concat!("use ::", "rig::"));
        let mut found: Vec<_> = sources(root).into_iter().filter(names_it).collect();
        found.sort();
        let allowed = ["commands/fleet.rs", "commands/mod.rs", "commands/plant.rs", "commands/rig.rs"];
        assert_eq!(found, allowed.map(|file| root.join(file)));
    }
}

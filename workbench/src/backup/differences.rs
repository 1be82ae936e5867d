//! What differs between two configurations, key by key as in their files.

use toml::{Table, Value};

use super::{Backup, Origin, file};

impl Backup {
    /// What changes where `before` becomes this, a line each; none where both are the same.
    pub fn differences(&self, before: &Self) -> Vec<String> {
        between("", &file::of_backup(before), &file::of_backup(self))
    }
}

impl Origin {
    /// In what this board differs from another, a line each.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        between("", &file::of_origin(other), &file::of_origin(self))
    }
}

fn between(path: &str, before: &Table, after: &Table) -> Vec<String> {
    let gone = before.keys().filter(|key| !after.contains_key(*key));
    let of_key = |key: &String| {
        let path = format!("{path}{key}");
        match (before.get(key), after.get(key)) {
            (before, after) if before == after => Vec::new(),
            (Some(Value::Table(before)), Some(Value::Table(after))) => {
                between(&format!("{path}."), before, after)
            }
            (before, after) => vec![format!("{path:<36} {} -> {}", words(before), words(after))],
        }
    };
    after.keys().chain(gone).flat_map(of_key).collect()
}

fn words(value: Option<&Value>) -> String {
    match value {
        None => "none".to_owned(),
        Some(Value::Table(table)) => format!("({} keys)", table.len()),
        Some(other) => other.to_string(),
    }
}

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
        let (before, after) = (before.get(key), after.get(key));
        let table = |value: Option<&Value>| value.and_then(Value::as_table).cloned();
        match (table(before), table(after)) {
            _ if before == after => Vec::new(),
            (None, None) => vec![format!("{path:<36} {} -> {}", words(before), words(after))],
            (before, after) => {
                between(&format!("{path}."), &before.unwrap_or_default(), &after.unwrap_or_default())
            }
        }
    };
    after.keys().chain(gone).flat_map(of_key).collect()
}

fn words(value: Option<&Value>) -> String {
    value.map_or_else(|| "none".to_owned(), Value::to_string)
}

//! The name of what is exported: an identifier of C.

use thiserror::Error;

/// Words that C and its libraries keep for themselves, so far as they look like names of models.
const KEPT: [&str; 44] = [
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum",
    "extern", "float", "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return",
    "short", "signed", "sizeof", "static", "struct", "switch", "typedef", "union", "unsigned", "void",
    "volatile", "while", "bool", "true", "false", "main", "abs", "exp", "tanh", "log", "floor", "errno",
];

/// The name is not an identifier of C.
#[derive(Debug, Error, PartialEq)]
#[error("--name {0}: a name of C is needed: letters, digits and underscores, a letter first")]
pub struct NoName(pub String);

/// # Errors
/// The name is not an identifier of C.
pub fn check(name: &str) -> Result<(), NoName> {
    let is_name = name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && !KEPT.contains(&name);
    if is_name { Ok(()) } else { Err(NoName(name.to_owned())) }
}

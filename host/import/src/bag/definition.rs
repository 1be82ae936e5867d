//! Definitions of messages in the language of ROS 2 (`ros2msg`): a type with its fields, and behind
//! lines of `=` the types that it uses.

use std::collections::HashMap;

/// The types of a message, the message itself first.
#[derive(Debug)]
pub struct Definition {
    pub types: Vec<Vec<Field>>,
}

/// A field of a type.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub name: String,
    pub kind: Kind,
    pub count: Count,
}

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// f, i or u, and its bytes.
    Number(char, usize),
    Text,
    /// The type at this place.
    Type(usize),
}

/// How many of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Count {
    One,
    Fixed(usize),
    /// As many as the message says.
    Any,
}

impl Definition {
    /// # Errors
    /// What cannot be understood, in words.
    pub fn parse(name: &str, text: &str) -> Result<Self, String> {
        let mut parts = vec![(canonical(name), Vec::new())];
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or("").trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                parts.push((canonical(name.trim()), Vec::new()));
            } else if !line.is_empty()
                && !line.starts_with("===")
                && let Some((_, lines)) = parts.last_mut()
            {
                lines.push(line);
            }
        }
        let places: HashMap<String, usize> =
            parts.iter().enumerate().rev().map(|(place, (name, _))| (name.clone(), place)).collect();
        let fields = |(name, lines): &(String, Vec<&str>)| -> Result<Vec<Field>, String> {
            let fields = lines.iter().filter_map(|line| field(name, line, &places).transpose());
            fields.collect()
        };
        Ok(Self { types: parts.iter().map(fields).collect::<Result<_, _>>()? })
    }
}

/// `sensor_msgs/JointState` of `sensor_msgs/msg/JointState`.
fn canonical(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// The field of a line of a type; None of a constant.
fn field(of: &str, line: &str, places: &HashMap<String, usize>) -> Result<Option<Field>, String> {
    let unknown = || format!("`{line}` of {of} is no field");
    let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(unknown)?;
    let name = rest.split_whitespace().next().ok_or_else(unknown)?;
    // A text with a bound has a sign of equality in its type.
    if name.contains('=') || rest.trim_start()[name.len()..].trim_start().starts_with('=') {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, count)) => match count.trim_end_matches(']') {
            "" => (kind, Count::Any),
            bound if bound.starts_with("<=") => (kind, Count::Any),
            count => (kind, Count::Fixed(count.parse().map_err(|_| unknown())?)),
        },
    };
    let kind = match kind {
        "bool" | "byte" | "char" | "uint8" => Kind::Number('u', 1),
        "int8" => Kind::Number('i', 1),
        "int16" => Kind::Number('i', 2),
        "uint16" => Kind::Number('u', 2),
        "int32" => Kind::Number('i', 4),
        "uint32" => Kind::Number('u', 4),
        "int64" => Kind::Number('i', 8),
        "uint64" => Kind::Number('u', 8),
        "float32" => Kind::Number('f', 4),
        "float64" => Kind::Number('f', 8),
        text if text == "string" || text.starts_with("string<=") => Kind::Text,
        other => {
            let package = of.split('/').next().unwrap_or("");
            let full = if other.contains('/') { canonical(other) } else { format!("{package}/{other}") };
            let place = places.get(&full).or_else(|| match other {
                "Header" => places.get("std_msgs/Header"),
                _ => None,
            });
            Kind::Type(*place.ok_or_else(|| format!("the type {other} of `{line}` in {of} is not defined"))?)
        }
    };
    Ok(Some(Field { name: name.to_owned(), kind, count }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_bounds_comments_and_other_types_are_understood() {
        let text = "# a comment\nuint8 OK=0\nint32 WIDE = 7\nstd_msgs/Header header\nstring<=10 name # behind\n\
                    float64[3] xyz\nPoint[<=5] points\nfloat32 gain 1.5\n\
                    ================\nMSG: std_msgs/Header\nstring frame_id\n===\nMSG: my/Point\nfloat64 x\n";
        let definition = Definition::parse("my/msg/Thing", text).expect("understood");
        let field = |name: &str, kind, count| Field { name: name.to_owned(), kind, count };
        assert_eq!(
            definition.types[0],
            [
                field("header", Kind::Type(1), Count::One),
                field("name", Kind::Text, Count::One),
                field("xyz", Kind::Number('f', 8), Count::Fixed(3)),
                field("points", Kind::Type(2), Count::Any),
                field("gain", Kind::Number('f', 4), Count::One),
            ]
        );
        assert!(Definition::parse("my/A", "Other x").expect_err("refused").contains("Other of `Other x`"));
    }
}

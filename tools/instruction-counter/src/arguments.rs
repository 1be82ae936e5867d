//! What the plugin is started with: `out=FILE`, `handler=ADDRESS`, `fn=NAME:ADDRESS` and
//! `way=NAME:NAME`, the latter three any number of times. Addresses are hexadecimal after `0x`; the
//! names of a way are those of functions before it.

use std::collections::BTreeSet;
use std::path::PathBuf;

/// A function to watch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// What it is called in the results.
    pub name: String,
    /// Where its first instruction stands.
    pub address: u64,
}

/// What to count, and where to write it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Arguments {
    /// The file for the results.
    pub out: PathBuf,
    /// Where the handlers of exceptions begin.
    pub handlers: BTreeSet<u64>,
    /// The functions to watch.
    pub functions: Vec<Function>,
    /// Ways from the begin of a function to the return of another that it calls: their places in
    /// the list above.
    pub ways: Vec<(usize, usize)>,
}

impl Arguments {
    /// Reads arguments of the form `key=value`.
    ///
    /// # Errors
    /// An argument that is none of the above, quoted; no `out`.
    pub fn parse<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<Self, String> {
        let mut parsed = Self::default();
        for argument in arguments {
            parsed.take(argument).ok_or_else(|| {
                format!("`{argument}` is not out=FILE, handler=0xADDRESS, fn=NAME:0xADDRESS or way=NAME:NAME")
            })?;
        }
        if parsed.out.as_os_str().is_empty() {
            return Err("out=FILE is missing".to_owned());
        }
        Ok(parsed)
    }

    fn take(&mut self, argument: &str) -> Option<()> {
        match argument.split_once('=')? {
            ("out", file) => self.out = file.into(),
            ("handler", place) => {
                self.handlers.insert(address(place)?);
            }
            ("fn", function) => {
                let (name, place) = function.rsplit_once(':')?;
                self.functions.push(Function { name: name.to_owned(), address: address(place)? });
            }
            ("way", names) => {
                let place = |name| self.functions.iter().position(|function| function.name == name);
                let (from, to) = names.split_once(':')?;
                self.ways.push((place(from)?, place(to)?));
            }
            _ => return None,
        }
        Some(())
    }
}

fn address(text: &str) -> Option<u64> {
    u64::from_str_radix(text.strip_prefix("0x")?, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::{Arguments, Function};

    #[test]
    fn output_handlers_and_functions_are_read() {
        let parsed = Arguments::parse(["out=/tmp/a=b", "handler=0x8000101", "fn=a::b:0x10", "handler=0x20"]);
        let expected = Arguments {
            out: "/tmp/a=b".into(),
            handlers: [0x20, 0x800_0101].into(),
            functions: vec![Function { name: "a::b".to_owned(), address: 0x10 }],
            ways: Vec::new(),
        };
        assert_eq!(parsed, Ok(expected));
    }

    #[test]
    fn a_way_joins_two_functions_that_were_named_before() {
        let parsed = Arguments::parse(["out=o", "fn=a:0x10", "fn=b:0x20", "way=a:b"]);
        assert_eq!(parsed.map(|arguments| arguments.ways), Ok(vec![(0, 1)]));
        assert!(Arguments::parse(["out=o", "fn=a:0x10", "way=a:b"]).is_err());
    }

    #[test]
    fn anything_else_is_refused_by_name() {
        for wrong in ["fn=0x10", "fn=a:10", "handler=", "verbose", "depth=3"] {
            let error = Arguments::parse(["out=o", wrong]).expect_err(wrong);
            assert!(error.starts_with(&format!("`{wrong}` is not")), "{error}");
        }
        assert_eq!(Arguments::parse([]), Err("out=FILE is missing".to_owned()));
    }
}

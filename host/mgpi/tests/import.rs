//! `mgpi import`: what is written of text and of pipes, and what is refused.

mod common;

use std::fs;
#[cfg(unix)]
use std::{process::Command, thread};

use common::Bench;

const LOGGER: &str = "Time (ms);Druck [psi];Weg [in];note\n0;14,5;0,25;a\n20;29,0;;b\n40;14,5;0,5;c\n";

#[test]
fn text_is_written_as_a_recording_from_a_file_and_from_a_pipe() {
    let bench = Bench::new();
    bench.write("log.txt", LOGGER);
    let map = "--map time=Time,pressure=Druck,contraction=Weg";
    let said = bench.succeeds(&format!("import log.txt {map} -o rec.csv"));
    assert_eq!(said, "3 rows of time_ms, pressure_psi, contraction_in in rec.csv\n");
    let expected = "time_ms,pressure_psi,contraction_in\n0,14.5,0.25\n20,29,\n40,14.5,0.5\n";
    assert_eq!(bench.read("rec.csv"), expected);
    let piped = bench.fed(&format!("import - {map} -o piped.csv"), LOGGER.as_bytes());
    assert!(piped.status.success(), "{}", String::from_utf8_lossy(&piped.stderr));
    assert_eq!(bench.read("piped.csv"), expected);
}

/// An array of NumPy's of times and pressures.
fn npy() -> Vec<u8> {
    let header =
        "{'descr': [('time_s', '<f8'), ('pressure_bar', '<f8')], 'fortran_order': False, 'shape': (3,), }\n";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    [0.0, 1.5, 0.1, f64::NAN, 0.2, 2.5].iter().for_each(|value: &f64| bytes.extend(value.to_le_bytes()));
    bytes
}

#[test]
fn a_pipe_of_any_kind_of_file_is_read_and_leaves_nothing_behind() {
    let bench = Bench::new();
    let expected = "time_s,pressure_bar\n0,1.5\n0.1,\n0.2,2.5\n";
    let piped = bench.fed("import - -o rec.csv", &npy());
    assert!(piped.status.success(), "{}", String::from_utf8_lossy(&piped.stderr));
    assert_eq!(bench.read("rec.csv"), expected);
    let through = bench.fed("import - -o -", &npy());
    assert_eq!(String::from_utf8_lossy(&through.stdout), expected);
    let cut = bench.fed("import - -o cut.csv", &npy()[..100]);
    let message = String::from_utf8_lossy(&cut.stderr);
    assert!(!cut.status.success() && message.contains("cut off or damaged"), "{message}");
    let left: Vec<_> = fs::read_dir(bench.path(""))
        .expect("a folder")
        .map(|entry| entry.expect("one").file_name())
        .collect();
    assert_eq!(left, ["rec.csv"]);
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_a_pipe() {
    let bench = Bench::new();
    let made = Command::new("mkfifo").arg(bench.path("fifo")).status().expect("mkfifo");
    assert!(made.success());
    let fifo = bench.path("fifo");
    let writer = thread::spawn(move || fs::write(fifo, npy()));
    bench.succeeds("import fifo -o rec.csv");
    writer.join().expect("no panic").expect("all is read");
    assert_eq!(bench.read("rec.csv"), "time_s,pressure_bar\n0,1.5\n0.1,\n0.2,2.5\n");
}

#[test]
fn text_without_a_unit_is_refused_since_nothing_would_be_written() {
    let bench = Bench::new();
    bench.write("log.txt", "t,p,x\n0,1,2\n1,2,3\n");
    let message = bench.refuses("import log.txt -o rec.csv");
    let expected = "no column has a unit, so that nothing would be written; --map says which is which: --map \
                    time=t:s,pressure=…; there are t, p, x";
    assert!(message.contains(expected), "{message}");
    assert!(!bench.path("rec.csv").exists());
}

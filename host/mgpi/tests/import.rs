//! `mgpi import` of text: what is written, and what is refused.

mod common;

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

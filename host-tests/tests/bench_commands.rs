//! The commands of the bench against the board's own code on a serial line: deploy, capture, track,
//! status. Time passes faster here than on a bench.

use fleet::line::Way;
use host_tests::desk_commands::DeskBench as Bench;
use serde_json::Value;

/// Times, and a column by its name.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let place = lines.next().expect("a header").split(',').position(|found| found == name).expect(name);
    lines.map(|line| line.split(',').nth(place).expect(name).parse().expect("a number")).collect()
}

#[test]
fn a_deployed_model_is_verified_and_the_board_is_ready() {
    let bench = Bench::new();
    assert_eq!(bench.status()["state"], "Off");
    let said = bench.succeeds("deploy paper.toml --kp 0.01 --max-bar 5");
    assert!(said.contains("read back and verified"), "{said}");
    assert_eq!(bench.status()["state"], "Ready");
    // Again, over the one that is there.
    bench.succeeds("deploy paper.toml");
}

#[test]
fn a_model_that_is_none_of_a_valve_board_is_refused() {
    let bench = Bench::new();
    let model = bench.read("paper.toml").replace("_bar", "_v");
    bench.write("volts.toml", &model);
    let message = bench.refuses("deploy volts.toml");
    assert!(message.contains("volts.toml: its input is in V"), "{message}");
    let message = bench.refuses("deploy none.toml");
    assert!(message.contains("none.toml"), "{message}");
    assert_eq!(bench.status()["state"], "Off");
}

#[test]
fn what_is_captured_is_a_recording_of_the_excitation_that_was_played() {
    let bench = Bench::new();
    bench.write("exc.csv", "time_s,command_bar\n0,0\n1,0\n3,4\n5,1\n7,0\n8,0\n");
    let said = bench.succeeds("capture --excitation exc.csv -o rec.csv --every 4");
    assert!(said.contains("one each 4 ms"), "{said}");
    assert!(!said.contains("lost"), "{said}");
    let recording = bench.read("rec.csv");
    let (times, commands) = (column(&recording, "time_s"), column(&recording, "command_bar"));
    assert!(times[0] < 0.004 && times[times.len() - 1] > 8.0 - 0.004, "from the first tick to the last");
    assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 0.004).abs() < 1e-9));
    for (time_s, command_bar) in times.iter().zip(&commands) {
        let expected = match time_s {
            ..1.0 => 0.0,
            1.0..3.0 => 2.0 * (time_s - 1.0),
            3.0..5.0 => 4.0 - 1.5 * (time_s - 3.0),
            5.0..7.0 => 1.0 - 0.5 * (time_s - 5.0),
            _ => 0.0,
        };
        // A code of the valve, and the tick that an order takes.
        assert!((command_bar - expected).abs() < 0.006, "{command_bar} bar at {time_s} s, not {expected}");
    }
    let stroke_mm = column(&recording, "contraction_mm").into_iter().fold(0.0, f64::max);
    assert!(stroke_mm > 50.0, "{stroke_mm}");
    assert_eq!(bench.status()["state"], "Off", "vented at the end");
    assert!(!bench.path("rec.csv.part").exists());
}

#[test]
fn what_the_board_cannot_be_asked_for_is_refused_before_it_moves() {
    let bench = Bench::new();
    bench.write("high.csv", "time_s,command_bar\n0,0\n1,2\n2,12\n");
    let message = bench.refuses("capture --excitation high.csv -o rec.csv");
    assert!(message.contains("bar is asked for; the board takes 0 to 8 bar"), "{message}");
    bench.write("none.csv", "time_s,reference_mm\n0,0\n1,2\n");
    let message = bench.refuses("capture --excitation none.csv -o rec.csv");
    assert!(message.contains("no column command_bar"), "{message}");
    assert!(bench.refuses("capture -o rec.csv --resume").contains("no part of a recording to go on with"));
    assert!(!bench.path("rec.csv.part").exists());
    bench.succeeds("deploy paper.toml");
    bench.write("far.csv", "time_s,reference_mm\n0,0\n1,500\n");
    let message = bench.refuses("track --reference far.csv -o log.csv");
    assert!(message.contains("the board takes -20 to 200 mm"), "{message}");
    assert!(!bench.path("log.csv").exists());
    assert_eq!(bench.status()["state"], "Ready");
}

#[test]
fn an_interrupted_capture_vents_and_goes_on_from_its_last_rest() {
    let bench = Bench::new();
    bench.write("exc.csv", "time_s,command_bar\n0,0\n4,3\n8,0\n9,0\n14,4\n20,0\n");
    let mut capture =
        bench.command("capture --excitation exc.csv -o rec.csv --every 10").spawn().expect("runs");
    // Somewhere in the second triangle.
    let part = bench.path("rec.csv.part");
    let has_come_far = || {
        let text = std::fs::read_to_string(&part).unwrap_or_default();
        text.lines()
            .last()
            .and_then(|row| row.split(',').next()?.parse::<f64>().ok())
            .is_some_and(|t| t > 11.0)
    };
    while !has_come_far() {
        assert!(capture.try_wait().expect("a child").is_none(), "it says above why it has ended");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let id = rustix::process::Pid::from_child(&capture);
    rustix::process::kill_process(id, rustix::process::Signal::INT).expect("interrupted");
    assert_eq!(capture.wait().expect("ended").code(), Some(130));
    assert_eq!(bench.status()["state"], "Off");

    assert!(bench.refuses("capture --excitation exc.csv -o rec.csv").contains("--resume continues it"));
    bench.write("other.csv", "time_s,command_bar\n0,0\n4,2\n");
    assert!(
        bench.refuses("capture --excitation other.csv -o rec.csv --resume").contains("another excitation")
    );
    bench.succeeds("capture --excitation exc.csv -o rec.csv --every 10 --resume");
    let recording = bench.read("rec.csv");
    assert!(recording.contains("# interrupted, resumed at 9 s"), "{}", &recording[..400]);
    let (times, commands) = (column(&recording, "time_s"), column(&recording, "command_bar"));
    assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 0.01).abs() < 0.0101), "no gap, no repetition");
    assert!(times[times.len() - 1] > 20.0 - 0.01, "to the last tick");
    let late = times.iter().zip(&commands).find(|(time_s, _)| **time_s >= 14.0).expect("the second peak");
    assert!((late.1 - 4.0).abs() < 0.05, "{late:?}");
}

#[test]
fn a_reference_is_tracked_and_logged_as_by_pil() {
    let bench = Bench::new();
    bench.write("ref.csv", "time_s,reference_mm\n0,10\n4,60\n8,10\n");
    let message = bench.refuses("track --reference ref.csv");
    assert!(message.contains("deploy a model first"), "{message}");
    bench.succeeds("deploy paper.toml");
    bench.succeeds("track --reference ref.csv -o log.csv --json log.json --every 4");
    let log = bench.read("log.csv");
    let header = "time_s,reference_mm,contraction_mm,pressure_bar,command_bar,feedforward_bar,feedback_bar";
    assert_eq!(log.lines().next(), Some(header));
    let json: Value = serde_json::from_str(&bench.read("log.json")).expect("JSON");
    let rmse_mm = json["tracking"]["rmse_mm"].as_f64().expect("a number");
    let (reference, contraction) = (column(&log, "reference_mm"), column(&log, "contraction_mm"));
    let square: f64 = reference.iter().zip(&contraction).map(|(r, c)| (r - c).powi(2)).sum();
    assert!((rmse_mm - (square / reference.len() as f64).sqrt()).abs() < 1e-9);
    assert!(rmse_mm < 20.0, "another muscle's model, but tracking: {rmse_mm} mm");
    assert_eq!((&json["overruns"], bench.status()["state"].as_str()), (&0.into(), Some("Ready")));
    let said = bench.succeeds("track --reference ref.csv --mode feedback");
    assert!(said.contains("feedback_only"), "{said}");
}

#[test]
fn a_board_that_adapts_follows_a_muscle_that_is_not_its_models() {
    let bench = Bench::new();
    let turns: String = (0..6).map(|turn| format!("{},80\n{},30\n", 10 * turn + 6, 10 * turn + 11)).collect();
    bench.write("ref.csv", &format!("time_s,reference_mm\n0,10\n1,30\n{turns}"));
    bench.succeeds("deploy paper.toml");
    let rmse_mm = |options: &str| {
        let said = bench.succeeds(&format!(
            "track --reference ref.csv --mode feedforward --json log.json --force {options}"
        ));
        let json: Value = serde_json::from_str(&bench.read("log.json")).expect("JSON");
        (json["feedforward_only"]["rmse_mm"].as_f64().expect("a number"), said)
    };
    let (plain_mm, said) = rmse_mm("");
    assert!(!said.contains("learnt"), "{said}");
    rmse_mm("--adapt");
    let (adapted_mm, said) = rmse_mm("--adapt");
    assert!(said.contains("learnt            offset"), "{said}");
    assert!(adapted_mm < 0.5 * plain_mm, "{plain_mm} mm, {adapted_mm} mm, {said}");
    assert!(bench.succeeds("status").contains("learnt      offset"));

    // Kept as a model, it follows the muscle; what was learnt goes with the old model.
    let status = bench.status();
    assert!(status["adapted"]["steps"].as_u64().is_some_and(|steps| steps > 100), "{status}");
    let said = bench.succeeds("adapted paper.toml -o now.toml");
    assert!(said.contains("now.toml: RMSE"), "{said}");
    assert!(bench.refuses("adapted paper.toml -o now.toml").contains("now.toml"));
    bench.succeeds("deploy now.toml");
    let (kept_mm, _) = rmse_mm("");
    // Less by what its structure cannot follow of what was learnt, which the command has said.
    assert!(kept_mm < 0.67 * plain_mm, "{plain_mm} mm, kept {kept_mm} mm");
    assert!(bench.refuses("adapted paper.toml -o other.toml").contains("another model"));
    assert!(bench.refuses("adapted now.toml -o other.toml").contains("learnt nothing"));
}

#[test]
fn a_bus_that_loses_and_damages_answers_costs_time_and_nothing_else() {
    let mut answers = 0;
    let bench = Bench::disturbed(move |way, mut bytes| {
        answers += usize::from(way == Way::FromBoard);
        match (way, answers % 23) {
            (Way::FromBoard, 7) => Vec::new(),
            (Way::FromBoard, 15) => {
                bytes.truncate(3);
                bytes
            }
            (Way::FromBoard, 19) => {
                bytes[1] ^= 0x10;
                bytes
            }
            _ => bytes,
        }
    });
    let patient = "--timeout-s 0.1";
    bench.succeeds(&format!("deploy paper.toml {patient}"));
    bench.write("exc.csv", "time_s,command_bar\n0,0\n5,4\n10,0\n");
    let said = bench.succeeds(&format!("capture --excitation exc.csv -o rec.csv --every 10 {patient}"));
    assert!(!said.contains("lost"), "{said}");
    let times = column(&bench.read("rec.csv"), "time_s");
    assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 0.01).abs() < 1e-9), "every row, once");
}

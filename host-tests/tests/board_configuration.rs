//! What a board has been told stays what it is: over a deployment, and over a backup and its
//! restoration.

use std::fmt::Write as _;
use std::time::Duration;

use board_client::bus::Board;
use board_client::bus::client::Address;
use board_client::bus::port::{Line, Parity};
use fleet::line::Way;
use host_tests::desk_commands::DeskBench as Bench;
use wire::registers::{BAUD, Id, Register, TABLE, UNIT, UploadOrder};

/// The board by its registers.
fn board(bench: &Bench) -> Board {
    Board::open(Address {
        port: bench.port().to_owned(),
        line: Line { baud: BAUD, parity: Parity::None },
        unit: UNIT,
        limit: Duration::from_millis(500),
    })
    .expect("a board")
}

fn number(bench: &Bench, id: Id) -> f64 {
    board(bench).read(id, id).expect("read").number(id)
}

/// The registers of the group "Protection".
fn protection() -> impl Iterator<Item = &'static Register> {
    TABLE.iter().filter(|register| register.address >> 8 == 4)
}

/// Sets every limit of the plant to that share of the way from its lowest to its highest value.
fn protect(bench: &Bench, share: f64) {
    let mut board = board(bench);
    for register in protection() {
        let wire::registers::Access::Write(min, max) = register.access else { panic!("{}", register.name) };
        board.set(register.id, min + share * (max - min)).expect(register.name);
    }
}

#[test]
fn a_deployment_keeps_what_the_user_has_set() {
    let bench = Bench::new();
    let said = bench.succeeds(
        "deploy paper.toml --kp 0.01 --max-bar 2 --min-bar 0.2 --slew-bar-per-s 5 --filter-s 0.05 --anti-windup-s 3",
    );
    assert!(
        said.contains("the board has no model yet")
            && said.contains("command_slew_bar_per_s  5: as asked for"),
        "{said}"
    );
    assert!(said.contains("kd_bar_s_per_mm         0: the default"), "{said}");
    let set = [
        (Id::Kp, 0.01),
        (Id::CommandMax, 2.0),
        (Id::CommandMin, 0.2),
        (Id::CommandSlew, 5.0),
        (Id::DerivativeFilter, 0.05),
        (Id::TrackingTime, 3.0),
    ];
    let is_set =
        || set.iter().for_each(|(id, value)| assert!((number(&bench, *id) - value).abs() < 1e-6, "{id:?}"));
    is_set();
    let said = bench.succeeds("deploy paper.toml");
    assert!(said.contains("kp_bar_per_mm           0.01, stays"), "{said}");
    is_set();
    // What is asked for changes, what is not stays; and what changes is said.
    let said = bench.succeeds("deploy paper.toml --kp 0.02");
    assert!(said.contains("kp_bar_per_mm           0.01 -> 0.02: as asked for"), "{said}");
    assert!(
        (number(&bench, Id::Kp) - 0.02).abs() < 1e-6 && (number(&bench, Id::CommandMax) - 2.0).abs() < 1e-6
    );
}

/// The order to commit is lost on its way: what is installed tells.
#[test]
fn a_deployment_behind_which_the_board_has_another_configuration_is_said() {
    let mut commits = 0;
    let bench = Bench::disturbed(move |way, bytes| {
        let address = Id::UploadOrder.register().address.to_be_bytes();
        let is_commit = way == Way::ToBoard
            && bytes.get(2..4) == Some(&address)
            && bytes.len() > 4
            && bytes[..bytes.len() - 2].ends_with(&UploadOrder::Commit.number().to_be_bytes());
        commits += usize::from(is_commit);
        if is_commit && commits > 1 { Vec::new() } else { bytes }
    });
    bench.succeeds("deploy paper.toml --kp 0.01");
    let said = bench.refuses("deploy paper.toml --kp 0.02 --timeout-s 0.1");
    assert!(
        said.contains("another configuration installed than the one that was sent: deploy it again"),
        "{said}"
    );
    assert!((number(&bench, Id::Kp) - 0.01).abs() < 1e-6, "it has the one before");
}

#[test]
fn a_limit_that_a_new_model_does_not_allow_is_brought_to_its_range_and_said() {
    let bench = Bench::new();
    bench.succeeds("deploy paper.toml --max-bar 5.5 --min-bar 2.5");
    bench
        .write("small.toml", &bench.read("paper.toml").replace("input_max_bar = 6.0", "input_max_bar = 2.0"));
    let dry = bench.succeeds("deploy small.toml --dry-run");
    assert!(dry.contains("command_max_bar         5.5 -> 2: the model's range ends there"), "{dry}");
    assert!((number(&bench, Id::CommandMax) - 5.5).abs() < 1e-6, "nothing has changed");
    let said = bench.succeeds("deploy small.toml");
    assert!(said.contains("command_min_bar         2.5 -> 0: the model's range ends there"), "{said}");
    assert_eq!((number(&bench, Id::CommandMin), number(&bench, Id::CommandMax)), (0.0, 2.0));
    // A limit that was the model's end follows the next model's.
    let said = bench.succeeds("deploy paper.toml");
    assert!(
        said.contains("command_max_bar         2 -> 6: the end of the model's range, as before"),
        "{said}"
    );
    let message = bench.refuses("deploy paper.toml --min-bar 3 --max-bar 3");
    assert!(message.contains("the lowest command, 3 bar, must be below the highest, 3 bar"), "{message}");
    let message = bench.refuses("deploy paper.toml --kp 11");
    assert!(message.contains("kp_bar_per_mm is to be 11; the board takes 0 to 10"), "{message}");
}

#[test]
fn a_model_that_is_off_by_more_than_ten_percent_of_stroke_is_deployed_by_force_only() {
    let bench = Bench::new();
    let mut model = bench.read("paper.toml");
    let _ = write!(
        model,
        "\n[identification]\nrecording = \"rec.csv\"\nsha256 = \"00\"\ntool = \"mgpi\"\nscored_rows = 100\n\
         stroke_mm = 100.0\nstarts = 1\ntermination = \"converged\"\nstandard_errors = {{}}\n\
         training = {{ rmse_mm = 27.0, mae_mm = 20.0, max_error_mm = 60.0 }}\n"
    );
    bench.write("poor.toml", &model);
    let message = bench.refuses("deploy poor.toml");
    assert!(
        message.contains("RMSE 27.00 % of stroke") && message.contains("--force deploys it all the same"),
        "{message}"
    );
    assert_eq!(bench.status()["state"], "Off");
    bench.succeeds("deploy poor.toml --force");
    bench.write("ref.csv", "time_s,reference_mm\n0,10\n1,20\n");
    let said = bench.succeeds("track --reference ref.csv --model poor.toml");
    assert!(said.contains("RMSE 27.00 % of stroke") && said.contains("the board has this model"), "{said}");
    let said = bench.succeeds("track --reference ref.csv");
    assert!(said.contains("what it is worth is not known here"), "{said}");
}

#[test]
fn a_model_in_other_units_is_deployed_as_the_same_model() {
    let bench = Bench::new();
    bench.succeeds("deploy paper.toml");
    let model = bench.read("paper.toml").replace("_bar", "_kpa").replace("_mm", "_cm");
    let model =
        model.replace("= 0.3385", "= 0.003385").replace("input_max_kpa = 6.0", "input_max_kpa = 600.0");
    let weights = "[6.035, 1.23, 2.025, 3.47, 1.785, -1.19, -0.35, -2.0049999999999997, -1.115, 3.125]";
    let start = model.find("weights_cm = ").expect("there") + "weights_cm = ".len();
    let end = start + model[start..].find('\n').expect("a line");
    bench.write("kpa.toml", &format!("{}{weights}{}", &model[..start], &model[end..]));
    let said = bench.succeeds("deploy kpa.toml");
    assert!(said.contains("kpa.toml: converted from kPa and cm to bar and mm"), "{said}");
    assert!(said.contains("the board has this model already"), "{said}");
}

#[test]
fn a_backup_restores_a_board_that_was_changed_in_everything() {
    let bench = Bench::new();
    let mut model = bench.read("paper.toml");
    model += "\n[extensions]\nvalve_lag = { time_constant_s = 0.048, lead_limit_bar = 1.7 }\n\
              creep = { time_constants_s = [0.1, 1.3], fractions = [0.02, 0.03] }\n\
              load = { reference_n = 20.3, knots_mm = [0.1, 60.7], offset_bar_per_n = [0.011, 0.023] }\n";
    bench.write("extended.toml", &model);
    bench.succeeds("deploy extended.toml --kp 0.0123 --ki 0.3 --kd 1e-4 --slew-bar-per-s 7.7 --max-bar 4.4");
    protect(&bench, 0.3);
    bench.succeeds("backup -o board.toml");
    let kept = bench.read("board.toml");
    for words in
        ["kp_bar_per_mm = 0.0123\n", "[model.extensions.valve_lag]", "number = 1\n", "vented_bar = 0.3\n"]
    {
        assert!(kept.contains(words), "{words} is missing in\n{kept}");
    }

    bench.succeeds(
        "deploy paper.toml --kp 0.4 --ki 0.5 --kd 0.1 --slew-bar-per-s 70 --max-bar 5.4 --min-bar 0.3",
    );
    protect(&bench, 0.6);
    let dry = bench.succeeds("restore board.toml --dry-run");
    for words in [
        "controller.kp_bar_per_mm             0.4 -> 0.0123",
        "protection.vented_bar                0.6 -> 0.3",
    ] {
        assert!(dry.contains(words), "{words} is missing in\n{dry}");
    }
    assert!((number(&bench, Id::Kp) - 0.4).abs() < 1e-6, "a dry run changes nothing");
    let said = bench.succeeds("restore board.toml");
    assert!(said.contains("board.toml is restored, read back and verified"), "{said}");
    bench.succeeds("backup -o again.toml");
    assert_eq!(bench.read("again.toml"), kept, "bit for bit");
    assert!(bench.succeeds("restore board.toml").contains("the board has all of board.toml already"));
    assert!(bench.refuses("backup -o board.toml").contains("exists already; --force overwrites it"));
}

/// What stands under a heading of a backup.
fn section<'a>(backup: &'a str, heading: &str) -> &'a str {
    let start = backup.find(heading).expect(heading) + heading.len();
    backup[start..].split("\n[").next().expect("a section").trim()
}

#[test]
fn a_backup_restores_how_a_board_is_reached_and_what_its_sensors_have_shown() {
    let bench = Bench::new();
    bench.succeeds("bus --set-number 17 --set-baud 19200 --set-parity even --set-turnaround-us 2500");
    bench.succeeds("calibrate pressure --low 0 --high 4 --readings 0.1,4.3");
    protect(&bench, 0.3);
    bench.succeeds("backup -o board.toml");
    let kept = bench.read("board.toml");
    let bus = "bus_number = 17\nbus_parity = 1\nbus_rate_bit_per_s = 19200\nbus_turnaround_us = 2500";
    assert_eq!(section(&kept, "[bus]"), bus, "{kept}");
    let day = number(&bench, Id::CalibrationDay);
    assert!(section(&kept, "[calibration]").contains(&format!("calibration_day = {day}")), "{kept}");

    // To another board, which is told of it before, and keeps of its own what it is told to.
    let other = Bench::new();
    other.write("board.toml", &kept);
    let dry = other.succeeds("restore board.toml --dry-run");
    for words in [
        "bus.bus_number                       1 -> 17",
        "calibration.calibration_day",
        "or of another one of the same number",
    ] {
        assert!(dry.contains(words), "{words} is missing in\n{dry}");
    }
    protect(&other, 0.6);
    other.succeeds("restore board.toml --keep-bus --keep-calibration");
    assert_eq!((number(&other, Id::BusNumber), number(&other, Id::CalibrationDay)), (1.0, 0.0));
    let said = other.succeeds("restore board.toml");
    assert!(said.contains("taken at the board's next start, or by mgpi bus --take"), "{said}");
    other.succeeds("backup -o again.toml");
    let again = other.read("again.toml");
    for heading in ["[bus]", "[calibration]", "[protection]"] {
        assert_eq!(section(&again, heading), section(&kept, heading), "bit for bit");
    }
}

#[test]
fn a_backup_of_the_format_before_leaves_the_bus_and_the_calibration_as_they_are() {
    let bench = Bench::new();
    protect(&bench, 0.3);
    bench.succeeds("backup -o new.toml");
    let without = |text: &str, heading: &str| {
        let start = text.find(heading).expect(heading);
        let end = text[start + 1..].find("\n[").map_or(text.len(), |length| start + length + 2);
        format!("{}{}", &text[..start], &text[end..])
    };
    let old = without(&without(&bench.read("new.toml"), "[bus]"), "[calibration]");
    bench.write("old.toml", &old.replacen("format = 2", "format = 1", 1));
    protect(&bench, 0.6);
    bench.succeeds("bus --set-number 17");
    bench.succeeds("calibrate pressure --low 0 --high 4 --readings 0.1,4.3");
    let day = number(&bench, Id::CalibrationDay);
    let said = bench.succeeds("restore old.toml --force");
    assert!(said.contains("protection.vented_bar") && !said.contains("bus."), "{said}");
    assert!((number(&bench, Id::VentedBar) - 0.3).abs() < 1e-6);
    assert_eq!((number(&bench, Id::BusNumber), number(&bench, Id::CalibrationDay)), (17.0, day));
}

#[test]
fn a_file_that_is_no_sound_backup_is_refused_with_its_line() {
    let bench = Bench::new();
    bench.succeeds("deploy paper.toml");
    protect(&bench, 0.3);
    bench.succeeds("backup -o board.toml");
    let kept = bench.read("board.toml");
    let line = |of: &str| 1 + kept.lines().position(|line| line.starts_with(of)).expect(of);
    let changed = |from: &str, to: &str| {
        assert!(kept.contains(from), "{from}");
        bench.write("bad.toml", &kept.replacen(from, to, 1));
        bench.refuses("restore bad.toml")
    };
    let starts = |message: &str, line: usize, what: &str| {
        let start = format!("error: bad.toml, line {line}: {what}");
        assert!(message.starts_with(&start), "{message} does not start with {start}");
    };
    starts(
        &changed("vented_bar = 0.3", "vented_bar = 0.4"),
        line("sha256"),
        "sha256: the lines below have another one",
    );
    starts(&changed("format = 2", "format = 3"), line("format"), "format: 3 is of another version");
    bench.write("bad.toml", &kept[..kept.len() / 2]);
    assert!(bench.refuses("restore bad.toml").contains("bad.toml, line "));
    // What was changed by hand is taken by force, if it is whole.
    let by_force = |from: &str, to: &str| {
        bench.write("bad.toml", &kept.replacen(from, to, 1));
        bench.refuses("restore bad.toml --force")
    };
    starts(&by_force("vented_bar", "vent_bar"), line("[protection]"), "[protection] vented_bar: missing");
    let message = by_force("[controller]\n", "[controller]\ngain = 1\n");
    starts(&message, line("[controller]") + 1, "[controller] gain: unknown key");
    let message = by_force("messages = ", "messages = 9");
    starts(&message, line("messages"), "[board] messages: 9");
    let message = by_force("bus_number = 1", "bus_number = 248");
    starts(&message, line("bus_number"), "[bus] bus_number: 248 is out of range, must be 1 to 247");
    let message = by_force("calibration_day = 0", "calibration_day = 0.5");
    starts(&message, line("calibration_day"), "[calibration] calibration_day: 0.5 is no whole number");
    let message =
        by_force("calibrated_pressure_codes_per_bar = 327.6", "calibrated_pressure_codes_per_bar = 500");
    assert!(message.contains("pressure: 1.5262516 times the standard sensor's gain"), "{message}");
    assert!((number(&bench, Id::CalibratedPressureGain) - 327.6).abs() < 1e-3);
    let message = by_force("q = 0.2959", "q = -0.2959");
    assert!(message.contains("no configuration that a board takes: q is -0.29589"), "{message}");
    let message = by_force("vented_bar = 0.3", "vented_bar = inf");
    assert!(message.contains("vented_bar is to be inf; the board takes 0 to 1"), "{message}");
    bench.write("bad.toml", &kept.replacen("vented_bar = 0.3", "vented_bar = 0.4", 1));
    bench.succeeds("restore bad.toml --force");
    assert!((number(&bench, Id::VentedBar) - 0.4).abs() < 1e-6);
}

#[test]
fn a_board_that_refuses_a_backup_has_what_it_had() {
    let bench = Bench::new();
    bench.succeeds("deploy paper.toml --kp 0.0123");
    protect(&bench, 0.3);
    bench.succeeds("backup -o board.toml");
    let other = Bench::new();
    protect(&other, 0.6);
    other.succeeds("backup -o new.toml");
    // A board without a model has no backup that one with a model could be brought to.
    bench.write("new.toml", &other.read("new.toml"));
    let message = bench.refuses("restore new.toml");
    assert!(message.contains("the backup is of a board without a model"), "{message}");
    bench.succeeds("backup -o after.toml");
    assert_eq!(bench.read("after.toml"), bench.read("board.toml"));
    // The other way round it gets everything.
    other.write("board.toml", &bench.read("board.toml"));
    other.succeeds("restore board.toml");
    other.succeeds("backup -o after.toml");
    assert_eq!(other.read("after.toml"), bench.read("board.toml"));
}

#[test]
fn a_muscle_that_does_not_follow_is_said_in_words_and_in_the_figures() {
    let bench = Bench::new();
    bench.succeeds("deploy paper.toml --max-bar 1");
    bench.write("ref.csv", "time_s,reference_mm\n0,0\n3,90\n6,0\n");
    let output = bench.run("track --reference ref.csv --json figures.json");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(output.status.success() && said.contains("the muscle did not follow: RMSE "), "{said}");
    assert!(said.contains("The command was at its upper limit, 1 bar, for "), "{said}");
    let figures: serde_json::Value = serde_json::from_str(&bench.read("figures.json")).expect("JSON");
    assert_eq!(figures["tracking"]["followed"], false);
    assert!(said.contains(figures["tracking"]["not_followed_because"].as_str().expect("words")));
}

#[test]
fn a_backup_from_before_a_calibration_is_not_called_another_board_s() {
    let bench = Bench::new();
    bench.succeeds("backup -o board.toml");
    bench.succeeds("calibrate pressure --low 0 --high 4 --readings 0.1,4.3");
    let dry = bench.succeeds("restore board.toml --dry-run");
    assert!(dry.contains("is from before this board was calibrated"), "{dry}");
    assert!(dry.contains("pressure_codes_per_unit") && !dry.contains("is of another board"), "{dry}");
}

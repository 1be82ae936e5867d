//! A model in other units than a board's is converted exactly: it simulates the same, in converted
//! units.

use std::path::Path;

use identification::HostExtendedModel;
use model_core::extension::ValveLagParameters;
use recording::model_file::ModelFile;
use recording::simulation::Rows;

/// Head of a model from kPa to m. One kPa is 0.01 bar, one m 1000 mm.
const HEAD: &str = r#"
format = 1
input = { column = "command_kpa" }
output = { column = "length_m" }
validity = { input_min_kpa = 10.0, input_max_kpa = 600.0, preconditioned = true }
"#;
const TANH: &str = r#"{ kind = "tanh", c0 = 1.6867, c1_per_kpa = 0.003385, c2 = -0.2319, c3 = 0.3211 }"#;
const LATER: &str = r#"{ kind = "tanh", c0 = 1.6867, c1_per_kpa = 0.003385, c2 = -0.2319, c3 = 0.4211 }"#;
const KNOTS: &str = r#"{ kind = "piecewise_linear", knots_kpa = [0.0, 150.0, 400.0, 600.0], values = [-0.1, 0.4, 1.5, 1.9] }"#;
const PLAYS: &str = r#"{ density = "exponential", count = 8, q = 0.3, rho = 0.18, tau = 5.5, alpha = 0.08 }"#;
const FREE: &str = r#"{ density = "free", q = 0.3, alpha_kpa = 12.0, weights = [0.1, 0.05, 0.2] }"#;
const OF_INPUT: &str =
    r#"{ density = "exponential", count = 8, q = 0.3, rho = 0.18, tau_per_kpa = 0.02, alpha_kpa = 9.0 }"#;
const LINE: &str = "{ gain_m = 0.06, offset_m = 0.003 }";
const ZONES: &str = "{ thresholds = [0.0, 0.1, 0.4], weights_m = [0.06, 0.012, -0.02], offset_m = 0.003 }";

/// Models of every kind, with their names.
fn models() -> Vec<(&'static str, String)> {
    let both = format!("{{ rising = {TANH}, falling = {LATER} }}");
    let of_input = "{ gain_m_per_kpa = 3e-4, offset_m = 0.003 }";
    let zones_of_input =
        "{ thresholds_kpa = [0.0, 50.0, 90.0], weights_m_per_kpa = [3e-4, 1e-4, -5e-5], offset_m = 0.003 }";
    vec![
        ("cpi", format!("kind = \"cpi\"\nplays = {OF_INPUT}\nline = {of_input}")),
        ("cpi of free weights", format!("kind = \"cpi\"\nplays = {FREE}\nline = {of_input}")),
        ("mpi", format!("kind = \"mpi\"\nplays = {OF_INPUT}\ndead_zones = {zones_of_input}")),
        ("sgpi", format!("kind = \"sgpi\"\nenvelope = {TANH}\nplays = {PLAYS}\nline = {LINE}")),
        ("mgpi, tanh", mgpi(TANH)),
        ("mgpi, piecewise linear", mgpi(KNOTS)),
        ("agpi", format!("kind = \"agpi\"\nenvelope = {both}\nplays = {PLAYS}\nline = {LINE}")),
        (
            "egpi",
            format!(
                "kind = \"egpi\"\nenvelope = {both}\nplays = {PLAYS}\nline = {LINE}\n\
                 memoryless = {{ rises_m = [0.002, 0.004, 0.003] }}"
            ),
        ),
    ]
}

fn mgpi(envelope: &str) -> String {
    format!("kind = \"mgpi\"\nenvelope = {envelope}\nplays = {PLAYS}\ndead_zones = {ZONES}")
}

/// Every extension, those with a side on either. Exponents above 1, so that rates too small for an
/// extension, which are told apart by the unit, are too small for the result as well.
const EXTENSIONS: [&str; 24] = [
    r#"valve_deadband = { band_kpa = 5.0, form = "backlash" }"#,
    r#"valve_deadband = { band_kpa = 5.0, form = "hold" }"#,
    "supply_saturation = { supply_kpa = 450.0 }",
    "valve_lag = { time_constant_s = 0.05, lead_limit_kpa = 150.0 }",
    "valve_lag = { time_constant_s = 0.05, lead_limit_kpa = 150.0, damping_ratio = 0.8 }",
    "valve_lag = { time_constant_s = 0.05, lead_limit_kpa = 150.0, absolute_supply_kpa = 900.0, \
     absolute_outside_kpa = 101.325 }",
    "transport_delay = { delay_s = 0.015 }",
    "load = { reference_n = 20.0, knots_m = [0.01, 0.06, 0.11], offset_kpa_per_n = [1.0, 2.0, 4.0] }",
    r#"load = { acts_on = "contraction", reference_n = 20.0, knots_m = [0.01], offset_m_per_n = [1e-4] }"#,
    "temperature = { reference_c = 25.0, knots_m = [0.01, 0.06], offset_kpa_per_k = [-1.0, 2.0] }",
    r#"temperature = { acts_on = "contraction", reference_c = 25.0, knots_m = [0.0], offset_m_per_k = [1e-4] }"#,
    "warm_up = { travel_m = 0.3, knots_m = [0.01, 0.11], offset_kpa = [30.0, 10.0] }",
    r#"warm_up = { acts_on = "contraction", travel_m = 0.3, knots_m = [0.01, 0.11], offset_m = [0.003, 0.001] }"#,
    "viscous_lag = { knots_m = [0.01, 0.06], viscosity_kpa_s_per_m = [200.0, 300.0] }",
    r#"viscous_lag = { acts_on = "contraction", knots_m = [0.01, 0.06], viscosity_s = [0.02, 0.03] }"#,
    "inertia = { knots_m = [0.01, 0.06], inertia_kpa_s2_per_m = [3.0, 2.0] }",
    r#"inertia = { acts_on = "contraction", knots_m = [0.06], inertia_s2 = [1e-4] }"#,
    "rate_dependent_width = { radius_kpa = 10.0, exponent = 1.5, filter_s = 0.05, knots_m = [0.01, 0.06], \
     width_kpa = [0.05, 0.1] }",
    "rate_dependent_thresholds = { exponent = 1.5, filter_s = 0.05, knots_m = [0.01, 0.06], gain = [20.0, 30.0] }",
    "rate_dependent_thresholds = { exponent = 1.5, filter_s = 0.05, knots_m = [0.01], gain = [20.0], \
     pressure_gain = 1e-3, resolution_kpa = 0.5 }",
    "creep = { time_constants_s = [0.1, 1.0, 10.0], fractions = [0.02, 0.03, 0.03] }",
    r#"creep = { acts_on = "pressure", time_constants_s = [0.1, 1.0], fractions = [0.02, 0.03] }"#,
    "drift = { rate_m_per_s = 1e-4, compensated = false }",
    "periodic_disturbance = { amplitude_m = 5e-4, frequency_hz = 3.0, phase_rad = 1.0, compensated = true }",
];

/// A model from kPa to m, and what becomes of it for a board.
fn converted(text: &str) -> (ModelFile, ModelFile) {
    let model = ModelFile::parse(Path::new("model.toml"), &format!("{HEAD}{text}")).expect(text);
    let board = model.for_board().expect("a pressure and a length").expect("valid");
    (model, board)
}

/// The largest difference of both models' outputs over triangles of falling height, as a share of
/// the stroke.
fn difference(model: &ModelFile, board: &ModelFile) -> f64 {
    let time_s: Vec<f64> = (0..3000).map(|row| 0.01 * f64::from(row)).collect();
    let triangle = |t: &f64| {
        let phase = (t / 4.0).fract();
        10.0 + (590.0 - 15.0 * t) * (1.0 - (2.0 * phase - 1.0).abs())
    };
    let kpa: Vec<f64> = time_s.iter().map(triangle).collect();
    let bar: Vec<f64> = kpa.iter().map(|kpa| 0.01 * kpa).collect();
    let load: Vec<f64> = time_s.iter().map(|t| 20.0 + 5.0 * (0.7 * t).sin()).collect();
    let temperature: Vec<f64> = time_s.iter().map(|t| 25.0 + 0.2 * t).collect();
    let answer = |file: &ModelFile, input: &[f64]| {
        let model = HostExtendedModel::try_new(&file.parameters, &file.extensions).expect("valid");
        let rows = Rows { time_s: &time_s, input, load: Some(&load), temperature: Some(&temperature) };
        rows.answer(&model.with_tolerance(0.0)).expect("answered")
    };
    let (m, mm) = (answer(model, &kpa), answer(board, &bar));
    let range = |values: &[f64]| {
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    assert!(range(&m) > 0.01, "it moves");
    m.iter().zip(&mm).map(|(m, mm)| (1e3 * m - mm).abs()).fold(0.0, f64::max) / range(&mm)
}

#[test]
fn a_model_of_any_kind_simulates_the_same_in_the_units_of_a_board() {
    for (name, text) in models() {
        let (model, board) = converted(&text);
        assert_eq!((board.input.name.as_str(), board.output.name.as_str()), ("command_bar", "length_mm"));
        let difference = difference(&model, &board);
        assert!(difference < 1e-12, "{name}: {difference:e} of the stroke");
        // And so does what is written of it.
        let again = ModelFile::parse(Path::new("board.toml"), &board.to_toml()).expect(name);
        assert_eq!(again.parameters.kind(), model.parameters.kind());
        let difference = self::difference(&model, &again);
        assert!(difference < 1e-12, "{name}, written: {difference:e} of the stroke");
    }
}

#[test]
fn an_extension_of_any_kind_does_the_same_in_the_units_of_a_board() {
    for extension in EXTENSIONS {
        let (plain, _) = converted(&mgpi(TANH));
        let (model, board) = converted(&format!("{}\n[extensions]\n{extension}", mgpi(TANH)));
        assert_eq!(model.causes(), board.causes());
        let difference = difference(&model, &board);
        assert!(difference < 1e-12, "{extension}: {difference:e} of the stroke");
        assert!(self::difference(&plain, &board) > 1e-9, "{extension} acts");
    }
}

#[test]
fn a_models_figures_are_converted_with_it() {
    let identification = r#"
[identification]
recording = "rec.csv"
sha256 = "00"
tool = "mgpi"
scored_rows = 100
stroke_m = 0.1
starts = 1
termination = "converged"
training = { rmse_m = 0.001, mae_m = 0.0005, max_error_m = 0.01 }
standard_errors = { c1_per_kpa = 1e-5, w0_m = 1e-3, q = 0.1 }
"#;
    let (_, board) = converted(&format!("{}{identification}", mgpi(TANH)));
    let identification = board.identification.as_ref().expect("kept");
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12 * expected, "{found}");
    near(identification.stroke, 100.0);
    near(identification.training.rmse, 1.0);
    near(identification.training.max_error, 10.0);
    let errors: Vec<f64> = identification.standard_errors.iter().map(|(_, error)| *error).collect();
    errors.iter().zip([1e-3, 0.1, 1.0]).for_each(|(found, expected)| near(*found, expected));
}

#[test]
fn a_model_without_a_pressure_or_a_length_stays_as_it_is() {
    let text = format!("{HEAD}{}", mgpi(TANH));
    for text in [text.replace("_kpa", "_v"), text.replace("_m =", "_n =").replace("_m\"", "_n\"")] {
        let model = ModelFile::parse(Path::new("model.toml"), &text).expect("valid");
        assert!(model.for_board().is_none(), "{} to {}", model.input, model.output);
    }
}

#[test]
fn a_lead_limit_that_is_not_given_is_two_bar_in_any_unit() {
    let (model, board) =
        converted(&format!("{}\n[extensions.valve_lag]\ntime_constant_s = 0.05", mgpi(TANH)));
    let limit = |file: &ModelFile| file.extensions.valve_lag.expect("there").lead_limit;
    assert_eq!((limit(&model), limit(&board)), (200.0, 2.0));
    // That of a lag that was found in a recording is in bar, whatever the recording's unit.
    let (mut found, _) = converted(&mgpi(TANH));
    found.extensions.valve_lag = Some(ValveLagParameters::new(0.05));
    assert_eq!(limit(&found.with_usual_lead_limit()), 200.0);
}

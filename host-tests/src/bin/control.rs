//! The benchmark of control: controllers, references and plants, as a table; and plants of the zoo
//! from their recordings to tracking, without a knob turned.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::{Parser, ValueEnum};
use host_tests::PERIOD_S;
use host_tests::control::controller::{Controller, Tunings};
use host_tests::control::course::{Converter, Setting, run};
use host_tests::control::drift::{self, Drifted};
use host_tests::control::known::{Desk, model};
use host_tests::control::reach;
use host_tests::control::reference::Course;
use host_tests::control::score::{Score, score};
use host_tests::control::sensitivity::largest;
use host_tests::control::subject::Subject;
use host_tests::game::zoo;
use indicatif::{ProgressBar, ProgressStyle};
use model_core::{Hysteresis, Tracking};
use rayon::prelude::*;
use recording::model_file::ModelFile;
use recording::model_file::control::{Observer, Tuning};
use rig::zoo::family::Part;
use tuning::learning::Learner;
use tuning::tune;

/// Passes of the learning.
const PASSES: usize = 6;

/// Unit: byte.
const STACK_BYTES: usize = 64 << 20;

/// Holds controllers against each other, on the same plants and references.
#[derive(Parser)]
struct Cli {
    /// In place of the table: this many plants of the zoo, each from its recording to tracking
    #[arg(long, value_name = "N")]
    zoo: Option<usize>,
    /// The first seed of the zoo's plants
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Which families of the zoo
    #[arg(long, default_value = "development")]
    families: Families,
    /// Also keep models in this folder, and take them from there
    #[arg(long, value_name = "DIR")]
    models: Option<PathBuf>,
    /// Only plants that have this in their name
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// The table for these plants too: the rig with a delay, a mass, a viscous lag
    #[arg(long)]
    all: bool,
    /// In place of the table: half an hour of a muscle that warms up, by the feed-forward alone
    #[arg(long)]
    drift: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Families {
    Development,
    Validation,
    Sealed,
}

impl Families {
    fn part(self) -> Part {
        match self {
            Self::Development => Part::Development,
            Self::Validation => Part::Validation,
            Self::Sealed => Part::Sealed,
        }
    }
}

fn main() -> Result<()> {
    let cli = Cli::parse();
    // A diagnosis keeps models of the largest size on the stack.
    rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES).build_global()?;
    match cli.zoo {
        Some(plants) => of_zoo(&cli, plants),
        None if cli.drift => of_drift(&cli),
        None => table(&cli),
    }
}

/// A plant with its model and the feedback that goes with it.
struct Ready {
    subject: Subject,
    model: ModelFile,
    tunings: Tunings,
}

impl Ready {
    fn of(subject: Subject, desk: Desk, kept: Option<&Path>) -> Result<Self> {
        let file = kept.map(|folder| folder.join(format!("{subject} {desk:?}.toml").replace(' ', "_")));
        let found = file.as_ref().filter(|file| file.exists());
        let model = match found {
            Some(file) => ModelFile::read(file)?,
            None => model(&subject.recording(), desk)?,
        };
        if let (Some(file), None) = (&file, found) {
            std::fs::create_dir_all(file.parent().context("no folder")?)?;
            std::fs::write(file, model.to_toml())?;
        }
        let tuned = |observes| tune(&model, PERIOD_S, None, observes).map(|tuned| tuned.tuning);
        let tunings = Tunings { alone: tuned(false)?, observed: tuned(true)? };
        Ok(Self { subject, model, tunings })
    }

    /// What the model reaches. Unit: mm.
    fn range_mm(&self) -> (f64, f64) {
        self.model.model.output_range()
    }

    fn run(&self, controller: Controller, course: Course, correction_mm: &[f64]) -> Result<Scored> {
        self.run_within(self.range_mm(), controller, course, correction_mm)
    }

    /// With a reference between these contractions (mm).
    fn run_within(
        &self,
        range_mm: (f64, f64),
        controller: Controller,
        course: Course,
        correction_mm: &[f64],
    ) -> Result<Scored> {
        let parameters = controller.parameters(&self.model, &self.tunings)?;
        let tracking = Tracking::try_new(&parameters)?;
        let reference_mm = course.points(range_mm);
        let setting = Setting {
            tracking: &tracking,
            mode: controller.mode(),
            preview_s: f64::from(parameters.extensions.preview_s(parameters.period_s)),
            reference_mm: &reference_mm,
            correction_mm,
            course,
            blocked_n: self.subject.blocked_n(),
            converter: Converter::Steps,
        };
        let ticks = run(&setting, &mut self.subject.plant(true), |_, mm| mm);
        let tick = |s: f64| Course::from_tick() + (s / PERIOD_S).round() as usize;
        let disturbed: Vec<usize> = match course {
            Course::Held => vec![tick(2.0), tick(7.0)],
            Course::Steps => (0..8).map(|step| tick(3.0 * f64::from(step))).collect(),
            _ => Vec::new(),
        };
        let score = score(&ticks, Course::from_tick(), self.model.stroke(), &disturbed, course.highest_hz());
        Ok(Scored {
            score,
            error_mm: ticks.iter().map(|tick| tick.reference_mm - tick.measured_mm).collect(),
        })
    }

    /// The scores of the passes of a learning.
    fn learn(&self, controller: Controller, course: Course) -> Result<Vec<Score>> {
        let ticks = course.points(self.range_mm()).len();
        let mut learner = Learner::new(ticks, PERIOD_S, controller.tuning(&self.tunings).learning_hz);
        let mut scores = Vec::new();
        for _ in 0..PASSES {
            let Scored { score, error_mm } = self.run(controller, course, learner.correction())?;
            scores.push(score);
            learner.learn(&error_mm);
        }
        Ok(scores)
    }

    fn line(&self) -> String {
        let causes = self.model.causes().join("+");
        let words = |tuning: &Tuning| {
            let Tuning { kp, ki, kd, maximum_sensitivity, bandwidth_hz, learning_hz, .. } = tuning;
            format!(
                "kp {kp:.4} bar/mm, ki {ki:.4} bar/(mm s), kd {kd:.5} bar s/mm, largest sensitivity {maximum_sensitivity:.2}, \
                 bandwidth {:.2} to {:.2} Hz, learning to {learning_hz:.2} Hz, limited by {}",
                bandwidth_hz.0, bandwidth_hz.1, tuning.limited_by
            )
        };
        let Tunings { alone, observed } = &self.tunings;
        let observer = observed.observer.map_or("none gains anything".to_owned(), |Observer { slope, reach, band }| {
            format!(
                "{}; the gains are for {slope:.1} mm/bar and grow up to {reach:.1} times, band {band:.3} mm",
                words(observed)
            )
        });
        format!(
            "{}: model {:.2} % of stroke{}{causes}; {}\n    observer: {observer}",
            self.subject,
            self.model.worth().map_or(f64::NAN, |worth| worth.percent()),
            if causes.is_empty() { "" } else { ", " },
            words(alone)
        )
    }
}

struct Scored {
    score: Score,
    error_mm: Vec<f64>,
}

fn table(cli: &Cli) -> Result<()> {
    use rig::effect::Effect;
    let rig = |effects: &[Effect], rich| Subject::Rig { effects: effects.to_vec(), rich, seed: 5 };
    let mut plants = vec![(rig(&[], false), Desk::Identify), (rig(&[], true), Desk::Diagnose)];
    if cli.all {
        for effect in [Effect::TransportDelay, Effect::Inertia, Effect::ViscousLag, Effect::Creep] {
            plants.push((rig(&[effect], true), Desk::Diagnose));
        }
    }
    let courses = [
        Course::Paper,
        Course::Triangles(0.1),
        Course::Cosines(0.2, 0.6),
        Course::Cosines(0.5, 0.6),
        Course::Cosines(2.0, 0.2),
        Course::Multisine,
        Course::Steps,
        Course::Held,
    ];
    let ready: Vec<Result<Ready>> =
        plants.into_iter().map(|(subject, desk)| Ready::of(subject, desk, cli.models.as_deref())).collect();
    for ready in ready {
        let ready = ready?;
        println!("\n{}", ready.line());
        println!("RMSE / largest error in % of stroke, settling into 1 % in s, effort in bar/s");
        print!("{:<22}", "");
        courses.iter().for_each(|course| print!(" {:>22}", course.name()));
        println!();
        let jobs: Vec<(Controller, Course)> = Controller::ALL
            .into_iter()
            .flat_map(|controller| courses.map(|course| (controller, course)))
            .collect();
        let scores: Vec<Result<Scored>> =
            jobs.par_iter().map(|(controller, course)| ready.run(*controller, *course, &[])).collect();
        for (row, controller) in scores.chunks(courses.len()).zip(Controller::ALL) {
            print!("{:<22}", controller.name());
            for scored in row {
                match scored {
                    Ok(scored) => print!(" {:>22}", cell(&scored.score)),
                    Err(error) => print!(" {error:>22}"),
                }
            }
            println!();
        }
        let learnt: Vec<Result<Vec<Score>>> =
            courses[..6].par_iter().map(|course| ready.learn(Controller::Tuned, *course)).collect();
        for pass in 1..PASSES {
            print!("{:<22}", format!("after pass {pass}"));
            for scores in &learnt {
                match scores {
                    Ok(scores) => print!(" {:>22}", cell(&scores[pass])),
                    Err(error) => print!(" {error:>22}"),
                }
            }
            println!();
        }
    }
    Ok(())
}

/// Half an hour with what is sound and with what warms up, for both ways to record.
fn of_drift(cli: &Cli) -> Result<()> {
    use rig::effect::Effect;
    println!(
        "RMSE of the feed-forward alone behind the first minute, % of stroke; the worst minute over that of the sound muscle"
    );
    for (rich, desk) in [(false, Desk::Identify), (true, Desk::Diagnose)] {
        let of_sound = Subject::Rig { effects: Vec::new(), rich, seed: FIRST_SEED };
        let ready = Ready::of(of_sound, desk, cli.models.as_deref())?;
        let parameters = Controller::Inverse.parameters(&ready.model, &ready.tunings)?;
        let tracking = Tracking::try_new(&parameters)?;
        let preview_s = f64::from(parameters.extensions.preview_s(parameters.period_s));
        let share = |drifted: &Drifted| 100.0 * drifted.whole_mm() / ready.model.stroke();
        for (course, name) in DRIFT_COURSES {
            let given = (course, preview_s, ready.range_mm());
            let run = |effects: &[Effect], seed: u64, learns: bool| {
                let subject = Subject::Rig { effects: effects.to_vec(), rich, seed };
                drift::run(&tracking, &mut subject.plant(true), given, !effects.is_empty(), learns)
            };
            let fresh = run(&[], FIRST_SEED, false);
            let learnt = run(&[], FIRST_SEED, true);
            println!(
                "{} {name}: sound {:.3}, with adaptation {:.3}, {:.2}",
                if rich { "many speeds" } else { "slow triangles" },
                share(&fresh),
                share(&learnt),
                learnt.worst_over(&fresh)
            );
            let (low, high) = ready.range_mm();
            let lower = (course, preview_s, (low - SHIFT_MM, high - SHIFT_MM));
            let lower = drift::run(&tracking, &mut fresh_plant(rich), lower, false, false);
            println!(
                "  sound, the reference {SHIFT_MM} mm lower: {:.3}, {:.2}",
                share(&lower),
                lower.worst_over(&fresh)
            );
            let warm = [Effect::Temperature, Effect::WarmUp];
            let seeds: Vec<u64> = (FIRST_SEED..FIRST_SEED + DRIFT_SEEDS).collect();
            let runs: Vec<_> = seeds
                .par_iter()
                .map(|&seed| (seed, run(&warm, seed, false), run(&warm, seed, true)))
                .collect();
            for (seed, plain, learnt) in &runs {
                println!(
                    "  warming, seed {seed}: {:.3}, {:.1}; with adaptation {:.3}, {:.2}; {:?}",
                    share(plain),
                    plain.worst_over(&fresh),
                    share(learnt),
                    learnt.worst_over(&fresh),
                    learnt.change
                );
            }
        }
    }
    Ok(())
}

/// By how much lower a sound muscle is asked, to show what the model is worth there: the muscles that
/// contract further when warm do so by 11 to 16 mm (printed by --drift). Unit: mm.
const SHIFT_MM: f64 = 12.0;

/// The sound muscle.
fn fresh_plant(rich: bool) -> rig::plant::Plant {
    Subject::Rig { effects: Vec::new(), rich, seed: FIRST_SEED }.plant(true)
}

/// Of the rig whose model is taken, and of the first that warms up.
const FIRST_SEED: u64 = 5;
/// How many that warm up.
const DRIFT_SEEDS: u64 = 8;
/// What they follow: 0.2 to 0.8 of the range, which a muscle that is a tenth of it longer or shorter
/// still reaches.
const DRIFT_COURSES: [(Course, &str); 3] = [
    (Course::Cosines(0.05, 0.6), "0.05 Hz"),
    (Course::Cosines(0.2, 0.6), "0.2 Hz"),
    (Course::Multisine, "0.05 to 2 Hz"),
];

fn cell(score: &Score) -> String {
    let settling = score.settling_s.map_or(String::new(), |s| format!(" {s:.2}"));
    let swings = if score.is_stable { "" } else { " SWINGS" };
    format!("{:.3}/{:.2}{settling} {:.0}{swings}", score.rmse, score.largest, score.effort_bar_per_s)
}

/// What becomes of a plant of the zoo with a controller.
struct Outcome {
    is_stable: bool,
    promised: f64,
    measured: f64,
    /// On each course, beside that with the fixed gains. Percent of stroke.
    rmse: Vec<(f64, f64)>,
    /// The same on the first course between where the model comes back to and its highest.
    within: (f64, f64),
    /// What of the first course the plant does not reach, by whatever controller. Percent of stroke.
    beyond: f64,
    /// What is left of the error of the first course after all passes, with the best of them.
    left: f64,
}

/// The courses of the zoo.
const COURSES: [Course; 4] = [Course::Paper, Course::Cosines(0.2, 0.6), Course::Multisine, Course::Steps];
/// The controllers of the zoo.
const CONTROLLERS: [Controller; 2] = [Controller::Tuned, Controller::Observed];

fn of_zoo(cli: &Cli, plants: usize) -> Result<()> {
    let exhibits = zoo::games(cli.first_seed, plants, &[cli.families.part()]);
    let subjects: Vec<Subject> = exhibits
        .into_iter()
        .map(|exhibit| Subject::Zoo(Box::new(exhibit)))
        .filter(|subject| cli.only.as_ref().is_none_or(|text| subject.to_string().contains(text)))
        .collect();
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} plants, {eta} left")?;
    let bar = ProgressBar::new(subjects.len() as u64).with_style(style);
    let outcomes: Vec<Option<[Outcome; 2]>> = subjects
        .par_iter()
        .map(|subject| {
            let said =
                match Ready::of(subject.clone(), Desk::Diagnose, cli.models.as_deref()).and_then(|ready| {
                    let [alone, observed] = CONTROLLERS.map(|controller| outcome(&ready, controller));
                    Ok(([alone?, observed?], ready))
                }) {
                    Ok((outcomes, ready)) => {
                        let lines = outcomes.each_ref().map(Outcome::line);
                        (
                            format!("{}\n    alone {}\n    observer {}", ready.line(), lines[0], lines[1]),
                            Some(outcomes),
                        )
                    }
                    Err(error) => (format!("{subject}: REFUSED: {error:#}"), None),
                };
            bar.suspend(|| println!("{}", said.0));
            bar.inc(1);
            said.1
        })
        .collect();
    bar.finish_and_clear();
    let all = outcomes.len();
    let done: Vec<&[Outcome; 2]> = outcomes.iter().flatten().collect();
    ensure!(!done.is_empty(), "no plant was tuned");
    println!("{} of {all} tuned, {} refused", done.len(), all - done.len());
    for (k, controller) in CONTROLLERS.iter().enumerate() {
        println!("{}:", controller.name());
        summary(&done.iter().map(|outcomes| &outcomes[k]).collect::<Vec<_>>());
    }
    Ok(())
}

fn summary(done: &[&Outcome]) {
    let count = |is: &dyn Fn(&Outcome) -> bool| done.iter().filter(|outcome| is(outcome)).count();
    println!("stable: {} of {}", count(&|outcome| outcome.is_stable), done.len());
    println!(
        "largest sensitivity at most 1.2 times the promised one: {} of {}",
        count(&|outcome| outcome.measured <= 1.2 * outcome.promised),
        done.len()
    );
    let mut left: Vec<f64> = done.iter().map(|outcome| outcome.left).collect();
    left.sort_by(f64::total_cmp);
    println!(
        "what {PASSES} passes of learning leave of the error, {}: median {:.3}, most {:.3}",
        COURSES[0].name(),
        left[left.len() / 2],
        left[left.len() - 1]
    );
    let beyond = done.iter().map(|outcome| outcome.beyond).fold(0.0, f64::max);
    println!(
        "beyond what the plant reaches, {}: in {} of {}, RMSE of at most {beyond:.2} % of stroke",
        COURSES[0].name(),
        count(&|outcome| outcome.beyond > 0.0),
        done.len()
    );
    let ratios = |name: &str, of: &dyn Fn(&Outcome) -> (f64, f64)| {
        let mut ratios: Vec<f64> =
            done.iter().map(|outcome| of(outcome)).map(|(ours, fixed)| ours / fixed).collect();
        ratios.sort_by(f64::total_cmp);
        println!(
            "RMSE over that of fixed gains, {name}: median {:.3}, largest {:.3}; worse in {} of {}",
            ratios[ratios.len() / 2],
            ratios[ratios.len() - 1],
            ratios.iter().filter(|ratio| **ratio > 1.0).count(),
            ratios.len()
        );
    };
    ratios(&format!("{} from where the model comes back to", COURSES[0].name()), &|outcome| outcome.within);
    for (k, course) in COURSES.iter().enumerate() {
        ratios(&course.name(), &|outcome| outcome.rmse[k]);
    }
}

impl Outcome {
    fn line(&self) -> String {
        let ratios: Vec<String> =
            self.rmse.iter().map(|(ours, fixed)| format!("{ours:.3}/{fixed:.3}")).collect();
        let (within, fixed) = self.within;
        format!(
            "{} sensitivity {:.2} of {:.2} promised; RMSE beside that of fixed gains, % of stroke: {}; the first one within \
             reach {within:.3}/{fixed:.3}, beyond it {:.3}; {:.2} of the first one after {PASSES} passes",
            if self.is_stable { "stable," } else { "UNSTABLE," },
            self.measured,
            self.promised,
            ratios.join(" "),
            self.beyond,
            self.left
        )
    }
}

fn outcome(ready: &Ready, controller: Controller) -> Result<Outcome> {
    let (mut rmse, mut is_stable) = (Vec::new(), true);
    for course in COURSES {
        let ours = ready.run(controller, course, &[])?.score;
        let fixed = ready.run(Controller::Fixed, course, &[])?.score;
        is_stable &= ours.is_stable;
        rmse.push((ours.rmse, fixed.rmse));
    }
    let parameters = controller.parameters(&ready.model, &ready.tunings)?;
    let measured = largest(&ready.subject, &parameters, ready.range_mm());
    let passes = ready.learn(controller, COURSES[0])?;
    let best = passes.iter().map(|pass| pass.rmse).fold(f64::INFINITY, f64::min);
    let left = best / passes[0].rmse;
    let promised = controller.tuning(&ready.tunings).maximum_sensitivity;
    let within = |controller| ready.run_within(reach::of_model(&ready.model), controller, COURSES[0], &[]);
    let within = (within(controller)?.score.rmse, within(Controller::Fixed)?.score.rmse);
    let reference_mm = &COURSES[0].points(ready.range_mm())[Course::from_tick()..];
    let reached_mm = reach::of_plant(&ready.subject, &ready.model);
    let beyond = 100.0 * reach::beyond_mm(reference_mm, reached_mm) / ready.model.stroke();
    Ok(Outcome { is_stable, promised, measured, rmse, within, beyond, left })
}

//! A set of causes with its fit, and what it costs.

use super::causes::{Cause, Law};
use super::effect::{Effect, Form};
use super::fit::Fit;
use super::fitted::Doubt;
use super::gain::Score;
use super::second_order::{DAMPED, RINGS, has_mass_and_viscosity_in_balance};
use recording::numbers::root_mean_square;

/// What a set costs whose creep is the tail of a faster effect, as a difference of logarithms of errors: no gain makes up for it.
const NEVER: f64 = 1e3;
/// Weight of the pure error beside the held-out one.
const PURE: f64 = 0.3;
/// What a second cause that resists motion has to be better by: neither is quite of our form. Not a lag before a mass, which
/// together are a form of their own.
const ALIKE: f64 = 0.08;
/// What a set has to be better by whose motion does not show: its inertia may be two other causes that lag.
const UNSEEN: f64 = 0.3;
/// The same of an inertia alone: it has no more than its rivals, a lag, or a lag and a delay.
const UNSEEN_ALONE: f64 = 0.05;
/// What a set has to be better by whose warm-up takes strokes away: whatever else fades looks like that.
const FADING: f64 = 0.3;
/// What a set with a lag has to be better by where its small delay, which belongs to the baseline, is as long as it may be:
/// it is then a lag and a delay.
const LEANING: f64 = 0.1;
/// What a viscous force beside a width that has one in it has to gain.
const VISCOUS: f64 = 0.05;
/// The share of a bound from which on a parameter counts as at it.
const WHOLE: f64 = 0.98;

/// A set of causes, fitted.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Each with its effect.
    pub causes: Vec<Cause>,
    /// The fit; its first effect is a delay of at most half a row, unless a delay is one of the causes.
    pub fit: Fit,
    /// Its held-out error.
    pub score: Score,
    /// Measured less simulated, free-running where the measured contraction enters otherwise, a value a scored row.
    pub residual: Vec<f64>,
    /// What differs between visits to the same state, if there are enough. Output unit.
    pub pure_error: Option<f64>,
    /// The same where states that are no longer visited twice count too. Output unit.
    pub spread: Option<f64>,
    /// What speaks against its causes.
    pub doubts: Vec<Doubt>,
    /// The damping ratio of its mass, if it has one, by all that damps it.
    pub damping_ratio: Option<f64>,
}

impl Candidate {
    /// What is minimised: the logarithm of the held-out error, and in part that of the pure error; of two causes that
    /// explain the same the simpler one is preferred.
    pub fn cost(&self) -> f64 {
        let pure = self.spread.map_or(0.0, |error| PURE * error.max(1e-12).ln());
        let alone = 1 + usize::from(self.is_third_order());
        let dynamic = self.causes.iter().filter(|cause| cause.resists_motion()).count().saturating_sub(alone);
        let complexity: f64 = self.causes.iter().map(|cause| cause.about().complexity).sum();
        let unseen = match &self.causes[..] {
            _ if !self.doubts.contains(&Doubt::Unseen) => 0.0,
            [one] if one.law() == Law::Mass => UNSEEN_ALONE,
            _ => UNSEEN,
        };
        let leaning = if self.leans() { LEANING } else { 0.0 };
        let fading = if self.doubts.contains(&Doubt::Fading) { FADING } else { 0.0 };
        let never = if self.outlasts() && !self.is_absent() { 0.0 } else { NEVER };
        let form = ALIKE * dynamic as f64 + unseen + leaning + fading + never;
        self.score.mean().max(1e-12).ln() + pure + complexity + self.containment() + form
    }

    /// Whether the motion that its causes name shows.
    pub fn shows(&self) -> bool {
        !self.doubts.contains(&Doubt::Unseen) && !self.is_faint() && !self.is_absent()
    }

    /// Whether a time that one of its causes names does not show by itself.
    pub fn is_faint(&self) -> bool {
        self.doubts.contains(&Doubt::Faint)
    }

    /// Whether something that its causes name is not there.
    fn is_absent(&self) -> bool {
        self.doubts.contains(&Doubt::Absent)
    }

    /// Whether what it names as slow goes on beyond the longest hold.
    pub fn outlasts(&self) -> bool {
        !self.doubts.contains(&Doubt::Over)
    }

    /// How much less a later set costs; not counted is what only decides between causes that contain each other.
    pub fn evidence(&self, later: &Self) -> f64 {
        (self.cost() - self.containment()) - (later.cost() - later.containment())
    }

    /// The error of its simulation alone, nothing taken off that is repeated at every visit to a state: root mean square. Output unit.
    pub fn simulated_error(&self) -> f64 {
        root_mean_square(&self.residual)
    }

    /// How many causes it comes to: beside a mass that hardly overshoots the viscosity that damps it is named too, and beside one
    /// that does overshoot no viscous force in the same balance.
    pub fn count(&self) -> usize {
        let is_one = has_mass_and_viscosity_in_balance(&self.fit) && !self.is_damped();
        self.causes.len() + usize::from(self.comes_to_more()) - usize::from(is_one)
    }

    /// Whether it comes to one cause more than it has.
    pub fn comes_to_more(&self) -> bool {
        self.is_damped() && !self.has(Law::Viscosity)
    }

    /// The causes that it names: a mass that hardly overshoots has the viscosity in it that damps it.
    pub fn names(&self) -> Vec<Cause> {
        let damping = self.comes_to_more().then(|| Cause::of_law(Law::Viscosity)).flatten();
        self.causes.iter().copied().chain(damping).collect()
    }

    fn has(&self, law: Law) -> bool {
        self.causes.iter().any(|cause| cause.law() == law)
    }

    /// What it has to be better by than what its causes contain. A mass that overshoots has more in it than a lag.
    fn containment(&self) -> f64 {
        if self.rings() { 0.0 } else { self.causes.iter().map(|cause| cause.about().containment).sum() }
    }

    /// Whether it has a mass that overshoots.
    fn rings(&self) -> bool {
        self.damping_ratio.is_some_and(|ratio| ratio < RINGS)
    }

    /// Whether it has one that hardly does.
    fn is_damped(&self) -> bool {
        self.damping_ratio.is_some_and(|ratio| ratio >= DAMPED)
    }

    /// Whether a cause that resists motion has the help of a small delay that is as long as it may be. A damped mass alone
    /// is a lag and a delay by itself.
    fn leans(&self) -> bool {
        let is_both = self.causes.len() == 1 && self.is_damped();
        self.causes.iter().any(|cause| cause.resists_motion()) && has_whole_small_delay(&self.fit) && !is_both
    }

    /// Where its width, the only fast cause, has a viscous force in it: the same set with such a force beside, if that was looked
    /// at and is worth it. Alone the width has taken most of the force for its own, and what is left of it is too little to be
    /// worth a cause.
    pub fn with_viscosity(&self, looked_at: &[Vec<Self>]) -> Option<Self> {
        let is_alone = self.causes.iter().filter(|cause| cause.is_fast()).count() == 1;
        if !is_alone || !self.has_viscous_width() {
            return None;
        }
        let is_both = |other: &&Self| {
            let has = |cause: &Cause| cause.law() == Law::Viscosity || self.causes.contains(cause);
            other.causes.len() == self.causes.len() + 1 && other.causes.iter().all(has)
        };
        let both = looked_at.iter().flatten().find(is_both)?;
        (self.score.gain(&both.score) >= VISCOUS).then(|| both.clone())
    }

    /// Whether its width grows as nearly as the speed as it may, and no viscous force stands beside.
    pub fn has_viscous_width(&self) -> bool {
        let of_width = |effect: &&Effect| matches!(effect.form, Form::Thresholds(_) | Form::Friction(_));
        let power = self.fit.effects.iter().find(of_width).and_then(|effect| effect.parameters.first());
        let is_alone = !self.has(Law::Viscosity);
        is_alone && power.is_some_and(|power| power.value >= WHOLE * power.high)
    }

    /// Whether it has a lag before a mass, on the output.
    pub fn is_third_order(&self) -> bool {
        self.fit.effects.iter().any(|effect| effect.form == Form::LagBefore)
    }
}

/// Whether the delay that no recording is free of is as long as it may be.
fn has_whole_small_delay(fit: &Fit) -> bool {
    let small = fit.effects.iter().filter(|effect| effect.form == Form::Delay);
    let delay = small.flat_map(|effect| &effect.parameters).find(|delay| delay.low < 0.0);
    delay.is_some_and(|delay| delay.value >= WHOLE * delay.high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::Seen;
    use crate::causes::cause;
    use crate::effect::{Driver, Parameter, Rate};

    /// With a small delay of a share of its bound.
    fn set(causes: &[Cause], damping_ratio: Option<f64>, share: f64) -> Candidate {
        let small = Parameter { value: 5e-3 * share, low: -5e-3, high: 5e-3, step: 1e-3 };
        let fit = Fit {
            effects: vec![Effect { form: Form::Delay, parameters: vec![small] }],
            seen: Seen::default(),
            weights: Vec::new(),
            residual: Vec::new(),
            unseen: Vec::new(),
        };
        Candidate {
            causes: causes.to_vec(),
            fit,
            score: Score { blocks: vec![1.0] },
            residual: Vec::new(),
            pure_error: None,
            spread: None,
            doubts: Vec::new(),
            damping_ratio,
        }
    }

    #[test]
    fn a_mass_pays_for_the_lag_that_it_contains_unless_it_rings() {
        let mass = |ratio| set(&[cause("inertia")], Some(ratio), 0.0).cost();
        assert_eq!(mass(0.2), set(&[], None, 0.0).cost());
        assert_eq!(mass(0.7), mass(0.2) + cause("inertia").about().containment);
    }

    #[test]
    fn a_lag_leans_on_a_whole_small_delay_and_a_damped_mass_alone_does_not() {
        let leaning = |causes: &[Cause], ratio| {
            set(causes, ratio, 1.0).cost() - set(causes, ratio, 0.5).cost() > 0.5 * LEANING
        };
        assert!(leaning(&[cause("viscous_lag")], None));
        assert!(leaning(&[cause("inertia")], Some(0.3)));
        assert!(!leaning(&[cause("inertia")], Some(0.8)));
        assert!(leaning(&[cause("inertia"), cause("creep")], Some(0.8)));
    }

    #[test]
    fn a_width_that_grows_nearly_as_the_speed_has_a_viscous_force_in_it() {
        let width = |power, error, causes: &[Cause]| {
            let mut set = set(causes, None, 0.0);
            let power = Parameter { value: power, low: 0.2, high: 0.75, step: 1e-3 };
            set.fit.effects.push(Effect { form: Form::Thresholds(Rate::Input), parameters: vec![power] });
            Candidate { score: Score { blocks: vec![error] }, ..set }
        };
        let alone = [cause("rate_dependent_width")];
        let both = [cause("viscous_lag"), cause("rate_dependent_width")];
        let looked_at = vec![vec![], vec![width(0.7, 0.9, &both)]];
        let named = |set: Candidate| set.with_viscosity(&looked_at).map(|both| both.causes);
        assert_eq!(named(width(0.75, 1.0, &alone)), Some(both.to_vec()));
        assert_eq!(named(width(0.6, 1.0, &alone)), None);
        assert_eq!(named(width(0.75, 0.8, &alone)), None);
        assert_eq!(named(width(0.75, 1.0, &[cause("transport_delay"), cause("rate_dependent_width")])), None);
    }

    #[test]
    fn a_damped_mass_comes_to_two_causes() {
        assert_eq!(set(&[cause("inertia")], Some(0.8), 0.0).count(), 2);
        assert_eq!(set(&[cause("inertia")], Some(0.3), 0.0).count(), 1);
        assert_eq!(set(&[cause("inertia"), cause("viscous_lag")], Some(0.8), 0.0).count(), 2);
    }

    #[test]
    fn a_mass_that_overshoots_and_the_viscous_force_in_its_balance_come_to_one_cause() {
        let both = |forms: [Form; 2], ratio| {
            let mut set = set(&[cause("inertia"), cause("viscous_lag")], Some(ratio), 0.0);
            set.fit.effects.extend(forms.map(|form| Effect { form, parameters: Vec::new() }));
            set.count()
        };
        let in_balance = [Form::Inertia, Form::Driven(Driver::Rate)];
        assert_eq!(both(in_balance, 0.3), 1);
        assert_eq!(both(in_balance, 0.8), 2);
        assert_eq!(both([Form::Inertia, Form::OutputLag], 0.3), 2);
    }
}

//! The parameters of a fit: what a nominal model does not know exactly, and the sizes of a hypothesis' effects.
//!
//! ```text
//!   value = start · e^{s x}   of a positive quantity,       value = start + s x   otherwise
//! ```
//! `x` is what is fitted, with a normal prior of mean 0 and precision `ρ`: 1 for the nuisances, so that `s` is their prior deviation, and 0.01 for sizes of
//! effects. Friction and gap come from the regression, masses and constants from the model file with its stated accuracy; a value that is
//! stated to be exact is no parameter.

use nalgebra::DVector;

use super::gears::Gear;
use super::hypothesis::{Free, Hypothesis, Scale};
use super::subject::Setup;
use crate::effects::Catalogue;
use crate::gearhead::{Exponential, FrictionLaw, Lines};
use crate::robot::{EffectEntry, Model};

/// Prior deviations of the logarithms of dry and viscous friction, Stribeck velocity and gap: a regression over smooth rows finds the first
/// within some per cent, and the others within a factor.
const DRY: f64 = 0.1;
const VISCOUS: f64 = 0.3;
const STRIBECK: f64 = 0.5;
const GAP: f64 = 0.15;
/// The same of dry friction where a law has next to none.
const UNKNOWN_DRY: f64 = 1.0;
/// The same of a gear's damping, which nobody measures.
const DAMPING: f64 = 0.7;
/// [1] Prior deviation of the rise of breakaway above dry friction, and of the share of friction behind the gap.
const RISE: f64 = 0.1;
const LINK_SHARE: f64 = 0.15;
/// [A] The same of the offset of a current sensor: a converter's step or so.
const OFFSET: f64 = 0.01;
/// [1] The same of the weight `w` of a current: the time at which a bus reads it.
const WEIGHT: f64 = 0.2;
/// What the names of the bodies' deviations begin with.
const BODIES: &str = "bodies";
/// Numbers of a body, see [`Model::deviating`].
pub(super) const NUMBERS: usize = crate::robot::Inertia::NUMBERS;

/// What a parameter is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    Coulomb(usize),
    Rise(usize),
    StribeckVelocity(usize),
    Viscous(usize),
    LinkShare(usize),
    Gap(usize),
    Stiffness(usize),
    Damping(usize),
    Offset(usize),
    Weight,
    /// Deviations of the nominal values, see [`Model::deviating`].
    Deviation(DVector<f64>),
    /// A parameter of an effect, by the effect's index.
    Effect(usize, String),
}

/// A parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub name: String,
    pub kind: Kind,
    /// Its value where `x` is zero.
    pub start: f64,
    /// `s`.
    scale: f64,
    /// Whether it is positive and changes by factors.
    positive: bool,
    min: f64,
    max: f64,
    /// `ρ`.
    pub precision: f64,
}

impl Parameter {
    fn additive(name: String, kind: Kind, start: f64, scale: f64) -> Self {
        let (min, max) = (f64::NEG_INFINITY, f64::INFINITY);
        Self { name, kind, start, scale, positive: false, min, max, precision: 1.0 }
    }

    fn positive(name: String, kind: Kind, start: f64, scale: f64) -> Self {
        Self { positive: true, ..Self::additive(name, kind, start, scale) }
    }

    /// Its value at `x`.
    pub fn value(&self, x: f64) -> f64 {
        let value = if self.positive { self.start * (self.scale * x).exp() } else { self.start + self.scale * x };
        value.clamp(self.min, self.max)
    }

    /// `x` of a value.
    fn position(&self, value: f64) -> f64 {
        if self.positive { (value / self.start).ln() / self.scale } else { (value - self.start) / self.scale }
    }

    /// The parameter where only these effects are left; `None` of another effect.
    pub fn of_effects(&self, kept: &[usize]) -> Option<Self> {
        let kind = match &self.kind {
            Kind::Effect(effect, name) => Kind::Effect(kept.iter().position(|one| one == effect)?, name.clone()),
            kind => kind.clone(),
        };
        Some(Self { kind, ..self.clone() })
    }

    /// Whether it is a deviation of the bodies, see [`inertial`].
    pub fn is_of_bodies(&self) -> bool {
        self.name.starts_with(BODIES)
    }

    /// `|∂value/∂x|`, limits aside.
    pub fn slope(&self, x: f64) -> f64 {
        if self.positive { self.scale * self.value(x) } else { self.scale }
    }
}

/// The model with some dry friction in laws that have none, so that it can grow.
pub(super) fn with_dry_friction(model: &Model) -> Model {
    let mut model = model.clone();
    for friction in model.joints.iter_mut().filter_map(|joint| joint.friction.as_mut()) {
        let FrictionLaw::Exponential(sides) = &mut friction.law else { continue };
        for side in sides {
            let least = least_dry(side);
            if side.coulomb < least {
                (side.coulomb, side.breakaway) = (least, side.breakaway.max(least));
            }
        }
    }
    model
}

/// [N·m or N] Dry friction below which a law has next to none: half of its viscous friction at the Stribeck velocity, where a law with dry friction has several times
/// as much. A fit only begins there. The rise of breakaway, a ratio, stays finite.
fn least_dry(side: &Exponential) -> f64 {
    (0.5 * side.viscous * side.stribeck_velocity).max(1e-3 * side.breakaway).max(f64::MIN_POSITIVE)
}

/// Everything of a model that the data may know better.
pub(super) fn nuisances(model: &Model) -> Vec<Parameter> {
    let mut all = vec![Parameter::additive("weight".to_owned(), Kind::Weight, 0.0, WEIGHT)];
    for (i, joint) in model.joints.iter().enumerate() {
        let name = |what: &str| format!("{}.{what}", joint.name);
        if let Some(friction) = &joint.friction {
            let [level, viscous] = levels(&friction.law);
            let is_known = match &friction.law {
                FrictionLaw::Exponential(sides) => sides.iter().all(|side| side.coulomb > least_dry(side)),
                FrictionLaw::TwoLines(_) => true,
            };
            let dry = if is_known { DRY } else { UNKNOWN_DRY };
            all.push(Parameter::positive(name("coulomb"), Kind::Coulomb(i), level, dry));
            all.push(Parameter::positive(name("viscous"), Kind::Viscous(i), viscous, VISCOUS));
            if let FrictionLaw::Exponential([one, other]) = &friction.law {
                let rise = 0.5 * (one.breakaway / one.coulomb + other.breakaway / other.coulomb) - 1.0;
                let rise = Parameter::additive(name("rise"), Kind::Rise(i), rise, RISE);
                // Friction that rises from rest is no rise of breakaway; a model that has it keeps it.
                all.push(Parameter { min: rise.start.min(0.0), ..rise });
                let speed = 0.5 * (one.stribeck_velocity + other.stribeck_velocity);
                all.push(Parameter::positive(name("stribeck_velocity"), Kind::StribeckVelocity(i), speed, STRIBECK));
            }
            let share = Parameter::additive(name("link_share"), Kind::LinkShare(i), friction.link_share, LINK_SHARE);
            all.push(Parameter { min: 0.0, max: 1.0, ..share });
        }
        all.extend(joint.backlash.filter(|gap| *gap > 0.0).map(|value| gap(i, &joint.name, value)));
        if let Some(stiffness) = joint.gear_stiffness.filter(|_| model.accuracy.stiffness > 0.0) {
            let scale = model.accuracy.stiffness;
            all.push(Parameter::positive(name("gear_stiffness"), Kind::Stiffness(i), stiffness, scale));
        }
        if let Some(damping) = joint.gear_damping.filter(|damping| *damping > 0.0) {
            all.push(Parameter::positive(name("gear_damping"), Kind::Damping(i), damping, DAMPING));
        }
        all.push(Parameter::additive(name("offset"), Kind::Offset(i), 0.0, OFFSET));
    }
    all.extend(constants(model));
    all
}

/// Rotor inertias and torque constants, in standard deviations.
fn constants(model: &Model) -> Vec<Parameter> {
    let n = model.joints.len();
    let mut all = Vec::new();
    for (i, joint) in model.joints.iter().enumerate() {
        let unit = |index: usize| DVector::from_fn((NUMBERS + 2) * n, |row, _| f64::from(u8::from(row == index)));
        let mut push = |what: &str, index: usize| {
            let name = format!("{}.{what} [σ]", joint.name);
            all.push(Parameter::additive(name, Kind::Deviation(unit(index)), 0.0, 1.0));
        };
        if model.accuracy.rotor_inertias > 0.0 && joint.rotor_inertia.is_some() {
            push("rotor_inertia", NUMBERS * n + i);
        }
        if model.constant_accuracy(i) > 0.0 && joint.motor.is_some() {
            push("torque_constant", (NUMBERS + 1) * n + i);
        }
    }
    all
}

/// Deviations of the bodies along these directions, in standard deviations.
pub(super) fn inertial(model: &Model, directions: &[DVector<f64>]) -> Vec<Parameter> {
    let length = (NUMBERS + 2) * model.joints.len();
    let one = |(k, direction): (usize, &DVector<f64>)| {
        let whole = direction.clone().resize_vertically(length, 0.0);
        Parameter::additive(format!("{BODIES}.{} [σ]", k + 1), Kind::Deviation(whole), 0.0, 1.0)
    };
    directions.iter().enumerate().map(one).collect()
}

/// The sizes of a hypothesis' effects at one of its starts.
pub(super) fn sizes(hypothesis: &Hypothesis, start: &[EffectEntry], catalogue: &Catalogue) -> Vec<Parameter> {
    /// Of a size that is expected within ten scales.
    const PRECISION: f64 = 0.01;
    let one = |free: &Free| {
        let entry = start.get(free.effect)?;
        let spec = catalogue.find(&entry.effect)?.about().parameters.iter().find(|one| one.name == free.parameter)?;
        let name = entry.joint.as_ref().map_or_else(String::new, |joint| format!("{joint}."));
        let name = format!("{name}{}.{}", entry.effect, free.parameter);
        let value = entry.parameters.get(&free.parameter).copied().or(spec.default).unwrap_or(0.0);
        let kind = Kind::Effect(free.effect, free.parameter.clone());
        let parameter = match free.scale {
            Scale::By(scale) => Parameter::additive(name, kind, value, scale),
            Scale::Times(scale) => Parameter::positive(name, kind, value, scale),
        };
        Some(Parameter { min: spec.min, max: spec.max, precision: PRECISION, ..parameter })
    };
    hypothesis.free.iter().filter_map(one).collect()
}

/// Moves gap and link share of `x` to those of a start's gears; a gap that the model does not have becomes a parameter.
pub(super) fn put_gears(model: &Model, gears: &[Option<Gear>], parameters: &mut Vec<Parameter>, x: &mut Vec<f64>) {
    for (joint, gear) in gears.iter().enumerate().filter_map(|(joint, gear)| Some((joint, gear.as_ref()?))) {
        let known = parameters.iter().any(|parameter| parameter.kind == Kind::Gap(joint));
        if !known && gear.gap > 0.0 {
            parameters.push(gap(joint, &model.joints[joint].name, gear.gap));
            x.push(0.0);
        }
        for (parameter, x) in parameters.iter().zip(x.iter_mut()) {
            match parameter.kind {
                Kind::Gap(of) if of == joint && gear.gap > 0.0 => *x = parameter.position(gear.gap),
                Kind::LinkShare(of) if of == joint => *x = parameter.position(gear.share),
                _ => {}
            }
        }
    }
}

/// Moves sizes of effects to those of the same effects on the same joints that were sought.
pub(super) fn put_sizes(effects: &[EffectEntry], sought: &[EffectEntry], parameters: &[Parameter], x: &mut [f64]) {
    for (parameter, x) in parameters.iter().zip(x) {
        let Kind::Effect(effect, name) = &parameter.kind else { continue };
        let own = effects.get(*effect);
        let same = own.and_then(|own| sought.iter().find(|one| one.effect == own.effect && one.joint == own.joint));
        if let Some(value) = same.and_then(|one| one.parameters.get(name)) {
            *x = parameter.position(*value);
        }
    }
}

fn gap(joint: usize, name: &str, gap: f64) -> Parameter {
    Parameter::positive(format!("{name}.backlash"), Kind::Gap(joint), gap, GAP)
}

/// The setup at `x`, from a model with the effects of a start.
pub(super) fn setup(model: &Model, effects: &[EffectEntry], parameters: &[Parameter], x: &[f64]) -> Setup {
    let mut model = model.clone();
    model.effects.extend(effects.iter().cloned());
    let first = model.effects.len() - effects.len();
    let mut setup = Setup { weight: 0.0, offsets: vec![0.0; model.joints.len()], model };
    let mut deviations = DVector::zeros((NUMBERS + 2) * setup.model.joints.len());
    for (parameter, x) in parameters.iter().zip(x) {
        match &parameter.kind {
            Kind::Deviation(direction) => deviations += direction * parameter.value(*x),
            Kind::Effect(effect, name) => {
                setup.model.effects[first + effect].parameters.insert(name.clone(), parameter.value(*x));
            }
            _ => put(&mut setup, parameter, parameter.value(*x)),
        }
    }
    if deviations.iter().any(|u| *u != 0.0) {
        setup.model = setup.model.deviating(deviations.as_slice());
    }
    setup
}

/// Gives a parameter of a joint a value.
fn put(setup: &mut Setup, parameter: &Parameter, value: f64) {
    let factor = if parameter.start > 0.0 { value / parameter.start } else { 1.0 };
    let joints = &mut setup.model.joints;
    match parameter.kind {
        Kind::Weight => setup.weight = value,
        Kind::Offset(joint) => setup.offsets[joint] = value,
        Kind::Gap(joint) => joints[joint].backlash = Some(value),
        Kind::Stiffness(joint) => joints[joint].gear_stiffness = Some(value),
        Kind::Damping(joint) => joints[joint].gear_damping = Some(value),
        Kind::LinkShare(joint) => joints[joint].friction.iter_mut().for_each(|friction| friction.link_share = value),
        Kind::Coulomb(joint) | Kind::Viscous(joint) | Kind::Rise(joint) | Kind::StribeckVelocity(joint) => {
            let Some(friction) = &mut joints[joint].friction else { return };
            match &mut friction.law {
                FrictionLaw::Exponential(sides) => {
                    sides.iter_mut().for_each(|side| put_exponential(side, &parameter.kind, value, factor));
                }
                FrictionLaw::TwoLines(sides) => {
                    sides.iter_mut().for_each(|side| put_lines(side, &parameter.kind, factor));
                }
            }
        }
        Kind::Deviation(_) | Kind::Effect(..) => {}
    }
}

fn put_exponential(side: &mut Exponential, kind: &Kind, value: f64, factor: f64) {
    match kind {
        Kind::Coulomb(_) => (side.coulomb, side.breakaway) = (side.coulomb * factor, side.breakaway * factor),
        Kind::Viscous(_) => side.viscous *= factor,
        Kind::StribeckVelocity(_) => side.stribeck_velocity *= factor,
        Kind::Rise(_) => side.breakaway = side.coulomb * (1.0 + value),
        _ => {}
    }
}

fn put_lines(side: &mut Lines, kind: &Kind, factor: f64) {
    match kind {
        Kind::Coulomb(_) => (side.a1, side.a2) = (side.a1 * factor, side.a2 * factor),
        Kind::Viscous(_) => side.b2 *= factor,
        _ => {}
    }
}

/// Dry and viscous friction, the mean of both directions; never zero, so that they can grow.
fn levels(law: &FrictionLaw) -> [f64; 2] {
    /// Share of the dry friction, per rad/s, that stands for no viscous friction.
    const LEAST: f64 = 0.01;
    let [dry, viscous] = match law {
        FrictionLaw::Exponential([one, other]) => {
            [0.5 * (one.coulomb + other.coulomb), 0.5 * (one.viscous + other.viscous)]
        }
        FrictionLaw::TwoLines([one, other]) => [0.5 * (one.a2 + other.a2), 0.5 * (one.b2 + other.b2)],
    };
    let dry = dry.max(f64::MIN_POSITIVE);
    [dry, viscous.max(LEAST * dry)]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn with_law(side: Exponential) -> Model {
        let mut model = Model::load(Path::new("robots/scara/model.toml")).expect("a model");
        for friction in model.joints.iter_mut().filter_map(|joint| joint.friction.as_mut()) {
            friction.law = FrictionLaw::Exponential([side; 2]);
        }
        model
    }

    /// The law of the first joint at a change of one of its parameters.
    fn law_at(model: &Model, what: &str, x: f64) -> Exponential {
        let parameters = nuisances(model);
        let name = format!("{}.{what}", model.joints[0].name);
        let moved: Vec<f64> = parameters.iter().map(|one| if one.name == name { x } else { 0.0 }).collect();
        let joint = setup(model, &[], &parameters, &moved).model.joints[0].clone();
        match joint.friction.map(|friction| friction.law) {
            Some(FrictionLaw::Exponential([side, _])) => side,
            other => panic!("{other:?}"),
        }
    }

    /// Regressions of smooth motion find none where something else of that size is missing; dry friction must be able to return.
    #[test]
    fn property_dry_friction_grows_from_none() {
        let none = Exponential { coulomb: 0.0, breakaway: 0.0, stribeck_velocity: 0.5, viscous: 0.01 };
        let model = with_dry_friction(&with_law(none));
        let here = law_at(&model, "coulomb", 0.0);
        assert!(
            here.coulomb > 0.0
                && here.coulomb <= none.viscous * none.stribeck_velocity
                && here.breakaway == here.coulomb,
            "{here:?}"
        );
        // Within three prior deviations by a factor of 20.
        assert!(law_at(&model, "coulomb", 3.0).coulomb > 20.0 * here.coulomb);
        // A law that has some stays as it is.
        let some = Exponential { coulomb: 0.1, breakaway: 0.12, ..none };
        assert_eq!(with_dry_friction(&with_law(some)), with_law(some));
    }

    #[test]
    fn property_friction_that_rises_from_rest_starts_as_it_is() {
        let rising = Exponential { coulomb: 0.1, breakaway: 0.05, stribeck_velocity: 0.5, viscous: 0.01 };
        let model = with_law(rising);
        // Rounding of a ratio.
        assert!((law_at(&model, "rise", 0.0).breakaway - rising.breakaway).abs() < 1e-15);
        assert!(law_at(&model, "rise", 1.0).breakaway > rising.breakaway);
        // Falling friction does not turn into rising friction.
        let falling = with_law(Exponential { breakaway: 0.11, ..rising });
        assert!(law_at(&falling, "rise", -5.0).breakaway >= rising.coulomb);
    }
}

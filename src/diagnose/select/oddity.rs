//! What keeps a fitted term from being the effect that it is called.

use crate::diagnose::fit::problem::Problem;
use crate::diagnose::fit::term::Term;
use crate::effects::ParameterSpec;
use crate::toml_input::Range;
use crate::units::JointKind;

/// Why a term is not the effect that it is called.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Oddity {
    /// A parameter has a value, SI, outside its range.
    Outside(&'static ParameterSpec, f64),
    /// With these parameters it is another effect.
    Another,
}

impl Oddity {
    /// That of a term with these coefficients; `None` where it is the effect.
    pub fn of(problem: &Problem, term: &Term, coefficients: &[f64]) -> Option<Self> {
        let joint = term.joints[0];
        let values = term.effect.parameters(&problem.motion, joint, &term.shape, coefficients);
        let mut parameters = term.effect.about().parameters.iter().zip(values);
        let outside = parameters.find(|(spec, value)| !(spec.min..=spec.max).contains(value));
        let is_itself = || term.effect.is_itself(&problem.motion, joint, &term.shape, coefficients);
        match outside {
            Some((spec, value)) => Some(Self::Outside(spec, value)),
            None => (!is_itself()).then_some(Self::Another),
        }
    }

    /// In words, for a joint of this kind.
    pub fn words(self, kind: JointKind) -> String {
        match self {
            Self::Outside(spec, value) => {
                let range = Range::between(spec.min, spec.max, spec.unit_for(kind));
                format!("its {} would be {value:.3e}, outside its range: {range}", spec.name)
            }
            Self::Another => "what fits best is no such effect (`explain` has its equation)".to_owned(),
        }
    }
}

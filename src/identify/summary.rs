//! Converts fitted coefficients to the quantities of the report, with units, standard errors and intervals.

use nalgebra::DMatrix;

use super::fit::LawFit;
use super::law::{CENTRIFUGAL, PER_DIRECTION};
use super::least_squares::Fit;
use super::points::Point;
use super::quantity::Quantity;
use super::result::{ExponentialEstimate, FrictionIdentification, LawKind, LinesEstimate, PerDirection};
use crate::distributions::student_975;
use crate::gearhead::FrictionLaw;
use crate::robot::Model;
use crate::units::JointKind;

/// Both laws as fitted, and which of them the data prefer.
pub struct Laws {
    /// Equation 9.
    pub lines: LawFit,
    /// Equation 6.
    pub exponential: LawFit,
    /// The law with the smaller misfit.
    pub preferred: LawKind,
    /// The preferred law with `C_ii` among its unknowns.
    pub with_centrifugal: LawFit,
}

/// Friction of a joint and `C_ii`, from the fits of both laws.
pub fn friction(kind: JointKind, points: &[Point], laws: &Laws) -> (FrictionIdentification, Quantity) {
    let Laws { lines, exponential, preferred, with_centrifugal } = laws;
    let preferred = *preferred;
    let centrifugal = centrifugal_of(kind, &with_centrifugal.fit, &with_centrifugal.fit.robust());
    let found = FrictionIdentification {
        preferred,
        lines: lines_of(kind, &lines.fit, &lines.fit.robust()),
        exponential: PerDirection {
            positive: exponential_of(kind, exponential, 0),
            negative: exponential_of(kind, exponential, 1),
        },
        speeds: fastest_and_slowest(points),
    };
    (found, centrifugal)
}

/// Standard errors from zero above which `C_ii` is real: by chance in one of a thousand joints. A joint that moves alone has none, and beside a free
/// `C_ii` the error of `F_V` is ten times as large.
const REAL: f64 = 3.3;

/// Whether `C_ii` differs from zero.
pub fn centrifugal_is_real(fit: &LawFit) -> bool {
    let Quantity { value, std_error, .. } = quantity(&fit.fit, &fit.fit.robust(), CENTRIFUGAL, String::new());
    value.abs() > REAL * std_error
}

/// Smallest and largest speed of the points.
fn fastest_and_slowest(points: &[Point]) -> [f64; 2] {
    points.iter().fold([f64::INFINITY, 0.0], |[low, high], point| {
        let speed = point.velocity.abs();
        [low.min(speed), high.max(speed)]
    })
}

/// One coefficient; `errors` is the covariance of all of them.
fn quantity(fit: &Fit, errors: &DMatrix<f64>, index: usize, unit: String) -> Quantity {
    let t = student_975(fit.degrees_of_freedom as f64);
    Quantity::new(fit.parameters[index], errors[(index, index)].sqrt(), t, unit)
}

/// `C_ii`.
pub fn centrifugal_of(kind: JointKind, fit: &Fit, errors: &DMatrix<f64>) -> Quantity {
    quantity(fit, errors, CENTRIFUGAL, format!("{}·s²/{}²", kind.effort_unit(), kind.position_unit()))
}

/// Equation 9 in both directions.
pub fn lines_of(kind: JointKind, fit: &Fit, errors: &DMatrix<f64>) -> PerDirection<LinesEstimate> {
    PerDirection { positive: lines_along(kind, fit, errors, 0), negative: lines_along(kind, fit, errors, 1) }
}

/// Equation 9 in the direction of index `k`.
fn lines_along(kind: JointKind, fit: &Fit, errors: &DMatrix<f64>, k: usize) -> LinesEstimate {
    let (effort, position) = (kind.effort_unit(), kind.position_unit());
    let at = |index: usize, unit: String| quantity(fit, errors, k * PER_DIRECTION + index, unit);
    LinesEstimate {
        a1: at(0, effort.into()),
        b1: at(1, format!("{effort}·s/{position}")),
        a2: at(2, effort.into()),
        b2: at(3, format!("{effort}·s/{position}")),
        switch_velocity: switch_velocity(fit, errors, k, format!("{position}/s")),
        curve_error_percent: None,
    }
}

/// Equation 8 and its standard error to first order in the coefficients' errors.
fn switch_velocity(fit: &Fit, errors: &DMatrix<f64>, k: usize, unit: String) -> Quantity {
    let at = k * PER_DIRECTION;
    let p = &fit.parameters[at..at + PER_DIRECTION];
    let slope = p[3] - p[1];
    let value = (p[0] - p[2]) / slope;
    let gradient = [1.0 / slope, value / slope, -1.0 / slope, -value / slope];
    let mut variance = 0.0;
    for i in 0..PER_DIRECTION {
        for j in 0..PER_DIRECTION {
            variance += gradient[i] * gradient[j] * errors[(at + i, at + j)];
        }
    }
    Quantity::new(value, variance.sqrt(), student_975(fit.degrees_of_freedom as f64), unit)
}

/// Equation 6 in the direction of index `k`.
fn exponential_of(kind: JointKind, fit: &LawFit, k: usize) -> ExponentialEstimate {
    let (effort, position) = (kind.effort_unit(), kind.position_unit());
    let errors = fit.fit.robust();
    let at = |index: usize, unit: String| quantity(&fit.fit, &errors, k * PER_DIRECTION + index, unit);
    ExponentialEstimate {
        coulomb: at(0, effort.into()),
        breakaway: at(1, effort.into()),
        stribeck_velocity: at(2, format!("{position}/s")),
        viscous: at(3, format!("{effort}·s/{position}")),
        curve_error_percent: None,
    }
}

/// Number of speeds at which two curves are compared.
const COMPARED: usize = 200;

impl FrictionIdentification {
    /// Writes the truth beside every coefficient of the true law's kind, and the error of both curves.
    pub fn compare(&mut self, truth: &FrictionLaw) {
        match truth {
            FrictionLaw::Exponential(law) => {
                for (found, law) in
                    [&mut self.exponential.positive, &mut self.exponential.negative].into_iter().zip(law)
                {
                    found.coulomb.compare(law.coulomb);
                    found.breakaway.compare(law.breakaway);
                    found.stribeck_velocity.compare(law.stribeck_velocity);
                    found.viscous.compare(law.viscous);
                }
            }
            FrictionLaw::TwoLines(_) => {}
        }
        compare_lines(&mut self.lines, truth, self.speeds);
        let [positive, negative] = curve_errors_percent(&self.law(LawKind::Exponential), truth, self.speeds);
        self.exponential.positive.curve_error_percent = Some(positive);
        self.exponential.negative.curve_error_percent = Some(negative);
    }
}

/// Writes the errors of the curves beside two lines, and the truth beside every coefficient if it is of their kind.
fn compare_lines(lines: &mut PerDirection<LinesEstimate>, truth: &FrictionLaw, speeds: [f64; 2]) {
    let law = FrictionLaw::TwoLines(lines.each().map(LinesEstimate::law));
    let errors = curve_errors_percent(&law, truth, speeds);
    for (k, found) in [&mut lines.positive, &mut lines.negative].into_iter().enumerate() {
        found.curve_error_percent = Some(errors[k]);
        if let FrictionLaw::TwoLines(truth) = truth {
            found.a1.compare(truth[k].a1);
            found.b1.compare(truth[k].b1);
            found.a2.compare(truth[k].a2);
            found.b2.compare(truth[k].b2);
            found.switch_velocity.compare(truth[k].switch_velocity());
        }
    }
}

/// [`curve_error_percent`] in the positive and the negative direction.
fn curve_errors_percent(found: &FrictionLaw, truth: &FrictionLaw, speeds: [f64; 2]) -> [f64; 2] {
    [1.0, -1.0].map(|sign| curve_error_percent(found, truth, sign, speeds))
}

/// RMS difference of two laws in one direction over the RMS of the second, per cent.
fn curve_error_percent(found: &FrictionLaw, truth: &FrictionLaw, sign: f64, [low, high]: [f64; 2]) -> f64 {
    let (mut error, mut size) = (0.0, 0.0);
    for k in 0..COMPARED {
        let v = sign * (low + (high - low) * k as f64 / (COMPARED - 1) as f64);
        error += (found.kinetic(v) - truth.kinetic(v)).powi(2);
        size += truth.kinetic(v).powi(2);
    }
    100.0 * (error / size).sqrt()
}

impl super::Identification {
    /// Writes the true values of a model beside the estimates, where the model has them.
    pub fn compare(&mut self, truth: &Model) {
        for found in &mut self.joints {
            let Some(joint) = truth.joints.iter().find(|joint| joint.name == found.joint) else { continue };
            found.methods.iter_mut().for_each(|method| method.compare(joint, &truth.effects));
            if let Some(friction) = joint.friction {
                found.friction.compare(&friction.law);
                found.centrifugal.compare(0.0);
                if let Some(published) = &mut found.published.friction {
                    compare_lines(&mut published.lines, &friction.law, found.friction.speeds);
                    published.centrifugal.compare(0.0);
                }
            }
            if let Some(gap) = joint.backlash {
                found.backlash.iter_mut().for_each(|backlash| backlash.compare(gap));
                let published = [&mut found.published.backlash, &mut found.published.backlash_filtered];
                published.into_iter().flatten().for_each(|one| one.mean.compare(gap));
            }
        }
    }
}

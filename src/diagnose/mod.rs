//! What the simulation gets wrong, and why: residual, candidates, selection, extension, gain.
//!
//! ```text
//!  recordings ─ prepare ─ observe ─▶ rows of smooth motion and torque ─ zones ─▶ rigid rows
//!                                    │
//!      baseline (nominal machine, free friction) + candidates (effects) ─ problem, regression ─▶ evidence ─ selection ─▶ effects
//!                                    │                                                                                   │
//!       shares, maps, spectra, floor ◀── estimate, uncertainty, probability, extend, stand_ins, patterns, unexplained ◀──┘
//! ```
//!
//! What the torque balance of rigid rows does not show has rows and evidence of its own, and never the same rows twice:
//!
//! | module | looks at | for |
//! |---|---|---|
//! | `ripple`, `order_lines` | narrow rows while a joint moves on | lines of many periods a turn |
//! | `lines` | samples while flanks touch | lines at a fixed frequency |
//! | `reversal` | turns, against a simulation of the gear | what friction and gear do there |
//! | `slip` | throws of the rotor against the link | a coupling that slips once |
//! | `standstill`, `command` | readings at rest, commands | current sensor and drive |
//! | `two_encoders` | motor against link encoder | delay, wind-up, gap |
//! | `compare` | two recordings of one machine | what has changed |
//!
//! Before anything is fitted, `mistakes` looks for errors of data or model file that are likelier than physics; where there are any, the diagnosis
//! ends with them.

mod axes;
mod baseline;
mod candidates;
mod command;
mod compare;
mod conclude;
mod confirm;
mod division;
mod estimate;
mod extend;
mod floor;
mod gain_interval;
mod gains;
mod gaps;
mod golden;
mod held;
mod kernel;
mod lines;
mod maps;
mod mended;
/// Mistakes in data or model file that are likelier than physics.
pub mod mistakes;
mod observe;
mod order_lines;
mod patterns;
mod prepare;
mod probability;
mod problem;
mod regression;
/// What a diagnosis returns.
pub mod result;
mod reversal;
mod ripple;
mod selection;
/// Which effects a recording can tell apart.
pub mod separability;
mod shares;
mod side_by_side;
mod slip;
mod spectra;
mod stand_ins;
mod standstill;
mod timing;
mod two_encoders;
mod typical;
mod uncertainty;
mod unexplained;
mod views;
mod zones;

pub use compare::compare;
pub use result::{
    Axis, AxisShare, BaselineEstimate, CandidateRecord, Change, Diagnosis, EffectGain, FitError, FoundEffect,
    FrequencySpectrum, JointShares, Measured, Method, OrderSpectrum, ReplayError, ResidualMap, ResidualSeries, Split,
    TwoEncoders, Unexplained, Verdict, Withdrawn, Zone, ZoneShares,
};
pub use selection::Rules;
pub use typical::typical;

use crate::dynamics::Dynamics;
use crate::effects::{Catalogue, Motion};
use crate::error::{Error, Result};
use crate::robot::{Masses, Model};
use crate::timeseries::{Channel, TimeSeries};
use division::Division;
use prepare::Prepared;
use problem::{Part, Problem};

/// What can be chosen about a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// When an effect is named.
    pub rules: Rules,
    /// Part at the end of each session that is held out where no session is, 0 to 1.
    pub held_out_share: f64,
    /// Whether gaps that the model file leaves out are measured too; it takes most of the time.
    pub backlash: bool,
    /// Effects that may be named.
    pub catalogue: Catalogue,
}

impl Default for Options {
    fn default() -> Self {
        Self { rules: Rules::default(), held_out_share: 0.3, backlash: true, catalogue: Catalogue::default() }
    }
}

/// Channels that a diagnosis reads; all others may be dropped.
pub fn channels() -> Vec<Channel> {
    vec![
        Channel::Position,
        Channel::Velocity,
        Channel::Current,
        Channel::Torque,
        Channel::CommandCurrent,
        Channel::ReferenceVelocity,
        Channel::LinkPosition,
    ]
}

/// Names what the nominal model lacks; `progress` hears what is being done and which share of it (0 to 1).
///
/// `hold_out` are sessions to judge on; where there are none, the end of each training session is kept for that.
///
/// # Errors
/// A session lacks the position, or the current or torque, of a joint; or there is too little motion.
pub fn diagnose(
    model: &Model,
    train: &[TimeSeries],
    hold_out: &[TimeSeries],
    options: &Options,
    progress: &mut dyn FnMut(&str, f64),
) -> Result<Diagnosis> {
    progress("looking for mistakes", 0.0);
    let recorded: Vec<&TimeSeries> = train.iter().chain(hold_out).collect();
    let suspected = mistakes::suspected(model, &recorded);
    if !suspected.is_empty() {
        return Ok(mistakes::diagnosis(model, suspected, false, options));
    }
    progress("smoothing", 0.0);
    let division = Division::new(train.len(), recorded.len(), options.held_out_share);
    let Prepared { sessions, earlier, shaken, ripple, as_recorded } =
        prepare::prepare(model, &recorded, division, options)?;
    let sessions: Vec<&TimeSeries> = sessions.iter().map(AsRef::as_ref).collect();
    let mut problem = pose(model, &sessions, division, options)?;
    problem.taken_out = ripple;
    progress("fitting the baseline", 0.1);
    let rules = if as_recorded.is_some() { options.rules.beside_another() } else { options.rules };
    let mut selection = selection::select(&mut problem, &rules, progress).ok_or_else(|| nothing_moves(model))?;
    stand_ins::withdraw(&mut problem, &mut selection).ok_or_else(|| nothing_moves(model))?;
    if let Some(as_recorded) = as_recorded {
        selection.as_recorded = as_recorded.at_rows_of(&problem);
    }
    let confirmed = confirm::confirm(&mut problem, &mut selection, 0, &|_| true).ok_or_else(|| nothing_moves(model))?;
    let data = conclude::Data { model, sessions: &sessions, division, earlier, shaken };
    let mut diagnosis = conclude::diagnosis(&data, &problem, &selection, &confirmed, options, progress)?;
    mistakes::remaining::judge(&mut diagnosis, model, &recorded);
    Ok(diagnosis)
}

/// Rows and zones of sessions, and which of them are held out.
fn pose<'m>(model: &'m Model, sessions: &[&TimeSeries], division: Division, options: &Options) -> Result<Problem<'m>> {
    let motion = observe::observe(model, sessions, &typical_inertia(model), observe::NOISE_SHARE)?;
    let held_out = held_out_rows(&motion, sessions, division);
    let mut problem = Problem::new(motion, held_out);
    // Where masses are a guess, no torque is evidence of anything.
    problem.catalogue = match model.masses {
        Masses::Known => ripple::of_wide_rows(&options.catalogue),
        Masses::Estimated => Catalogue::empty(),
    };
    problem.standstill = standstill::Standstill::of(&problem.motion, &sessions[..division.trained()]);
    find_zones(&mut problem)?;
    Ok(problem)
}

/// Inertia of each joint with its rotor at q = 0: the scale that turns noise of acceleration into torque.
fn typical_inertia(model: &Model) -> Vec<f64> {
    let dof = model.joints.len();
    let mut mass = nalgebra::DMatrix::zeros(dof, dof);
    Dynamics::new(&model.robot).mass_matrix(&vec![0.0; dof], &mut mass);
    (0..dof).map(|joint| mass[(joint, joint)] + model.joints[joint].reflected_inertia()).collect()
}

/// Whether each row is held out.
fn held_out_rows(motion: &Motion, sessions: &[&TimeSeries], division: Division) -> Vec<bool> {
    let after: Vec<f64> = (0..sessions.len()).map(|number| division.held_out_after(number, sessions[number])).collect();
    motion.session.iter().zip(&motion.time).map(|(session, time)| *time > after[*session]).collect()
}

/// Rigid zones with a rough Coulomb friction, and again with the torque that a first fit leaves over.
fn find_zones(problem: &mut Problem) -> Result<()> {
    let coulomb: Vec<f64> = (0..problem.baseline.len()).map(|joint| rough_coulomb(problem, joint)).collect();
    let zones = |problem: &Problem, left_over: Option<&[Vec<f64>]>, margins: &zones::Margins| {
        zones::rigid_zone(&problem.motion, &coulomb, left_over, &problem.held_out, margins)
    };
    problem.zones = zones(problem, None, &zones::RIGID);
    enough_rows(problem)?;
    if let Some(fitted) = problem.fit(&[], Part::Train, regression::NU) {
        let of_joint = |joint| views::residual(problem, &[], &fitted, joint);
        let left_over: Vec<Vec<f64>> = (0..coulomb.len()).map(of_joint).collect();
        problem.zones = zones(problem, Some(&left_over), &zones::RIGID);
        problem.judged = zones(problem, Some(&left_over), &zones::JUDGED);
    }
    for joint in 0..coulomb.len() {
        // A motion that never rests long on a flank is judged where it is fitted.
        if [Part::Train, Part::HeldOut].iter().any(|part| problem.judged_rows(joint, *part).len() < FEWEST_ROWS) {
            problem.judged[joint].clone_from(&problem.zones[joint]);
        }
    }
    enough_rows(problem)
}

/// Rows that a joint needs, to be fitted and to be judged.
const FEWEST_ROWS: usize = 30;

/// Whether every joint has rows to fit its friction to.
fn enough_rows(problem: &Problem) -> Result<()> {
    for (joint, model) in problem.motion.model.joints.iter().enumerate() {
        let found = problem.rows(joint, Part::Train).len();
        let needed = FEWEST_ROWS;
        if found < needed {
            return Err(Error::TooLittleData {
                quantity: "torque",
                joint: model.name.clone(),
                found,
                unit: "samples of steady contact",
                needed,
                advice: "move every joint of the model for some seconds in both directions; leave a joint that stands still out of the model",
            });
        }
    }
    Ok(())
}

/// Median of what friction takes while the joint moves, in what is trained on.
fn rough_coulomb(problem: &Problem, joint: usize) -> f64 {
    let m = &problem.motion.joints[joint];
    let moving = (0..problem.motion.rows()).filter(|row| !problem.held_out[*row] && m.direction[*row].abs() > 0.99);
    let mut levels: Vec<f64> = moving.map(|row| (m.torque[row] - m.rigid[row]) * m.direction[row]).collect();
    if levels.is_empty() {
        return 0.0;
    }
    let middle = levels.len() / 2;
    levels.select_nth_unstable_by(middle, f64::total_cmp).1.max(0.0)
}

fn nothing_moves(model: &Model) -> Error {
    Error::TooLittleData {
        quantity: "friction",
        joint: model.joints.first().map(|joint| joint.name.clone()).unwrap_or_default(),
        found: 0,
        unit: "directions of motion",
        needed: 2,
        advice: "move every joint in both directions",
    }
}

//! Names: what a selection takes and held-out data confirm.
//!
//! A selection takes a limited number of effects ([`Rules::most`]). Where some are withdrawn, their places are free again: effects are sought
//! on the other joints, and those are confirmed in turn. On a joint where a name was withdrawn its structure is still there, so that the next
//! best name would be its substitute; unless what was withdrawn is no more than a [simpler](Problem::bar_for_simpler) effect.

use super::confirm::{Confirmed, confirm};
use super::selection::{Selection, select_further};
use super::substitutes;
use crate::diagnose::fit::problem::Problem;
use crate::diagnose::options::Rules;

/// Confirms the effects of a selection, and takes further ones in the place of those that are withdrawn; `None` where the rest cannot be fitted.
/// `rules` are those of the selection, and those of the names.
pub fn name(
    problem: &mut Problem,
    selection: &mut Selection,
    [of_selection, of_names]: [&Rules; 2],
) -> Option<Confirmed> {
    let mut withdrawn = Vec::new();
    loop {
        let mut confirmed = confirm(problem, selection, 0, &|_| true, Some(of_names))?;
        let none_is_new = confirmed.withdrawn.is_empty();
        withdrawn.append(&mut confirmed.withdrawn);
        confirmed.withdrawn = [withdrawn.clone(), selection.replaced.clone()].concat();
        if none_is_new || !select_further(problem, selection, of_selection)? {
            return Some(confirmed);
        }
        substitutes::withdraw(problem, selection)?;
    }
}

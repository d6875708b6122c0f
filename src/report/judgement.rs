//! What the score of every sample says, for readers.

use super::document::Section;
use super::number::significant;
use super::table::Table;
use crate::diagnose::{JudgedName, JudgedSet, Judgement};

/// Sentences for the terminal, and the table of sets.
pub fn section(judgement: &Judgement) -> Section {
    let mut section = Section::new("What the simulation says of every sample");
    if let Some(reason) = &judgement.not_applied {
        section.text.push(format!("Not judged by simulation: {reason}"));
        return section;
    }
    section.text.push(answer(judgement));
    section.text.extend(distance(judgement));
    if judgement.adopted {
        section.text.push(
            "The extended model is the machine as it was fitted to every sample: it predicts data held out better than the one that was fitted to smooth motion. Torque errors along the motion are those of the latter."
                .to_owned(),
        );
    }
    if !judgement.not_tried.is_empty() {
        section.text.push(format!("There was no time for: {}.", judgement.not_tried.join(", ")));
    }
    section
}

/// The sets with gains, sizes and windows, for the page alone.
pub fn details(judgement: &Judgement) -> Section {
    let mut sets = Table::new("", &["effects", "gain held out [nat]", "probability", "sizes"]);
    judgement.sets.iter().for_each(|set| sets.row(row(set)));
    let mut windows = Table::new("Parts of the recordings", &["recording", "from", "to", "use"]);
    for window in &judgement.windows {
        let used = if window.fitted { "to fit" } else { "to judge" };
        let [from, to] = [window.from, window.to].map(|time| format!("{time:.0} s"));
        windows.row([window.session.clone(), from, to, used.to_owned()]);
    }
    let tables = [sets, windows].into_iter().filter(|table| !table.rows.is_empty()).collect();
    let text = "Every set was fitted to some parts of the recordings with all values of the model free within their accuracy, and judged by others. \
                A gain is the logarithm of how much more probable the readings are than without an effect."
        .to_owned();
    Section { text: vec![text], tables, detail: true, ..Section::new("Sets of effects, judged by simulation") }
}

fn row(set: &JudgedSet) -> [String; 4] {
    let sizes: Vec<String> =
        set.sizes.iter().map(|(name, size)| format!("{name} = {}", significant(size.value, 3))).collect();
    let probability = set.probability.map_or_else(|| "–".to_owned(), |probability| format!("{probability:.2}"));
    [set.name.clone(), format!("{:.0}", set.gain_nats), probability, sizes.join(", ")]
}

/// What the posterior says, in one sentence.
fn answer(judgement: &Judgement) -> String {
    if judgement.unexplained {
        return "No set of effects explains the recording sample by sample: the machine differs in something else, or a fit stopped short of it. By this score nothing is named."
            .to_owned();
    }
    let sure: Vec<&JudgedName> = judgement.names.iter().filter(|name| name.is_supported()).collect();
    if !sure.is_empty() {
        return format!("It supports {}.", sure.into_iter().map(words).collect::<Vec<_>>().join(", and "));
    }
    match judgement.names.as_slice() {
        [] => "It supports no effect.".to_owned(),
        names => format!(
            "It decides for no effect; the most probable are {}.",
            names
                .iter()
                .map(|name| format!("{} ({:.0} %)", name.effect, 100.0 * name.probability))
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

fn words(name: &JudgedName) -> String {
    let joints = if name.joints.is_empty() { String::new() } else { format!(" on {}", name.joints.join(", ")) };
    let others = if name.confusable_with.is_empty() {
        String::new()
    } else {
        format!(", which looks like {}", name.confusable_with.join(", "))
    };
    format!("{}{joints} ({:.0} % sure{others})", name.effect, 100.0 * name.probability)
}

fn distance(judgement: &Judgement) -> Option<String> {
    let distance = judgement.distance.as_ref()?;
    let scores = [distance.baseline, distance.best].map(|score| significant(score, 3));
    let floor = distance.floor.map_or_else(
        || "; without a torque beside its own, that set loses the recording's track".to_owned(),
        |floor| format!(", {} on average if that set is right", significant(floor, 3)),
    );
    Some(format!(
        "Score of a reading: {} nats for the nominal model with friction and gap, {} for the best set{floor}.{}",
        scores[0],
        scores[1],
        missed(judgement)
    ))
}

/// Torque that the best set misses, where nothing is explained.
fn missed(judgement: &Judgement) -> String {
    let missed =
        judgement.distance.iter().filter(|_| judgement.unexplained).flat_map(|distance| &distance.missed_torque);
    let missed: Vec<String> = missed.map(|factor| significant(*factor, 2)).collect();
    match &missed[..] {
        [] => String::new(),
        [one] => format!(" It misses a torque of {one} times the noise of the measured one."),
        all => {
            format!(" It misses torques of {} times the noise of the measured ones, joint by joint.", all.join(", "))
        }
    }
}

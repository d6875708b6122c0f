//! Interprets the name of a column: quantity, role, joint, unit.
//!
//! ```text
//!   /joint_states/joint1/position   joint1, position            A1_motor_position_deg   A1, position at the motor, deg
//!   actual_q_0                      number 0, position          joint1 position [deg]   joint1, position, deg
//!   joint_positions[0]              number 0, position          target_qd_2             number 2, reference velocity
//! ```
//! A name is cut into segments at `/ . :`, and these into words at other characters, at changes between letters and digits,
//! and at capitals. The last word for a quantity counts; words for roles count next to it, or as a segment of their own. The
//! remaining words name the joint.

use super::table::Column;
use super::unit_words::{FileUnit, bare, unit_of};
use super::words::{Quantity, Role, Word, meaning};
use crate::units::Dimension;

/// A word of a name.
#[derive(Debug, Clone, PartialEq)]
struct Token {
    /// The word in lower case.
    word: String,
    /// Place in the name [bytes].
    start: usize,
    end: usize,
    segment: usize,
    /// Whether no character separates it from the word before.
    glued: bool,
}

impl Token {
    fn number(&self) -> Option<u64> {
        self.word.parse().ok().filter(|_| self.word.bytes().all(|byte| byte.is_ascii_digit()))
    }
}

/// The meaning of a column's name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    /// What the column holds.
    pub(super) quantity: Quantity,
    /// Which signal of this quantity: measured, reference, at the motor or at the link.
    pub(super) role: Role,
    /// The unit that the name or the row of units states.
    pub(super) unit: Option<FileUnit>,
    /// A unit that is stated but unknown.
    pub(super) strange_unit: Option<String>,
    /// Parts of the joint's name, from the left; empty if it has a number alone, or nothing.
    pub(super) joint: Vec<String>,
    /// The last number of the joint's name.
    pub(super) number: Option<u64>,
    /// Why the quantity or the role has to be confirmed.
    pub(super) guess: Option<&'static str>,
}

/// Words that have a meaning only together: the words, quantity, role, doubt.
const PHRASES: [(&[&str], Quantity, Role, &str); 8] = [
    (&["q", "dot"], Quantity::Velocity, Role::Actual, ""),
    (&["q", "ddot"], Quantity::Other, Role::Actual, ""),
    (&["q", "d"], Quantity::Position, Role::Reference, "q_d: the desired position, as libfranka writes it?"),
    (&["dq", "d"], Quantity::Velocity, Role::Reference, "dq_d: the desired velocity, as libfranka writes it?"),
    (&["tau", "j"], Quantity::Torque, Role::Link, "tau_J: the torque behind the gear, as libfranka writes it?"),
    (&["observation", "state"], Quantity::Position, Role::Actual, "a state of LeRobot: a position, in what unit?"),
    (&["tau", "d"], Quantity::Other, Role::Reference, ""),
    (&["tau", "ext"], Quantity::Other, Role::Link, ""),
];

/// Interprets the name of a column; `None` if it names no quantity of a joint.
pub(super) fn read(column: &Column) -> Option<Named> {
    let (name, bracket) = split_unit(&column.name);
    let stated = bracket.map(str::to_owned).or_else(|| column.unit.as_deref().map(|unit| bare(unit).to_owned()));
    let mut unit = stated.as_deref().and_then(unit_of);
    let strange_unit = stated.filter(|text| unit.is_none() && !text.is_empty());
    let mut tokens = tokens(name);
    if tokens.iter().any(|token| meaning(&token.word) == Some(Word::Quantity(Quantity::Other))) {
        return None;
    }
    let mut used = vec![false; tokens.len()];
    let (quantity, mut role, guess, place) = quantity(&tokens, &mut used)?;
    if quantity == Quantity::Other {
        return None;
    }
    if unit.is_none()
        && let Some((found, places)) = unit_at_end(&tokens, &used, quantity)
    {
        unit = Some(found);
        places.for_each(|place| used[place] = true);
    }
    let roles = roles(&tokens, &mut used, place);
    for other in [Role::Reference, Role::Link, Role::Motor] {
        if role == Role::Actual && roles.contains(&other) {
            role = other;
        }
    }
    let left: Vec<bool> = used.iter().map(|used| !used).collect();
    let mut keep = left.iter();
    tokens.retain(|_| keep.next().copied().unwrap_or(false));
    let number = tokens.iter().rev().find_map(Token::number);
    Some(Named { quantity, role, unit, strange_unit, joint: joint(name, &tokens), number, guess })
}

/// A name without the unit in brackets at its end, and that unit; a number in brackets is no unit.
pub(super) fn split_unit(name: &str) -> (&str, Option<&str>) {
    let trimmed = name.trim_end();
    let open = match trimmed.chars().last() {
        Some(']') => trimmed.rfind('['),
        Some(')') => trimmed.rfind('('),
        _ => None,
    };
    match open.map(|at| (trimmed[..at].trim_end(), bare(&trimmed[at..]))) {
        Some((rest, inside)) if !rest.is_empty() && inside.parse::<f64>().is_err() => (rest, Some(inside)),
        _ => (name, None),
    }
}

/// The words of a name, in lower case.
pub(super) fn words(name: &str) -> Vec<String> {
    tokens(name).into_iter().map(|token| token.word).collect()
}

fn tokens(name: &str) -> Vec<Token> {
    let mut tokens: Vec<Token> = Vec::new();
    let (mut segment, mut before) = (0, ' ');
    for (at, c) in name.char_indices() {
        if !c.is_alphanumeric() {
            segment += usize::from(matches!(c, '/' | '.' | ':'));
        } else {
            let continues = before.is_alphanumeric()
                && before.is_numeric() == c.is_numeric()
                && !(before.is_lowercase() && c.is_uppercase());
            match tokens.last_mut().filter(|_| continues) {
                Some(last) => {
                    last.word.extend(c.to_lowercase());
                    last.end = at + c.len_utf8();
                }
                None => tokens.push(Token {
                    word: c.to_lowercase().collect(),
                    start: at,
                    end: at + c.len_utf8(),
                    segment,
                    glued: before.is_alphanumeric(),
                }),
            }
        }
        before = c;
    }
    tokens
}

/// The last quantity of a name, with its place; marks its words as used.
fn quantity(tokens: &[Token], used: &mut [bool]) -> Option<(Quantity, Role, Option<&'static str>, usize)> {
    for (words, quantity, role, doubt) in PHRASES {
        let fits = |at: &usize| {
            tokens[*at..].iter().zip(words).all(|(token, word)| token.word == *word) && at + words.len() <= tokens.len()
        };
        let Some(at) = (0..tokens.len()).rev().find(fits) else { continue };
        let last = at + words.len() - 1;
        // `tau_J1` is joint 1, and `tau_J_1` the first of `tau_J`.
        if tokens[last].word == "j" && tokens.get(last + 1).is_some_and(|next| next.glued) {
            continue;
        }
        used[at..=last].fill(true);
        return Some((quantity, role, Some(doubt).filter(|doubt| !doubt.is_empty()), last));
    }
    let found = tokens.iter().enumerate().rev().find_map(|(at, token)| match meaning(&token.word) {
        Some(Word::Quantity(quantity)) => Some((quantity, Role::Actual, None, at)),
        Some(Word::Guess(quantity, role, doubt)) => Some((quantity, role, Some(doubt), at)),
        _ => None,
    });
    // A single letter counts only with a number after it.
    let numbered = |(at, token): (usize, &Token)| {
        (token.word == "i" && tokens.get(at + 1).is_some_and(|next| next.number().is_some())).then_some(at)
    };
    let current = || tokens.iter().enumerate().find_map(numbered);
    let found = found.or_else(|| Some((Quantity::Current, Role::Actual, Some("`i`: a current in A?"), current()?)))?;
    used[found.3] = true;
    Some(found)
}

/// The unit at the end of a name, before its number if it ends with one: `_deg`, `_rad_s`; and its places.
fn unit_at_end(tokens: &[Token], used: &[bool], quantity: Quantity) -> Option<(FileUnit, std::ops::Range<usize>)> {
    let end = tokens.len() - usize::from(tokens.last().is_some_and(|token| token.number().is_some()));
    [(2, "/"), (2, "·"), (1, "")].into_iter().find_map(|(count, sign)| {
        let places = end.checked_sub(count)?..end;
        let words: Vec<&str> = tokens[places.clone()].iter().map(|token| token.word.as_str()).collect();
        let unit = unit_of(&words.join(sign))?;
        let free = !used[places.clone()].contains(&true) && !tokens[places.start].glued;
        (free && fits(unit, quantity)).then_some((unit, places))
    })
}

/// Whether a unit fits this quantity; volts fit a current, a torque, a force or an effort.
pub(super) fn fits(unit: FileUnit, quantity: Quantity) -> bool {
    let Some((dimension, _)) = unit.si() else { return false };
    match quantity {
        Quantity::Position => matches!(dimension, Dimension::Angle | Dimension::Length),
        Quantity::Velocity => matches!(dimension, Dimension::AngularVelocity | Dimension::Velocity),
        Quantity::Current => matches!(dimension, Dimension::Current | Dimension::Voltage),
        Quantity::Torque | Quantity::Force | Quantity::Effort => {
            matches!(dimension, Dimension::Torque | Dimension::Force | Dimension::Voltage | Dimension::Current)
        }
        Quantity::Temperature => dimension == Dimension::Temperature,
        Quantity::Other => false,
    }
}

/// Roles next to the quantity, and roles in segments that consist only of roles and fillers; marks their words as used.
fn roles(tokens: &[Token], used: &mut [bool], place: usize) -> Vec<Role> {
    let mut roles = Vec::new();
    let role_of = |token: &Token| match meaning(&token.word) {
        Some(Word::Role(role)) => Some(role),
        // "current position": the present one.
        Some(Word::Quantity(Quantity::Current)) => Some(Role::Actual),
        _ => None,
    };
    let home = tokens[place].segment;
    let (before, after) = (tokens[..place].iter().enumerate().rev(), tokens.iter().enumerate().skip(place + 1));
    let sides: [Box<dyn Iterator<Item = (usize, &Token)>>; 2] = [Box::new(before), Box::new(after)];
    for side in sides {
        for (at, token) in side.take_while(|(_, token)| token.segment == home) {
            if used[at] {
                continue;
            }
            let Some(role) = role_of(token) else { break };
            roles.push(role);
            used[at] = true;
        }
    }
    for segment in tokens.chunk_by(|a, b| a.segment == b.segment).filter(|segment| segment[0].segment != home) {
        let plain = |token: &Token| role_of(token).is_some() || meaning(&token.word) == Some(Word::Filler);
        if segment.iter().all(plain) {
            roles.extend(segment.iter().filter_map(role_of));
            for (at, token) in tokens.iter().enumerate() {
                used[at] |= token.segment == segment[0].segment;
            }
        }
    }
    roles
}

/// The parts of the joint's name, as the name spells them. Segments that consist only of fillers are left out.
fn joint(name: &str, tokens: &[Token]) -> Vec<String> {
    let filler = |token: &Token| meaning(&token.word) == Some(Word::Filler);
    let segments = tokens.chunk_by(|a, b| a.segment == b.segment);
    let named = segments.filter(|segment| !segment.iter().all(filler)).map(|segment| {
        let mut text = String::new();
        for (at, token) in segment.iter().enumerate() {
            let between = at.checked_sub(1).map_or("", |last| &name[segment[last].end..token.start]);
            // Words that were used otherwise stood between the two.
            let between = if between.chars().any(char::is_alphanumeric) { "_" } else { between };
            text += if between.is_empty() || between == "-" { between } else { "_" };
            text += &name[token.start..token.end];
        }
        text
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use Quantity::{Current, Effort, Position, Torque, Velocity};
    use Role::{Actual, Link, Motor, Reference};

    #[test]
    fn property_names_of_programs_in_use_are_understood() {
        for (name, quantity, role, joint, number, unit) in [
            ("/joint_states/joint1/position", Position, Actual, "joint1", Some(1), None),
            ("/joint_states/shoulder_pan_joint/effort", Effort, Actual, "shoulder_pan_joint", None, None),
            ("position_0", Position, Actual, "0", Some(0), None),
            ("q1", Position, Actual, "1", Some(1), None),
            ("dq1", Velocity, Actual, "1", Some(1), None),
            ("tau1", Torque, Actual, "1", Some(1), None),
            ("actual_q_0", Position, Actual, "0", Some(0), None),
            ("target_qd_5", Velocity, Reference, "5", Some(5), None),
            ("actual_current_0", Current, Actual, "0", Some(0), None),
            ("joint_positions[0]", Position, Actual, "joint_0", Some(0), None),
            ("motor_current", Current, Motor, "", None, None),
            ("current_position_2", Position, Actual, "2", Some(2), None),
            ("A1_motor_position_deg", Position, Motor, "A1", Some(1), Some("deg")),
            ("joint1 position [deg]", Position, Actual, "joint1", Some(1), Some("deg")),
            ("Joint 2 Velocity (rad/s)", Velocity, Actual, "Joint_2", Some(2), Some("rad/s")),
            ("joint1_velocity_deg_s", Velocity, Actual, "joint1", Some(1), Some("deg/s")),
            ("joint1_current_a", Current, Actual, "joint1", Some(1), Some("A")),
            ("elbow.torque_nm", Torque, Actual, "elbow", None, Some("N·m")),
            ("elbow_ref_pos", Position, Reference, "elbow", None, None),
            ("j2.link_position", Position, Link, "j2", Some(2), None),
            ("link2_position", Position, Actual, "link2", Some(2), None),
            ("q.1", Position, Actual, "1", Some(1), None),
            ("controller_state/reference/elbow/velocity", Velocity, Reference, "elbow", None, None),
            ("jointPos3", Position, Actual, "joint_3", Some(3), None),
        ] {
            let column = Column { name: name.to_owned(), ..Column::default() };
            let found = read(&column).unwrap_or_else(|| panic!("{name}"));
            let unit_name = found.unit.map(|unit| unit.name);
            assert_eq!((found.quantity, found.role, found.joint.join("/").as_str()), (quantity, role, joint), "{name}");
            assert_eq!((found.number, unit_name, found.guess), (number, unit, None), "{name}");
        }
    }

    #[test]
    fn property_names_that_leave_doubts_are_guesses() {
        for name in ["observation.state.0", "action.1", "q_d_0", "dq_d[3]", "tau_J_2", "i_1"] {
            let column = Column { name: name.to_owned(), ..Column::default() };
            assert!(read(&column).is_some_and(|found| found.guess.is_some()), "{name}");
        }
    }

    #[test]
    fn property_other_columns_are_no_channels() {
        for name in [
            "frame_index",
            "task",
            "actual_TCP_pose_0",
            "joint1.acceleration",
            "/imu/angular_velocity/x",
            "i",
            "note",
            "",
        ] {
            assert_eq!(read(&Column { name: name.to_owned(), ..Column::default() }), None, "{name}");
        }
    }
}

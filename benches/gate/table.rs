//! The gate's table.

use std::fmt::Write as _;

use super::case::{Case, Rival};

/// [nat] Held-out gain above which a rival counts as named.
pub const NAMED: f64 = 30.0;

/// The lines of one machine.
pub fn lines(case: &Case) -> String {
    let mut text = format!(
        "{}: baseline {:.4} nats a sample{}, λ {:.1?}, {} steps; regression names {}; {:.0} s + {:.0} s",
        case.name,
        case.unexplained,
        case.floor.map_or_else(String::new, |floor| format!(" (floor {floor:.4})")),
        case.baseline.lambda,
        case.baseline.steps,
        case.named.as_deref().unwrap_or("nothing"),
        case.seconds[0],
        case.seconds[1],
    );
    case.hidden.iter().for_each(|hidden| {
        let _ = write!(text, "\n    hidden {hidden}");
    });
    for rival in &case.rivals {
        let mark = if case.is_hidden(rival) { "*" } else { " " };
        let _ = write!(
            text,
            "\n  {mark} {:38} held out {:8.0}, train {:8.0}, λ {:.1?}, {} steps, {:.0} s;",
            rival.name, rival.held_out, rival.train, rival.lambda, rival.steps, rival.seconds
        );
        for (name, size) in &rival.sizes {
            let _ =
                write!(text, " {} {:.5} ± {:.5}", name.rsplit('.').next().unwrap_or(name), size.value, size.std_error);
        }
    }
    text
}

/// A row for each kind of machine.
pub fn table(cases: &[Case]) -> String {
    let kind = |case: &Case| {
        let effect = case.hidden.first().and_then(|hidden| hidden.split(' ').next()).unwrap_or("none").to_owned();
        let strength = case.name.rsplit_once('×').map_or("", |(_, strength)| strength);
        if effect == "none" { effect } else { format!("{effect} ×{strength}") }
    };
    let mut kinds: Vec<String> = Vec::new();
    for case in cases {
        if !kinds.contains(&kind(case)) {
            kinds.push(kind(case));
        }
    }
    let mut text = String::from(
        "| machines | n | true first | other first | none | gain of the true one [nat] | best rival [nat] | regression first | s |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for name in kinds {
        let own: Vec<&Case> = cases.iter().filter(|case| kind(case) == name).collect();
        let count = |what: &dyn Fn(&Case) -> bool| own.iter().filter(|case| what(case)).count();
        let first = |case: &Case| case.first(NAMED).map(|rival| case.is_hidden(rival));
        let best = |case: &Case, hidden: bool| {
            let of_kind = |rival: &&Rival| case.is_hidden(rival) == hidden;
            case.rivals.iter().find(of_kind).map_or_else(|| "–".to_owned(), |rival| format!("{:.0}", rival.held_out))
        };
        let all = |hidden: bool| own.iter().map(|case| best(case, hidden)).collect::<Vec<_>>().join(", ");
        let regression = count(&|case| case.named.as_ref().is_some_and(|named| name.starts_with(named.as_str())));
        let seconds = own.iter().map(|case| case.seconds[1]).sum::<f64>() / own.len() as f64;
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} | {} | {regression} | {seconds:.0} |",
            own.len(),
            count(&|case| first(case) == Some(true)),
            count(&|case| first(case) == Some(false)),
            count(&|case| first(case).is_none()),
            all(true),
            all(false),
        );
    }
    text
}

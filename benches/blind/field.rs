//! What the machines of the field say, as a table: one column for each accuracy of the nominal model, one part for each kind of machine.

use std::fmt::Write as _;

use super::calibration::calibration;
use super::case::Case;
use super::hidden::{Arm, Field};
use super::share::Share;
use super::table::quantile;
use super::verdict::Gap;

/// What is counted over.
pub struct FieldTable<'a> {
    pub cases: &'a [Case],
    /// [nats] evidence that a diagnosis asks of an effect.
    pub nats: f64,
}

/// Name of a figure, what is asked of it, and how it is counted over the cases of one column.
type Figure<'a> = (&'a str, &'a str, Box<dyn Fn(&[&Case]) -> String + 'a>);

impl FieldTable<'_> {
    /// All parts, as Markdown; nothing where no machine was of the field.
    pub fn text(&self) -> String {
        let parts = Arm::ALL.into_iter().filter_map(|arm| self.part(arm));
        let parts: Vec<String> = parts.chain(self.without_report()).collect();
        parts.join("\n")
    }

    fn of(&self, field: Field) -> Vec<&Case> {
        self.cases.iter().filter(|case| case.order.field == Some(field)).collect()
    }

    fn part(&self, arm: Arm) -> Option<String> {
        let mut roughs: Vec<f64> = self
            .cases
            .iter()
            .filter_map(|case| case.order.field)
            .filter(|one| one.arm == arm)
            .map(|one| one.rough)
            .collect();
        roughs.sort_by(f64::total_cmp);
        roughs.dedup();
        if roughs.is_empty() {
            return None;
        }
        let columns: Vec<Vec<&Case>> = roughs.iter().map(|&rough| self.of(Field { arm, rough })).collect();
        let heads: Vec<String> = roughs.iter().map(|&rough| head(rough)).collect();
        let mut text =
            format!("| {} | asked | {} |\n|---|---|{}\n", title(arm), heads.join(" | "), "---|".repeat(roughs.len()));
        for (figure, asked, count) in self.figures() {
            let cells: Vec<String> = columns.iter().map(|cases| count(cases)).collect();
            let _ = writeln!(text, "| {figure} | {asked} | {} |", cells.join(" | "));
        }
        let all: Vec<&Case> = columns.concat();
        Some(format!("{text}\n{}", calibration(all.into_iter())))
    }

    fn figures(&self) -> Vec<Figure<'_>> {
        let nats = self.nats;
        let first_of_separable = move |cases: &[&Case]| {
            let separable = cases.iter().filter(|case| case.is_full() && case.is_separable(nats));
            Share::of(separable.map(|case| case.verdict.is_first())).text()
        };
        let median = |cases: &[&Case]| {
            let mut seconds: Vec<f64> = cases.iter().map(|case| case.verdict.seconds).collect();
            quantile(&mut seconds, 0.5)
        };
        vec![
            (
                "healthy machines with any name but `link_inertia`",
                "≤ 2 %",
                Box::new(|cases| {
                    Share::of(
                        healthy(cases).map(|case| case.verdict.found.iter().any(|one| one.effect != "link_inertia")),
                    )
                    .text()
                }),
            ),
            (
                "healthy machines with `link_inertia`",
                "",
                Box::new(|cases| Share::of(healthy(cases).map(|case| case.verdict.names("link_inertia"))).text()),
            ),
            (
                "healthy machines with a mistake suspected",
                "0 %",
                Box::new(|cases| Share::of(healthy(cases).map(|case| !case.verdict.mistakes.is_empty())).text()),
            ),
            (
                "strength 1: separable",
                "",
                Box::new(move |cases| {
                    Share::of(cases.iter().filter(|case| case.is_full()).map(|case| case.is_separable(nats))).text()
                }),
            ),
            ("strength 1, separable: named first", "≥ 90 %", Box::new(first_of_separable)),
            (
                "strength 1, separable or not: named first",
                "",
                Box::new(|cases| {
                    Share::of(cases.iter().filter(|case| case.is_full()).map(|case| case.verdict.is_first())).text()
                }),
            ),
            (
                "strength 1: something else named first",
                "",
                Box::new(|cases| {
                    let named = cases.iter().filter(|case| case.is_full());
                    Share::of(named.map(|case| !case.verdict.found.is_empty() && !case.verdict.is_first())).text()
                }),
            ),
            (
                "size within its 95 % interval",
                "90 to 99 %",
                Box::new(|cases| {
                    let first = cases.iter().filter(|case| case.is_single() && case.verdict.is_first());
                    Share::of(first.flat_map(|case| case.verdict.sizes()).map(|size| size.is_inside())).text()
                }),
            ),
            ("gaps measured", "", Box::new(|cases| Share::of(gaps(cases).map(|gap| gap.measured.is_some())).text())),
            (
                "gap within its 95 % interval",
                "90 to 99 %",
                Box::new(|cases| Share::of(gaps(cases).filter_map(Gap::is_inside)).text()),
            ),
            (
                "error of a gap, median",
                "",
                Box::new(|cases| {
                    let off = |gap: &Gap| gap.measured.as_ref().map(|one| 100.0 * (one.value / gap.truth - 1.0).abs());
                    format!("{} %", quantile(&mut gaps(cases).filter_map(off).collect::<Vec<_>>(), 0.5))
                }),
            ),
            (
                "runs without a report",
                "0",
                Box::new(|cases| Share::of(cases.iter().map(|case| case.verdict.failure.is_some())).text()),
            ),
            ("a diagnosis [s], two at a time, median", "", Box::new(median)),
        ]
    }

    /// Each run that ended in an error or a panic, with its message.
    fn without_report(&self) -> Option<String> {
        let failed = self.cases.iter().filter_map(|case| Some((case, case.verdict.failure.as_ref()?)));
        let lines: Vec<String> =
            failed.map(|(case, message)| format!("- `{}`: {message}", case.order.name())).collect();
        (!lines.is_empty()).then(|| format!("Runs without a report:\n{}", lines.join("\n")))
    }
}

fn healthy<'a>(cases: &'a [&Case]) -> impl Iterator<Item = &'a Case> {
    cases.iter().copied().filter(|case| case.order.effects.is_empty())
}

/// The gaps of machines that hide nothing.
fn gaps<'a>(cases: &'a [&Case]) -> impl Iterator<Item = &'a Gap> {
    healthy(cases).flat_map(|case| &case.verdict.gaps)
}

fn title(arm: Arm) -> &'static str {
    match arm {
        Arm::Planar => "planar arm",
        Arm::SixJoints => "six joints under gravity",
    }
}

/// How far masses are off by one standard deviation.
fn head(rough: f64) -> String {
    if rough == 0.0 { "exact".to_owned() } else { format!("rough, masses {:.0} % off", 10.0 * rough) }
}

//! What many machines say, as a table.

use std::fmt::Write as _;

use super::calibration::calibration;
use super::case::Case;
use super::comparison::Comparison;
use super::hidden::CHANGES;
use super::share::Share;
use super::strengths::EFFECTS;
use super::verdict::Size;

/// What is counted over.
pub struct Table<'a> {
    pub cases: &'a [Case],
    pub comparisons: &'a [Comparison],
    /// [nats] evidence that a diagnosis asks of an effect: what is told by more is separable.
    pub nats: f64,
}

impl<'a> Table<'a> {
    /// All parts, as Markdown.
    pub fn text(&self) -> String {
        [self.figures(), self.by_effect(), calibration(self.laboratory())].join("\n")
    }

    /// The machines of the laboratory; those of the field have a table of their own.
    fn laboratory(&self) -> impl Iterator<Item = &'a Case> {
        self.cases.iter().filter(|case| case.order.field.is_none())
    }

    fn hiding(&self, effects: usize) -> impl Iterator<Item = &'a Case> {
        self.laboratory().filter(move |case| case.order.effects.len() == effects)
    }

    fn of_strength(&self, full: bool) -> impl Iterator<Item = &'a Case> {
        self.hiding(1).filter(move |case| (case.order.strength == 1.0) == full)
    }

    fn figures(&self) -> String {
        let nats = self.nats;
        let named = |full: bool| {
            Share::of(self.of_strength(full).filter(|case| case.is_separable(nats)).map(|case| case.verdict.is_first()))
        };
        let of_all = |full: bool| Share::of(self.of_strength(full).map(|case| case.verdict.is_first()));
        let single = || self.hiding(1);
        let both = |case: &Case| case.verdict.effects.iter().all(|effect| case.verdict.names(effect));
        let mut ratios: Vec<f64> = single().filter_map(Case::error_ratio).collect();
        let mut seconds: Vec<f64> = self.laboratory().map(|case| case.verdict.seconds).collect();
        let rows = [
            ("named first, separable, strength 1", "≥ 95 %", named(true).text()),
            ("named first, separable, less strength", "≥ 85 %", named(false).text()),
            ("named first, separable or not, strength 1", "", of_all(true).text()),
            ("named first, separable or not, less strength", "", of_all(false).text()),
            (
                "named first or listed as inseparable, where the effect shows",
                "≥ 99 %",
                Share::of(single().filter(|case| case.shows(nats)).map(Case::is_first_or_listed)).text(),
            ),
            (
                "clean machines with anything named",
                "≤ 2 %",
                Share::of(self.hiding(0).map(|case| !case.verdict.found.is_empty())).text(),
            ),
            (
                "two effects at once, both separable, both named",
                "≥ 80 %",
                Share::of(self.hiding(2).filter(|case| case.is_separable(nats)).map(both)).text(),
            ),
            ("two effects at once, separable or not, both named", "", Share::of(self.hiding(2).map(both)).text()),
            (
                "effect out of the catalogue: `unexplained` or a declared look-alike, where it shows",
                "≥ 90 %",
                Share::of(single().filter(|case| case.shows(nats)).filter_map(Case::left_out_well)).text(),
            ),
            (
                "size within its 95 % interval",
                "90 to 99 %",
                Share::of(self.sizes().map(|size| size.is_inside())).text(),
            ),
            (
                "held-out torque error / that of the same machine with nothing hidden, median",
                "≤ 1.1",
                quantile(&mut ratios, 0.5),
            ),
            ("the same, 90 % of the machines below", "", quantile(&mut ratios, 0.9)),
            ("a diagnosis [s], two at a time, median", "≤ 5", quantile(&mut seconds, 0.5)),
        ];
        let mut text = String::from("| figure | asked | measured |\n|---|---|---|\n");
        for (figure, asked, measured) in rows {
            let _ = writeln!(text, "| {figure} | {asked} | {measured} |");
        }
        let of = |quantity: &str| {
            let own = self.comparisons.iter().filter(|one| one.order.changed() == Some(quantity));
            Share::of(own.map(Comparison::is_first)).text()
        };
        for (quantity, factor) in CHANGES {
            let percent = 100.0 * (factor - 1.0);
            let _ =
                writeln!(text, "| change of `{quantity}` by {percent:.0} % named first | ≥ 95 % | {} |", of(quantity));
        }
        let _ = writeln!(text, "| no change, and none named | | {} |", of(""));
        text
    }

    fn sizes(&self) -> impl Iterator<Item = Size> {
        self.hiding(1).filter(|case| case.verdict.is_first()).flat_map(|case| case.verdict.sizes())
    }

    fn by_effect(&self) -> String {
        let mut text = String::from(
            "| effect | shows, 1 / less | separable, 1 / less | closest stand-in: loss [nats], median | first of separable, 1 / less | first of all, 1 / less | first or listed | out of the catalogue | size in interval | error ratio |\n\
             |---|---|---|---|---|---|---|---|---|---|\n",
        );
        for effect in EFFECTS {
            let of = |full: bool| self.of_strength(full).filter(|case| case.single() == Some(effect));
            let all = || of(true).chain(of(false));
            if all().next().is_none() {
                continue;
            }
            let both = |share: &dyn Fn(bool) -> Share| format!("{} / {}", share(true).short(), share(false).short());
            let mut ratios: Vec<f64> = all().filter_map(Case::error_ratio).collect();
            let sizes = all().filter(|case| case.verdict.is_first()).flat_map(|case| case.verdict.sizes());
            let _ = writeln!(
                text,
                "| `{effect}` | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                both(&|full| Share::of(of(full).map(|case| case.shows(self.nats)))),
                both(&|full| Share::of(of(full).map(|case| case.is_separable(self.nats)))),
                closest(all()),
                both(&|full| {
                    Share::of(of(full).filter(|case| case.is_separable(self.nats)).map(|case| case.verdict.is_first()))
                }),
                both(&|full| Share::of(of(full).map(|case| case.verdict.is_first()))),
                Share::of(all().filter(|case| case.shows(self.nats)).map(Case::is_first_or_listed)).short(),
                Share::of(all().filter(|case| case.shows(self.nats)).filter_map(Case::left_out_well)).short(),
                Share::of(sizes.map(|size| size.is_inside())).short(),
                quantile(&mut ratios, 0.5),
            );
        }
        text
    }
}

/// The effect that is most often the closest stand-in, and the median of what the closest loses.
fn closest<'c>(cases: impl Iterator<Item = &'c Case>) -> String {
    let told: Vec<_> = cases.filter_map(|case| case.told.first()?.as_ref()).collect();
    let names: Vec<&str> = told.iter().filter_map(|told| Some(told.rivals.first()?.effect)).collect();
    let often = |name: &&str| names.iter().filter(|other| *other == name).count();
    // The last of equals: the list is in the order of the seeds.
    let Some(name) = names.iter().max_by_key(|name| often(name)) else { return "not told".to_owned() };
    let mut losses: Vec<f64> = told.iter().map(|told| told.least()).collect();
    losses.sort_by(f64::total_cmp);
    format!("`{name}`: {:.0}", losses[losses.len() / 2])
}

/// A part of values in their order; the median is the part 0.5.
pub fn quantile(values: &mut [f64], part: f64) -> String {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => "–".to_owned(),
        count => format!("{:.2}", values[((count as f64 * part) as usize).min(count - 1)]),
    }
}

//! Dates and times of day as text: `2026-11-20T12:34:56.789Z`, `20.11.2026 12:34:56`, `12:34:56.789`,
//! `0 days 00:00:00.001`.

/// [ns] in a second.
const SECOND: i64 = 1_000_000_000;
/// [s] in a day.
const DAY: i64 = 86_400;

/// [ns] since 1970, or since midnight where there is no date; `None` if the text is not a time.
///
/// Years from 1678 to 2261 fit into 64 bits.
pub(super) fn nanoseconds(text: &str) -> Option<i64> {
    // Most cells are numbers, which this rejects quickly.
    if !text.contains(':') || !text.is_ascii() {
        return None;
    }
    if let Some((days, time)) = text.split_once(" days ") {
        return total(days.trim().parse().ok()?, time_of_day(time.trim())?);
    }
    match text.find(['T', ' ']) {
        None => total(0, time_of_day(text)?),
        Some(at) => {
            let (time, shift) = zone(text[at + 1..].trim())?;
            total(date(&text[..at])?, time_of_day(time)?.checked_sub(shift.checked_mul(SECOND)?)?)
        }
    }
}

fn total(days: i64, nanoseconds: i64) -> Option<i64> {
    days.checked_mul(DAY)?.checked_mul(SECOND)?.checked_add(nanoseconds)
}

/// A time of day without its zone, and the zone's difference from universal time [s].
fn zone(text: &str) -> Option<(&str, i64)> {
    if let Some(time) = text.strip_suffix(['Z', 'z']) {
        return Some((time, 0));
    }
    let Some(at) = text.rfind(['+', '-']) else { return Some((text, 0)) };
    let digits: String = text[at + 1..].chars().filter(|c| *c != ':').collect();
    let number = |range| digits.get(range).map_or(Some(0), |part: &str| number(part));
    let shift = number(0..2)? * 3600 + number(2..4)? * 60;
    Some((text[..at].trim(), if text[at..].starts_with('-') { -shift } else { shift }))
}

/// A whole number of at most four digits.
fn number(text: &str) -> Option<i64> {
    let digits = (1..=4).contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_digit());
    if digits { text.parse().ok() } else { None }
}

/// [ns] of `hours:minutes:seconds`, the seconds with decimals.
fn time_of_day(text: &str) -> Option<i64> {
    let mut parts = text.splitn(3, ':');
    let (hours, minutes, seconds) = (number(parts.next()?)?, number(parts.next()?)?, parts.next().unwrap_or("0"));
    let (seconds, decimals) = seconds.split_once(['.', ',']).unwrap_or((seconds, ""));
    let seconds = number(seconds)?;
    if hours > 24 || minutes > 59 || seconds > 60 || !decimals.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let nanoseconds: i64 = format!("{:0<9.9}", decimals).parse().ok()?;
    Some((hours * 3600 + minutes * 60 + seconds) * SECOND + nanoseconds)
}

/// Days from 1970-01-01 to a date: `2026-11-20`, `2026/11/20` or `20.11.2026`.
fn date(text: &str) -> Option<i64> {
    let parts: Vec<i64> = text.split(['-', '/', '.']).map(number).collect::<Option<_>>()?;
    let &[first, month, last] = parts.as_slice() else { return None };
    let (year, day) = if text.contains('.') { (last, first) } else { (first, last) };
    if !(1678..=2261).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // H. Hinnant, "chrono-compatible low-level date algorithms": years begin in March, so that a leap day is the last.
    let year = if month <= 2 { year - 1 } else { year };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    Some(era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_dates_have_their_seconds_since_1970() {
        for (text, seconds, rest) in [
            ("1970-01-01T00:00:00Z", 0, 0),
            // POSIX, "Seconds Since the Epoch"; the billionth second is 2001-09-09 01:46:40.
            ("2001-09-09 01:46:40", 1_000_000_000, 0),
            ("2001-09-09T03:46:40.000000001+02:00", 1_000_000_000, 1),
            ("2001/09/09 01:46:40.5", 1_000_000_000, 500_000_000),
            ("09.09.2001 01:46:40,25", 1_000_000_000, 250_000_000),
            ("2000-02-29T00:00:00", 951_782_400, 0),
            ("2000-03-01T00:00:00", 951_868_800, 0),
            ("12:00:01.001", 43_201, 1_000_000),
            ("1 days 00:00:00.000001", 86_400, 1000),
        ] {
            assert_eq!(nanoseconds(text), Some(seconds * SECOND + rest), "{text}");
        }
    }

    #[test]
    fn property_other_text_is_no_time() {
        for text in ["", "1.5", "12", "a:b", "12:60", "2001-13-01 00:00:00", "2001-09 00:00", "1:2:3:4", "µ:1", "-1:00"]
        {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }
}

//! Formats of numbers for readers: a few significant digits, and none beyond the uncertainty.

/// `value` with `digits` significant digits, in scientific notation only where it is very large or very small.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return if value.is_nan() {
            "–"
        } else if value > 0.0 {
            "∞"
        } else {
            "−∞"
        }
        .into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let digits = i32::try_from(digits.max(1)).unwrap_or(i32::MAX);
    let magnitude = order(value, digits);
    if !(-5..7).contains(&magnitude) {
        return format!("{value:.*e}", usize::try_from(digits - 1).unwrap_or(0));
    }
    format!("{value:.*}", usize::try_from(digits - 1 - magnitude).unwrap_or(0))
}

/// `value` and its standard error with the same number of decimals: two significant digits of the error.
pub fn with_error(value: f64, std_error: f64) -> (String, String) {
    if !(std_error.is_finite() && std_error > 0.0) {
        return (significant(value, 4), significant(std_error, 2));
    }
    let decimals = usize::try_from(1 - order(std_error, 2)).unwrap_or(0);
    if decimals > 7 {
        let digits = usize::try_from(order(value, 2) - order(std_error, 2) + 2).unwrap_or(2).clamp(2, 9);
        return (significant(value, digits), significant(std_error, 2));
    }
    (unsigned_zero(format!("{value:.decimals$}")), format!("{std_error:.decimals$}"))
}

/// Writes "-0.0" as "0.0".
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|byte| matches!(byte, b'0' | b'.')) => rest.to_owned(),
        _ => text,
    }
}

/// Both ends of an interval, with as many decimals as its width justifies.
pub fn interval([lower, upper]: [f64; 2]) -> String {
    let quarter = (upper - lower) / 4.0;
    format!("{} … {}", with_error(lower, quarter).0, with_error(upper, quarter).0)
}

/// A percentage with its sign, one decimal below 10 %, two below 1 %.
pub fn percent(value: f64) -> String {
    let decimals = match value.abs() {
        size if size < 1.0 => 2,
        size if size < 10.0 => 1,
        _ => 0,
    };
    format!("{value:+.decimals$} %")
}

/// A percentage of a whole: without decimals, except where that would round it up to the whole.
pub fn part(percent: f64) -> String {
    match percent {
        99.5..99.95 => format!("{percent:.1} %"),
        99.95..100.0 => "more than 99.9 %".to_owned(),
        _ => format!("{percent:.0} %"),
    }
}

/// Decimal exponent of the first digit after rounding to `digits` digits.
fn order(value: f64, digits: i32) -> i32 {
    let magnitude = exponent(value);
    let scale = 10f64.powi(digits - 1 - magnitude);
    if (value.abs() * scale).round() >= 10f64.powi(digits) { magnitude + 1 } else { magnitude }
}

/// Decimal exponent of the first digit; 0 for zero.
fn exponent(value: f64) -> i32 {
    if value == 0.0 {
        return 0;
    }
    #[expect(clippy::cast_possible_truncation, reason = "an f64 has an exponent between -324 and 308")]
    let exponent = value.abs().log10().floor() as i32;
    exponent
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn property_digits_follow_the_uncertainty() {
        assert_eq!(with_error(0.271_834, 0.001_23), ("0.2718".into(), "0.0012".into()));
        assert_eq!(with_error(0.271_834, 0.000_999), ("0.2718".into(), "0.0010".into()));
        assert_eq!(with_error(-240.67, 1.3), ("-240.7".into(), "1.3".into()));
        assert_eq!(with_error(-0.001, 0.5).0, "0.00");
        assert_eq!(interval([0.270_1, 0.274_9]), "0.2701 … 0.2749");
    }

    #[test]
    fn property_a_part_is_not_rounded_up_to_the_whole() {
        let printed = [-3.4, 42.4, 99.4, 99.62, 99.97, 100.0].map(part);
        assert_eq!(printed, ["-3 %", "42 %", "99 %", "99.6 %", "more than 99.9 %", "100 %"]);
    }

    #[test]
    fn property_significant_digits_are_counted_from_the_first() {
        assert_eq!(significant(0.004_712_3, 3), "0.00471");
        assert_eq!(significant(9.999, 2), "10");
        assert_eq!(significant(123_456.0, 3), "123456");
        assert_eq!(significant(1.234e-9, 3), "1.23e-9");
        assert_eq!(significant(f64::NAN, 3), "–");
    }
}

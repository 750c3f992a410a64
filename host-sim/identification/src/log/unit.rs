//! Units in headings.

/// Kind of quantity that a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Time,
    Angle,
    Length,
    AngularSpeed,
    Speed,
    Torque,
    Force,
    Current,
    /// A known unit that cannot be converted, for example encoder counts.
    Unusable,
}

/// A unit. A number in it times `factor` is the number in s, rad, m, rad/s, m/s, N m, N or A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub(super) kind: Kind,
    pub(super) factor: f64,
    /// Spelling of the unit in messages.
    pub(super) name: &'static str,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const TURN: f64 = std::f64::consts::TAU;
/// Standard gravity, m/s^2, for kilogram-force.
const G: f64 = 9.80665;
/// Pound-force in N, inch and foot in m.
const POUND: f64 = 4.448_221_615_260_5;
const INCH: f64 = 0.0254;
const FOOT: f64 = 0.3048;

/// Kind, factor, name, and spellings, in lower case without blanks, points, asterisks, hyphens, circumflexes and underscores.
const UNITS: &[(Kind, f64, &str, &[&str])] = &[
    (Kind::Time, 1.0, "s", &["s", "sec", "secs", "second", "seconds"]),
    (Kind::Time, 1e-3, "ms", &["ms", "msec", "msecs", "millis", "millisecond", "milliseconds"]),
    (Kind::Time, 1e-6, "us", &["us", "usec", "usecs", "micros", "microsecond", "microseconds"]),
    (Kind::Time, 1e-9, "ns", &["ns", "nsec", "nsecs", "nanosec", "nanos", "nanosecond", "nanoseconds"]),
    (Kind::Angle, 1.0, "rad", &["rad", "rads", "radian", "radians"]),
    (Kind::Angle, 1e-3, "mrad", &["mrad"]),
    (Kind::Angle, 1e-6, "urad", &["urad"]),
    (Kind::Angle, DEGREE, "deg", &["deg", "degs", "degree", "degrees"]),
    (Kind::Angle, 1e-3 * DEGREE, "mdeg", &["mdeg", "millideg", "millidegrees"]),
    (Kind::Angle, 1e-2 * DEGREE, "cdeg", &["cdeg", "centideg", "centidegrees"]),
    (Kind::Angle, TURN, "rev", &["rev", "revs", "revolution", "revolutions", "turn", "turns"]),
    (Kind::Length, 1.0, "m", &["m", "meter", "meters", "metre", "metres"]),
    (Kind::Length, 1e-2, "cm", &["cm"]),
    (Kind::Length, 1e-3, "mm", &["mm", "millimeter", "millimeters", "millimetre", "millimetres"]),
    (Kind::Length, 1e-6, "um", &["um", "micron", "microns"]),
    (Kind::AngularSpeed, 1.0, "rad/s", &["rad/s", "rad/sec", "rads1", "radps", "radpers", "rad/second"]),
    (Kind::AngularSpeed, 1e-3, "mrad/s", &["mrad/s", "mrads1", "mradps"]),
    (Kind::AngularSpeed, DEGREE, "deg/s", &["deg/s", "deg/sec", "degs1", "degps", "dps", "degpers", "degrees/s"]),
    (Kind::AngularSpeed, TURN / 60.0, "rpm", &["rpm", "r/min", "rev/min", "1/min", "min1", "u/min"]),
    (Kind::AngularSpeed, TURN, "rev/s", &["rev/s", "revs1", "rps", "turn/s", "turns/s"]),
    (Kind::Speed, 1.0, "m/s", &["m/s", "m/sec", "ms1", "mps"]),
    (Kind::Speed, 1e-2, "cm/s", &["cm/s", "cms1"]),
    (Kind::Speed, 1e-3, "mm/s", &["mm/s", "mm/sec", "mms1", "mmps"]),
    (Kind::Torque, 1.0, "N m", &["nm", "newtonmeter", "newtonmeters", "newtonmetre", "newtonmetres"]),
    (Kind::Torque, 1e-3, "mN m", &["mnm"]),
    (Kind::Torque, 1e-6, "uN m", &["unm"]),
    (Kind::Torque, 1e-2, "cN m", &["cnm"]),
    (Kind::Torque, 1e3, "kN m", &["knm"]),
    (Kind::Torque, 1e-2, "N cm", &["ncm"]),
    (Kind::Torque, 1e-3, "N mm", &["nmm"]),
    (Kind::Torque, G, "kgf m", &["kgfm", "kpm"]),
    (Kind::Torque, 1e-2 * G, "kgf cm", &["kgfcm", "kgcm", "kpcm"]),
    (Kind::Torque, POUND * FOOT, "lbf ft", &["lbfft", "lbft", "ftlb", "ftlbf", "ftlbs"]),
    (Kind::Torque, POUND * INCH, "lbf in", &["lbfin", "lbin", "inlb", "inlbf", "inlbs"]),
    (Kind::Torque, POUND * INCH / 16.0, "ozf in", &["ozfin", "ozin", "inoz"]),
    (Kind::Force, 1.0, "N", &["n", "newton", "newtons"]),
    (Kind::Force, 1e-3, "mN", &["mn"]),
    (Kind::Force, 1e3, "kN", &["kn"]),
    (Kind::Force, G, "kgf", &["kgf", "kp"]),
    (Kind::Force, POUND, "lbf", &["lbf"]),
    (Kind::Current, 1.0, "A", &["a", "amp", "amps", "ampere", "amperes", "arms"]),
    (Kind::Current, 1e-3, "mA", &["ma", "milliamp", "milliamps", "mamp", "mamps", "marms"]),
    (Kind::Current, 1e-6, "uA", &["ua"]),
    (
        Kind::Unusable,
        f64::NAN,
        "counts",
        &["count", "counts", "cnt", "cnts", "inc", "incs", "increments", "lsb", "raw"],
    ),
    (Kind::Unusable, f64::NAN, "%", &["%", "percent", "permille", "‰", "pu"]),
];

impl Unit {
    /// Parses a unit; `None` if the text is not one.
    pub(super) fn parse(text: &str) -> Option<Self> {
        // `rad_s` is accepted because a variable's name cannot contain a slash.
        let text = text.trim();
        let per_second = ["_s", "_sec"]
            .iter()
            .find_map(|end| text.strip_suffix(end))
            .filter(|rest| ["rad", "deg", "m", "mm", "rev", "mrad"].contains(&rest.to_lowercase().as_str()));
        let text = per_second.map_or_else(|| text.to_owned(), |rest| format!("{rest}/s"));
        let mut plain = String::new();
        for c in text.chars() {
            match c {
                ' ' | '\u{a0}' | '.' | '*' | '·' | '⋅' | '×' | '-' | '−' | '^' | '_' | '(' | ')' => {}
                'µ' | 'μ' => plain.push('u'),
                '°' | 'º' => plain.push_str("deg"),
                '⁻' => {}
                '¹' => plain.push('1'),
                c => plain.extend(c.to_lowercase()),
            }
        }
        let known = UNITS.iter().find(|(.., spellings)| spellings.contains(&plain.as_str()));
        known.map(|&(kind, factor, name, _)| Self { kind, factor, name })
    }
}

/// Names of the units of these kinds, for a message.
pub(super) fn listed(kinds: &[Kind]) -> String {
    let names: Vec<&str> =
        UNITS.iter().filter(|(kind, ..)| kinds.contains(kind)).map(|(_, _, name, _)| *name).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::{Kind, Unit, listed};

    #[test]
    fn usual_spellings_of_units_are_read_and_other_words_are_none() {
        for (text, kind, factor) in [
            ("deg", Kind::Angle, 0.017_453_292_519_943_295),
            ("°", Kind::Angle, 0.017_453_292_519_943_295),
            ("N m", Kind::Torque, 1.0),
            ("N·m", Kind::Torque, 1.0),
            ("mNm", Kind::Torque, 1e-3),
            ("N cm", Kind::Torque, 1e-2),
            ("kgf.cm", Kind::Torque, 0.098_066_5),
            ("in-lb", Kind::Torque, 0.112_984_829),
            ("mA", Kind::Current, 1e-3),
            ("rpm", Kind::AngularSpeed, 0.104_719_755),
            ("°/s", Kind::AngularSpeed, 0.017_453_292_519_943_295),
            ("rad s^-1", Kind::AngularSpeed, 1.0),
            ("(rad/s)", Kind::AngularSpeed, 1.0),
            ("µs", Kind::Time, 1e-6),
            ("mm", Kind::Length, 1e-3),
        ] {
            let unit = Unit::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert!(unit.kind == kind && (unit.factor / factor - 1.0).abs() < 1e-8, "{text}: {unit:?}");
        }
        // `grad` is ambiguous: gon, or German for degree.
        for text in ["grad", "furlong", "", "q", "1", "joint"] {
            assert_eq!(Unit::parse(text), None, "{text}");
        }
        assert_eq!(listed(&[Kind::Force]), "N, mN, kN, kgf, lbf");
    }
}

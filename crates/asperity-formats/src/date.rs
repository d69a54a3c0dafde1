//! Dates of time stamps.

use std::fmt::Display;

/// Formats year, month, day, hour, minute and second.
pub(crate) fn text<T: Display>([year, month, day, hour, minute, second]: [T; 6]) -> String {
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}")
}

/// Formats seconds since 1970-01-01 as a date and time of UTC.
pub(crate) fn utc(seconds: u32) -> String {
    let (days, rest) = (i64::from(seconds) / 86400, seconds % 86400);
    // Days of years that start on 1 March, in eras of 400 years (146097 days) from 0000-03-01.
    let day = days + 719468;
    let (era, day) = (day / 146097, day % 146097);
    let year = (day - day / 1460 + day / 36524 - day / 146096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (day, month) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    let year = year + 400 * era + i64::from(month <= 2);
    let [hour, minute, second] = [rest / 3600, rest / 60 % 60, rest % 60].map(i64::from);
    text([year, month, day, hour, minute, second]) + "Z"
}

#[cfg(test)]
mod tests {
    use super::utc;

    #[test]
    fn seconds_are_days_of_the_gregorian_calendar() {
        // By `date -u -d @…`.
        for (seconds, date) in [
            (1, "1970-01-01T00:00:01Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_230_767_999, "2008-12-31T23:59:59Z"),
            (1_678_463_840, "2023-03-10T15:57:20Z"),
            (4_107_542_399, "2100-02-28T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(utc(seconds), date);
        }
    }
}

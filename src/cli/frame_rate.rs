//! The value of `--rate`: frames per second.
//!
//! In: a whole number, a decimal number or a ratio. Out: a ratio of whole numbers, as video streams store it. Always: the rates of television and film that are
//! 1000/1001 of a whole number, such as 29.97, are exactly that.

use std::fmt;
use std::str::FromStr;

/// Whole rates of which a video may have 1000/1001.
const RATES_OF_TELEVISION: [u32; 5] = [24, 30, 48, 60, 120];
/// Largest difference of a decimal number from such a rate: 23.98 means 24000/1001 = 23.976.
const DECIMALS_TOLERANCE: f64 = 0.005;
/// Decimal numbers are exact to a thousandth.
const THOUSANDTHS: u32 = 1000;

/// A number of frames in a number of seconds, both above 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRate {
    pub frames: u32,
    pub seconds: u32,
}

/// A text that is no frame rate.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("write a whole number of frames per second, as 25, a decimal number above 0.001, as 29.97, or a ratio, as 30000/1001")]
pub(crate) struct FrameRateError;

impl Default for FrameRate {
    fn default() -> Self {
        Self { frames: 25, seconds: 1 }
    }
}

impl FrameRate {
    /// For tours, which need the feature `view`.
    #[cfg(any(test, feature = "view"))]
    pub fn per_second(self) -> f64 {
        f64::from(self.frames) / f64::from(self.seconds)
    }

    /// The rate as a whole number; `None` if it is none.
    pub fn whole(self) -> Option<u32> {
        self.frames.is_multiple_of(self.seconds).then_some(self.frames / self.seconds)
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.whole() {
            Some(whole) => write!(f, "{whole}"),
            None => write!(f, "{}/{}", self.frames, self.seconds),
        }
    }
}

impl FromStr for FrameRate {
    type Err = FrameRateError;
    fn from_str(text: &str) -> Result<Self, FrameRateError> {
        let rate = |frames: u32, seconds: u32| Self { frames, seconds };
        let parsed = match text.split_once(['/', ':']) {
            Some((frames, seconds)) => frames.trim().parse().ok().zip(seconds.trim().parse().ok()).map(|(f, s)| rate(f, s)),
            None => text.trim().parse().ok().map(|whole| rate(whole, 1)).or_else(|| text.trim().parse().ok().and_then(of_decimal)),
        };
        parsed.filter(|rate| rate.frames > 0 && rate.seconds > 0).ok_or(FrameRateError)
    }
}

/// The rate of a decimal number; `None` if it is too large or too small for one.
fn of_decimal(value: f64) -> Option<FrameRate> {
    let of_television = |whole: &&u32| (f64::from(**whole) * 1000.0 / 1001.0 - value).abs() < DECIMALS_TOLERANCE;
    if let Some(whole) = RATES_OF_TELEVISION.iter().find(of_television) {
        return Some(FrameRate { frames: whole * 1000, seconds: 1001 });
    }
    let thousandths = (value * f64::from(THOUSANDTHS)).round();
    (1.0..=f64::from(u32::MAX)).contains(&thousandths).then_some(FrameRate { frames: thousandths as u32, seconds: THOUSANDTHS })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_decimal_and_ratio_rates_are_read() {
        for (text, frames, seconds, shown) in [
            ("25", 25, 1, "25"),
            ("29.97", 30_000, 1001, "30000/1001"),
            ("23.976", 24_000, 1001, "24000/1001"),
            ("23.98", 24_000, 1001, "24000/1001"),
            ("59.94", 60_000, 1001, "60000/1001"),
            ("30000/1001", 30_000, 1001, "30000/1001"),
            ("30000:1001", 30_000, 1001, "30000/1001"),
            ("12.5", 12_500, 1000, "12500/1000"),
            ("50.0", 50_000, 1000, "50"),
            ("1/10", 1, 10, "1/10"),
        ] {
            let rate: FrameRate = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            assert_eq!((rate, rate.to_string().as_str()), (FrameRate { frames, seconds }, shown), "{text}");
        }
        assert!(("29.97".parse::<FrameRate>().expect("a rate").per_second() - 29.970_03).abs() < 1e-5);
        assert_eq!(("50.0".parse::<FrameRate>().map(FrameRate::whole), "12.5".parse().map(FrameRate::whole)), (Ok(Some(50)), Ok(None)));
    }

    #[test]
    fn other_texts_are_refused() {
        for text in ["", "0", "-25", "0/1", "25/0", "1/2/3", "25 fps", "nan", "inf", "1e30", "0.0001", "5000000000"] {
            assert_eq!(text.parse::<FrameRate>(), Err(FrameRateError), "{text}");
        }
    }
}

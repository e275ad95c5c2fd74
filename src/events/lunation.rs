//! Mean new and full moons, and the Saros series that they belong to.
//!
//! In: instants and numbers of lunations. Out: mean phases within 15 hours of the true phases, and numbers of series. Lunation 0 is the new moon of
//! 2000-01-06 (Meeus 1998, Astronomical Algorithms, chapter 49). Not here: the true phases.

use crate::time::Instant;

/// TT Julian date of the mean new moon of lunation 0 (Meeus 1998, eq. 49.1).
const LUNATION_0_JD_TT: f64 = 2_451_550.097_66;
/// Days between mean new moons.
const SYNODIC_MONTH_DAYS: f64 = 29.530_588_861;
/// In a Julian century (Meeus 1998, eq. 49.3).
const LUNATIONS_PER_CENTURY: f64 = 1236.85;

/// New moon or full moon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    New,
    Full,
}

/// A mean new or full moon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Syzygy {
    pub phase: Phase,
    /// Number of the lunation. A new moon begins its lunation; a full moon belongs to the lunation of the last new moon before it.
    pub lunation: i64,
}

impl Syzygy {
    /// The last syzygy whose mean instant is not after `t`. The nonlinear terms of the mean instant are ignored, which is an error of half a day in 3000 BC.
    pub(crate) fn at_or_before(phase: Phase, t: Instant) -> Self {
        let offset = if phase == Phase::New { 0.0 } else { 0.5 };
        let lunation = ((t.jd_tt() - LUNATION_0_JD_TT) / SYNODIC_MONTH_DAYS - offset).floor() as i64;
        Self { phase, lunation }
    }

    /// The syzygy of the same phase in the next lunation.
    pub(crate) fn next(self) -> Self {
        Self { lunation: self.lunation + 1, ..self }
    }

    /// Meeus's k: lunations past the new moon of lunation 0.
    fn k(self) -> f64 {
        self.lunation as f64 + if self.phase == Phase::New { 0.0 } else { 0.5 }
    }

    /// The instant of the mean phase (Meeus 1998, eq. 49.1, without the term of the fourth power).
    pub(crate) fn mean_instant(self) -> Instant {
        let centuries = self.k() / LUNATIONS_PER_CENTURY;
        let jd_tt = LUNATION_0_JD_TT + SYNODIC_MONTH_DAYS * self.k() + 0.000_154_37 * centuries * centuries - 1.5e-7 * centuries.powi(3);
        Instant::from_jd_tt(jd_tt)
    }

    /// Whether the Moon is near enough to its node for an eclipse: the absolute sine of its mean argument of latitude is at most 0.36 (Meeus 1998, chapter 54).
    pub(crate) fn eclipse_is_possible(self) -> bool {
        let centuries = self.k() / LUNATIONS_PER_CENTURY;
        let argument_deg = 160.7108 + 390.670_502_84 * self.k() - 0.001_611_8 * centuries * centuries;
        argument_deg.to_radians().sin().abs() <= 0.36
    }

    /// Number of the Saros series, as van den Bergh counts them (Periodicity and Variation of Solar (and Lunar) Eclipses, 1955).
    ///
    /// Eclipses of one series are 223 lunations apart, and 358 lunations (an inex) add 1 to the number of the series. As 38 times 358 is 1 modulo 223, one
    /// lunation adds 38 modulo 223. References: the solar eclipse of 2024-04-08 is of series 139, the lunar eclipse of 2022-11-08 of 136
    /// (Espenak and Meeus 2006). These rules determine the number only modulo 223. Of the possible numbers, the result is the one nearest to the middle of the
    /// range of series that produce eclipses at the date of the syzygy. At the references this range was about 117 to 156 (Sun) and 110 to 150 (Moon), with
    /// the middles 137 and 130, which grow by 1 in an inex.
    pub(crate) fn saros_series(self) -> i64 {
        let (reference_lunation, reference_series, middle_series_at_reference) = match self.phase {
            Phase::New => (300, 139, 137),
            Phase::Full => (282, 136, 130),
        };
        let lunations = self.lunation - reference_lunation;
        let number_modulo_223 = reference_series + 38 * lunations;
        let middle_series = middle_series_at_reference as f64 + lunations as f64 / 358.0;
        number_modulo_223 + 223 * ((middle_series - number_modulo_223 as f64) / 223.0).round() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_numbers_agree_with_the_canons() {
        // Espenak and Meeus, Five Millennium Canons: (the day before the eclipse, phase, series). The day before, because the mean phase may be earlier than
        // the eclipse by up to 15 hours.
        for (day_before, phase, series) in [
            ("2017-08-20", Phase::New, 145),
            ("2024-04-07", Phase::New, 139),
            ("1999-08-10", Phase::New, 145),
            ("2009-07-21", Phase::New, 136),
            ("1919-05-28", Phase::New, 136),
            ("2015-03-19", Phase::New, 120),
            ("2012-05-19", Phase::New, 128),
            ("2022-11-07", Phase::Full, 136),
            ("2018-07-26", Phase::Full, 129),
            ("2019-01-20", Phase::Full, 134),
            ("2025-03-13", Phase::Full, 123),
        ] {
            // If the last mean phase is more than a day before this day, the eclipse's is the next one.
            let mut syzygy = Syzygy::at_or_before(phase, Instant::parse(day_before).expect("a day"));
            if syzygy.mean_instant() < Instant::parse(day_before).expect("a day").plus_seconds(-86_400.0) {
                syzygy = syzygy.next();
            }
            assert_eq!(syzygy.saros_series(), series, "{day_before}");
            // The next lunation belongs to another series.
            assert_ne!(syzygy.next().saros_series(), series, "{day_before}");
        }
    }

    #[test]
    fn a_saros_leads_to_the_same_series_and_an_inex_to_the_next() {
        for phase in [Phase::New, Phase::Full] {
            for lunation in (-20_000..14_000).step_by(97) {
                let syzygy = Syzygy { phase, lunation };
                let series_after = |by: i64| Syzygy { phase, lunation: lunation + by }.saros_series();
                let increase_to = |series: i64| (series - syzygy.saros_series()).rem_euclid(223);
                assert_eq!((increase_to(series_after(223)), increase_to(series_after(358))), (0, 1), "{lunation}");
            }
        }
    }
}

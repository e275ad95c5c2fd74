//! Instants and time scales.

/// An instant: seconds of TDB past J2000 (2000-01-01T12:00 TDB).
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Instant {
    tdb_s: f64,
}

#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct TimeError(pub String);

impl Instant {
    pub fn from_tdb_seconds_past_j2000(tdb_s: f64) -> Self {
        Self { tdb_s }
    }
    pub fn from_jd_tdb(jd_tdb: f64) -> Self {
        Self { tdb_s: (jd_tdb - crate::units::JD_J2000) * crate::units::SECONDS_PER_DAY }
    }
    pub fn from_jd_tt(_jd_tt: f64) -> Self {
        unimplemented!()
    }
    /// ISO 8601 UTC (`2024-04-08T18:17:16Z`, years before 1 as astronomical `-2999-…`) or `jd_tdb:2460409.262`.
    pub fn parse(_text: &str) -> Result<Self, TimeError> {
        unimplemented!()
    }
    pub fn tdb_seconds_past_j2000(self) -> f64 {
        self.tdb_s
    }
    pub fn jd_tdb(self) -> f64 {
        self.tdb_s / crate::units::SECONDS_PER_DAY + crate::units::JD_J2000
    }
    pub fn jd_tt(self) -> f64 {
        unimplemented!()
    }
    pub fn jd_ut1(self) -> f64 {
        unimplemented!()
    }
    /// `2024-04-08T18:17:16Z`, with milliseconds when they are not zero.
    pub fn to_utc_iso(self) -> String {
        unimplemented!()
    }
    pub fn plus_seconds(self, s: f64) -> Self {
        Self { tdb_s: self.tdb_s + s }
    }
}

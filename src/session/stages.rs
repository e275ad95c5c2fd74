//! Time by stage.

use std::time::{Duration, Instant};

/// The stages of the way from files to a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    Catalog,
    Kernel,
    Scene,
    Shaders,
    Maps,
    Plan,
    Draw,
    Write,
}

impl Stage {
    pub const ALL: [Self; 8] = [Self::Catalog, Self::Kernel, Self::Scene, Self::Shaders, Self::Maps, Self::Plan, Self::Draw, Self::Write];

    pub fn name(self) -> &'static str {
        match self {
            Self::Catalog => "catalog",
            Self::Kernel => "kernel",
            Self::Scene => "scene",
            Self::Shaders => "shaders",
            Self::Maps => "maps",
            Self::Plan => "plan",
            Self::Draw => "draw",
            Self::Write => "write",
        }
    }
}

/// Elapsed time of each stage, summed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stages {
    spent: [Duration; Stage::ALL.len()],
}

impl Stages {
    pub fn add(&mut self, stage: Stage, spent: Duration) {
        self.spent[stage as usize] += spent;
    }
    /// Runs `work` and adds its time.
    pub fn measure<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let done = work();
        self.add(stage, start.elapsed());
        done
    }
    pub fn spent(&self, stage: Stage) -> Duration {
        self.spent[stage as usize]
    }
    /// `{"catalog_ms": …, …}`.
    pub fn to_json(&self) -> serde_json::Value {
        let ms = |s: Stage| (format!("{}_ms", s.name()), serde_json::json!((self.spent(s).as_secs_f64() * 1e6).round() / 1e3));
        serde_json::Value::Object(Stage::ALL.into_iter().map(ms).collect())
    }
}

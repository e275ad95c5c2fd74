//! Times of the stages: elapsed time, and CPU time of all threads of the process if it is counted.
//!
//! In: the time of each run of a stage. Out: the sum for each stage, sums and differences of such lists, and their JSON. Not here: the measurement of CPU time.

use std::time::{Duration, Instant};

/// The stages from files to an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Reading catalogs.
    Catalog,
    /// Reading the ephemeris.
    Kernel,
    /// Building the scene.
    Scene,
    /// Compiling shader modules.
    Shaders,
    /// Reading maps and shape models.
    Maps,
    /// Planning passes and uniforms.
    Plan,
    /// Executing the plan.
    Draw,
    /// Writing files.
    Write,
}

impl Stage {
    /// All stages, in the order of reports.
    pub const ALL: [Self; 8] = [Self::Catalog, Self::Kernel, Self::Scene, Self::Shaders, Self::Maps, Self::Plan, Self::Draw, Self::Write];

    /// The name in reports.
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

/// Total elapsed and CPU time of each stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stages {
    elapsed: [Duration; Stage::ALL.len()],
    cpu: [Option<Duration>; Stage::ALL.len()],
}

impl Stages {
    /// Adds elapsed time.
    pub fn add(&mut self, stage: Stage, elapsed: Duration) {
        self.elapsed[stage as usize] += elapsed;
    }
    /// Runs `work` and adds its elapsed time.
    pub fn measure<T>(&mut self, stage: Stage, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(stage, start.elapsed());
        result
    }
    /// Elapsed time.
    pub fn elapsed(&self, stage: Stage) -> Duration {
        self.elapsed[stage as usize]
    }
    /// Adds CPU time. If none is ever added to a stage, its CPU time is unknown.
    pub fn add_cpu(&mut self, stage: Stage, cpu_time: Duration) {
        let cpu = &mut self.cpu[stage as usize];
        *cpu = Some(cpu.unwrap_or_default() + cpu_time);
    }
    /// CPU time of all threads while the stage ran; `None` if unknown.
    pub fn cpu(&self, stage: Stage) -> Option<Duration> {
        self.cpu[stage as usize]
    }
    /// The times of `self` and `other`, added stage by stage.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        for stage in Stage::ALL {
            self.add(stage, other.elapsed(stage));
            if let Some(cpu) = other.cpu(stage) {
                self.add_cpu(stage, cpu);
            }
        }
        self
    }
    /// The times added since `earlier` was copied from the same total.
    pub fn since(&self, earlier: &Self) -> Self {
        let mut difference = Self::default();
        for stage in Stage::ALL {
            difference.add(stage, self.elapsed(stage).saturating_sub(earlier.elapsed(stage)));
            if let Some(cpu) = self.cpu(stage) {
                difference.add_cpu(stage, cpu.saturating_sub(earlier.cpu(stage).unwrap_or_default()));
            }
        }
        difference
    }
    /// Elapsed times: `{"catalog_ms": …, …}`.
    pub fn to_json(&self) -> serde_json::Value {
        let field = |stage: Stage| (format!("{}_ms", stage.name()), serde_json::json!(milliseconds(self.elapsed(stage))));
        serde_json::Value::Object(Stage::ALL.into_iter().map(field).collect())
    }
}

/// Milliseconds, rounded to microseconds for reports.
pub fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn since_is_the_difference_and_unmeasured_cpu_time_stays_unknown() {
        let ms = Duration::from_millis;
        let mut before = Stages::default();
        before.add(Stage::Draw, ms(5));
        before.add_cpu(Stage::Draw, ms(9));
        let mut after = before.clone();
        after.add(Stage::Draw, ms(2));
        after.add_cpu(Stage::Draw, ms(4));
        after.add(Stage::Plan, ms(1));
        let since = after.since(&before);
        assert_eq!((since.elapsed(Stage::Draw), since.cpu(Stage::Draw)), (ms(2), Some(ms(4))));
        assert_eq!((since.elapsed(Stage::Plan), since.cpu(Stage::Plan)), (ms(1), None));
    }
}

//! Runs fuzz targets in a plain loop, with any toolchain: `orrery-fuzz TARGET|all SECONDS [SEED]`.
//!
//! In: the targets, their seed inputs (valid ones), and the inputs of past findings in fuzz/inputs/TARGET/. These run first, then random mutations of them and
//! of earlier mutations. Out: the number of runs of each target and the longest run. A finding (a panic, a run longer than
//! [`MAX_CPU_TIME`] or [`MAX_WALL_TIME`], or memory beyond [`MAX_GROWTH_BYTES`]) is written to fuzz/findings/ and ends the program with status 1. Always: the
//! same SEED, the number that starts the random generator, gives the same inputs.

use orrery_fuzz::{TARGETS, Target};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Maximum CPU time of a run.
const MAX_CPU_TIME: Duration = Duration::from_secs(5);
/// Maximum wall time of a run, which finds a run that only waits. Longer than [`MAX_CPU_TIME`], because other programs may use the cores.
const MAX_WALL_TIME: Duration = Duration::from_secs(60);
/// Maximum growth of the program's memory since the start of a target.
const MAX_GROWTH_BYTES: u64 = 1 << 30;
/// Inputs are truncated to this size.
const MAX_INPUT_BYTES: usize = 1 << 20;
/// Maximum number of inputs in the pool, from which mutations start.
const MAX_POOL: usize = 256;
/// Interval at which the watch thread checks the running input.
const WATCH_INTERVAL: Duration = Duration::from_millis(20);

/// The pseudorandom generator SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 to `count` - 1; 0 if `count` is 0.
    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }
}

/// The input with one to four random changes: bits or bytes changed, words of the format or extreme numbers inserted, pieces copied, repeated, removed, or
/// taken from `other`.
fn mutated(input: &[u8], other: &[u8], words: &[&str], random: &mut Random) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..1 + random.below(4) {
        let start = random.below(bytes.len() + 1);
        let length = 1 + random.below(16);
        let end = (start + length).min(bytes.len());
        match random.below(9) {
            0 if start < bytes.len() => bytes[start] ^= 1 << random.below(8),
            1 if start < bytes.len() => bytes[start] = random.next() as u8,
            2 => drop(bytes.drain(start..end)),
            3 => {
                let piece = bytes[start..end].to_vec();
                let copy_start = random.below(bytes.len() + 1);
                bytes.splice(copy_start..copy_start, piece);
            }
            4 if !words.is_empty() => drop(bytes.splice(start..start, words[random.below(words.len())].bytes())),
            5 if !words.is_empty() => drop(bytes.splice(start..end, words[random.below(words.len())].bytes())),
            6 if !other.is_empty() => {
                let other_start = random.below(other.len());
                bytes.splice(start..end, other[other_start..(other_start + length).min(other.len())].iter().copied());
            }
            7 => {
                // Little-endian: 0, the greatest u32, the greatest i32, and NaN as f32 and f64.
                let extreme: &[u8] =
                    [&[0; 4][..], &[0xff; 4], &[0xff, 0xff, 0xff, 0x7f], &[0, 0, 0xc0, 0x7f], &[0, 0, 0, 0, 0, 0, 0xf8, 0x7f]]
                        [random.below(5)];
                bytes.splice(start..(start + extreme.len()).min(bytes.len()), extreme.iter().copied());
            }
            _ => {
                let piece = bytes[start..end].repeat(1 + random.below(64));
                bytes.splice(start..end, piece);
            }
        }
    }
    bytes.truncate(MAX_INPUT_BYTES);
    bytes
}

/// The input that is running, and when its run started.
struct Run {
    start: Instant,
    /// CPU time of the process when the watch thread first saw this run; `None` before that.
    cpu_time_at_start: Option<Duration>,
    input: Vec<u8>,
}

/// The current run, for the watch thread; `None` between runs.
static RUNNING: Mutex<Option<Run>> = Mutex::new(None);

fn running() -> MutexGuard<'static, Option<Run>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Run {
    fn of(input: &[u8]) -> Self {
        Self { start: Instant::now(), cpu_time_at_start: None, input: input.to_vec() }
    }

    /// Whether the run has exceeded a limit. Called only by the watch thread, because reading the CPU time takes longer than most runs.
    fn is_too_long(&mut self) -> bool {
        let now = cpu_time();
        let cpu_time_at_start = *self.cpu_time_at_start.get_or_insert(now.unwrap_or_default());
        let wall_time = self.start.elapsed();
        wall_time > MAX_WALL_TIME || now.map_or(wall_time, |now| now.saturating_sub(cpu_time_at_start)) > MAX_CPU_TIME
    }
}

/// CPU time of this process in user space; `None` if the system does not report it.
fn cpu_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Field 14 (`utime`, in hundredths of a second), counted from the end of field 2, the program's name, which may contain blanks: proc(5).
    let ticks: u64 = stat.rsplit_once(')')?.1.split_whitespace().nth(11)?.parse().ok()?;
    Some(Duration::from_millis(10 * ticks))
}

/// Prints a finding, writes its input to fuzz/findings/ and ends the program.
fn report_finding(target: &str, random_seed: u64, input: &[u8], what: &str) -> ! {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("findings");
    let path = folder.join(format!("{target}-{random_seed}"));
    let written = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, input));
    println!("{target:16} {what}: {} bytes, {}", input.len(), written.map_or_else(|e| e.to_string(), |()| path.display().to_string()));
    std::process::exit(1)
}

/// The inputs of past findings of a target, and others worth keeping, sorted by file name: a folder lists its files in any order.
fn kept_inputs(target: &Target) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("inputs").join(target.name);
    let mut paths: Vec<_> = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).expect("a kept input")).collect()
}

/// Runs one input, watched; a panic is a finding.
fn run_watched(target: &Target, random_seed: u64, input: &[u8]) {
    *running() = Some(Run::of(input));
    if catch_unwind(AssertUnwindSafe(|| (target.run)(input))).is_err() {
        report_finding(target.name, random_seed, input, "it panics");
    }
    *running() = None;
}

/// Fuzzes a target for some time. Returns the number of runs and the time of the longest one.
fn fuzz(target: &'static Target, time: Duration, random_seed: u64) -> (u64, Duration) {
    let mut random = Random(random_seed);
    let mut pool = (target.seeds)();
    pool.extend(kept_inputs(target));
    // Not watched: this run loads what all runs share.
    let _ = catch_unwind(AssertUnwindSafe(|| (target.run)(&pool[0])));
    for input in &pool {
        run_watched(target, random_seed, input);
    }
    let (start, mut runs, mut longest) = (Instant::now(), 0, Duration::ZERO);
    while start.elapsed() < time {
        let (base, other) = (random.below(pool.len()), random.below(pool.len()));
        let input = mutated(&pool[base], &pool[other], target.words, &mut random);
        let start_of_run = Instant::now();
        run_watched(target, random_seed, &input);
        runs += 1;
        longest = longest.max(start_of_run.elapsed());
        // Some mutations are mutated further, to get beyond what single changes reach. In a full pool they replace inputs at random, and sometimes a seed
        // input returns.
        if random.below(16) == 0 {
            if pool.len() < MAX_POOL {
                pool.push(input);
            } else {
                let replaced = random.below(MAX_POOL);
                pool[replaced] = if random.below(4) == 0 { (target.seeds)().swap_remove(0) } else { input };
            }
        }
    }
    (runs, longest)
}

/// Resident memory of this process; `None` if the system does not report it.
fn resident_bytes() -> Option<u64> {
    let pages: u64 = std::fs::read_to_string("/proc/self/statm").ok()?.split(' ').nth(1)?.parse().ok()?;
    // Pages of 4 kB, as on x86-64.
    Some(pages * 4096)
}

/// The watch thread: reports a run that takes too long or too much memory. Ends once the `Arc` behind `in_progress` is dropped, after `fuzz` has returned.
fn watch(target: &str, random_seed: u64, in_progress: &Weak<()>) {
    let bytes_at_start = resident_bytes();
    while in_progress.strong_count() > 0 {
        std::thread::sleep(WATCH_INTERVAL);
        let growth = resident_bytes().zip(bytes_at_start).map_or(0, |(now, at_start)| now.saturating_sub(at_start));
        let finding = running().as_mut().and_then(|run| {
            let what = if run.is_too_long() {
                "it takes too long"
            } else if growth > MAX_GROWTH_BYTES {
                "it takes more than a gigabyte"
            } else {
                return None;
            };
            Some((what, run.input.clone()))
        });
        if let Some((what, input)) = finding {
            report_finding(target, random_seed, &input, what);
        }
    }
}

fn main() -> std::process::ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let chosen: Vec<&'static Target> = TARGETS.iter().filter(|t| arguments.first().is_some_and(|a| a == "all" || a == t.name)).collect();
    let time = arguments.get(1).and_then(|a| Duration::try_from_secs_f64(a.parse().ok()?).ok()).filter(|time| !time.is_zero());
    let random_seed = arguments.get(2).map_or(Some(1), |a| a.parse().ok());
    let (false, Some(time), Some(random_seed)) = (chosen.is_empty(), time, random_seed) else {
        let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
        eprintln!("orrery-fuzz TARGET|all SECONDS [SEED]; targets: {}", names.join(", "));
        return 2.into();
    };
    for target in chosen {
        let (name, token) = (target.name, Arc::new(()));
        let in_progress = Arc::downgrade(&token);
        let watch_thread = std::thread::spawn(move || watch(name, random_seed, &in_progress));
        let (runs, longest) = fuzz(target, time, random_seed);
        println!("{name:16} {runs:>10} runs, the longest {:.3} s", longest.as_secs_f64());
        drop(token);
        let _ = watch_thread.join();
    }
    0.into()
}

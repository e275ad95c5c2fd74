//! Runs fuzz targets as a plain loop on any toolchain: `orrery-fuzz TARGET|all SECONDS [SEED]`.
//!
//! Begins with the kept inputs of fuzz/inputs/TARGET/, mutates sound inputs and what it made of them, and counts. A finding (a panic, a run longer than [`PATIENCE`], or memory
//! beyond [`MAX_GROWTH_BYTES`]) is written to fuzz/findings/ and ends the program with status 1. The same seed makes the same inputs.

use orrery_fuzz::{TARGETS, Target};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

/// No input of at most [`MAX_BYTES`] may take more processor time.
const PATIENCE: Duration = Duration::from_secs(5);
/// Nor more time on the clock, if it only waits; other programs may have the processors.
const PATIENCE_ON_CLOCK: Duration = Duration::from_secs(60);
/// No input may take more memory than this beyond what the program had.
const MAX_GROWTH_BYTES: u64 = 1 << 30;
/// Longer inputs are cut.
const MAX_BYTES: usize = 1 << 20;
/// Inputs that are kept to go on from.
const MAX_POOL: usize = 256;

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }
}

/// Some changes to an input: bytes, numbers, words, pieces moved, doubled, removed, or taken from another input.
fn mutated(input: &[u8], other: &[u8], words: &[&str], random: &mut Random) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(bytes.len() + 1);
        let length = 1 + random.below(16);
        let end = (at + length).min(bytes.len());
        match random.below(9) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = random.next() as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = bytes[at..end].to_vec();
                let to = random.below(bytes.len() + 1);
                bytes.splice(to..to, piece);
            }
            4 if !words.is_empty() => drop(bytes.splice(at..at, words[random.below(words.len())].bytes())),
            5 if !words.is_empty() => drop(bytes.splice(at..end, words[random.below(words.len())].bytes())),
            6 if !other.is_empty() => {
                let from = random.below(other.len());
                bytes.splice(at..end, other[from..(from + length).min(other.len())].iter().copied());
            }
            7 => {
                let extreme: &[u8] =
                    [&[0; 4][..], &[0xff; 4], &[0xff, 0xff, 0xff, 0x7f], &[0, 0, 0xc0, 0x7f], &[0, 0, 0, 0, 0, 0, 0xf8, 0x7f]]
                        [random.below(5)];
                bytes.splice(at..(at + extreme.len()).min(bytes.len()), extreme.iter().copied());
            }
            _ => {
                let piece = bytes[at..end].repeat(1 + random.below(64));
                bytes.splice(at..end, piece);
            }
        }
    }
    bytes.truncate(MAX_BYTES);
    bytes
}

/// The input that runs, for the watch, and since when: on the clock, and of this process's processor time.
struct Run {
    since: Instant,
    since_processor: Option<Duration>,
    input: Vec<u8>,
}

static RUNNING: Mutex<Option<Run>> = Mutex::new(None);

fn running() -> MutexGuard<'static, Option<Run>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Run {
    fn of(input: &[u8]) -> Self {
        Self { since: Instant::now(), since_processor: None, input: input.to_vec() }
    }

    /// Asked by the watch: the processor's time is read there alone, since reading it takes longer than most runs.
    fn is_too_long(&mut self) -> bool {
        let now = processor_time();
        let begun = *self.since_processor.get_or_insert(now.unwrap_or_default());
        let waited = self.since.elapsed();
        waited > PATIENCE_ON_CLOCK || now.map_or(waited, |now| now.saturating_sub(begun)) > PATIENCE
    }
}

/// User time of this process; none where the system does not say.
fn processor_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The fields after the program's name, which may hold blanks; the 14th of all, in hundredths of a second.
    let ticks: u64 = stat.rsplit_once(')')?.1.split_whitespace().nth(11)?.parse().ok()?;
    Some(Duration::from_millis(10 * ticks))
}

/// Says a finding, keeps its input and ends the program.
fn found(target: &str, seed: u64, input: &[u8], what: &str) -> ! {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("findings");
    let path = folder.join(format!("{target}-{seed}"));
    let kept = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, input));
    println!("{target:16} {what}: {} bytes, {}", input.len(), kept.map_or_else(|e| e.to_string(), |()| path.display().to_string()));
    std::process::exit(1)
}

/// What is kept for a target: inputs that once fell, and some that reach far.
fn kept_inputs(target: &Target) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("inputs").join(target.name);
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    files.map(|file| std::fs::read(file.path()).expect("a kept input")).collect()
}

/// The number of runs and the longest of them.
fn attack(target: &'static Target, time: Duration, seed: u64) -> (u64, Duration) {
    let mut random = Random(seed);
    let mut pool = (target.seeds)();
    pool.extend(kept_inputs(target));
    // Once unwatched: it loads what all runs share.
    let _ = catch_unwind(AssertUnwindSafe(|| (target.run)(&pool[0])));
    for input in &pool {
        *running() = Some(Run::of(input));
        if catch_unwind(AssertUnwindSafe(|| (target.run)(input))).is_err() {
            found(target.name, seed, input, "it panics");
        }
        *running() = None;
    }
    let (begun, mut runs, mut longest) = (Instant::now(), 0, Duration::ZERO);
    while begun.elapsed() < time {
        let (from, other) = (random.below(pool.len()), random.below(pool.len()));
        let input = mutated(&pool[from], &pool[other], target.words, &mut random);
        let start = Instant::now();
        *running() = Some(Run::of(&input));
        if catch_unwind(AssertUnwindSafe(|| (target.run)(&input))).is_err() {
            found(target.name, seed, &input, "it panics");
        }
        *running() = None;
        runs += 1;
        longest = longest.max(start.elapsed());
        // Chains of changes reach further than single ones.
        if random.below(16) == 0 {
            if pool.len() < MAX_POOL {
                pool.push(input);
            } else {
                let at = random.below(MAX_POOL);
                pool[at] = if random.below(4) == 0 { (target.seeds)().swap_remove(0) } else { input };
            }
        }
    }
    (runs, longest)
}

/// Bytes of memory that this process holds; none where the system does not say.
fn resident_bytes() -> Option<u64> {
    let pages: u64 = std::fs::read_to_string("/proc/self/statm").ok()?.split(' ').nth(1)?.parse().ok()?;
    Some(pages * 4096)
}

/// Ends the program where a run outlasts [`PATIENCE`] or takes too much memory: for a thread of its own.
fn watch(target: &str, seed: u64, is_over: &Weak<()>) {
    let before = resident_bytes();
    while is_over.strong_count() > 0 {
        std::thread::sleep(Duration::from_millis(20));
        let grown = resident_bytes().zip(before).map_or(0, |(now, before)| now.saturating_sub(before));
        let what = running().as_mut().and_then(|run| match () {
            () if run.is_too_long() => Some(("it does not end", run.input.clone())),
            () if grown > MAX_GROWTH_BYTES => Some(("it takes more than a gigabyte", run.input.clone())),
            () => None,
        });
        if let Some((what, input)) = what {
            found(target, seed, &input, what);
        }
    }
}

fn main() -> std::process::ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let chosen: Vec<&'static Target> = TARGETS.iter().filter(|t| words.first().is_some_and(|w| w == "all" || w == t.name)).collect();
    let seconds = words.get(1).and_then(|w| w.parse::<f64>().ok()).filter(|s| *s > 0.0 && s.is_finite());
    let seed = words.get(2).map_or(Some(1), |w| w.parse().ok());
    let (false, Some(seconds), Some(seed)) = (chosen.is_empty(), seconds, seed) else {
        let names: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
        eprintln!("orrery-fuzz TARGET|all SECONDS [SEED]; targets: {}", names.join(", "));
        return 2.into();
    };
    for target in chosen {
        let (name, done) = (target.name, Arc::new(()));
        let is_over = Arc::downgrade(&done);
        let watching = std::thread::spawn(move || watch(name, seed, &is_over));
        let (runs, longest) = attack(target, Duration::from_secs_f64(seconds), seed);
        println!("{name:16} {runs:>10} runs, the longest {:.3} s", longest.as_secs_f64());
        drop(done);
        let _ = watching.join();
    }
    0.into()
}

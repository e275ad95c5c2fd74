//! The library on disk: damaged and foreign entries, concurrent access, and disks that refuse writes.

use crate::support::sweep;
use orrery::FrameImages;
use orrery::shader::key::covering_keys;
use orrery::shader::library::{ShaderLibrary, file_name};
use orrery::shader::{Lowering, ModuleId, ShaderModule};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex};

/// Length of an entry's magic number.
const MAGIC_BYTES: usize = 8;
/// Length of what precedes an entry's content: the magic number, and a checksum of 32 bytes.
const HEADER_BYTES: usize = MAGIC_BYTES + 32;

/// A stand-in for the renderer's lowering. Its tape depends on the module, so that the tape of another module is detected.
fn lowering() -> Lowering {
    Lowering {
        digest: "test 1".into(),
        lower: |module, _| Ok(tape_of(module)),
        check: |module, bytes| if bytes == tape_of(module) { Ok(()) } else { Err("another module's tape".into()) },
    }
}

fn tape_of(module: &naga::Module) -> Vec<u8> {
    format!("{} types", module.types.len()).into_bytes()
}

/// Four modules; the second text names no lights, so it is not a key and is left out.
fn ids() -> Vec<ModuleId> {
    ["lambert.albedo-normal.sun1.ellipsoid", "emissive.albedo.sphere", "emissive.albedo.sun0.sphere", "tone_map", "point"]
        .iter()
        .filter_map(|t| t.parse().ok())
        .collect()
}

struct Messages(Arc<Mutex<Vec<String>>>);

impl Messages {
    fn lines(&self) -> Vec<String> {
        self.0.lock().expect("no panic").clone()
    }
}

fn open(cache: &Path) -> (ShaderLibrary, Messages) {
    let messages = Arc::new(Mutex::new(Vec::new()));
    let sink = Arc::clone(&messages);
    (ShaderLibrary::open(cache, lowering(), move |line| sink.lock().expect("no panic").push(line.to_owned())), Messages(messages))
}

/// Equality in everything that a renderer or a reader uses. Spans are not stored on disk and are not compared.
fn assert_same(a: &ShaderModule, b: &ShaderModule) {
    assert_eq!((&a.id, &a.wgsl, &a.layout, &a.source_map, &a.tape), (&b.id, &b.wgsl, &b.layout, &b.source_map, &b.tape));
    let ir = |m: &ShaderModule| postcard::to_stdvec(&(&m.module, &m.info)).expect("encodes");
    assert_eq!(ir(a), ir(b));
}

/// A view draws with modules in memory, but filling the disk ends with the first module that it refuses: each thread has built at most one.
#[test]
fn filling_a_disk_ends_when_it_is_full() {
    let folder = tempfile::tempdir().expect("a folder");
    let (library, messages) = open(folder.path());
    // A file in the place of the folder refuses every module.
    let path = library.status().folder.expect("a folder");
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    std::fs::write(&path, "").expect("written");
    let modules: Vec<ModuleId> = covering_keys(2).into_iter().map(ModuleId::Keyed).collect();
    assert!(modules.len() > 2 * rayon::current_num_threads(), "too few to tell");
    assert!(library.warm_on_disk(&modules, || ()).is_empty());
    let built = library.statistics().emitted;
    assert!((1..=rayon::current_num_threads() as u64).contains(&built), "{built} modules");
    assert!(library.cannot_be_written() && messages.lines().len() == 1, "{:?}", messages.lines());
    // More than there are threads, so that at least one has not been built.
    let some = &modules[..rayon::current_num_threads() + 1];
    assert!(library.warm(some, || ()).is_empty());
    assert!(library.statistics().emitted > built && some.iter().all(|id| library.origin(id).is_some()), "for a view all are built");
}

fn newly_built(id: &ModuleId) -> ShaderModule {
    ShaderModule::build(id, &lowering()).expect("builds")
}

#[test]
fn a_second_library_reads_what_the_first_wrote() {
    let dir = tempfile::tempdir().expect("temp");
    let ids = ids();
    assert_eq!(ids.len(), 4, "one text without lights is not a key");
    for round in 0..2 {
        let (library, messages) = open(dir.path());
        for id in &ids {
            assert_same(&library.get(id).expect("module"), &newly_built(id));
            assert!(Arc::ptr_eq(&library.get(id).expect("module"), &library.get(id).expect("module")));
        }
        let s = library.statistics();
        let n = ids.len() as u64;
        assert_eq!((s.emitted, s.written, s.from_disk, s.repaired), if round == 0 { (n, n, 0, 0) } else { (0, 0, n, 0) });
        assert_eq!(s.from_memory, 2 * n);
        assert!(messages.lines().is_empty(), "{:?}", messages.lines());
        assert_eq!(library.status().entries, n);
        assert_eq!((library.verify().valid, library.verify().damaged.len()), (n, 0));
    }
}

/// Replaces an entry by `damaged` and expects the right module, one message, and an intact entry afterwards.
fn assert_repaired(dir: &Path, id: &ModuleId, path: &Path, intact: &[u8], damaged: &[u8], what: &str) {
    std::fs::write(path, damaged).expect("write");
    let (library, messages) = open(dir);
    assert_eq!(library.verify().damaged.len(), 1, "{what}");
    assert_same(&library.get(id).expect(what), &newly_built(id));
    library.get(id).expect(what);
    let lines = messages.lines();
    assert!(lines.len() == 1 && lines[0].contains("is replaced"), "{what}: {lines:?}");
    assert_eq!(library.statistics().repaired, 1, "{what}");
    assert_eq!(std::fs::read(path).expect("read"), intact, "{what}: the entry is intact again");
}

#[test]
fn damaged_entries_are_detected_and_repaired() {
    let dir = tempfile::tempdir().expect("temp");
    let id: ModuleId = "tone_map".parse().expect("name");
    let (library, _) = open(dir.path());
    library.get(&id).expect("module");
    let path = library.entry_path(&id).expect("on disk");
    let intact = std::fs::read(&path).expect("written");
    for keep in [0, 1, 7, 8, 39, 40, 41, intact.len() / 2, intact.len() - 1] {
        assert_repaired(dir.path(), &id, &path, &intact, &intact[..keep], &format!("cut to {keep} bytes"));
    }
    // Magic, checksum, the first bytes of the content, and 24 positions spread over the rest.
    let positions = (0..48).chain((0..24).map(|i| 48 + (intact.len() - 49) * i / 23));
    for at in positions {
        let mut damaged = intact.clone();
        damaged[at] ^= 1 << (at % 8);
        assert_repaired(dir.path(), &id, &path, &intact, &damaged, &format!("bit flipped in byte {at}"));
    }
    assert_repaired(dir.path(), &id, &path, &intact, b"a text file", "foreign");
    let mut longer = intact.clone();
    longer.push(0);
    assert_repaired(dir.path(), &id, &path, &intact, &longer, "a byte too many");
}

#[test]
fn an_intact_entry_of_another_module_or_generator_is_rejected() {
    let dir = tempfile::tempdir().expect("temp");
    let ids = ids();
    let (library, _) = open(dir.path());
    ids.iter().for_each(|id| drop(library.get(id).expect("module")));
    let path = |id| library.entry_path(id).expect("on disk");
    let (first, second) = (std::fs::read(path(&ids[0])).expect("read"), std::fs::read(path(&ids[1])).expect("read"));
    assert_repaired(dir.path(), &ids[0], &path(&ids[0]), &first, &second, "another module's entry");

    let other_lowering = Lowering { digest: "test 2".into(), ..lowering() };
    let other_library = ShaderLibrary::open(dir.path(), other_lowering, |_| {});
    other_library.get(&ids[0]).expect("module");
    assert_ne!(other_library.generator_digest(), library.generator_digest());
    assert_eq!((other_library.statistics().from_disk, other_library.status().entries), (0, 1), "each generator has its own folder");
    assert_eq!(other_library.status().other_entries, ids.len() as u64);
    let foreign = std::fs::read(other_library.entry_path(&ids[0]).expect("on disk")).expect("read");
    assert_repaired(dir.path(), &ids[0], &path(&ids[0]), &first, &foreign, "another generator's entry");

    assert_eq!(library.clear().expect("clears"), ids.len() as u64 + 1);
    assert_eq!((library.status().entries, library.status().other_entries), (0, 0));
}

/// Four threads, each with a library of its own, stand for the processes. Each file is removed by one of them; the others find it gone, which is no error.
#[test]
fn several_processes_may_clear_the_library_at_once() {
    const FILES: u64 = 3000;
    let cache = tempfile::tempdir().expect("temp");
    let folder = cache.path().join("orrery/shaders/another-generator");
    std::fs::create_dir_all(&folder).expect("made");
    (0..FILES).for_each(|k| std::fs::write(folder.join(format!("{k}.shader")), "x").expect("write"));
    let removed: u64 = std::thread::scope(|scope| {
        let clearing: Vec<_> = (0..4).map(|_| scope.spawn(|| open(cache.path()).0.clear().expect("clears"))).collect();
        clearing.into_iter().map(|thread| thread.join().expect("no panic")).sum()
    });
    assert!(removed == FILES && !folder.exists(), "{removed} of {FILES}");
}

#[test]
fn a_path_below_a_file_warns_and_cannot_be_cleared() {
    let dir = tempfile::tempdir().expect("temp");
    let file = dir.path().join("not-a-folder");
    std::fs::write(&file, "x").expect("write");
    let (library, messages) = open(&file);
    for id in ids() {
        assert_same(&library.get(&id).expect("module"), &newly_built(&id));
    }
    let lines = messages.lines();
    assert!(lines.len() == 1 && lines[0].contains("cannot be written") && lines[0].contains("--cache"), "{lines:?}");
    assert_eq!((library.statistics().written, library.status().entries), (0, 0));
    assert_eq!(library.verify().damaged.len(), 0);
    let error = library.clear().expect_err("the folder cannot be read").to_string();
    assert!(error.contains("not-a-folder") && error.contains("cannot be read"), "{error}");
}

#[test]
fn missing_folders_are_created_at_the_first_write() {
    let dir = tempfile::tempdir().expect("temp");
    let nested = dir.path().join("not/there/yet");
    let (library, messages) = open(&nested);
    for id in ids() {
        assert_same(&library.get(&id).expect("module"), &newly_built(&id));
    }
    assert_eq!((library.status().entries, library.verify().valid), (ids().len() as u64, ids().len() as u64));
    assert!(messages.lines().is_empty() && nested.is_dir(), "{:?}", messages.lines());
}

/// A folder that can be read but not written. The superuser may write to any ordinary folder; for that user the test takes a folder of the kernel.
#[cfg(unix)]
#[test]
fn a_read_only_folder_only_warns() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().expect("temp");
    let set_mode = |mode| std::fs::set_permissions(dir.path(), std::fs::Permissions::from_mode(mode)).expect("permissions");
    set_mode(0o555);
    let refuses_writes = |p: &&Path| p.is_dir() && std::fs::write(p.join("probe"), "x").is_err();
    let folders = [dir.path(), Path::new("/proc/self"), Path::new("/sys/kernel")];
    let Some(folder) = folders.iter().find(|p| refuses_writes(p)) else { panic!("this user writes into every folder") };
    let (library, messages) = open(folder);
    for id in ids() {
        assert_same(&library.get(&id).expect("module"), &newly_built(&id));
    }
    let lines = messages.lines();
    assert!(lines.len() == 1 && lines[0].contains("cannot be written"), "{lines:?}");
    assert_eq!((library.statistics().written, library.status().entries), (0, 0));
    set_mode(0o755);
}

#[test]
fn an_entry_that_is_a_folder_only_warns() {
    let dir = tempfile::tempdir().expect("temp");
    let (library, messages) = open(dir.path());
    let id = &ids()[0];
    std::fs::create_dir_all(library.entry_path(id).expect("path")).expect("folder");
    assert_same(&library.get(id).expect("module"), &newly_built(id));
    let lines = messages.lines();
    assert!(lines.len() == 1 && lines[0].contains("cannot be read") && lines[0].contains(&file_name(id)), "{lines:?}");
    // Other entries are still written.
    library.get(&ids()[1]).expect("module");
    assert!(library.statistics().written == 1 && messages.lines().len() == 1, "{:?}", messages.lines());
}

#[test]
fn file_names_begin_with_the_key_and_are_short() {
    for id in ids() {
        assert!(file_name(&id).starts_with(&id.to_string()));
    }
    let long_key: ModuleId =
        "lommel-seeliger.albedo-normal-specular-night.sun3.mesh.twosided-alphatexture-vertexcolour".parse().expect("key");
    assert!(file_name(&long_key).len() < 200);
}

/// Environment variable with the cache folder of a child process.
const CHILD_CACHE: &str = "ORRERY_TEST_LIBRARY_CHILD";

/// Does nothing except in the processes that the tests below start, where it fills the library in [`CHILD_CACHE`].
#[test]
fn child_fills_a_library() {
    let Some(cache) = std::env::var_os(CHILD_CACHE) else { return };
    let (library, messages) = open(&PathBuf::from(cache));
    for _ in 0..3 {
        for id in ids() {
            assert_same(&library.get(&id).expect("module"), &newly_built(&id));
        }
    }
    println!("emitted {} written {} messages {:?}", library.statistics().emitted, library.statistics().written, messages.lines());
}

fn child(cache: &Path) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("this binary"));
    // The test binary lists its tests by their path without the crate name.
    let own_path = module_path!().split_once("::").map_or("", |(_, path)| path);
    command.args(["--exact", &format!("{own_path}::child_fills_a_library"), "--nocapture"]).env(CHILD_CACHE, cache);
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    command
}

#[test]
fn eight_processes_and_as_many_threads_fill_one_library_at_once() {
    let dir = tempfile::tempdir().expect("temp");
    let children: Vec<_> = (0..8).map(|_| child(dir.path()).spawn().expect("starts")).collect();
    let (library, messages) = open(dir.path());
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| ids().iter().for_each(|id| assert_same(&library.get(id).expect("module"), &newly_built(id))));
        }
    });
    for child in children {
        let output = child.wait_with_output().expect("ends");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && text.contains("messages []"), "{text}{}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(messages.lines().is_empty(), "{:?}", messages.lines());
    let n = ids().len() as u64;
    assert_eq!(library.statistics().emitted + library.statistics().from_disk, n, "the threads of one library must share the work");
    assert_eq!((library.verify().valid, library.verify().damaged.len()), (n, 0));
    let folder = library.entry_path(&ids()[0]).expect("path").parent().expect("folder").to_owned();
    assert_eq!(std::fs::read_dir(folder).expect("read").count() as u64, n, "no temporary file is left");
}

/// Simulates a full disk: the shell limits files to length 0 and ignores the resulting signal, so each write fails.
#[cfg(unix)]
#[test]
fn a_full_disk_only_warns() {
    let dir = tempfile::tempdir().expect("temp");
    let child_command = child(dir.path());
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\""]).arg(child_command.get_program()).args(child_command.get_args());
    let output = command.env(CHILD_CACHE, dir.path()).output().expect("sh runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("written 0") && text.matches("cannot be written").count() == 1, "{text}");
    let (library, messages) = open(dir.path());
    assert_eq!(library.status().entries, 0);
    library.get(&ids()[0]).expect("module");
    assert!(messages.lines().is_empty());
}

/// An entry with edited content and a correct checksum, such as an attacker with write access to the folder could create.
fn tampered(intact: &[u8], edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    use sha2::{Digest, Sha256};
    let (magic, content) = (&intact[..MAGIC_BYTES], &intact[HEADER_BYTES..]);
    let mut content = content.to_vec();
    edit(&mut content);
    [magic, Sha256::digest(&content).as_slice(), &content].concat()
}

/// One byte is changed at each of 400 positions throughout the content. Every entry that is still accepted is a valid module, and its tape passes the
/// check of the software renderer's lowering; `verify` reports each changed entry and never panics.
#[test]
fn tampered_entries_are_accepted_only_if_valid() {
    let dir = tempfile::tempdir().expect("temp");
    let lowering = orrery::lowering();
    let id: ModuleId = "point".parse().expect("name");
    let library = ShaderLibrary::open(dir.path(), lowering.clone(), |_| {});
    library.get(&id).expect("module");
    let path = library.entry_path(&id).expect("on disk");
    let intact = std::fs::read(&path).expect("written");
    let length = intact.len() - HEADER_BYTES;
    let (mut accepted, mut replaced) = (0, 0);
    for k in 0..400 {
        let at = k * (length - 1) / 399;
        let damaged = tampered(&intact, |content| content[at] = content[at].wrapping_add([1, 0x80, 0xff, 7][k % 4]));
        std::fs::write(&path, &damaged).expect("write");
        let library = ShaderLibrary::open(dir.path(), lowering.clone(), |_| {});
        assert_eq!(library.verify().damaged.len(), 1, "byte {at}");
        let module = library.get(&id).expect("a module");
        if library.statistics().repaired == 1 {
            replaced += 1;
            assert_eq!(std::fs::read(&path).expect("read"), intact, "byte {at}: the entry is intact again");
            continue;
        }
        accepted += 1;
        orrery::shader::module::validate(&module.module).expect("valid");
        (lowering.check)(&module.module, &module.tape).expect("its own tape");
        // As if a renderer could not use the module: it is built anew, in memory and on disk, and a second time there is nothing to replace.
        assert_eq!(
            (library.replace_tampered(std::slice::from_ref(&id)), library.replace_tampered(std::slice::from_ref(&id))),
            (1, 0),
            "byte {at}"
        );
        assert_eq!(std::fs::read(&path).expect("read"), intact, "byte {at}: the entry is intact again");
        // As if the replacement could not be written: the tampered entry is on disk again. It must not be read again: the caller would have it
        // replaced without end.
        std::fs::write(&path, &damaged).expect("write");
        assert_eq!(library.get(&id).expect("a module").wgsl, ShaderModule::build(&id, &lowering).expect("builds").wgsl);
        assert_eq!(library.replace_tampered(std::slice::from_ref(&id)), 0, "byte {at}");
        std::fs::write(&path, &intact).expect("write");
    }
    println!("of 400 tampered entries {replaced} are replaced when read, {accepted} are valid modules");
    assert!(replaced > 100 && accepted > 0, "{replaced} and {accepted}: the sweep needs both rejected and accepted entries");
    // The unmodified entry itself is valid.
    let library = ShaderLibrary::open(dir.path(), lowering, |_| {});
    assert_eq!((library.verify().valid, library.get(&id).is_ok(), library.replace_tampered(&[id])), (1, true, 0));
}

/// A tampered entry that a plan or a renderer cannot use does not fail the frame: the entry is replaced and the image is the same.
#[test]
fn a_tampered_entry_that_cannot_be_used_is_replaced_and_the_frame_drawn() {
    use orrery::{NaifId, SamplingQuality, Session, Sources, ViewRequest};
    let dir = tempfile::tempdir().expect("temp");
    let messages = Arc::new(Mutex::new(Vec::<String>::new()));
    let request = {
        // Amalthea.
        let mut request = ViewRequest::of(NaifId(505), orrery::Instant::parse("2024-01-01").expect("a time"));
        (request.width, request.height) = (16, 16);
        request
    };
    let draw = || {
        let messages = Arc::clone(&messages);
        let sources = Sources { cache: Some(dir.path().to_owned()), ..Sources::default() };
        let session = Session::open(&sources, move |line| messages.lock().expect("no panic").push(line.to_owned())).expect("opens");
        session
            .draw(&request, SamplingQuality::of(request.quality), FrameImages::Display)
            .map(|drawn| drawn.frame.display)
            .map_err(|e| e.to_string())
    };
    let expected = draw().expect("an image");
    let shaders =
        std::fs::read_dir(dir.path().join("orrery/shaders")).expect("a folder").next().expect("a generator").expect("an entry").path();
    let entries: Vec<PathBuf> = std::fs::read_dir(shaders).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    assert!(entries.len() >= 2, "{entries:?}");
    let mut renamed = 0;
    for path in &entries {
        let intact = std::fs::read(path).expect("read");
        // One name at a time is changed wherever it occurs. If it is the name of a field or binding, no plan can fill the module.
        let names = ["exposure", "body_from", "camera", "source", "image", "scene"];
        for name in names {
            let places: Vec<usize> = intact
                .windows(name.len())
                .enumerate()
                .filter(|(_, w)| *w == name.as_bytes())
                .map(|(at, _)| at.saturating_sub(HEADER_BYTES))
                .collect();
            if places.is_empty() {
                continue;
            }
            renamed += 1;
            // One name in three, unless every sweep runs in full.
            if !sweep::runs(renamed, 3) {
                continue;
            }
            let damaged = tampered(&intact, |content| places.iter().for_each(|at| content[*at] = b'Z'));
            std::fs::write(path, damaged).expect("write");
            assert_eq!(draw().as_ref(), Ok(&expected), "{name} in {}", path.display());
            let lines: Vec<String> = messages.lock().expect("no panic").drain(..).collect();
            assert!(lines.len() <= 1 && lines.iter().all(|l| l.contains("is replaced") || l.contains("is not used")), "{lines:?}");
            std::fs::write(path, &intact).expect("write");
        }
    }
    assert!(renamed > 2, "{renamed} names were found in the entries");
}

/// A library folder that cannot be read is reported, not treated as empty.
#[test]
fn unreadable_library_folders_are_reported() {
    let dir = tempfile::tempdir().expect("temp");
    std::fs::create_dir_all(dir.path().join("orrery")).expect("a folder");
    std::fs::write(dir.path().join("orrery/shaders"), "a file").expect("a file");
    let (library, _) = open(dir.path());
    assert!(library.status().unreadable.is_some_and(|why| why.contains("shaders cannot be read")));
    assert!(library.verify().unreadable.is_some());
    assert!(library.clear().is_err_and(|e| e.to_string().contains("shaders cannot be read")));
    // A folder that does not exist yet counts as empty.
    let (library, _) = open(&dir.path().join("none"));
    assert_eq!((library.status().unreadable, library.verify().unreadable), (None, None));
    assert!(library.clear().is_ok_and(|removed| removed == 0));
}

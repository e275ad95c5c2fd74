//! Edits of the fragments while the renderer draws.

use super::frame::{scene, sphere, with_threads};
use glam::Vec3;
use orrery::FrameImages;
use orrery::render::plan::ModuleProvider;
use orrery::render::software::{SoftwareRenderer, lowering};
use orrery::scene::draw::MapSet;
use orrery::shader::fragments::{FRAGMENTS, Fragments};
use orrery::shader::{ModuleId, ShaderError, ShaderLibrary, ShaderModule};
use std::sync::{Arc, Mutex};

/// The modules of a library whose fragments are edited between the first fetch of a module and its decoding, as another thread might do.
struct EditedMeanwhile<'a> {
    library: &'a ShaderLibrary,
    renderer: &'a SoftwareRenderer,
    edit: Mutex<Option<Fragments>>,
}

impl ModuleProvider for EditedMeanwhile<'_> {
    fn module(&self, name: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        let module = self.library.get(name);
        if let Some(edited) = self.edit.lock().expect("not poisoned").take() {
            self.library.set_fragments(edited);
            self.renderer.forget_modules();
        }
        module
    }
}

#[test]
fn a_module_fetched_before_an_edit_is_not_kept_after_it() {
    let library = ShaderLibrary::in_memory(lowering());
    let renderer = SoftwareRenderer::new(with_threads(2)).expect("a renderer");
    let (path, text) = FRAGMENTS.iter().find(|(path, _)| *path == "lib/photometry/lambert.wesl").expect("a fragment");
    let darker = text.replacen("return ", "return 0.5 * ", 1);
    assert_ne!(*text, darker);
    let edited = Fragments::with_files([((*path).to_owned(), darker)]);
    let modules = EditedMeanwhile { library: &library, renderer: &renderer, edit: Mutex::new(Some(edited)) };
    let plan = scene([60, 60], vec![sphere(Vec3::new(1.0, 0.3, 0.2), MapSet::default())]);
    let [during, after] = [0, 1].map(|_| renderer.render(&plan, &modules, FrameImages::DisplayAndHdr).expect("a frame").0.hdr);
    let fresh = SoftwareRenderer::new(with_threads(2)).expect("a renderer");
    let expected = fresh.render(&plan, &library, FrameImages::DisplayAndHdr).expect("a frame").0.hdr;
    assert!(during != expected, "the edit must be visible");
    assert!(after == expected, "the renderer has kept the module from before the edit");
}

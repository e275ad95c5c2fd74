//! The first image is requested before there is a window, so that it is drawn while the window opens.

use crate::view::interface::{CpuTestRenderer, interface, session, settle};
use egui_kittest::Harness;
use orrery::catalog::NaifId;
use orrery::session::Session;
use orrery::view::panels::Interface;
use orrery::view::window::cpu_painter::Painter;
use orrery::view::worker::render_worker::{FailedJob, InlineWorker, RenderJob, RenderWorker, RenderedView, Task};
use std::sync::{Arc, Mutex};

/// Width and height of each requested image, pixels.
type Sizes = Arc<Mutex<Vec<[u32; 2]>>>;

/// Whether the requested images are drawn.
#[derive(Clone, Copy, PartialEq)]
enum Images {
    Drawn,
    /// They never arrive.
    Withheld,
}

/// A worker that records the sizes of the requested images.
struct RecordingWorker {
    inner: InlineWorker<'static>,
    sizes: Sizes,
    images: Images,
}

impl RenderWorker for RecordingWorker {
    fn session(&self) -> &Session {
        self.inner.session()
    }
    fn submit(&self, job: RenderJob) {
        self.sizes.lock().expect("sizes").push([job.request.width, job.request.height]);
        if self.images == Images::Drawn {
            self.inner.submit(job);
        }
    }
    fn take(&self) -> Option<Result<RenderedView, FailedJob>> {
        self.inner.take()
    }
    fn run(&self, task: Task) {
        self.inner.run(task);
    }
}

/// A window whose first image is requested for a viewport of this size, and the list of sizes of requested images. `change` is called between
/// that request and the first frame.
fn open_window(viewport_px: [u32; 2], images: Images, change: fn(&mut Interface)) -> (Harness<'static, Interface>, Sizes) {
    let sizes = Sizes::default();
    let worker = RecordingWorker { inner: InlineWorker::new(session()), sizes: Arc::clone(&sizes), images };
    let mut interface = interface(NaifId::MOON, "2017-05-17T00:00:00Z");
    interface.settings.panels.viewport_px = viewport_px;
    interface.request_first_image(&worker);
    change(&mut interface);
    let window = Harness::builder()
        .with_size([900.0, 560.0])
        .with_max_steps(40)
        .renderer(CpuTestRenderer(Painter::default()))
        .build_ui_state(move |ui, interface: &mut Interface| interface.ui(ui, &worker), interface);
    (window, sizes)
}

#[test]
fn the_first_image_is_requested_once_and_before_the_first_frame() {
    for viewport_px in [[720, 480], [300, 900], [0, 0]] {
        let (mut window, sizes) = open_window(viewport_px, Images::Drawn, |_| {});
        settle(&mut window);
        let sizes = sizes.lock().expect("sizes").clone();
        let last = window.state().shown().expect("an image");
        // The first image is coarse: a third as wide and high as the viewport of the previous run. All others have the full resolution of this window.
        let first = viewport_px.map(|side| side.max(1).div_ceil(3));
        assert_eq!(sizes[0], first, "{sizes:?}");
        assert!(sizes.len() > 1 && sizes[1..].iter().all(|[width, _]| *width == last.width), "{sizes:?}");
        assert_eq!(window.state().settings.panels.viewport_px, [last.width, last.height], "the size for the next run");
    }
    // While the first image has not arrived, another is requested only if the view changes.
    let request_count = |change: fn(&mut Interface)| {
        let (mut window, sizes) = open_window([720, 480], Images::Withheld, change);
        window.run_steps(3);
        assert!(window.state().shown().is_none());
        sizes.lock().expect("sizes").len()
    };
    assert_eq!(request_count(|_| {}), 1);
    assert!(request_count(|interface| interface.viewer.view.fov_deg = 20.0) > 1, "the other view was not requested");
}

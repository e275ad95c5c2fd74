//! The coarse image of the air on the GPU, which stores it as half floats, against the software renderer.

use crate::support::gpu::gpu;
use crate::support::session::SESSION;
use crate::support::sweep;
use orrery::image::DisplayImage;
use orrery::render::frame::Frame;
use orrery::render::plan::SamplingQuality;
use orrery::scene::request::{Position, Quality, ViewRequest};
use orrery::{FrameImages, Instant, NaifId};

fn image(frame: Frame) -> DisplayImage {
    DisplayImage { width: frame.width, height: frame.height, rgba: frame.display }
}

#[test]
fn both_renderers_interpolate_the_same_air() {
    let Some(gpu) = gpu() else { return };
    let session = &*SESSION;
    let views = [("2024-06-08T18:17:16Z", Quality::Draft), ("2024-04-08T18:17:16Z", Quality::Standard)];
    for (_, (time, quality)) in views.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 2)) {
        let request = ViewRequest {
            position: Position::AboveTarget { towards: None, distance_radii: Some(3.0) },
            quality,
            width: 200,
            height: 174,
            fov_deg: Some(45.0),
            ..ViewRequest::of(NaifId::EARTH, Instant::parse(time).expect("a time"))
        };
        let (_, plan) = session.plan(&request, SamplingQuality::of(quality)).expect("a plan");
        assert!(plan.passes.iter().any(|p| p.name == "coarse air"), "{time}: the plan must have a coarse image");
        let (on_gpu, _) = gpu.render(&plan, session.library(), FrameImages::Display).expect("drawn");
        let (soft, _) = session.renderer().render(&plan, session.library(), FrameImages::Display).expect("drawn");
        let difference = image(soft).difference(&image(on_gpu.clone())).expect("one size");
        println!("{time}: mean {:.4}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max);
        assert!(difference.mean < 0.3 && difference.p999 <= 3, "{time}: mean {:.3}, 99.9 % {}", difference.mean, difference.p999);
        // Against the air evaluated in each pixel on the GPU: only the interpolation differs.
        let request = ViewRequest { may_use_coarse_air: false, ..request };
        let (_, exact_plan) = session.plan(&request, SamplingQuality::of(quality)).expect("a plan");
        let (exact, _) = gpu.render(&exact_plan, session.library(), FrameImages::Display).expect("drawn");
        let difference = image(exact).difference(&image(on_gpu)).expect("one size");
        println!("{time}: against each pixel: mean {:.4}, greatest {}", difference.mean, difference.max);
        assert!(difference.max <= 2 && difference.p999 <= 1, "{time}: greatest {}, 99.9 % {}", difference.max, difference.p999);
    }
}

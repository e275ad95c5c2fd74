//! Questions that emitted modules answer: the lanes carry every digit, and a wrong question gets one line.

use orrery::probe::Prober;
use orrery::probe::lanes::Lanes;
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::session::{Session, Sources};
use orrery::shader::fragments::probe_samples;
use std::sync::LazyLock;

static SESSION: LazyLock<Session> = LazyLock::new(|| {
    let cache = std::env::temp_dir().join(format!("orrery-probe-{}", std::process::id()));
    Session::open(&Sources { cache: Some(cache), ..Sources::default() }, |_| {}).expect("opens")
});

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer")
}

#[test]
fn each_column_answers_its_own_question() {
    let module = probe_samples().into_iter().next().expect("a probe");
    let lanes = Lanes::plain(module, 1);
    // A ramp over the distance, so that a swapped or blended lane shows.
    let questions: Vec<_> = (0..1000)
        .map(|k| {
            let mut q = [0.0; 12];
            (q[0], q[1], q[2]) = (1.0, 1.0, 2.0 * f64::from(k) / 1000.0);
            q
        })
        .collect();
    for (precision, tolerance) in [(Precision::F32, 2e-7), (Precision::F64, 6e-8)] {
        let answers = lanes.answers(&renderer(precision), SESSION.library(), &questions).expect("answers");
        assert_eq!(answers.len(), questions.len());
        for (rows, q) in answers.iter().zip(&questions) {
            let expected = 1.0 - q[2] / 2.0;
            assert!((f64::from(rows[0][0]) - expected).abs() < tolerance, "{precision:?}: {} for {expected}", rows[0][0]);
        }
    }
}

#[test]
fn a_wrong_question_is_named_in_one_line() {
    let renderer = renderer(Precision::F32);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    for (question, about) in [
        ("", "JSON"),
        ("[]", "JSON object"),
        ("{}", "\"q\" is missing"),
        (r#"{"q":3}"#, "not a string"),
        (r#"{"q":"colour"}"#, "disc-overlap"),
        (r#"{"q":"disc-overlap","k":1,"model":"linear"}"#, "`d`"),
        (r#"{"q":"disc-overlap","k":1,"d":1,"model":"square"}"#, "square"),
        (r#"{"q":"disc-overlap","k":-1,"d":1,"model":"linear"}"#, "\"k\""),
        (r#"{"q":"disc-overlap","k":1,"d":1,"model":"linear","e":1}"#, "`e`"),
    ] {
        let error = prober.answer(question).expect_err(question);
        assert!(error.contains(about) && !error.contains('\n'), "{question}: {error}");
    }
}

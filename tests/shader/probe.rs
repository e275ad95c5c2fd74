//! Queries that emitted modules answer: each pixel answers its own query, answers agree with images and references, and an invalid query gets an error
//! of one line.

use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::{AerosolFunction, AerosolPhase};
use orrery::probe::batch::PreparedProbe;
use orrery::probe::{Prober, QUERIES, Requirement};
use orrery::render::software::{Options, Precision, SoftwareRenderer};
use orrery::shader::id::probe_samples;

fn renderer(precision: Precision) -> SoftwareRenderer {
    SoftwareRenderer::new(Options { precision, ..Options::default() }).expect("a renderer")
}

#[test]
fn each_query_gets_its_own_answer() {
    // probe_disc_overlap by the linear model: the semi-axes of an occluding disc and its distance from the Sun's centre, in solar radii.
    let module = probe_samples().into_iter().next().expect("a probe");
    let probe = PreparedProbe::without_bindings(module, 1);
    // The answer changes from query to query, so exchanged or blended answers are detected.
    let queries: Vec<_> = (0..1000)
        .map(|k| {
            let mut query = [0.0; 12];
            (query[0], query[1], query[2]) = (1.0, 1.0, 2.0 * f64::from(k) / 1000.0);
            query
        })
        .collect();
    for (precision, tolerance) in [(Precision::F32, 2e-7), (Precision::F64, 6e-8)] {
        let results = probe.results(&renderer(precision), SESSION.library(), &queries).expect("results");
        assert_eq!(results.len(), queries.len());
        for (rows, query) in results.iter().zip(&queries) {
            let expected = 1.0 - query[2] / 2.0;
            assert!((f64::from(rows[0][0]) - expected).abs() < tolerance, "{precision:?}: {} for {expected}", rows[0][0]);
        }
    }
}

#[test]
fn an_invalid_query_gets_an_error_of_one_line() {
    let renderer = renderer(Precision::F32);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    for (query, message_part) in [
        ("", "JSON"),
        ("[]", "JSON object"),
        ("{}", "\"q\" is missing"),
        (r#"{"q":3}"#, "not a string"),
        (r#"{"q":"colour"}"#, "disc-overlap"),
        (r#"{"q":"disc-overlap","k":1,"model":"linear"}"#, "`d`"),
        (r#"{"q":"pixel","view":{"position":{"body":"mars","radii":[3,0,0]},"look":{"at":"mars"}},"x":1024,"y":0}"#, "1024x1024"),
        (r#"{"q":"pixel","view":{"position":{"body":"pandora2","radii":[3,0,0]},"look":{"at":"mars"}},"x":1,"y":0}"#, "pandora2"),
        (r#"{"q":"disc-overlap","k":1,"d":1,"model":"square"}"#, "square"),
        (r#"{"q":"disc-overlap","k":-1,"d":1,"model":"linear"}"#, "\"k\""),
        (r#"{"q":"disc-overlap","k":1,"d":1,"model":"linear","e":1}"#, "`e`"),
        (r#"{"q":"disc-overlap","k":1,"d":1,"k":2}"#, "field `k` is given twice"),
        // In f32, the limb of such a disc would miss the Sun even where it crosses the Sun's centre.
        (r#"{"q":"disc-overlap","k":1e8,"d":1e8}"#, "at most 1e6 solar radii"),
        (r#"{"q":"disc-overlap","semi_major":1e8,"semi_minor":1,"centre_distance":0}"#, "\"semi_major\" is 1e8"),
        (r#"{"q":"ring-shadow","flattening":0.1,"point":[1e7,0,0],"sun":[1,0,0]}"#, "below 1e6 equatorial radii"),
        (r#"{"q":"ring-transmission","profile":[{"r_in":1,"r_out":2,"tau_normal":1e30}],"point":[1,0,1],"sun":[0,0,1]}"#, "from 0 to 1e4"),
    ] {
        let error = prober.answer(query).expect_err(query).to_string();
        assert!(error.contains(message_part) && !error.contains('\n'), "{query}: {error}");
    }
}

/// The atmosphere of the example of `scatter`, with `more` after its fields and `species` after those of its gas.
fn scatter_query(more: &str, species: &str, cam: [f64; 3], dir: [f64; 3]) -> String {
    let gas = r#""scattering_per_m":[5.8e-6,1.35e-5,3.31e-5],"extinction_per_m":[5.8e-6,1.35e-5,3.31e-5],"phase":"rayleigh""#;
    format!(
        r#"{{"q":"scatter","atmosphere":{{"planet_radius_km":6371,"top_km":60,"species":[{{"profile":"exponential","scale_height_km":8,{gas}{species}}}]{more}}},"cam":{cam:?},"dir":{dir:?},"sun":[0,1,0],"tier":"pixel-16"}}"#
    )
}

/// The answer about a ray does not depend on the camera's distance. The ray whose line passes the centre at 1.001 radii crosses only air; that at half a radius
/// hits the ground.
#[test]
fn a_distant_camera_sees_the_same_air() {
    let renderer = renderer(Precision::F64);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    for (offset, hits_ground) in [(1.001, false), (0.5, true)] {
        let answer = |distance: f64| prober.answer(&scatter_query("", "", [distance, offset, 0.0], [-1.0, 0.0, 0.0])).expect("an answer");
        let near = answer(2.0);
        assert_eq!(near["hits_ground"], hits_ground);
        assert!(near["transmittance"][2].as_f64().expect("a number") < 0.9, "the ray passes through air: {near}");
        for distance in [1e4, 1e6, 1e8] {
            let far = answer(distance);
            assert_eq!(far["hits_ground"], hits_ground, "{distance}");
            for (name, k) in ["transmittance", "radiance"].into_iter().flat_map(|name| (0..3_usize).map(move |k| (name, k))) {
                let [near, far] = [&near, &far].map(|answer| answer[name][k].as_f64().expect("a number"));
                assert!((far - near).abs() < 1e-5, "{distance}: {name} {far}, from 2 radii {near}");
            }
        }
    }
}

#[test]
fn an_atmosphere_that_would_be_misread_is_refused() {
    let renderer = renderer(Precision::F32);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let (cam, dir) = ([0.0, 0.0, 1.0001], [1.0, 0.0, 0.2]);
    let tent = r#"},{"profile":"tent","centre_km":25,"half_width_km":15,"extinction_per_m":[1e-6,1e-6,1e-6]"#;
    for (query, message_part) in [
        (scatter_query("", r#","G":0.8"#, cam, dir), "`G`"),
        (scatter_query("", "", cam, dir).replace("rayleigh", "mie"), "`mie` is not a phase function"),
        (scatter_query("", r#","g":"0.5""#, cam, dir), "g must be a number between -1 and 1, or three (red, green, blue)"),
        (scatter_query("", r#","g":[0.5,0.6]"#, cam, dir), "g must be a number between -1 and 1, or three (red, green, blue)"),
        (scatter_query(r#","topp_km":60"#, "", cam, dir), "`topp_km`"),
        (scatter_query("", &format!(r#"{tent},"scattering_per_m":[1e-6,0,0]"#), cam, dir), "scattering_per_m must be 0"),
        (
            scatter_query("", "", cam, dir).replace(r#"extinction_per_m":[5.8e-6"#, r#"extinction_per_m":[5.7e-6"#),
            "at least scattering_per_m",
        ),
        (scatter_query("", "", [0.9, 0.0, 0.0], dir), "inside the planet"),
        (scatter_query("", "", [1e200, 0.0, 0.0], dir), "more than 1e9 planet radii away"),
    ] {
        let error = prober.answer(&query).expect_err(&query).to_string();
        assert!(error.contains(message_part) && !error.contains('\n'), "{query}: {error}");
    }
    for field in AerosolPhase::FIELDS {
        let [least, greatest] = field.limits;
        for value in [least - 0.1, greatest + 0.1] {
            let query = scatter_query("", &format!(r#","{}":{value}"#, field.query_key), cam, dir);
            let error = prober.answer(&query).expect_err(&query).to_string();
            assert_eq!(error, format!("field \"atmosphere\": {} must be {}", field.query_key, field.allowed()));
        }
        for other in AerosolFunction::ALL.into_iter().filter(|function| !field.functions.contains(function)) {
            let query = scatter_query("", &format!(r#","{}":{least}"#, field.query_key), cam, dir).replace("rayleigh", other.query_word());
            let error = prober.answer(&query).expect_err(&query).to_string();
            assert!(error.contains("beside a phase that has it"), "{query}: {error}");
        }
    }
    // The reference files have further fields, which say the same in other units.
    let more = r#","note":"air","r_top":1.0094"#;
    let species = format!(
        r#","scattering_per_planet_radius":[36.9,86.2,210.5],"extinction_per_planet_radius":[36.9,86.2,210.5]{tent},"scattering_per_m":[0.0,0.0,0.0],"phase":"none","scattering_per_planet_radius":[0,0,0],"extinction_per_planet_radius":[4.1,12.0,0.5]"#
    );
    let with_more = scatter_query(more, &species, cam, dir);
    assert_eq!(
        prober.answer(&with_more).unwrap_or_else(|e| panic!("{with_more}: {e}")),
        prober.answer(&scatter_query("", tent, cam, dir)).expect("an answer")
    );
}

/// The list that `probe --questions` prints agrees with the parser on the fields of each query, and on which of them are optional.
#[test]
fn the_list_of_queries_matches_their_fields() {
    let renderer = renderer(Precision::F32);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    for kind in QUERIES {
        let example: serde_json::Map<String, serde_json::Value> = serde_json::from_str(kind.example).expect("an object");
        let answer = |fields: &serde_json::Map<String, serde_json::Value>| prober.answer(&serde_json::json!(fields).to_string());
        assert_eq!(example["q"], kind.name);
        answer(&example).unwrap_or_else(|e| panic!("{}: {e}", kind.example));
        // The parser names its own fields in the error about an unknown one.
        let mut with_unknown_field = example.clone();
        with_unknown_field.remove("q");
        with_unknown_field.insert("zzz".into(), 1.into());
        let error = (kind.answer)(&prober, with_unknown_field.into()).expect_err(kind.name).to_string();
        let mut accepted: Vec<&str> = error.split('`').skip(3).step_by(2).collect();
        let mut listed: Vec<&str> = kind.fields.iter().map(|f| f.name).collect();
        accepted.sort_unstable();
        listed.sort_unstable();
        assert_eq!(accepted, listed, "{}: {error}", kind.name);
        for field in kind.fields {
            assert!(!field.description.is_empty());
            let mut without = example.clone();
            without.remove(field.name);
            match field.requirement {
                Requirement::Required => {
                    let error = answer(&without).expect_err(field.name).to_string();
                    assert!(error.contains(&format!("`{}` is missing", field.name)), "{error}");
                }
                Requirement::Optional(_) => drop(answer(&without).unwrap_or_else(|e| panic!("{} without {}: {e}", kind.name, field.name))),
                Requirement::Alternative => {}
            }
        }
    }
}

/// The help text of `scatter` names each function and each field of an aerosol.
#[test]
fn the_help_of_scatter_explains_each_field_of_an_aerosol() {
    let scatter = QUERIES.iter().find(|kind| kind.name == "scatter").expect("listed");
    let help = scatter.fields.iter().find(|field| field.name == "atmosphere").expect("listed").description;
    let words: Vec<&str> = help.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    for field in AerosolPhase::FIELDS {
        assert!(words.contains(&field.query_key), "{}: {help}", field.query_key);
    }
    for function in AerosolFunction::ALL {
        assert!(help.contains(function.query_word()), "{function:?}: {help}");
    }
}

/// A query without a model uses the limb-darkened disc; without coefficients it uses those of the Sun.
#[test]
fn the_default_model_is_limb_darkened() {
    let renderer = renderer(Precision::F64);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let blocked =
        |more: &str| prober.answer(&format!(r#"{{"q":"disc-overlap","k":0.5,"d":0.1{more}}}"#)).expect("answers")["blocked"].clone();
    let by_default = blocked("");
    assert_eq!(by_default, blocked(r#","model":"limb-darkened","u1":0.40,"u2":0.26"#));
    assert!(by_default.as_f64() > blocked(r#","model":"uniform-disc""#).as_f64(), "the middle of the disc is brighter than its mean");
    assert_eq!(blocked(r#","u1":0.6"#), blocked(r#","u1":0.6,"u2":0"#), "u2 is 0 if only u1 is given");
    let sunlight = |more: &str| {
        let query = format!(r#"{{"q":"sunlight","body":"earth","time":"2024-04-08T18:17:16Z","lat":30,"lon":-100{more}}}"#);
        prober.answer(&query).expect("answers")
    };
    assert_eq!(sunlight(""), sunlight(r#","model":"limb-darkened""#));
}

const CAMERA: &str = r#"{"position":{"body":"mars","radii":[0.6,-2.9,1.1]},"look":{"at":"mars"},"fov_deg":40}"#;
const SIDE: u32 = 65;

fn pixel(precision: Precision, x: u32, y: u32) -> serde_json::Value {
    let renderer = renderer(precision);
    let prober = Prober { session: &SESSION, renderer: &renderer };
    let time = "2024-04-08T18:17:16Z";
    let query = format!(r#"{{"q":"pixel","view":{CAMERA},"time":"{time}","size":[{SIDE},{SIDE}],"x":{x},"y":{y}}}"#);
    prober.answer(&query).expect("answers")
}

#[test]
fn a_pixel_reports_the_values_of_its_draws() {
    use orrery::render::plan::SamplingQuality;
    use orrery::scene::request::{CameraFile, Purpose, ViewRequest};
    use orrery::time::Instant;
    let mut request = ViewRequest::of(orrery::catalog::NaifId::EARTH, Instant::parse("2024-04-08T18:17:16Z").expect("a time"));
    (request.target, request.purpose) = (None, Purpose::LINEAR);
    CameraFile::parse("camera", CAMERA).expect("reads").resolve(SESSION.catalog(), &mut request).expect("resolves");
    (request.width, request.height) = (SIDE, SIDE);
    let drawn = SESSION.draw(&request, SamplingQuality { samples: 4, anisotropy: 8 }, FrameImages::DisplayAndHdr).expect("drawn");
    let mars = drawn.scene.bodies.iter().find(|b| b.name == "Mars").expect("Mars");
    for (x, y) in [(32, 32), (25, 40), (40, 22)] {
        let (single, double) = (pixel(Precision::F32, x, y), pixel(Precision::F64, x, y));
        let in_image = drawn.frame.hdr[(y * SIDE + x) as usize];
        for (k, expected) in in_image[..3].iter().enumerate() {
            // The same to rounding: the values are read out between the operations that the image's kernels fuse.
            let in_f32 = single["radiance"][k].as_f64().expect("a number");
            assert!((in_f32 / f64::from(*expected) - 1.0).abs() < 5e-7, "channel {k} of {x},{y}: {in_f32} {expected}");
            let in_f64 = double["radiance"][k].as_f64().expect("a number");
            assert!((in_f64 - f64::from(*expected)).abs() < 1e-4, "{in_f64} {expected}");
        }
        assert_eq!((single["body"].as_str(), single["part"].as_str()), (Some("Mars"), Some("globe")));
        let globe = single["draws"].as_array().expect("draws").iter().find(|d| d["part"] == "globe").expect("the globe");
        let values = globe["values"].as_object().expect("values");
        // The colour that the globe's draw writes is its radiance times its coverage.
        for k in 0..3 {
            let number = |v: &serde_json::Value| v.as_f64().expect("a number");
            let (radiance, coverage) = (number(&values["radiance"][k]), number(&values["coverage"]));
            assert!((number(&globe["colour"][k]) - radiance * coverage).abs() < 1e-6, "{globe}");
        }
        for name in ["albedo", "normal", "sunlight", "hit.position", "hit.cos_emission", "coordinates.uv", "albedo_texel"] {
            assert!(values.get(name).is_some_and(|v| !v.is_null()), "{name} is not among {:?}", values.keys().collect::<Vec<_>>());
        }
    }
    // The centre is the sub-observer point, whose latitude the scene gives as planetocentric and the pixel as planetographic: Mars' axes
    // are 3396.19 and 3376.20 km.
    let middle = pixel(Precision::F64, 32, 32);
    let planetographic_deg = (mars.sub_observer.lat_centric_deg.to_radians().tan() * (3396.19f64 / 3376.20).powi(2)).atan().to_degrees();
    assert!((middle["lat"].as_f64().expect("lat") - planetographic_deg).abs() < 1e-4, "{} {planetographic_deg}", middle["lat"]);
    assert!((middle["lon"].as_f64().expect("lon") - mars.sub_observer.lon_east_deg).abs() < 1e-4, "{}", middle["lon"]);
    // Outside the disc only stars are drawn.
    let beside = pixel(Precision::F32, 0, 0);
    let light = beside["radiance"][0].as_f64().expect("a number");
    assert!(beside["body"].is_null() && beside["lat"].is_null() && light < 1e-6, "{beside}");
}

/// The pixel below a place has the place's latitude and longitude, also on bodies with three different axes: where Amalthea's normal has the longitude 45
/// degrees, the place has 19.
#[test]
fn the_pixel_below_a_place_has_its_latitude_and_longitude() {
    let prober = Prober { session: &SESSION, renderer: SESSION.renderer() };
    for (body, lat, lon) in [("amalthea", 0.0, 45.0), ("phobos", 30.0, -60.0), ("vesta", -20.0, 130.0), ("moon", 50.0, 10.0)] {
        let position = format!(r#"{{"body":"{body}","latitude_deg":{lat},"longitude_deg":{lon},"height_km":0.001}}"#);
        let view = format!(r#"{{"position":{position},"look":{{"at":"{body}"}},"fov_deg":5}}"#);
        let question = format!(r#"{{"q":"pixel","view":{view},"time":"2024-06-01T00:00:00Z","size":[65,65],"x":32,"y":32}}"#);
        let below = prober.answer(&question).unwrap_or_else(|e| panic!("{question}: {e}"));
        // The view is towards the centre: it meets the ground less than half a metre from the place, 0.004 degrees on Phobos.
        for (field, expected) in [("lat", lat), ("lon", lon)] {
            let found = below[field].as_f64().unwrap_or_else(|| panic!("{field} in {below}"));
            assert!((found - expected).abs() < 0.01, "{body}: {field} {found}, not {expected}");
        }
    }
}

/// A star exactly behind Jupiter's centre. Seen from the ground it is drawn there: both have the aberration of the Earth's motion. From beside the Earth only
/// the star has it, as docs/accuracy.md says: they are apart by the speed of the Earth, 30.2 km/s, over that of light, for a direction abeam.
#[test]
fn stars_are_displaced_against_bodies_in_views_from_beside_a_body() {
    use orrery::catalog::NaifId;
    use orrery::ephemeris::apparent::RaDec;
    use orrery::ephemeris::topocentric::ground_point_km;
    let prober = Prober { session: &SESSION, renderer: SESSION.renderer() };
    let ephemeris = SESSION.ephemeris();
    let time = orrery::time::Instant::from_jd_tdb(2_460_652.5);
    let earth_km = ephemeris.state(NaifId::EARTH, NaifId::SOLAR_SYSTEM_BARYCENTER, time, None).expect("the Earth").state.pos_km;
    let body_from_icrf = ephemeris.body_from_icrf(NaifId::EARTH, time).expect("an orientation");
    let radii_km = SESSION.catalog().body(NaifId::EARTH).expect("the Earth").radii_km;
    let ground_km = body_from_icrf.transpose() * ground_point_km(radii_km, 50.0, 10.0, 1.0).0;
    let beside_km = glam::DVec3::new(0.0, 0.0, 3.0 * radii_km.x);
    for (position, offset_km, expected_arcsec) in [
        (r#"{"body":"earth","latitude_deg":50,"longitude_deg":10,"height_km":1}"#, ground_km, 0.0),
        (r#"{"body":"earth","radii":[0,0,3]}"#, beside_km, 20.8),
    ] {
        let viewer_km = earth_km + offset_km;
        let jupiter_km = ephemeris.light_time_position(NaifId(599), viewer_km, time).expect("Jupiter").0;
        let RaDec { ra_deg, dec_deg } = RaDec::of(jupiter_km - viewer_km);
        let pixel_of = |what: String| {
            let view = format!(r#"{{"position":{position},"look":{{"at":"jupiter"}},"fov_deg":0.05}}"#);
            let question = format!(r#"{{"q":"project","view":{view},"time":"jd_tdb:2460652.5","size":[512,512],{what}}}"#);
            let answer = prober.answer(&question).unwrap_or_else(|e| panic!("{question}: {e}"));
            ["x", "y"].map(|field| answer[field].as_f64().unwrap_or_else(|| panic!("{field} in {answer}")))
        };
        let [x, y] = pixel_of(r#""body":"jupiter""#.to_owned());
        let [star_x, star_y] = pixel_of(format!(r#""ra_deg":{ra_deg},"dec_deg":{dec_deg}"#));
        let apart_arcsec = (star_x - x).hypot(star_y - y) * 0.05 * 3600.0 / 512.0;
        assert!((apart_arcsec - expected_arcsec).abs() < 0.02 + 0.02 * expected_arcsec, "{position}: {apart_arcsec} arcsec");
    }
}

/// The pixels of stars and of a direction equal those of the reference (tests/data/stars_public.json), in the frame or behind the camera; what the Earth
/// covers is reported as hidden.
#[test]
fn stars_and_directions_are_projected_to_the_reference_pixels() {
    let prober = Prober { session: &SESSION, renderer: SESSION.renderer() };
    let answer = |more: &str| {
        // The view `bull` of the reference.
        let look = "[0.40193385173382296,0.8619499266302462,0.3090169943749474]";
        let view =
            format!(r#"{{"position":{{"body":"earth","km":[20000,0,0]}},"look":{{"direction":{look}}},"up":"celestial","fov_deg":35}}"#);
        prober.answer(&format!(r#"{{"q":"project","view":{view},"time":"2000-01-01T00:00:00Z","size":[900,900],{more}}}"#))
    };
    // The numbers below are rounded to a thousandth of a pixel; aberration displaces a star by up to 0.15 pixels.
    let is_near = |v: &serde_json::Value, x: f64, y: f64| (v["x"].as_f64().expect("x") - x).hypot(v["y"].as_f64().expect("y") - y) < 0.002;
    let aldebaran = answer(r#""star":"HIP 21421""#).expect("a star");
    assert!(is_near(&aldebaran, 354.653, 486.187) && aldebaran["in_frame"] == true && aldebaran["hidden"] == false, "{aldebaran}");
    // Antares is behind the camera.
    let antares = answer(r#""star":"80763""#).expect("a star");
    assert!(is_near(&antares, 397.066, 237.970) && antares["in_frame"] == false, "{antares}");
    // The position of Aldebaran by right ascension and declination, J2000, without proper motion.
    let by_coordinates = answer(r#""ra_deg":68.98016,"dec_deg":16.50930"#).expect("a direction");
    assert!(is_near(&by_coordinates, 354.653, 486.187), "{by_coordinates}");
    // The Earth hides objects behind it, towards -x, but not itself.
    let behind = answer(r#""ra_deg":180.0,"dec_deg":0.0"#).expect("a direction");
    assert!(behind["hidden"] == true && behind["in_frame"] == false, "{behind}");
    assert_eq!(answer(r#""body":"earth""#).expect("a body")["hidden"], false);
    for (more, message_part) in [
        (r#""star":"Nemesis""#, "no star `Nemesis`"),
        (r#""body":"vulcan""#, "field `body`"),
        (r#""ra_deg":1.0"#, "give one of"),
        (r#""ra_deg":1.0,"dec_deg":91.0"#, "-90 to 90"),
        (r#""star":"HIP 1","body":"mars""#, "give one of"),
    ] {
        let error = answer(more).expect_err("refused");
        assert!(error.to_string().contains(message_part), "{error}");
    }
}

//! The options that describe a view, shared by the commands that render or explain a view.
//!
//! In: arguments. Out: a [`ViewRequest`]. The clock is read here to resolve `now`: the modules below the command line take instants and read no clock.

use super::CliError;
use crate::catalog::{Catalog, NaifId};
use crate::ephemeris::topocentric::ground_point_km;
use crate::files::read_text;
use crate::scene::draw::PixelView;
use crate::scene::effects::{Effect, EffectOverrides};
use crate::scene::request::view_request::MAX_IMAGE_PX;
use crate::scene::request::{
    CameraFile, Composition, EYE_HEIGHT_KM, ExposureRequest, Layers, Look, Position, Telescope, ToneMap, ViewRequest, up_by_name,
};
use crate::scene::{RequestValue, Scene, SceneError};
use crate::time::{Instant, TimeError};
use crate::wording::{echo, suggestion_or_list};
use std::path::PathBuf;

/// Largest camera file, bytes; real ones have about a dozen fields.
const MAX_CAMERA_FILE_BYTES: u64 = 1 << 20;

/// The help of `--effects`, which names every effect.
fn effects_help() -> String {
    let names = Effect::ALL.map(Effect::name).join(", ");
    format!("Set effects on (+) or off (-): {names}; for one body only: moon:-eclipse")
}

/// Target, camera, time and image options.
#[derive(clap::Args, Clone, Debug, Default)]
#[command(next_help_heading = "View")]
pub(crate) struct ViewArgs {
    /// Body to look at: a name, or a NAIF code such as 599
    #[arg(long, value_name = "BODY", value_hint = clap::ValueHint::Other)]
    pub target: Option<String>,
    /// Look from this body's centre (with --distance-radii: from that distance from the target, on the side of this body; with --at: from this body's surface)
    /// [default: the direction of the Earth, or of the Sun for the Earth]
    #[arg(long, value_name = "BODY", value_hint = clap::ValueHint::Other)]
    pub from: Option<String>,
    /// Distance from the target's centre in its equatorial radii [default: the disc fills 3/4 of the image height]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub distance_radii: Option<f64>,
    /// Planetographic latitude and planetocentric east longitude: with --from a place to stand on, otherwise the place of the target that the camera is above
    #[arg(long, value_name = "LAT,LON", allow_hyphen_values = true)]
    pub at: Option<String>,
    /// Height above the surface at --at in km [default: 0.0017, eye level; above the target: from --distance-radii]
    #[arg(long, value_name = "KM", allow_negative_numbers = true, requires = "at")]
    pub height_km: Option<f64>,
    /// Camera file (JSON); its fields are described below
    #[arg(long, value_name = "FILE", conflicts_with_all = ["from", "distance_radii", "at", "height_km"])]
    pub camera_json: Option<PathBuf>,
    /// Time: ISO 8601 UTC, jd_tdb:DAY, or now
    #[arg(long, value_name = "T", default_value = "now", allow_hyphen_values = true)]
    pub time: String,
    /// Vertical field of view in degrees [default: 20; 45 with --distance-radii or --at; with --from, whatever fits the target]
    #[arg(long, value_name = "D", allow_negative_numbers = true, help_heading = "Image")]
    pub fov: Option<f64>,
    /// Up direction: north (of the target), zenith, celestial or ecliptic [default: north; on a surface the zenith]
    #[arg(long, value_name = "WHAT", help_heading = "Image")]
    pub up: Option<String>,
    /// Mirror the image left to right, as a star diagonal does; texts stay readable
    #[arg(long, help_heading = "Image")]
    pub mirror: bool,
    /// Image size in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", help_heading = "Image")]
    pub size: String,
    /// Exposure in stops (at 0 a white surface facing the Sun at 1 au is white), or auto
    #[arg(long, value_name = "STOPS", default_value = "auto", allow_hyphen_values = true, help_heading = "Image")]
    pub exposure: String,
    /// Tone mapping of highlights: filmic (linear to 0.8, then a shoulder) or clipped (linear to white)
    #[arg(long, value_name = "HOW", default_value = "filmic", help_heading = "Image")]
    pub tone_map: String,
    #[arg(long, value_name = "+A,-B", allow_hyphen_values = true, help_heading = "Image", help = effects_help())]
    pub effects: Option<String>,
    /// Layers: +orbits, +traces (where bodies have been, as seen from the target), +labels (names and markers), +features (names of craters and landing
    /// sites), +caption, +scale-bar, +compass, +outline (of the selected body, else of the target), +bloom; +minor-planets, +comets (with a marker on each
    /// body too faint to be seen); +bright-stars (bright enough to be seen, whatever the exposure); +star-names, +constellations, +boundaries,
    /// +grid-equatorial, +grid-equatorial-date (of the true equator of date), +grid-ecliptic, +grid-galactic, +grid-horizon (from a surface), +grid-body
    /// and +terminator (of each body), +eclipse-path (umbra and penumbra on each body, and where the shadow goes), +eclipse-cones (shadows in space: those
    /// that reach the target, and the target's own);
    /// +instruments (fields of view around the target); -data (the default is on if a catalog file has a table [[layer]]); -stars, -milky-way,
    /// -zodiacal-light (the default is on if the exposure shows them)
    #[arg(long, value_name = "+A,-B", allow_hyphen_values = true, help_heading = "Image")]
    pub layers: Option<String>,
    /// Outline the field of view of a telescope in the middle of a perspective image: focal length, eyepiece and its apparent field (1000/25/52), or focal
    /// length and sensor (1000/22.3x14.9), in mm and degrees
    #[arg(long, value_name = "F/E/A", help_heading = "Image")]
    pub telescope: Option<String>,
    /// Brighten stars, Milky Way and zodiacal light by this many stops, to show them next to a lit planet
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, help_heading = "Image")]
    pub stars_boost: f64,
    /// What the pixels show: final, depth, normal, albedo, uv, sunlight, eclipse, ring, optical-depth or cost; the
    /// file's metadata explain the colours
    #[arg(long, value_name = "WHAT", default_value = "final", help_heading = "Image")]
    pub pixels: String,
}

/// Whether a text is the word for the current time. Spaces around it are ignored, as they are around a date.
pub(super) fn is_now(text: &str) -> bool {
    text.trim().eq_ignore_ascii_case("now")
}

/// Parses the value of `--time`: `now`, to the second, or any text that [`Instant::parse`] accepts. An error names the option.
pub(crate) fn parse_time_option(text: &str) -> Result<Instant, CliError> {
    let utc_now = || chrono::Utc::now().format("%Y-%m-%dT%H:%M:%SZ").to_string();
    let text = if is_now(text) { utc_now() } else { text.to_owned() };
    Instant::parse(&text).map_err(|e| CliError::Usage(format!("--time: {e}")))
}

/// Parses a time that may come from another option or from standard input: as [`parse_time_option`], but the error does not name `--time`, and `now` is to the
/// millisecond.
pub(super) fn parse_time_or_now(text: &str) -> Result<Instant, TimeError> {
    if is_now(text) {
        return Instant::parse(&chrono::Utc::now().format("%Y-%m-%dT%H:%M:%S%.3fZ").to_string());
    }
    Instant::parse(text)
}

fn invalid_option(option: &str, value: &str, allowed: &str) -> CliError {
    CliError::Usage(format!("{option} {}: {allowed}", echo(value)))
}

/// Width and height, in pixels, from a text such as `1024x768`. The range is checked here, because the views of a tour clamp the size silently.
pub(crate) fn parse_size(text: &str) -> Result<(u32, u32), CliError> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    let (width, height): (u32, u32) = sides.ok_or_else(|| invalid_option("--size", text, "write width x height in pixels, as 1024x768"))?;
    if [width, height].iter().any(|side| !(1..=MAX_IMAGE_PX).contains(side)) {
        return Err(invalid_option("--size", text, &format!("each side must be 1 to {MAX_IMAGE_PX} pixels")));
    }
    Ok((width, height))
}

/// Latitude and east longitude, in degrees, from a text such as `48.86,2.35`.
fn parse_place_on_ground(text: &str) -> Result<(f64, f64), CliError> {
    let numbers = text.split_once(',').and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    let (latitude, longitude): (f64, f64) =
        numbers.ok_or_else(|| invalid_option("--at", text, "write latitude,longitude in degrees, as 48.86,2.35"))?;
    if !(-90.0..=90.0).contains(&latitude) {
        return Err(invalid_option("--at", text, "a latitude is -90 to 90 degrees"));
    }
    if !(-360.0..=360.0).contains(&longitude) {
        return Err(invalid_option("--at", text, "a longitude is -360 to 360 degrees, east"));
    }
    Ok((latitude, longitude))
}

fn parse_pixel_view(text: &str) -> Result<PixelView, CliError> {
    PixelView::by_name(text)
        .ok_or_else(|| invalid_option("--pixels", text, &suggestion_or_list(text, &PixelView::ALL.map(PixelView::name))))
}

impl ViewArgs {
    /// The request that these options describe.
    pub(crate) fn request(&self, catalog: &Catalog) -> Result<ViewRequest, CliError> {
        self.request_with(catalog, Composition::default())
    }

    /// As [`Self::request`], for an image with this composition.
    pub(crate) fn request_with(&self, catalog: &Catalog, composition: Composition) -> Result<ViewRequest, CliError> {
        let body_of_option =
            |option: &str, name: &String| catalog.body_or_barycenter(name).map_err(|e| CliError::Usage(format!("{option}: {e}")));
        let time = parse_time_option(&self.time)?;
        let target = self.target.as_ref().map(|name| body_of_option("--target", name)).transpose()?;
        let mut request = ViewRequest::of(target.unwrap_or(NaifId::EARTH), time);
        request.target = target;
        request.composition = composition;
        // The camera file and its name in messages.
        let mut camera_file = None;
        if let Some(file) = &self.camera_json {
            if file.as_os_str() == "-" {
                return Err(invalid_option("--camera-json", "-", "standard input is not read; name a file"));
            }
            let file_name = echo(&file.display().to_string());
            let text = read_text(file, MAX_CAMERA_FILE_BYTES).map_err(|e| CliError::Failed(format!("{file_name}: {e}")))?;
            let camera = CameraFile::parse(&file_name, &text).map_err(|e| CliError::Failed(e.to_string()))?;
            camera.resolve(catalog, &mut request).map_err(|e| match e {
                SceneError::CameraField { field, why } => CliError::Failed(format!("{file_name}: {field}: {why}")),
                other => CliError::Failed(format!("{file_name}: {other}")),
            })?;
            camera_file = Some((file_name, camera));
        } else {
            let target = target.ok_or_else(|| CliError::Usage("no target: give --target BODY or --camera-json FILE".into()))?;
            if catalog.body(target).is_none() {
                let name = self.target.as_deref().unwrap_or("");
                return Err(invalid_option("--target", name, "a barycentre cannot be drawn: name a body"));
            }
            let from = self.from.as_ref().map(|name| body_of_option("--from", name)).transpose()?;
            request.position = self.position(catalog, target, from)?;
            request.up = request.position.default_up();
        }
        if self.fov.is_some() {
            request.fov_deg = self.fov;
        }
        if let Some(up) = &self.up {
            request.up = up_by_name(up).map_err(|e| CliError::Usage(format!("--up: {e}")))?;
        }
        request.is_mirrored |= self.mirror;
        (request.width, request.height) = parse_size(&self.size)?;
        if !self.exposure.eq_ignore_ascii_case("auto") {
            let stops = self.exposure.parse().map_err(|_| invalid_option("--exposure", &self.exposure, "a number of stops, or auto"))?;
            request.exposure = ExposureRequest::Stops(stops);
        }
        if let Some(effects) = &self.effects {
            request.effects = EffectOverrides::parse(effects).map_err(|e| CliError::Usage(format!("--effects: {e}")))?;
        }
        if let Some(layers) = &self.layers {
            request.layers = Layers::parse(layers).map_err(|e| CliError::Usage(format!("--layers: {e}")))?;
        }
        if let Some(telescope) = &self.telescope {
            request.telescope = Some(Telescope::parse(telescope).map_err(|e| CliError::Usage(format!("--telescope: {e}")))?);
        }
        request.stars_boost_stops = self.stars_boost;
        let unknown_tone_map =
            || invalid_option("--tone-map", &self.tone_map, &suggestion_or_list(&self.tone_map, &ToneMap::ALL.map(ToneMap::name)));
        request.tone_map = ToneMap::by_name(&self.tone_map).ok_or_else(unknown_tone_map)?;
        request.pixel_view = parse_pixel_view(&self.pixels)?;
        request.check().and_then(|()| request.check_bodies(catalog)).map_err(|e| self.request_error(&e, camera_file.as_ref()))?;
        Ok(request)
    }

    /// The option that gives this value of a request; `None` if none does.
    fn option_of(&self, value: RequestValue) -> Option<&'static str> {
        let (distance, height) = (self.distance_radii.map(|_| "--distance-radii"), self.height_km.map(|_| "--height-km"));
        match value {
            RequestValue::Size => Some("--size"),
            RequestValue::FieldOfView => self.fov.map(|_| "--fov"),
            RequestValue::Distance => distance,
            RequestValue::Latitude | RequestValue::Longitude => self.at.as_ref().map(|_| "--at"),
            RequestValue::Height => height,
            // Above a place of the target.
            RequestValue::CameraOffset => distance.or(height),
            RequestValue::Exposure => Some("--exposure"),
            RequestValue::StarsBoost => Some("--stars-boost"),
            RequestValue::DomeTilt => Some("--dome-tilt"),
            RequestValue::EyeSeparation => Some("--eye-separation-km"),
            RequestValue::TelescopeLength | RequestValue::ApparentField => Some("--telescope"),
            RequestValue::Time => Some("--time"),
        }
    }

    /// The error of an invalid request. For a value outside its range it begins with the option, or with the file and the field.
    fn request_error(&self, error: &SceneError, camera_file: Option<&(String, CameraFile)>) -> CliError {
        if let SceneError::EffectBody(e) = error {
            return CliError::Usage(format!("--effects: {e}"));
        }
        let value = if let SceneError::OutOfRange(e) = error { Some(e.what) } else { None };
        if let Some(option) = value.and_then(|value| self.option_of(value)) {
            return CliError::Usage(format!("{option}: {error}"));
        }
        match camera_file {
            Some((name, file)) => CliError::Failed(match value.and_then(|value| file.field_of(value)) {
                Some(field) => format!("{name}: {field}: {error}"),
                None => format!("{name}: {error}"),
            }),
            None => CliError::Usage(error.to_string()),
        }
    }

    /// The camera's position, from `--at`, `--height-km` and `--distance-radii`. `from`: the body of `--from`.
    fn position(&self, catalog: &Catalog, target: NaifId, from: Option<NaifId>) -> Result<Position, CliError> {
        let ground = self.at.as_deref().map(parse_place_on_ground).transpose()?;
        if let Some(height_km) = self.height_km.filter(|height_km| !height_km.is_finite()) {
            return Err(CliError::Usage(format!("--height-km {height_km:?}: must be a number")));
        }
        if ground.is_some() && self.distance_radii.is_some() {
            if from.is_some() {
                let why = "--distance-radii: with --from and --at, the camera stands on that body; give --height-km instead, or neither";
                return Err(CliError::Usage(why.into()));
            }
            if self.height_km.is_some() {
                return Err(CliError::Usage("--distance-radii and --height-km both say how high the camera is: give one of them".into()));
            }
        }
        Ok(match (ground, from) {
            (Some((latitude_deg, longitude_deg)), Some(body)) => {
                Position::Ground { body, latitude_deg, longitude_deg, height_km: self.height_km.unwrap_or(EYE_HEIGHT_KM) }
            }
            (Some((latitude_deg, longitude_deg)), None) => {
                // The caller has checked that the catalog has the target, so the defaults are not reached.
                let radii_km = catalog.body(target).map_or(glam::DVec3::ONE, |b| b.radii_km);
                let (ground_km, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, GROUND_HEIGHT_KM);
                let radius_km = radii_km.max_element();
                let name = catalog.body(target).map_or("the target", |b| b.name.as_str());
                let height_km = match (self.height_km, self.distance_radii) {
                    (Some(height_km), _) => height_km,
                    (None, distance_radii) => {
                        let distance_radii = distance_radii.unwrap_or(DEFAULT_DISTANCE_ABOVE_PLACE_RADII);
                        let distance_km = distance_radii * radius_km;
                        if distance_km <= ground_km.length() {
                            return Err(CliError::Usage(format!(
                                "--distance-radii {distance_radii:?}: the camera is inside {name}, whose ground there is {:.4} radii from its centre",
                                ground_km.length() / radius_km
                            )));
                        }
                        height_at_distance_km(ground_km, normal, distance_km)
                    }
                };
                if height_km <= 0.0 {
                    return Err(CliError::Usage(format!(
                        "--height-km: a camera {height_km:?} km above the surface is inside {name}: give a greater height"
                    )));
                }
                let offset_km = ground_km + normal * height_km;
                Position::Offset { body: target, offset_km, axes: crate::scene::request::Axes::BodyFixed }
            }
            (None, Some(from)) if self.distance_radii.is_none() => Position::Centre(from),
            (None, towards) => Position::AboveTarget { towards, distance_radii: self.distance_radii },
        })
    }
}

/// The message for an image in which the ground below the camera hides the entire target; `None` if the target is above the horizon or the camera not on the
/// ground.
pub(super) fn below_horizon_message(request: &ViewRequest, scene: &Scene) -> Option<String> {
    let Position::Ground { body: ground, .. } = request.position else { return None };
    let target = request.target.filter(|_| request.look == Look::Target)?;
    let below_deg = scene.degrees_below_ground(target, ground)?;
    let name = |id: NaifId| scene.body(id).map_or("the target", |body| body.name.as_str());
    Some(format!(
        "{}: {below_deg:.1} degrees below the horizon, hidden by the ground of {}; choose another --time or --at",
        name(target),
        name(ground)
    ))
}

/// The height at which a point above a place on the ground is `distance_km` from the body's centre. `ground_km`: the place relative to that centre, body axes.
/// `normal`: the direction of the place's vertical, a unit vector, body axes.
fn height_at_distance_km(ground_km: glam::DVec3, normal: glam::DVec3, distance_km: f64) -> f64 {
    // The vertical of an oblate or triaxial body does not pass through the centre. The point of the vertical that is closest to the centre is `depth_km` below
    // the ground and `closest_km` from the centre.
    let depth_km = ground_km.dot(normal);
    let closest_km = (ground_km - normal * depth_km).length();
    // Pythagoras, as a product of two roots because the square of a huge distance would overflow.
    (distance_km - closest_km).sqrt() * (distance_km + closest_km).sqrt() - depth_km
}

/// Height of the ground itself above the ellipsoid.
const GROUND_HEIGHT_KM: f64 = 0.0;

/// Default distance from the target's centre, in equatorial radii, of a camera above a place of the target.
const DEFAULT_DISTANCE_ABOVE_PLACE_RADII: f64 = 3.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// The right axis of a camera on the ground is horizontal, and its up axis is less than 90 degrees from the zenith: at many latitudes of three bodies, for
    /// targets high and low in the sky and below the horizon. Negative control: with the target's north up, more than 40 of the 108 images (six pairs of
    /// bodies, nine places, two times) are rolled, with a sine of the tilt above 0.1.
    #[test]
    fn the_horizon_is_level_from_the_ground() {
        use crate::ephemeris::Ephemeris;
        use crate::scene::viewpoint::viewer;
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("an ephemeris");
        let mut tilted_count_with_north_up = 0;
        for (from, target) in
            [("earth", "sun"), ("earth", "moon"), ("earth", "earth"), ("mars", "phobos"), ("mars", "sun"), ("moon", "earth")]
        {
            for (at, time) in ["90,0", "89.9,10", "51.5,-0.1", "32.8,-96.8", "0,0", "0,179.9", "-4.6,137.4", "-67,40", "-90,0"]
                .into_iter()
                .flat_map(|at| ["2024-04-08T18:42:38Z", "2013-08-20T07:11:29Z"].map(|time| (at, time)))
            {
                let some = |text: &str| Some(text.to_owned());
                let args = ViewArgs {
                    target: some(target),
                    from: some(from),
                    at: some(at),
                    time: time.into(),
                    fov: Some(40.0),
                    size: "64x64".into(),
                    exposure: "auto".into(),
                    tone_map: "filmic".into(),
                    pixels: "final".into(),
                    ..ViewArgs::default()
                };
                let request = args.request(&catalog).expect(at);
                let Position::Ground { body, latitude_deg, longitude_deg, .. } = request.position else {
                    panic!("{at} is not a place on the ground")
                };
                let radii_km = catalog.body(body).expect("a body").radii_km;
                let (_, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, GROUND_HEIGHT_KM);
                let zenith = ephemeris.body_from_icrf(body, request.time).expect("an orientation").transpose() * normal;
                let camera = viewer(&catalog, &ephemeris, &request).expect("a camera").camera;
                // The camera looks at the zenith or the nadir: every roll is level.
                if camera.forward.cross(zenith).length() < 1e-6 {
                    continue;
                }
                let tilt_sine = camera.right.dot(zenith);
                assert!(tilt_sine.abs() < 1e-12 && camera.up.dot(zenith) > 0.0, "{from} {at} to {target}: tilted, sine {tilt_sine}");
                let with_north_up = ViewArgs { up: some("north"), ..args }.request(&catalog).expect(at);
                let camera = viewer(&catalog, &ephemeris, &with_north_up).expect("a camera").camera;
                tilted_count_with_north_up += usize::from(camera.right.dot(zenith).abs() > 0.1);
            }
        }
        assert!(
            tilted_count_with_north_up > 40,
            "with the target's north up only {tilted_count_with_north_up} horizons are tilted, so the views do not test the roll"
        );
    }

    /// As `--help` says, `--distance-radii` is the distance from the centre, also above places of oblate and triaxial bodies, and the place is below the
    /// camera.
    #[test]
    fn the_distance_above_a_place_is_from_the_centre() {
        let catalog = Catalog::embedded();
        for (target, at, distance_radii) in [
            ("saturn", "60,0", 3.0),
            ("saturn", "-90,0", 0.95),
            ("saturn", "0,200", 1.0001),
            ("earth", "45,10", 1e7),
            ("phobos", "30,40", 1.0001),
            ("hyperion", "-50,100", 2.0),
            ("moon", "0,0", 3.0),
        ] {
            let (latitude_deg, longitude_deg) = parse_place_on_ground(at).expect(at);
            let mut args = ViewArgs { at: Some(at.to_owned()), distance_radii: Some(distance_radii), ..ViewArgs::default() };
            let body = catalog.body_or_barycenter(target).expect(target);
            let radii_km = catalog.body(body).expect(target).radii_km;
            let (ground_km, normal) = ground_point_km(radii_km, latitude_deg, longitude_deg, GROUND_HEIGHT_KM);
            let from = None;
            let offset_km = |args: &ViewArgs| match args.position(&catalog, body, from) {
                Ok(Position::Offset { offset_km, .. }) => offset_km,
                other => panic!("{target} {at}: {other:?}"),
            };
            let camera_km = offset_km(&args);
            let found_radii = camera_km.length() / radii_km.max_element();
            assert!((found_radii / distance_radii - 1.0).abs() < 1e-12, "{target} {at}: {found_radii} radii, not {distance_radii}");
            let off_vertical_km = normal.cross(camera_km - ground_km).length();
            assert!(off_vertical_km < 1e-9 * camera_km.length(), "{target} {at}: {off_vertical_km} km from the place's vertical");
            args.distance_radii = None;
            let default_radii = offset_km(&args).length() / radii_km.max_element();
            assert!((default_radii - DEFAULT_DISTANCE_ABOVE_PLACE_RADII).abs() < 1e-12, "{target} {at}: {default_radii}");
            args.distance_radii = Some(ground_km.length() / radii_km.max_element() - 1e-6);
            assert!(args.position(&catalog, body, from).is_err_and(|e| e.to_string().contains("--distance-radii")), "{target} {at}");
        }
    }

    #[test]
    fn spaces_around_a_time_are_ignored() {
        let earliest = Instant::parse("2024-01-01").expect("a time");
        for now in ["now", " now ", "\tNOW"] {
            assert!(is_now(now), "{now:?}");
            assert!(parse_time_option(now).is_ok_and(|t| t > earliest) && parse_time_or_now(now).is_ok_and(|t| t > earliest), "{now:?}");
        }
        assert_eq!(parse_time_option(" 2024-01-01 ").expect("a time"), earliest);
        assert!(!is_now("no w") && parse_time_option("no w").is_err() && parse_time_or_now("").is_err());
    }

    #[test]
    fn sizes_places_and_pixel_views_are_read_or_refused_with_the_option_named() {
        assert_eq!(parse_size("640x480").expect("a size"), (640, 480));
        assert_eq!(parse_place_on_ground("-33.9, 151.2").expect("a place"), (-33.9, 151.2));
        assert!(parse_size("640").unwrap_err().to_string().contains("--size 640"));
        assert!(parse_place_on_ground("north").unwrap_err().to_string().contains("--at north"));
        assert!(parse_pixel_view("colour").unwrap_err().to_string().contains("optical-depth"));
        assert_eq!(parse_pixel_view("Optical-Depth").expect("a view"), PixelView::OpticalDepth);
    }
}

//! One view: where the camera stands, where it looks, how wide, how bright, and what is drawn.

use crate::catalog::{Catalog, NaifId};
use crate::scene::draw::features::PixelView;
use crate::scene::error::SceneError;
use crate::scene::purpose::Purpose;
use crate::scene::request::composition::{Composition, Projection};
use crate::scene::request::effects::EffectOverrides;
use crate::time::Instant;
use crate::wording::{echo, suggestion_or_list};
use glam::DVec3;
use serde::Deserialize;

/// Axes in which a vector of a request is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// International Celestial Reference Frame.
    #[default]
    Icrf,
    /// Turning with the body that the position names.
    BodyFixed,
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Over the target on the side of `towards` (`None`: the Earth's side; for the Earth itself the Sun's side), at a distance
    /// from its centre in equatorial radii (`None`: so that the disc fills 3/4 of the frame's height).
    Over {
        /// Whose side of the target; `None`: the Earth's, for the Earth the Sun's.
        towards: Option<NaifId>,
        /// From the target's centre in its equatorial radii; `None`: fitted.
        distance_radii: Option<f64>,
    },
    /// At a body's centre or a barycentre, moving with it: directions carry its stellar aberration. The body itself is not drawn.
    Centre(NaifId),
    /// Above a point of a body's reference ellipsoid: planetographic latitude, east longitude, height along the normal.
    Ground {
        /// Whose ground it is.
        body: NaifId,
        /// Planetographic, -90 to 90.
        latitude_deg: f64,
        /// East, -360 to 360.
        longitude_deg: f64,
        /// Above 0.
        height_km: f64,
    },
    /// At an offset from a body's centre.
    Offset {
        /// Whose centre the offset counts from.
        body: NaifId,
        /// From the centre to the camera.
        offset_km: DVec3,
        /// In which it is given.
        axes: Axes,
    },
}

impl Position {
    /// What is up where nothing else is asked for: whoever stands on ground sees its horizon level.
    pub fn usual_up(&self) -> Up {
        match self {
            Self::Ground { .. } => Up::Zenith,
            Self::Over { .. } | Self::Centre(_) | Self::Offset { .. } => Up::North,
        }
    }
}

/// Where the camera looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Look {
    /// At the target.
    Target,
    /// Along a direction; body-fixed axes are those of the body that the position names.
    Along {
        /// Of any length.
        direction: DVec3,
        /// In which it is given.
        axes: Axes,
    },
}

/// What is up in the picture. A direction along the line of sight is replaced by the next best axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Up {
    /// The north pole of the target (of the body stood on, where there is no target).
    #[default]
    North,
    /// Away from the centre of the body stood on.
    Zenith,
    /// The celestial pole, ICRF +z.
    Celestial,
    /// The pole of the ecliptic of J2000.
    Ecliptic,
    /// A direction.
    Along {
        /// Of any length.
        direction: DVec3,
        /// In which it is given.
        axes: Axes,
    },
}

/// Nearer than this nobody sees a difference: half a level of 255 at mid grey is 0.02 stops.
pub const SETTLED_STOPS: f64 = 0.02;

/// How bright the picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ExposureRequest {
    /// By what fills the frame.
    #[default]
    Auto,
    /// Stops: at 0 a white plane facing the Sun at 1 au reaches linear 1; each stop doubles.
    Stops(f64),
    /// On the way from these stops to those of `Auto`, so far as a part of 0 to 1 says.
    Gliding {
        /// Where it begins.
        from_stops: f64,
        /// 0 to 1.
        part: f64,
    },
}

impl ExposureRequest {
    /// The stops of a picture whose light meter says `metered_stops`.
    pub fn stops_of(self, metered_stops: f64) -> f64 {
        match self {
            Self::Auto => metered_stops,
            Self::Stops(stops) => stops,
            // What nobody sees is the end of the way: the picture at rest is the metered one, wherever the way began.
            Self::Gliding { from_stops, .. } if (metered_stops - from_stops).abs() <= SETTLED_STOPS => metered_stops,
            Self::Gliding { from_stops, part } => from_stops + (metered_stops - from_stops) * part.clamp(0.0, 1.0),
        }
    }
}

/// How light beyond white is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// True to 0.8 of white, then a shoulder, as film has.
    #[default]
    Filmic,
    /// True up to white, where it is cut.
    Clipped,
}

impl ToneMap {
    /// Every choice.
    pub const ALL: [Self; 2] = [Self::Filmic, Self::Clipped];

    /// As options and links have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Filmic => "filmic",
            Self::Clipped => "clipped",
        }
    }

    /// The choice of a name, former names too.
    pub fn by_name(name: &str) -> Option<Self> {
        // `film` and `plain` are the names of earlier versions.
        let former = [("film", Self::Filmic), ("plain", Self::Clipped)];
        let known = Self::ALL.map(|t| (t.name(), t)).into_iter().chain(former);
        known.into_iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, t)| t)
    }
}

/// What is drawn over the bodies to explain them, or as a lens would.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    /// The lines on which bodies move about their parents.
    pub orbits: bool,
    /// Names and markers of bodies.
    pub labels: bool,
    /// Points of the catalog's data layers.
    pub data: bool,
    /// Names of surface features.
    pub features: bool,
    /// Body, date, standpoint and field of view.
    pub caption: bool,
    /// A round length at the target's distance, or an angle.
    pub scale_bar: bool,
    /// Where the target's north is.
    pub compass: bool,
    /// A line of light around the selected body.
    pub outline: bool,
    /// Light beyond white spreads, as in a lens.
    pub bloom: bool,
    /// As far as the exposure shows them.
    pub stars: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            orbits: false,
            labels: false,
            data: true,
            features: false,
            caption: false,
            scale_bar: false,
            compass: false,
            outline: false,
            bloom: false,
            stars: true,
        }
    }
}

impl Layers {
    /// Every layer's name.
    pub const NAMES: [&str; 10] = ["orbits", "labels", "data", "features", "caption", "scale-bar", "compass", "outline", "bloom", "stars"];

    fn by_name(&mut self, name: &str) -> Option<&mut bool> {
        match name {
            "orbits" => Some(&mut self.orbits),
            "labels" => Some(&mut self.labels),
            "data" => Some(&mut self.data),
            "features" => Some(&mut self.features),
            "caption" => Some(&mut self.caption),
            "scale-bar" => Some(&mut self.scale_bar),
            "compass" => Some(&mut self.compass),
            "outline" => Some(&mut self.outline),
            "bloom" => Some(&mut self.bloom),
            "stars" => Some(&mut self.stars),
            _ => None,
        }
    }

    /// Those that are not as usual: `+orbits,-stars`.
    pub fn to_text(mut self) -> String {
        let mut usual = Self::default();
        let switched = Self::NAMES.into_iter().filter_map(|name| {
            let on = *self.by_name(name)?;
            (on != *usual.by_name(name)?).then(|| format!("{}{name}", if on { '+' } else { '-' }))
        });
        switched.collect::<Vec<_>>().join(",")
    }

    /// Reads `+orbits,-labels`.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let mut layers = Self::default();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let wrong = |why: String| SceneError::Request(format!("layer `{}`: {why}", echo(part)));
            let (on, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
                (Some(name), _) => (true, name),
                (_, Some(name)) => (false, name),
                (None, None) => return Err(wrong("write + or - before its name".into())),
            };
            *layers.by_name(name).ok_or_else(|| wrong(suggestion_or_list(name, &Self::NAMES)))? = on;
        }
        Ok(layers)
    }
}

/// Trade of speed for accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// One sample a pixel.
    Draft,
    /// Four samples a pixel.
    #[default]
    Standard,
    /// Four samples a pixel, maps with twice the taps.
    Reference,
}

impl Quality {
    /// From the quickest to the most accurate.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Standard, Self::Reference];

    /// As options and links have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Reference => "reference",
        }
    }

    /// The quality of a name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|q| q.name().eq_ignore_ascii_case(name))
    }
}

/// One view. `target` may be missing only where the look gives a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewRequest {
    /// When the light arrives at the camera.
    pub time: Instant,
    /// The body that the camera looks at.
    pub target: Option<NaifId>,
    /// Where the camera stands.
    pub position: Position,
    /// Where it looks.
    pub look: Look,
    /// What is up in the picture.
    pub up: Up,
    /// How the picture is put together.
    pub composition: Composition,
    /// Vertical field of view, degrees; of a fisheye, that of its circle. `None`: [`FOV_DEFAULT_DEG`], or what fits the target where only that can.
    pub fov_deg: Option<f64>,
    /// Pixels, each 1..=16384.
    pub width: u32,
    /// Pixels, 1..=16384.
    pub height: u32,
    /// How bright the picture is.
    pub exposure: ExposureRequest,
    /// How light beyond white is shown.
    pub tone_map: ToneMap,
    /// Effects that are on or off whatever their bounds say.
    pub effects: EffectOverrides,
    /// What is drawn over the bodies.
    pub layers: Layers,
    /// What the viewer has picked out; `None`: the target.
    pub selected: Option<NaifId>,
    /// Speed against accuracy.
    pub quality: Quality,
    /// What the pixels show.
    pub pixel_view: PixelView,
    /// What the picture is for: below which bound a feature is left out.
    pub purpose: Purpose,
}

/// Field of view when neither it nor a distance is asked for: a long lens, so that nearly a hemisphere shows.
pub const FOV_DEFAULT_DEG: f64 = 20.0;
/// Field of view when a place to stand is given: at 3 radii the disc then fills 85 % of the frame's height.
pub const FOV_AT_DISTANCE_DEG: f64 = 45.0;
/// Part of the frame's height that a fitted disc fills.
pub const FITTED_DISC: f64 = 0.75;

impl ViewRequest {
    /// The default view of a body: see [`Position::Over`].
    pub fn of(target: NaifId, time: Instant) -> Self {
        Self {
            time,
            target: Some(target),
            position: Position::Over { towards: None, distance_radii: None },
            look: Look::Target,
            up: Up::North,
            composition: Composition::default(),
            fov_deg: None,
            width: 1024,
            height: 1024,
            exposure: ExposureRequest::Auto,
            tone_map: ToneMap::Filmic,
            effects: EffectOverrides::default(),
            layers: Layers::default(),
            selected: None,
            quality: Quality::default(),
            pixel_view: PixelView::Final,
            purpose: Purpose::Display,
        }
    }

    /// Refuses effects asked of bodies that the catalog does not have.
    pub fn check_bodies(&self, catalog: &Catalog) -> Result<(), SceneError> {
        for name in self.effects.bodies() {
            catalog.named(name).map_err(|e| SceneError::Request(format!("effects: {e}")))?;
        }
        Ok(())
    }

    /// Refuses what no camera can do, naming the value.
    pub fn check(&self) -> Result<(), SceneError> {
        let bad = |what: String| Err(SceneError::Request(what));
        if !(1..=16384).contains(&self.width) || !(1..=16384).contains(&self.height) {
            return bad(format!("size {}x{}: each side must be 1 to 16384 pixels", self.width, self.height));
        }
        if let Some(fov) = self.fov_deg
            && !(1e-7..=170.0).contains(&fov)
            && self.composition.projection == Projection::Perspective
        {
            return bad(format!("field of view {fov:?}: must be 0.0000001 to 170 degrees"));
        }
        if let Position::Over { distance_radii: Some(d), .. } = self.position
            && !(d > 0.0 && d.is_finite())
        {
            return bad(format!("distance {d:?} radii: must be a number above 0"));
        }
        if let Position::Ground { latitude_deg, longitude_deg, height_km, .. } = self.position {
            if !(-90.0..=90.0).contains(&latitude_deg) {
                return bad(format!("latitude {latitude_deg:?}: must be -90 to 90 degrees"));
            }
            if !(-360.0..=360.0).contains(&longitude_deg) {
                return bad(format!("longitude {longitude_deg:?}: must be -360 to 360 degrees east"));
            }
            if !(height_km > 0.0 && height_km.is_finite()) {
                return bad(format!("height {height_km:?} km: must be above the ground"));
            }
        }
        if let Position::Offset { offset_km, .. } = self.position
            && !offset_km.is_finite()
        {
            return bad("the camera's offset must be finite".into());
        }
        if let ExposureRequest::Stops(ev) | ExposureRequest::Gliding { from_stops: ev, .. } = self.exposure
            && !(-60.0..=60.0).contains(&ev)
        {
            return bad(format!("exposure {ev:?}: must be -60 to 60 stops"));
        }
        self.composition.check()?;
        if !self.time.tdb_seconds_past_j2000().is_finite() {
            return bad("the time is not a finite number".into());
        }
        Ok(())
    }
}

/// Height of a standing viewer's eye, kilometres.
pub const EYE_HEIGHT_KM: f64 = 0.0017;

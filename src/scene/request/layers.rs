//! Layers: everything drawn behind and over the bodies, and bloom. The user switches each layer on or off by its name.
//!
//! In: a text such as `+orbits,-stars`. Out: [`Layers`], or an error that names the invalid part. Always: a layer that the text does not name has its
//! default.

use crate::scene::error::SceneError;
use crate::wording::{echo, suggestion_or_list};

/// Declares each layer: its field, its name, and whether it is on by default.
macro_rules! layers {
    ($($(#[$about:meta])* $field:ident: $name:literal $default:literal,)*) => {
        /// Which layers are drawn.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Layers {
            $($(#[$about])* pub $field: bool,)*
        }

        impl Default for Layers {
            fn default() -> Self {
                Self { $($field: $default),* }
            }
        }

        impl Layers {
            /// Only bodies.
            pub const NONE: Self = Self { $($field: false),* };
            /// All layers.
            pub const ALL: Self = Self { $($field: true),* };
            /// Every layer's name.
            pub const NAMES: [&str; [$($name),*].len()] = [$($name),*];

            /// The switch of the layer with this name; `None` if there is no such layer.
            pub fn switch_by_name(&mut self, name: &str) -> Option<&mut bool> {
                match name {
                    $($name => Some(&mut self.$field),)*
                    _ => None,
                }
            }
        }
    };
}

layers! {
    /// Orbits of bodies about their parents.
    orbits: "orbits" false,
    /// Past positions of bodies, relative to the target.
    traces: "traces" false,
    /// Names and markers of bodies; with `comets` also names of comets.
    labels: "labels" false,
    /// Points, lines and images of the catalog's data layers.
    data: "data" true,
    /// Names of surface features.
    features: "features" false,
    /// Caption: body, date, viewpoint and field of view.
    caption: "caption" false,
    /// Scale bar: a round length at the target's ground in the image's middle, or an angle.
    scale_bar: "scale-bar" false,
    /// Compass: the direction of the target's north pole.
    compass: "compass" false,
    /// Outline of the selected body.
    outline: "outline" false,
    /// Bloom: light brighter than white spreads as in a lens.
    bloom: "bloom" false,
    /// Stars that the exposure shows.
    stars: "stars" true,
    /// All stars brightened, so that those to magnitude 9.5 are visible at any exposure; no effect inside an atmosphere.
    bright_stars: "bright-stars" false,
    /// The Milky Way or the panorama that replaces it, if the exposure shows it.
    milky_way: "milky-way" true,
    /// Zodiacal light, if the exposure shows it.
    zodiacal_light: "zodiacal-light" true,
    /// Minor planets as points of light, with markers for those too faint.
    minor_planets: "minor-planets" false,
    /// Comets with heads and tails.
    comets: "comets" false,
    /// Proper names of the visible stars.
    star_names: "star-names" false,
    /// Figures and names of constellations.
    constellations: "constellations" false,
    /// Boundaries of the constellations.
    boundaries: "boundaries" false,
    /// Grid of right ascension and declination, ICRF.
    grid_equatorial: "grid-equatorial" false,
    /// Grid of right ascension and declination, true equator and equinox of date.
    grid_equatorial_date: "grid-equatorial-date" false,
    /// Grid of ecliptic longitude and latitude, J2000.
    grid_ecliptic: "grid-ecliptic" false,
    /// Grid of galactic longitude and latitude.
    grid_galactic: "grid-galactic" false,
    /// Grid of azimuth and altitude, if the camera stands on the ground.
    grid_horizon: "grid-horizon" false,
    /// Grid of planetocentric longitude and planetographic latitude on each body.
    grid_body: "grid-body" false,
    /// The terminator of each body: where the Sun's centre is on the horizon.
    terminator: "terminator" false,
    /// Outlines of umbra and penumbra on the ground of each body, and their paths.
    eclipse_path: "eclipse-path" false,
    /// Shadow cones in space: those of the target's occluders and the target's own.
    eclipse_cones: "eclipse-cones" false,
    /// Fields of view of the catalog's instruments, around the target.
    instruments: "instruments" false,
}

impl Layers {
    /// The layers that differ from the default, such as `+orbits,-stars`.
    pub fn to_text(mut self) -> String {
        let mut default = Self::default();
        let differing = Self::NAMES.into_iter().filter_map(|name| {
            let on = *self.switch_by_name(name)?;
            (on != *default.switch_by_name(name)?).then(|| format!("{}{name}", if on { '+' } else { '-' }))
        });
        differing.collect::<Vec<_>>().join(",")
    }

    /// Reads a text such as `+orbits,-labels`.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let mut layers = Self::default();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let error = |why: String| SceneError::Request(format!("layer `{}`: {why}", echo(part)));
            let (on, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
                (Some(name), _) => (true, name),
                (_, Some(name)) => (false, name),
                (None, None) => return Err(error("write + or - before its name".into())),
            };
            *layers.switch_by_name(&name.to_ascii_lowercase()).ok_or_else(|| error(suggestion_or_list(name, &Self::NAMES)))? = on;
        }
        Ok(layers)
    }
}

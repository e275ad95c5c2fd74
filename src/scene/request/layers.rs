//! Layers: what is drawn beyond and over the bodies, each switched by its name.

use crate::scene::error::SceneError;
use crate::wording::{echo, suggestion_or_list};

/// Of each layer: its field, its name, and whether it is usually drawn.
macro_rules! layers {
    ($($(#[$about:meta])* $field:ident: $name:literal $usual:literal,)*) => {
        /// What is drawn beyond and over the bodies, or as a lens would.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Layers {
            $($(#[$about])* pub $field: bool,)*
        }

        impl Default for Layers {
            fn default() -> Self {
                Self { $($field: $usual),* }
            }
        }

        impl Layers {
            /// Nothing but bodies.
            pub const NONE: Self = Self { $($field: false),* };
            /// All of them.
            pub const ALL: Self = Self { $($field: true),* };
            /// Every layer's name.
            pub const NAMES: [&str; [$($name),*].len()] = [$($name),*];

            /// The switch of a layer's name.
            pub fn by_name(&mut self, name: &str) -> Option<&mut bool> {
                match name {
                    $($name => Some(&mut self.$field),)*
                    _ => None,
                }
            }
        }
    };
}

layers! {
    /// The lines on which bodies move about their parents.
    orbits: "orbits" false,
    /// Where they have been, as seen from the target.
    traces: "traces" false,
    /// Names and markers of bodies.
    labels: "labels" false,
    /// Points, lines and images of the catalog's data layers.
    data: "data" true,
    /// Names of surface features.
    features: "features" false,
    /// Body, date, standpoint and field of view.
    caption: "caption" false,
    /// A round length at the target's distance, or an angle.
    scale_bar: "scale-bar" false,
    /// Where the target's north is.
    compass: "compass" false,
    /// A line of light around the selected body.
    outline: "outline" false,
    /// Light beyond white spreads, as in a lens.
    bloom: "bloom" false,
    /// As far as the exposure shows them.
    stars: "stars" true,
    /// The same: the Milky Way, or the panorama in its place.
    milky_way: "milky-way" true,
    /// The same.
    zodiacal_light: "zodiacal-light" true,
    /// Points of light, and marks where they are too faint.
    minor_planets: "minor-planets" false,
    /// Heads and tails.
    comets: "comets" false,
    /// Proper names of the stars that show.
    star_names: "star-names" false,
    /// Figures and names.
    constellations: "constellations" false,
    /// Of the constellations.
    boundaries: "boundaries" false,
    /// Right ascension and declination, ICRF.
    grid_equatorial: "grid-equatorial" false,
    /// Ecliptic longitude and latitude, J2000.
    grid_ecliptic: "grid-ecliptic" false,
    /// Galactic longitude and latitude.
    grid_galactic: "grid-galactic" false,
    /// Azimuth and altitude of who stands on ground.
    grid_horizon: "grid-horizon" false,
    /// Longitude and planetographic latitude on the target.
    grid_body: "grid-body" false,
    /// Where the Sun's centre rises and sets on the target.
    terminator: "terminator" false,
    /// Umbra and penumbra of what stands before the target's Sun, and where they go on its ground.
    eclipse_path: "eclipse-path" false,
    /// The same in space, and the target's own.
    eclipse_cones: "eclipse-cones" false,
    /// Fields of view of the catalog's instruments, around the target.
    instruments: "instruments" false,
}

impl Layers {
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

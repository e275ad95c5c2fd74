//! Layers: what is drawn beyond and over the bodies, each switched by its name.

use crate::scene::error::SceneError;
use crate::wording::{echo, suggestion_or_list};

/// What is drawn beyond and over the bodies, or as a lens would.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    /// The lines on which bodies move about their parents.
    pub orbits: bool,
    /// Names and markers of bodies.
    pub labels: bool,
    /// A line of light around the selected body.
    pub outline: bool,
    /// Light beyond white spreads, as in a lens.
    pub bloom: bool,
    /// As far as the exposure shows them.
    pub stars: bool,
    /// The same: the Milky Way, or the panorama in its place.
    pub milky_way: bool,
    /// The same.
    pub zodiacal_light: bool,
    /// Figures and names.
    pub constellations: bool,
    /// Of the constellations.
    pub boundaries: bool,
    /// Right ascension and declination, ICRF.
    pub grid_equatorial: bool,
    /// Ecliptic longitude and latitude, J2000.
    pub grid_ecliptic: bool,
    /// Galactic longitude and latitude.
    pub grid_galactic: bool,
    /// Azimuth and altitude of who stands on ground.
    pub grid_horizon: bool,
    /// Longitude and planetographic latitude on the target.
    pub grid_body: bool,
    /// Where the Sun's centre rises and sets on the target.
    pub terminator: bool,
}

impl Default for Layers {
    fn default() -> Self {
        Self { stars: true, milky_way: true, zodiacal_light: true, ..Self::NONE }
    }
}

impl Layers {
    /// Nothing but bodies.
    pub const NONE: Self = Self {
        orbits: false,
        labels: false,
        outline: false,
        bloom: false,
        stars: false,
        milky_way: false,
        zodiacal_light: false,
        constellations: false,
        boundaries: false,
        grid_equatorial: false,
        grid_ecliptic: false,
        grid_galactic: false,
        grid_horizon: false,
        grid_body: false,
        terminator: false,
    };
    /// Every layer's name.
    pub const NAMES: [&str; 15] = [
        "orbits",
        "labels",
        "outline",
        "bloom",
        "stars",
        "milky-way",
        "zodiacal-light",
        "constellations",
        "boundaries",
        "grid-equatorial",
        "grid-ecliptic",
        "grid-galactic",
        "grid-horizon",
        "grid-body",
        "terminator",
    ];

    /// The switch of a layer's name.
    pub fn by_name(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "orbits" => &mut self.orbits,
            "labels" => &mut self.labels,
            "outline" => &mut self.outline,
            "bloom" => &mut self.bloom,
            "stars" => &mut self.stars,
            "milky-way" => &mut self.milky_way,
            "zodiacal-light" => &mut self.zodiacal_light,
            "constellations" => &mut self.constellations,
            "boundaries" => &mut self.boundaries,
            "grid-equatorial" => &mut self.grid_equatorial,
            "grid-ecliptic" => &mut self.grid_ecliptic,
            "grid-galactic" => &mut self.grid_galactic,
            "grid-horizon" => &mut self.grid_horizon,
            "grid-body" => &mut self.grid_body,
            "terminator" => &mut self.terminator,
            _ => return None,
        })
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

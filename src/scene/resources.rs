//! Inputs of a scene in addition to catalog and ephemeris: files, and tables that take long to compute.
//!
//! A scene builder lists the requirements of a view ([`Requirements`]); the owner of files and caches supplies them ([`Resources`]). An effect whose resource
//! is missing is left out of the scene; the effect's decision gives the missing resource as the reason.

use crate::catalog::NaifId;
use crate::ephemeris::Ephemeris;
use crate::mesh::Mesh;
use crate::scene::atmosphere::sky_brightness::SkyBrightnessCache;
use crate::scene::draw::MapFiles;
use crate::scene::draw::features::Shape;
use crate::scene::eclipse::shadow_path::ShadowPaths;
use crate::scene::light::bright_ground::BrightGround;
use crate::scene::light::night_lights::NightLights;
use crate::scene::request::view_request::ViewRequest;
use crate::scene::rings::radial_sums::RadialSumsCache;
use crate::scene::rings::ring_shine::RingShineCache;
use crate::scene::rings::ring_table::RingTables;
use crate::scene::rings::shadow_on_body::ShadowGridCache;
use crate::scene::sky::map::SkyMap;
use crate::scene::sky::minor_planet_columns::MinorPlanetColumns;
use crate::scene::visibility::limb_profiles::LimbProfileCache;
use glam::{DVec3, Vec4};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};

/// The body whose shape model a view draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshRequirement {
    pub body: NaifId,
    /// Unit vector towards the Sun in body axes, and the Sun's angular radius in radians, from which [`Resources::sun_altitudes`] are computed; `None` if the
    /// mesh casts no shadows on itself.
    pub self_shadow_sun: Option<(DVec3, f64)>,
}

/// The files and tables that a view needs in addition to catalog and ephemeris.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Requirements {
    /// Shape models.
    pub meshes: Vec<MeshRequirement>,
    /// Bodies whose draws read a table of multiple scattering ([`crate::scene::multi_scatter_table`]).
    pub scattering_tables: Vec<NaifId>,
    /// For each drawn body: its map files, and the shape of its globe, which determines how the maps are decoded.
    pub maps: Vec<(MapFiles, Shape)>,
    /// The file of the sky's panorama (the user's or the built-in one); `None` if the view does not draw it.
    pub sky_map: Option<String>,
}

/// The files and tables that were loaded or computed.
#[derive(Clone, Debug, Default)]
pub struct Resources {
    /// Names of map and mesh files, as in the catalog and in [`Requirements`], that could not be read; bodies are drawn without them.
    pub unreadable: BTreeSet<String>,
    /// Shape models.
    pub meshes: BTreeMap<NaifId, Arc<Mesh>>,
    /// Altitude of the Sun's centre above the horizon that the mesh itself forms at each vertex, in radii of the Sun's disc. For a
    /// body that is missing here the scene computes them.
    pub sun_altitudes: BTreeMap<NaifId, Arc<Vec<f32>>>,
    /// City lights, which the light meter takes into account when it chooses the exposure.
    pub night_lights: BTreeMap<NaifId, Arc<NightLights>>,
    /// The bright ground of bodies near the camera, by which the light meter exposes deserts and ice; ground of a body that is missing here counts as uniform.
    pub bright_grounds: BTreeMap<NaifId, Arc<BrightGround>>,
    /// Tables of multiple scattering; [`crate::scene::multi_scatter_table`] describes their layout.
    pub scattering_tables: BTreeMap<NaifId, Arc<Vec<Vec4>>>,
    /// The user's panorama of the sky; `None` for the built-in Milky Way.
    pub sky_map: Option<SkyMap>,
}

impl Resources {
    /// Whether a map or mesh file is known to be unreadable.
    pub(crate) fn is_unreadable(&self, file: &str) -> bool {
        self.unreadable.contains(file)
    }

    /// The panorama of the sky: the user's, or the built-in Milky Way.
    pub(crate) fn sky_map(&self) -> SkyMap {
        self.sky_map.clone().unwrap_or_else(SkyMap::milky_way)
    }
}

/// Tables that are kept from frame to frame. The caller of scene builders owns one instance.
#[derive(Debug, Default)]
pub struct Caches {
    pub(crate) ring_tables: RingTables,
    pub(crate) radial_sums: RadialSumsCache,
    pub(crate) ring_shadows: ShadowGridCache,
    pub(crate) sky_brightness: SkyBrightnessCache,
    pub(crate) ring_shines: RingShineCache,
    pub(crate) shadow_paths: ShadowPaths,
    pub(crate) limb_profiles: LimbProfileCache,
    /// The elements of the catalog's minor planets as columns.
    pub(crate) minor_planets: OnceLock<Arc<MinorPlanetColumns>>,
}

impl Caches {
    /// Caches with the given cache of ring-shine tables, which can also store them on disk.
    pub(crate) fn with_ring_shines(ring_shines: RingShineCache) -> Self {
        Self { ring_shines, ..Self::default() }
    }
}

/// Inputs that every part of a scene reads.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub request: &'a ViewRequest,
    pub ephemeris: &'a Ephemeris,
    pub resources: &'a Resources,
    pub caches: &'a Caches,
}

//! Reads shape models when a view first needs them, and computes the shadows that they cast on themselves.
//!
//! In: catalog entries. Out: models from the folders of `--textures` or `--catalogs`, and at each of their vertices the *Sun altitude*: the angle of the
//! Sun's centre above the skyline that the model's relief forms, in units of its angular radius ([`crate::mesh::self_shadow`]). Computed Sun
//! altitudes are reused until the Sun's direction in body axes has changed by `SUN_DIRECTION_TOLERANCE_RAD`. An error is a single line.

use crate::catalog::{Body, NaifId};
use crate::files::{check_inside, is_there, read_text};
use crate::memo::Memo;
use crate::mesh::{Mesh, ShapeParameters, obj};
use glam::DVec3;
use std::path::PathBuf;
use std::sync::Arc;

/// Change of the Sun's direction in body axes below which computed Sun altitudes are reused: about a tenth of the Sun's angular radius seen from the Earth.
const SUN_DIRECTION_TOLERANCE_RAD: f64 = 5e-4;
/// Relative change of the Sun's angular radius below which computed Sun altitudes are reused.
const SUN_SIZE_TOLERANCE: f64 = 0.01;
/// Largest number of sets of Sun altitudes, each of one model for one direction of the Sun, in memory: enough for two views of several bodies.
const MAX_SUN_ALTITUDE_SETS: usize = 8;
/// Largest number of models in memory.
const MAX_MODELS: usize = 64;
/// Largest OBJ file, bytes.
const MAX_BYTES: u64 = 1 << 30;

/// The inputs from which the Sun altitudes at a model's vertices are computed.
struct SunAltitudeInputs {
    model: Arc<Mesh>,
    towards_sun: DVec3,
    sun_radius_rad: f64,
}

impl SunAltitudeInputs {
    /// Whether Sun altitudes computed for `self` can be used for `other`: the same model, and the Sun in nearly the same direction and of nearly the same size.
    fn is_usable_for(&self, other: &Self) -> bool {
        let sine = self.towards_sun.cross(other.towards_sun).length();
        let is_near = sine < SUN_DIRECTION_TOLERANCE_RAD && self.towards_sun.dot(other.towards_sun) > 0.0;
        let is_same_size = (self.sun_radius_rad / other.sun_radius_rad - 1.0).abs() < SUN_SIZE_TOLERANCE;
        Arc::ptr_eq(&self.model, &other.model) && is_near && is_same_size
    }
}

/// The shape models of a session, and the Sun altitudes at their vertices.
pub struct Meshes {
    folders: Vec<PathBuf>,
    /// Models by body; an error gives the file, and why the model cannot be drawn.
    models: Memo<NaifId, Result<Arc<Mesh>, String>>,
    sun_altitudes: Memo<SunAltitudeInputs, Arc<Vec<f32>>>,
}

impl Meshes {
    /// Searches these folders for files; earlier folders take precedence.
    pub fn new(folders: impl IntoIterator<Item = PathBuf>) -> Self {
        Self {
            folders: folders.into_iter().collect(),
            models: Memo::with_capacity(MAX_MODELS),
            sun_altitudes: Memo::with_capacity(MAX_SUN_ALTITUDE_SETS),
        }
    }

    /// A body's model.
    ///
    /// # Errors
    /// The file, and why the model cannot be drawn.
    pub fn model(&self, body: &Body) -> Result<Arc<Mesh>, String> {
        self.models.get(body.id, || self.read(body))
    }

    fn read(&self, body: &Body) -> Result<Arc<Mesh>, String> {
        let entry = body.mesh.as_ref().ok_or_else(|| format!("the catalog has no mesh of {}", body.name))?;
        let Some((folder, path)) = self.folders.iter().map(|f| (f, f.join(&entry.file))).find(|(_, path)| is_there(path)) else {
            let searched: Vec<_> = self.folders.iter().map(|f| f.display().to_string()).collect();
            return Err(format!(
                "mesh {} is not in {}",
                entry.file,
                if searched.is_empty() { "any named folder (--textures, --catalogs)".into() } else { searched.join(" nor in ") }
            ));
        };
        let name = path.display();
        let text = check_inside(folder, &path).and_then(|()| read_text(&path, MAX_BYTES)).map_err(|e| format!("{name}: {e}"))?;
        // The error starts with the number of its line.
        let obj = obj::parse(&text).map_err(|e| format!("{name}:{e}"))?;
        let shape = ShapeParameters {
            radii_km: body.radii_km,
            scale_km: entry.scale_km,
            map_stretch: body.map_stretch(),
            two_sided: entry.two_sided,
        };
        Ok(Arc::new(Mesh::of(&obj, &shape).map_err(|e| format!("{name}: {e}"))?))
    }

    /// The Sun altitude at each vertex; the model's own relief forms the horizon. `towards_sun`: unit vector in body axes. `sun_radius_rad`: the Sun's
    /// angular radius.
    pub fn sun_altitudes(&self, model: &Arc<Mesh>, towards_sun: DVec3, sun_radius_rad: f64) -> Arc<Vec<f32>> {
        let inputs = SunAltitudeInputs { model: Arc::clone(model), towards_sun, sun_radius_rad };
        self.sun_altitudes
            .get_compatible(SunAltitudeInputs::is_usable_for, inputs, || Arc::new(model.sun_altitudes(towards_sun, sun_radius_rad)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Arc<Mesh> {
        let text = "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
        let shape = ShapeParameters { radii_km: DVec3::ONE, scale_km: 1.0, map_stretch: glam::DVec2::ONE, two_sided: false };
        Arc::new(Mesh::of(&obj::parse(text).expect("reads"), &shape).expect("a model"))
    }

    #[test]
    fn sun_altitudes_are_reused_until_the_sun_has_moved() {
        let (meshes, model) = (Meshes::new([]), model());
        let sun_radius_rad = 0.005;
        let altitudes_for_angle = |model: &Arc<Mesh>, turned_rad: f64| {
            meshes.sun_altitudes(model, DVec3::new(turned_rad.cos(), turned_rad.sin(), 0.0), sun_radius_rad)
        };
        let first = altitudes_for_angle(&model, 0.0);
        assert!(Arc::ptr_eq(&first, &altitudes_for_angle(&model, 0.8 * SUN_DIRECTION_TOLERANCE_RAD)));
        assert!(!Arc::ptr_eq(&first, &altitudes_for_angle(&model, 1.2 * SUN_DIRECTION_TOLERANCE_RAD)));
        assert!(!Arc::ptr_eq(&first, &altitudes_for_angle(&model, std::f64::consts::PI)), "from the other side");
        assert!(!Arc::ptr_eq(&first, &altitudes_for_angle(&self::model(), 0.0)), "another shape");
        // More sets than the limit drop the oldest one.
        (1..=MAX_SUN_ALTITUDE_SETS).for_each(|k| drop(altitudes_for_angle(&model, 0.1 * k as f64)));
        assert!(!Arc::ptr_eq(&first, &altitudes_for_angle(&model, 0.0)));
    }
}

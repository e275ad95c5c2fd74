//! Shape models by body, each read once when a view first wants it, and the shadows they throw on themselves.
//!
//! In: catalog entries. Out: models from `--textures` or from beside the catalog files, and heights of the Sun at their vertices
//! ([`crate::mesh::horizon`]), kept while the Sun moves no more than [`TOLERANCE_RAD`] in the body's sky. A file that cannot be read is one line.

use crate::catalog::{Body, NaifId};
use crate::mesh::{Figure, Model, obj};
use crate::scene::draw::MeshAmounts;
use glam::DVec3;
use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Turn of the Sun in the body's axes up to which heights stand: a tenth of its radius seen from the Earth.
pub const TOLERANCE_RAD: f64 = 5e-4;
/// Sets of heights that are kept: two views of some bodies at a time.
const KEPT: usize = 8;
/// Bytes of a file at the most.
const BYTES_AT_MOST: u64 = 1 << 30;

struct Heights {
    model: Arc<Model>,
    towards: DVec3,
    radius_rad: f64,
    values: Arc<Vec<f32>>,
}

#[derive(Default)]
pub struct Meshes {
    folders: Vec<PathBuf>,
    models: Mutex<BTreeMap<NaifId, Arc<Model>>>,
    heights: Mutex<VecDeque<Heights>>,
}

impl Meshes {
    /// Files of an earlier folder come first.
    pub fn new(folders: impl IntoIterator<Item = PathBuf>) -> Self {
        Self { folders: folders.into_iter().collect(), ..Self::default() }
    }

    /// Every model that was read.
    pub fn read(&self) -> BTreeMap<NaifId, Arc<Model>> {
        self.models.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Reads a body's model.
    ///
    /// # Errors
    /// The file, and why it cannot be drawn.
    pub fn load(&self, body: &Body) -> Result<(), String> {
        let Some(named) = &body.mesh else { return Ok(()) };
        let Some(path) = self.folders.iter().map(|f| f.join(&named.file)).find(|p| p.is_file()) else {
            let searched: Vec<_> = self.folders.iter().map(|f| f.display().to_string()).collect();
            return Err(format!(
                "mesh {} is not in {}",
                named.file,
                if searched.is_empty() { "any folder that was named".into() } else { searched.join(" nor in ") }
            ));
        };
        let shown = path.display();
        let bytes = std::fs::metadata(&path).map_err(|e| format!("{shown}: {e}"))?.len();
        if bytes > BYTES_AT_MOST {
            return Err(format!("{shown}: {bytes} bytes, more than {BYTES_AT_MOST}, the most that are read"));
        }
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{shown}: {e}"))?;
        let obj = obj::parse(&text).map_err(|e| format!("{shown}:{e}"))?;
        let figure = Figure {
            radii_km: body.radii_km,
            scale_km: named.scale_km,
            latitude_stretch: body.map_latitude_stretch(),
            two_sided: named.two_sided,
        };
        let model = Model::of(&obj, &figure).map_err(|e| format!("{shown}: {e}"))?;
        self.models.lock().unwrap_or_else(PoisonError::into_inner).insert(body.id, Arc::new(model));
        Ok(())
    }

    /// Heights of the Sun at each vertex, where the draw asks for them.
    pub fn heights(&self, mesh: &MeshAmounts) -> Option<Arc<Vec<f32>>> {
        let (towards, radius_rad) = mesh.sun?;
        let holds = |h: &&Heights| {
            let turned = h.towards.cross(towards).length() < TOLERANCE_RAD && h.towards.dot(towards) > 0.0;
            Arc::ptr_eq(&h.model, &mesh.model) && turned && (h.radius_rad / radius_rad - 1.0).abs() < 0.01
        };
        let mut kept = self.heights.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = kept.iter().find(holds) {
            return Some(found.values.clone());
        }
        let values = Arc::new(mesh.model.sun_heights(towards, radius_rad));
        kept.truncate(KEPT - 1);
        kept.push_front(Heights { model: mesh.model.clone(), towards, radius_rad, values: values.clone() });
        Some(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Arc<Model> {
        let text = "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
        let figure = Figure { radii_km: DVec3::ONE, scale_km: 1.0, latitude_stretch: 1.0, two_sided: false };
        Arc::new(Model::of(&obj::parse(text).expect("reads"), &figure).expect("a model"))
    }

    fn lit(model: &Arc<Model>, turned_rad: f64) -> MeshAmounts {
        let towards = DVec3::new(turned_rad.cos(), turned_rad.sin(), 0.0);
        MeshAmounts { model: model.clone(), sun: Some((towards, 0.005)), sun_heights: None }
    }

    #[test]
    fn heights_stand_until_the_sun_has_moved() {
        let (meshes, model) = (Meshes::default(), model());
        let heights = |mesh: &MeshAmounts| meshes.heights(mesh).expect("lit");
        let first = heights(&lit(&model, 0.0));
        assert!(Arc::ptr_eq(&first, &heights(&lit(&model, 0.8 * TOLERANCE_RAD))));
        assert!(!Arc::ptr_eq(&first, &heights(&lit(&model, 1.2 * TOLERANCE_RAD))));
        assert!(!Arc::ptr_eq(&first, &heights(&lit(&model, std::f64::consts::PI))), "from the other side");
        assert!(!Arc::ptr_eq(&first, &heights(&lit(&self::model(), 0.0))), "another shape");
        assert!(meshes.heights(&MeshAmounts { sun: None, ..lit(&model, 0.0) }).is_none());
        // What was not asked for lately goes.
        (1..=KEPT).for_each(|k| drop(heights(&lit(&model, 0.1 * k as f64))));
        assert!(!Arc::ptr_eq(&first, &heights(&lit(&model, 0.0))));
    }
}

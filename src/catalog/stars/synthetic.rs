//! A star catalog larger than the embedded one, for measurements of speed.
//!
//! In: a number of stars. Out: the embedded stars and invented fainter ones, the same at each call.

use super::{Star, StarCatalog};
use crate::random::Random;

/// Growth of the number of stars with limiting magnitude: tenfold in 1 / 0.48 magnitudes. From the 15,537 embedded stars down to magnitude 7 this leads to the
/// 2.5 million of Tycho-2 at magnitude 11.6 (Hog et al. 2000, Astron. Astrophys. 355, L27: 99 % complete to 11).
const DECADES_PER_MAGNITUDE: f64 = 0.48;
/// Limiting magnitude of the embedded stars.
const EMBEDDED_MAGNITUDE_LIMIT: f64 = 7.0;

impl StarCatalog {
    /// The embedded stars and fainter invented stars, `count` in total, but at least the embedded ones. Invented stars are uniformly distributed over the sky,
    /// without motion and parallax; each has the colour index of a random embedded star.
    pub fn synthetic(count: usize) -> Self {
        let embedded = Self::embedded();
        let mut stars = embedded.stars.clone();
        let mut random = Random::new(0);
        let decades_beyond_embedded = (count.max(1) as f64 / embedded.stars.len() as f64).log10().max(0.0);
        while stars.len() < count {
            // Inverse transform sampling: the number of stars down to magnitude m, divided by the number of embedded stars, is uniformly distributed. Beyond
            // the limit of the embedded stars it grows as 10^(0.48 m).
            let count_ratio = random.between(1.0, 10_f64.powf(decades_beyond_embedded));
            let v_magnitude = EMBEDDED_MAGNITUDE_LIMIT + count_ratio.log10() / DECADES_PER_MAGNITUDE;
            let b_v = random.choose(&embedded.stars).b_v;
            stars.push(Star {
                hip: 0,
                direction: random.direction(),
                motion_per_year: glam::DVec3::ZERO,
                parallax_rad: 0.0,
                v_magnitude: v_magnitude as f32,
                b_v,
            });
        }
        Self::new(embedded.epoch_jd, stars)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn star_counts_grow_by_the_stated_decades_per_magnitude() {
        let sky = StarCatalog::synthetic(200_000);
        assert_eq!(sky.stars().len(), 200_000);
        let count_to = |limit: f32| sky.stars().iter().filter(|s| s.v_magnitude <= limit).count() as f64;
        // The 47 000 stars down to magnitude 8 have a Poisson noise of half a per cent.
        let slope = (count_to(9.0) / count_to(8.0)).log10();
        assert!((slope - DECADES_PER_MAGNITUDE).abs() < 0.02, "{slope}");
        assert_eq!(count_to(6.5), StarCatalog::embedded().stars().iter().filter(|s| s.v_magnitude <= 6.5).count() as f64);
        assert!(sky.stars().iter().any(|s| s.hip == 32349), "Sirius is in it");
    }
}

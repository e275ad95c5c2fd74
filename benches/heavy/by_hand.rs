//! The heavy shader hand-written with intrinsics, for AVX2 and for AVX-512: the reference for the tape's speed.
//!
//! Formulas and constants are those of heavy.wgsl. `exp` and `asin` use the polynomials of S. Moshier's Cephes library, `atan2` one of degree 11. x86-64 only.

use super::heavy::{UNIFORMS, lanes};

/// Half the side of the image, in body radii.
const HALF_SIDE: f32 = 1.2;
/// Height of the top of the atmosphere, in scale heights.
const TOP_HEIGHT: f32 = 8.0;
/// Samples of the air along a view ray.
const SAMPLES: u32 = 16;

/// The finest level of the texture, as linear RGBA floats.
pub struct Texels {
    pub width: i32,
    pub height: i32,
    pub linear: Vec<[f32; 4]>,
}

/// The shader over the vectors of one module of `lanes`. A macro, because a function with a target feature cannot be generic in that feature.
macro_rules! shader {
    ($module:ident, $features:literal) => {
        pub mod $module {
            use super::lanes::$module::*;
            use super::{HALF_SIDE, SAMPLES, TOP_HEIGHT, Texels, UNIFORMS};

            #[target_feature(enable = $features)]
            fn exp(x: Vector) -> Vector {
                let x = max(min(x, splat(88.0)), splat(-87.0));
                let n = round(mul(x, splat(std::f32::consts::LOG2_E)));
                let r = fma(n, splat(2.121_944_4e-4), fma(n, splat(-0.693_359_4), x));
                let mut p = splat(1.987_569_1e-4);
                for c in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 0.166_666_65, 0.5] {
                    p = fma(p, r, splat(c));
                }
                let p = add(fma(mul(r, r), p, r), splat(1.0));
                scale_by_power(p, n)
            }

            /// asin, by the half-angle formula for |x| above 1/2.
            #[target_feature(enable = $features)]
            fn asin(x: Vector) -> Vector {
                let a = abs(x);
                let large = less(splat(0.5), a);
                let z = select(mul(a, a), mul(splat(0.5), sub(splat(1.0), a)), large);
                let s = select(a, sqrt(z), large);
                let mut p = splat(4.216_32e-2);
                for c in [2.418_131_1e-2, 4.547_002_5e-2, 7.495_300_3e-2, 0.166_667_52] {
                    p = fma(p, z, splat(c));
                }
                let r = fma(mul(p, z), s, s);
                let r = select(r, fma(splat(-2.0), r, splat(std::f32::consts::FRAC_PI_2)), large);
                with_sign(r, x)
            }
            #[target_feature(enable = $features)]
            fn acos(x: Vector) -> Vector {
                sub(splat(std::f32::consts::FRAC_PI_2), asin(x))
            }

            #[target_feature(enable = $features)]
            fn atan2(y: Vector, x: Vector) -> Vector {
                let (ax, ay) = (abs(x), abs(y));
                let steep = less(ax, ay);
                let t = div(select(ay, ax, steep), max(select(ax, ay, steep), splat(1e-30)));
                let z = mul(t, t);
                let mut p = splat(-0.011_719_135);
                for c in [0.052_647_349, -0.116_432_87, 0.193_543_46, -0.332_622_85, 0.999_977_3] {
                    p = fma(p, z, splat(c));
                }
                let a = mul(p, t);
                let a = select(a, sub(splat(std::f32::consts::FRAC_PI_2), a), steep);
                let a = select(a, sub(splat(std::f32::consts::PI), a), less(x, splat(0.0)));
                with_sign(a, y)
            }

            /// Column density of air from a height out to space, as in heavy.wgsl: a length of air at ground density. All lengths are in scale heights.
            /// `cosine`: of the direction's zenith angle.
            #[target_feature(enable = $features)]
            fn column(height: Vector, cosine: Vector, body_radius: f32) -> Vector {
                let c = (std::f32::consts::FRAC_PI_2 * body_radius).sqrt();
                let below = less(cosine, splat(0.0));
                let up = mul(div(splat(c), fma(splat(c - 1.0), abs(cosine), splat(1.0))), exp(neg(height)));
                if !any(below) {
                    return up;
                }
                let s = sqrt(max(sub(splat(1.0), mul(cosine, cosine)), splat(1e-6)));
                let lowest = fma_minus(add(splat(body_radius), height), s, splat(body_radius));
                let down = sub(mul(splat(2.0 * c), exp(neg(max(lowest, splat(0.0))))), up);
                select(up, down, below)
            }

            /// Bilinear filtering at the finest level: u repeats, v is clamped.
            #[target_feature(enable = $features)]
            fn sample(map: &Texels, u: Vector, v: Vector) -> [Vector; 3] {
                let x = fma(u, splat(map.width as f32), splat(-0.5));
                let y = fma(v, splat(map.height as f32), splat(-0.5));
                let (x0, y0) = (floor(x), floor(y));
                let (fx, fy) = (sub(x, x0), sub(y, y0));
                let (xi, yi, wx, wy) = (store_i32(x0), store_i32(y0), store(fx), store(fy));
                let mut out = [[0f32; LANES]; 3];
                for lane in 0..LANES {
                    let at = |dx: i32, dy: i32| {
                        let x = (xi[lane] + dx).rem_euclid(map.width);
                        let y = (yi[lane] + dy).clamp(0, map.height - 1);
                        map.linear[(y * map.width + x) as usize]
                    };
                    let (a, b, c, d) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
                    for channel in 0..3 {
                        let top = a[channel] + (b[channel] - a[channel]) * wx[lane];
                        let bottom = c[channel] + (d[channel] - c[channel]) * wx[lane];
                        out[channel][lane] = top + (bottom - top) * wy[lane];
                    }
                }
                out.map(|channel| load(&channel))
            }

            /// Draws the entire image, top row first.
            ///
            /// # Safety
            /// The machine has the features of this module; `size` is a multiple of the lanes.
            #[target_feature(enable = $features)]
            pub unsafe fn draw(size: usize, map: &Texels, out: &mut [[f32; 4]]) {
                let [sun, occluder, air] = UNIFORMS;
                let sun_v = [splat(sun[0]), splat(sun[1]), splat(sun[2])];
                let dot_sun = |p: [Vector; 3]| fma(p[2], sun_v[2], fma(p[1], sun_v[1], mul(p[0], sun_v[0])));
                let sunlight_fraction = |p: [Vector; 3]| {
                    let to = [sub(splat(occluder[0]), p[0]), sub(splat(occluder[1]), p[1]), sub(splat(occluder[2]), p[2])];
                    let distance = sqrt(fma(to[2], to[2], fma(to[1], to[1], mul(to[0], to[0]))));
                    let separation = acos(max(min(div(dot_sun(to), distance), splat(1.0)), splat(-1.0)));
                    let radius = asin(min(div(splat(occluder[3]), distance), splat(1.0)));
                    // As smoothstep(radius - 0.05, radius + 0.05, separation).
                    let t = mul(sub(separation, sub(radius, splat(0.05))), splat(10.0));
                    let t = max(min(t, splat(1.0)), splat(0.0));
                    mul(mul(t, t), minus_product(splat(2.0), t, splat(3.0)))
                };
                let top = 1.0 + TOP_HEIGHT * air[0];
                // In scale heights.
                let body_radius = 1.0 / air[0];
                let offsets = load(&std::array::from_fn(|lane| lane as f32 + 0.5));
                let scale = 2.0 / size as f32 * HALF_SIDE;
                for row in 0..size {
                    let py = splat((1.0 - (row as f32 + 0.5) * 2.0 / size as f32) * HALF_SIDE);
                    for column_start in (0..size).step_by(LANES) {
                        let px = fma(add(splat(column_start as f32), offsets), splat(scale), splat(-HALF_SIDE));
                        let r2 = fma(px, px, mul(py, py));
                        let inside = less(r2, splat(top * top));
                        let pixels = &mut out[row * size + column_start..row * size + column_start + LANES];
                        if !any(inside) {
                            pixels.fill([0.0, 0.0, 0.0, 1.0]);
                            continue;
                        }
                        let hits = less(r2, splat(1.0));
                        let z_top = sqrt(max(sub(splat(top * top), r2), splat(0.0)));
                        let z_end = select(neg(z_top), sqrt(max(sub(splat(1.0), r2), splat(0.0))), hits);
                        let step = mul(sub(z_top, z_end), splat(1.0 / SAMPLES as f32));
                        let (mut light, mut column_to_camera) = ([splat(0.0); 3], splat(0.0));
                        for n in 0..SAMPLES {
                            let p = [px, py, minus_product(splat(n as f32 + 0.5), step, z_top)];
                            let radius = sqrt(fma(p[2], p[2], fma(p[1], p[1], mul(p[0], p[0]))));
                            let height = mul(max(sub(radius, splat(1.0)), splat(0.0)), splat(body_radius));
                            let density = mul(exp(neg(height)), step);
                            let cosine = div(dot_sun(p), radius);
                            let column_to_sun = mul(column(height, cosine, body_radius), splat(air[0]));
                            column_to_camera = add(column_to_camera, density);
                            let (total_column, sunlit_density) = (add(column_to_camera, column_to_sun), mul(density, sunlight_fraction(p)));
                            for c in 0..3 {
                                let transmittance = exp(mul(splat(-air[c + 1]), total_column));
                                light[c] = fma(mul(splat(air[c + 1]), transmittance), sunlit_density, light[c]);
                            }
                        }
                        let mut colour = light;
                        if any(hits) {
                            let p = [px, py, z_end];
                            let u = fma(atan2(px, z_end), splat(0.159_154_94), splat(0.5));
                            let v = mul(acos(max(min(py, splat(1.0)), splat(-1.0))), splat(std::f32::consts::FRAC_1_PI));
                            let ground = sample(map, u, v);
                            let sunlit = mul(max(dot_sun(p), splat(0.0)), sunlight_fraction(p));
                            for c in 0..3 {
                                let on_ground = fma(mul(ground[c], exp(mul(splat(-air[c + 1]), column_to_camera))), sunlit, light[c]);
                                colour[c] = select(light[c], on_ground, hits);
                            }
                        }
                        let lanes = colour.map(|channel| store(select(splat(0.0), channel, inside)));
                        for (lane, pixel) in pixels.iter_mut().enumerate() {
                            *pixel = [lanes[0][lane], lanes[1][lane], lanes[2][lane], 1.0];
                        }
                    }
                }
            }
        }
    };
}
shader!(avx2, "avx2,fma");
shader!(avx512, "avx512f,avx512dq");

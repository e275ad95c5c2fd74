//! The features of a draw, which determine the code of its shader. The shader key, which names the shader module, is derived from [`DrawFeatures`]
//! alone.
//!
//! Plain values: `scene::features` sets them, `shader::key` reads them. Two draws with equal features run the same shader module;
//! they may differ in their uniforms. Not here: which combinations are valid (`shader::key`), and the choice of features for a draw
//! (`scene::features`).

/// What a draw shows: ground with one of the photometric models, or another kind of surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Surface {
    /// Shines by itself, such as the Sun's photosphere.
    Emissive,
    Lambert,
    LommelSeeliger,
    LunarLambert,
    OrenNayar,
    /// The atmosphere where a view ray does not end on the ground.
    Sky,
    /// The cloud shell.
    Cloud,
    /// A flat ring of particles.
    Ring,
}

impl Surface {
    pub const ALL: [Self; 8] =
        [Self::Emissive, Self::Lambert, Self::LommelSeeliger, Self::LunarLambert, Self::OrenNayar, Self::Sky, Self::Cloud, Self::Ring];
}

/// The textures that modulate the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct MapSet {
    pub albedo: bool,
    pub normal: bool,
    /// The water mask: where water mirrors Sun and sky.
    pub specular: bool,
    /// The lights of cities.
    pub night: bool,
    /// The cloud map in the ground's draw: for the clouds' shadow and, with [`AirPass::ReadWithClouds`], also for showing the clouds themselves.
    pub cloud_shadow: bool,
}

/// The geometry: a sphere or an ellipsoid, which the fragment shader intersects, or the triangles of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Shape {
    Sphere,
    Ellipsoid,
    Mesh,
}

/// How the visible part of the Sun's disc is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum EclipseModel {
    #[default]
    None,
    /// The visible part changes linearly with the distance between the centres of the discs, from external to internal contact.
    Linear,
    /// Exact overlap of uniform discs.
    UniformDisc,
    /// Overlap of discs, with quadratic limb darkening of the Sun per colour channel.
    LimbDarkened,
    /// Like `LimbDarkened`; in addition, the first occluder's atmosphere refracts reddened light into that occluder's umbra.
    Refracted,
}

impl EclipseModel {
    pub const ALL: [Self; 5] = [Self::None, Self::Linear, Self::UniformDisc, Self::LimbDarkened, Self::Refracted];
    /// The models that a user may choose.
    pub const CHOICES: [Self; 4] = [Self::Linear, Self::UniformDisc, Self::LimbDarkened, Self::Refracted];

    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Linear => "linear",
            Self::UniformDisc => "uniform-disc",
            Self::LimbDarkened => "limb-darkened",
            Self::Refracted => "refracted",
        }
    }
}

/// Number of occluders, and the model of their shadows. Either both are set or neither is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct Eclipse {
    /// At most [`MAX_OCCLUDERS`].
    pub occluders: u8,
    pub model: EclipseModel,
}

impl Eclipse {
    /// This eclipse in the shadow of another body's rings, where the simpler models give way to `LimbDarkened`: this halves the number of keys with both.
    pub(crate) fn beside_ring_shadow(self) -> Self {
        match self.model {
            EclipseModel::Linear | EclipseModel::UniformDisc => Self { model: EclipseModel::LimbDarkened, ..self },
            EclipseModel::None | EclipseModel::LimbDarkened | EclipseModel::Refracted => self,
        }
    }
}

/// Maximum number of occluders of a draw.
pub const MAX_OCCLUDERS: u8 = 4;

/// The shadow of rings on a globe, its air and its clouds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum RingShadow {
    #[default]
    None,
    /// Of the body's own rings: one ray to the Sun's centre.
    PointSun,
    /// Of the body's own rings: the transmittance averaged over the Sun's disc.
    Penumbra,
    /// Of the rings of another body, such as a moon's planet: read from a grid of places (`scene::rings::shadow_grid`).
    OfPlanet,
}

impl RingShadow {
    pub const ALL: [Self; 4] = [Self::None, Self::PointSun, Self::Penumbra, Self::OfPlanet];

    /// Whether it is the shadow of the body's own rings.
    pub const fn is_of_own_rings(self) -> bool {
        matches!(self, Self::PointSun | Self::Penumbra)
    }
}

/// The planet's shadow on its ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum BodyShadow {
    #[default]
    None,
    /// A spherical planet and a point Sun.
    Sphere,
    /// An ellipsoidal planet and the Sun's disc.
    EllipsoidPenumbra,
}

impl BodyShadow {
    pub const ALL: [Self; 3] = [Self::None, Self::Sphere, Self::EllipsoidPenumbra];
}

/// How the in-scattered light of the atmosphere is computed. The numbers of samples are maxima: by day, a ray along which the height only increases or only
/// decreases needs fewer (shaders/lib/air/sample_counts.wesl).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum AtmosphereModel {
    #[default]
    None,
    /// Five samples along each pixel's view ray. Nothing is computed per vertex: the name is that of a similar model of an older engine.
    Vertex,
    /// Eight samples along each pixel's view ray; the optical depth towards the Sun is analytic.
    Pixel8,
    /// As `Pixel8`, with 16 samples.
    Pixel16,
    /// As `Pixel8`, with 32 samples.
    Pixel32,
    /// As `Pixel16`, with the light of higher orders of scattering from a table.
    Table,
}

impl AtmosphereModel {
    pub const ALL: [Self; 6] = [Self::None, Self::Vertex, Self::Pixel8, Self::Pixel16, Self::Pixel32, Self::Table];
    /// The models that a user may choose.
    pub const CHOICES: [Self; 5] = [Self::Vertex, Self::Pixel8, Self::Pixel16, Self::Pixel32, Self::Table];

    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Vertex => "vertex",
            Self::Pixel8 => "pixel-8",
            Self::Pixel16 => "pixel-16",
            Self::Pixel32 => "pixel-32",
            Self::Table => "table",
        }
    }
}

/// The atmosphere: Rayleigh scattering is always included, the other species by flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct Air {
    pub model: AtmosphereModel,
    /// An aerosol such as haze or dust, which scatters mainly forward.
    pub mie: bool,
    /// A layer that only absorbs.
    pub absorption: bool,
}

/// The role of a draw with respect to the coarse image of the air, an image with fewer texels than the screen has pixels. This image holds the light of the
/// air, and the sunlight that passes the occluders to the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum AirPass {
    /// Each pixel evaluates the light of the air.
    #[default]
    None,
    /// The pixels read the image where its interpolation is accurate enough, and evaluate the light elsewhere.
    Read,
    /// The draw fills the image with the light of the air.
    Drawn,
    /// As `Read`. In addition, in the pixels that read the image, the ground's draw also shows the clouds; the clouds' own draw shows them in the others.
    ReadWithClouds,
    /// The draw fills the image with the sunlight that passes the occluders.
    SunlightDrawn,
}

impl AirPass {
    pub const ALL: [Self; 5] = [Self::None, Self::Read, Self::Drawn, Self::ReadWithClouds, Self::SunlightDrawn];

    /// Whether the draw reads the image.
    pub const fn is_reader(self) -> bool {
        matches!(self, Self::Read | Self::ReadWithClouds)
    }

    /// Whether the draw fills a part of the image.
    pub const fn fills_image(self) -> bool {
        matches!(self, Self::Drawn | Self::SunlightDrawn)
    }
}

/// Properties of a mesh; all `false` for other shapes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct MeshFlags {
    /// Both sides of each triangle are visible.
    pub two_sided: bool,
    /// The albedo map's alpha makes the mesh transparent.
    pub alpha_texture: bool,
    /// The vertices have colours, which multiply the albedo.
    pub vertex_colour: bool,
}

/// Factor on the number of texture reads in the green channel of [`PixelView::Cost`]; the red channel shows the number of instructions. With this factor, 16
/// reads are as bright as 16384 instructions, so that reads and instructions are both visible.
pub const INSTRUCTIONS_PER_READ: f64 = 1024.0;

/// The quantity that a pixel shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum PixelView {
    #[default]
    Final,
    /// Depth relative to the body's centre, along the line from the camera to it: 0.5 at the centre's depth, 1 one radius (of a ring, its outer radius) in
    /// front of it, 0 one radius behind it.
    Depth,
    /// The normal in body axes; -1 to 1 is shown as 0 to 1.
    Normal,
    Albedo,
    /// Coordinates in the maps; on a ring, radius and longitude.
    Uv,
    /// Irradiance on the surface by the Sun and by bodies and rings that reflect its light, with shadows.
    Sunlight,
    /// Fraction of sunlight that passes the occluders.
    Eclipse,
    /// Transmittance of the ring for sunlight; on the ring itself, its opacity along the view ray.
    Ring,
    /// Optical depth of the air, or of the ring, along the view ray, per channel.
    OpticalDepth,
    /// Cost of the pixel: the shader module is that of the final image, and the renderer counts the module's operations.
    Cost,
}

impl PixelView {
    pub const ALL: [Self; 10] = [
        Self::Final,
        Self::Depth,
        Self::Normal,
        Self::Albedo,
        Self::Uv,
        Self::Sunlight,
        Self::Eclipse,
        Self::Ring,
        Self::OpticalDepth,
        Self::Cost,
    ];

    /// The view with this name, whatever the case of its letters; `None` if there is none.
    pub fn by_name(name: &str) -> Option<Self> {
        // Earlier versions called the final image `shaded`.
        let known = Self::ALL.map(|v| (v.name(), v)).into_iter().chain([("shaded", Self::Final)]);
        known.into_iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, v)| v)
    }

    /// Whether the pixel shows radiance or, in the cost view, what it costs to compute that radiance.
    pub(crate) fn shows_radiance(self) -> bool {
        matches!(self, Self::Final | Self::Cost)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Final => "final",
            Self::Depth => "depth",
            Self::Normal => "normal",
            Self::Albedo => "albedo",
            Self::Uv => "uv",
            Self::Sunlight => "sunlight",
            Self::Eclipse => "eclipse",
            Self::Ring => "ring",
            Self::OpticalDepth => "optical-depth",
            Self::Cost => "cost",
        }
    }
}

/// Procedural relief and albedo finer than a body's maps, computed by shaders/lib/detail.wesl.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Detail {
    #[default]
    None,
    /// Craters, on old ground without air.
    Craters,
    /// Hills and hollows, on ground under air.
    Hills,
    /// Billows of a cloud deck.
    Billows,
}

impl Detail {
    pub const ALL: [Self; 4] = [Self::None, Self::Craters, Self::Hills, Self::Billows];
}

/// Maximum number of lights that the air scatters: the Sun, and the strongest light of another body.
pub const MAX_AIR_LIGHTS: u8 = 2;

/// Maximum number of custom surfaces (the user's WESL functions that colour the ground) in one run.
pub const MAX_CUSTOM_SURFACES: u8 = 4;

/// The features of one draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct DrawFeatures {
    pub surface: Surface,
    pub maps: MapSet,
    /// Relief and albedo finer than the maps.
    pub detail: Detail,
    /// Number of the custom surface that colours the ground: 0 for none, else 1..=[`MAX_CUSTOM_SURFACES`].
    pub custom_surface: u8,
    /// Number of images blended over the albedo by their alpha, at most `catalog::MAX_OVERLAYS`.
    pub overlays: u8,
    /// Number of lights, at most `scene::thresholds::MAX_LIGHTS`: the Sun first, then bodies that reflect light.
    pub lights: u8,
    pub eclipse: Eclipse,
    /// Shadow of rings on the globe.
    pub ring_shadow: RingShadow,
    /// Whether ring-shine lights the globe.
    pub ring_shine: bool,
    /// Shadow of the globe on the rings.
    pub body_shadow: BodyShadow,
    pub air: Air,
    /// Whether the draw reads or fills the coarse image of the air, or neither.
    pub air_pass: AirPass,
    pub shape: Shape,
    /// Whether the draw uses the heights of the lunar limb profile. In the Moon's draw they shape the Moon's limb, in the Sun's draw the edge of the part that
    /// the Moon hides.
    pub limb_heights: bool,
    /// Whether pixels at the limb show the mean light over their area. A draw of the sky averages the light of the air beyond the limb; other draws average
    /// the light of a thin crescent with that of the air in front of it.
    pub thin_limb: bool,
    pub flags: MeshFlags,
    pub view: PixelView,
}

impl DrawFeatures {
    /// The minimal features: a black sphere.
    pub const MINIMAL: Self = Self {
        surface: Surface::Lambert,
        maps: MapSet { albedo: false, normal: false, specular: false, night: false, cloud_shadow: false },
        detail: Detail::None,
        custom_surface: 0,
        overlays: 0,
        lights: 0,
        eclipse: Eclipse { occluders: 0, model: EclipseModel::None },
        ring_shadow: RingShadow::None,
        ring_shine: false,
        body_shadow: BodyShadow::None,
        air: Air { model: AtmosphereModel::None, mie: false, absorption: false },
        air_pass: AirPass::None,
        shape: Shape::Sphere,
        limb_heights: false,
        thin_limb: false,
        flags: MeshFlags { two_sided: false, alpha_texture: false, vertex_colour: false },
        view: PixelView::Final,
    };

    /// The features of the draw that fills the coarse image of this draw's air; `None` if this draw reads no such image.
    pub fn coarse_air(&self) -> Option<Self> {
        self.air_pass.is_reader().then_some(Self {
            // Lambert stands for any ground: the air's light does not depend on the ground's photometric model.
            surface: if self.surface == Surface::Cloud { Surface::Cloud } else { Surface::Lambert },
            lights: self.lights.min(MAX_AIR_LIGHTS),
            eclipse: self.eclipse,
            air: self.air,
            air_pass: AirPass::Drawn,
            shape: self.shape,
            ..Self::MINIMAL
        })
    }

    /// The features of the draw that fills the coarse image with the sunlight that passes the occluders to this draw's ground; `None` if this draw does not
    /// read that sunlight.
    pub fn coarse_sunlight(&self) -> Option<Self> {
        let reads = self.air_pass.is_reader() && self.eclipse.occluders > 0 && self.surface != Surface::Cloud;
        reads.then_some(Self { lights: 1, eclipse: self.eclipse, air_pass: AirPass::SunlightDrawn, shape: self.shape, ..Self::MINIMAL })
    }
}

//! The seeds: valid inputs, which are mutated. They are short, so that each part is changed often.

use orrery::shader::fragments::FRAGMENTS;
use std::io::Cursor;

/// A catalog to which each fuzzed catalog file is added: a star and a planet to which its entries can refer. The embedded catalog would take a hundred times as
/// long.
pub const BASE: &str = r#"[[body]]
id = 10
name = "Sun"
kind = "star"
radii_km = [695700.0, 695700.0, 695700.0]
geometric_albedo = 0.0
colour_linear_srgb = [1.0, 1.0, 1.0]
photometry = { model = "emissive", u1 = [0.4, 0.5, 0.6], u2 = [0.2, 0.2, 0.2] }
rotation = { model = "pck" }
motion = { theory = "planetary" }
[[body]]
id = 499
name = "Mars"
kind = "planet"
parent = "Sun"
radii_km = [3396.19, 3396.19, 3376.2]
geometric_albedo = 0.17
colour_linear_srgb = [1.4, 0.9, 0.5]
photometry = { model = "oren-nayar", roughness_deg = 18.0 }
rotation = { model = "pck" }
motion = { theory = "planetary" }
"#;

/// A catalog file with a moon, a ring and an atmosphere.
pub const BODY: &str = r#"[[body]]
id = 401
name = "Phobos"
aliases = ["fear"]
kind = "moon"
parent = "Mars"
radii_km = [13.0, 11.4, 9.1]
geometric_albedo = 0.07
colour_linear_srgb = [1.0, 1.0, 1.0]
photometry = { model = "lunar-lambert", lunar_weight = 0.5 }
rotation = { model = "pck" }
motion = { theory = "planetary" }
[body.maps.albedo]
file = "a.png"
gain = [1.0, 1.0, 1.0]
[[ring]]
body = "Mars"
name = "dust"
inner_km = 4e3
outer_km = 5e3
tau_normal = 0.1
[[atmosphere]]
body = "Mars"
top_km = 80.0
[[atmosphere.species]]
name = "dust"
scale_height_km = 11.0
scattering_per_km = [0.1, 0.2, 0.3]
"#;

/// Catalog files with one overlay of each projection.
pub const OVERLAYS: [&str; 2] = [
    r#"[[overlay]]
body = "Mars"
name = "map"
file = "a.png"
gain = [1.0, 1.0, 1.0]
opacity = 0.5
projection = "equirectangular"
west_deg = -10.0
east_deg = 10.0
south_deg = -5.0
north_deg = 5.0
"#,
    r#"[[overlay]]
body = "mars"
name = "photograph"
file = "b.jpg"
projection = "orthographic"
latitude_deg = 10.0
longitude_deg = 20.0
width_km = 300.0
height_km = 200.0
"#,
];

/// Catalog files with one moment of each kind of viewpoint: above the target's side that faces a body, over a place, from a body.
pub const MOMENTS: [&str; 3] = [
    r#"[[moment]]
name = "then"
kind = "transit"
about = "There."
time = "2024-04-08T18:17:16Z"
target = "Mars"
source = "none"
side = "Sun"
radii = 3.0
"#,
    r#"[[moment]]
name = "there"
kind = "rings"
about = "Then."
time = "1979-03-05T12:05:00Z"
target = "Sun"
source = "none"
over = "Mars"
latitude_deg = 1.0
longitude_deg = 2.0
height_km = 3.0
fov_deg = 40.0
"#,
    r#"[[moment]]
name = "from"
kind = "photograph"
about = "So."
time = "1990-02-14T04:48:00Z"
target = "Sun"
source = "none"
from = "Mars"
fov_deg = 0.4
"#,
];

/// Star tables: with named columns, and as hip2.dat.
pub const STARS: [&str; 2] = [
    "# name,RA_deg(ICRS, J1991.25),dec_deg,V,plx,pmRA,pmDec,B-V,rv_km_s\nVega,279.23,38.78,0.03,130.2,200.9,286.2,-0.001,-20.6\nx,0,0,6,,,,,\n",
    // The line of Vega in hip2.dat: van Leeuwen 2007, CDS I/311.
    " 91262   5 0 1  4.8735540000  0.6769140000  130.23   200.94   286.23   0.33   0.36   0.36   0.37   0.44 114  1.33  0    0.0    0  0.0868 \
     0.0017 0.005 1 -0.001 0.003 -0.010\n",
];

/// A data layer in each format, after a byte that chooses the format and whether the layer belongs to a body or to the sky: see `data_layer` in targets.rs.
pub fn layers() -> Vec<Vec<u8>> {
    // One block of 2880 bytes with the header, whose cards have 80 characters, and one with the data.
    let fits = |cards: &[&str]| {
        let cards = cards.iter().chain(&["END"]).map(|card| format!("{card:<80}")).collect::<String>();
        let mut bytes = format!("{cards:<2880}").into_bytes();
        bytes.resize(2 * 2880, 7);
        bytes
    };
    let size = [
        "SIMPLE  =                    T",
        "BITPIX  =                    8",
        "NAXIS   =                    2",
        "NAXIS1  =                    4",
        "NAXIS2  =                    2",
    ];
    let wcs = [
        "CTYPE1  = 'RA---TAN'",
        "CTYPE2  = 'DEC--TAN'",
        "CRVAL1  = 10.0",
        "CRVAL2  = 20.0",
        "CRPIX1  = 2.5",
        "CRPIX2  = 1.5",
        "CDELT1  = -0.01",
        "CDELT2  = 0.01",
    ];
    // The first byte modulo 5 is the format: CSV, VOTable, GeoJSON, KML, FITS. From 128 on, the layer belongs to the sky.
    let texts: [(u8, &str); 4] = [
        (0, "time,lat,lon,colour\n2024-04-08,1,2,#ff0000\n,\"3\",4,\n"),
        (
            131,
            "<VOTABLE><RESOURCE><TABLE><FIELD name=\"ra\" unit=\"deg\"/><FIELD name=\"x\" ucd=\"pos.eq.dec\"/>\
             <DATA><TABLEDATA><TR><TD>1</TD><TD>&#50;</TD></TR></TABLEDATA></DATA></TABLE></RESOURCE></VOTABLE>",
        ),
        (
            2,
            r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"time":1.7e12},
"geometry":{"type":"Polygon","coordinates":[[[1,2],[3,4],[5,6],[1,2]]]}}]}"#,
        ),
        (
            3,
            "<kml><Placemark><TimeSpan><begin>2024</begin></TimeSpan><LineString><coordinates>1,2,3 4,5</coordinates></LineString></Placemark></kml>",
        ),
    ];
    let with_first_byte = |first: u8, content: &[u8]| [&[first], content].concat();
    let mut all: Vec<_> = texts.iter().map(|(first, text)| with_first_byte(*first, text.as_bytes())).collect();
    all.push(with_first_byte(4, &fits(&size)));
    all.push(with_first_byte(134, &fits(&[&size[..], &wcs].concat())));
    all
}

/// A text kernel with the pole and prime meridian of Mars.
pub const PCK: &str = "\\begindata\nBODY4_NUT_PREC_ANGLES = ( 190.7 19139.8 21.4 38280.7 )\nBODY4_MAX_PHASE_DEGREE = 1\nBODY499_POLE_RA = ( 317.2 \
    -0.1 0. )\nBODY499_POLE_DEC = ( 54.4 -6.1D-2 0. )\nBODY499_PM = ( 176.0 350.89 0. )\nBODY499_NUT_PREC_RA += ( 0 0.4 )\n\\begintext\n";

/// The settings file of the window.
pub const SETTINGS: &str = r#"{"dark":null,"zoom":1.2,"names":true,"unit":"miles","home":{"latitude_deg":51.5,"longitude_deg":0},"place":null,
"bookmarks":[{"name":"a","view":{"target":699,"eye":{"kind":"orbit","body":699},"time":"2024-01-01T00:00:00Z"}}],"recent":[]}"#;

/// Seeds with the text of the built-in fragment at `path`: one, or none if there is no such fragment.
pub fn fragment(path: &str) -> Vec<Vec<u8>> {
    FRAGMENTS.iter().filter(|(name, _)| *name == path).map(|(_, text)| text.as_bytes().to_vec()).collect()
}

/// Tables of minor planets: CSV, JSON of JPL's database, MPCORB.DAT.
pub const MINOR_PLANETS: [&str; 3] = [
    "name,e,a_au,i_deg,node_deg,argp_deg,M_deg,epoch_mjd,H,G\nCeres,0.0789125,2.7672543,10.58769,80.25498,73.42179,60.07881,60200,3.34,0.15\n",
    r#"{"signature":{"version":"1.0"},"fields":["full_name","epoch.mjd","e","a","i","om","w","ma","H","G"],
"data":[["     1 Ceres (A801 AA)",60200,".0789125","2.7672543",10.58769,"80.25498","73.42179","60.07881","3.34",null]]}"#,
    "00001    3.34  0.15 K239D  60.07881   73.42179   80.25498   10.58769  0.0789125  0.21410522   2.7672543\n",
];

/// A tour with two stops: one as JSON, one as a link.
pub const TOUR: &str = r#"{"title":"a","stops":[
{"view":{"target":"saturn","eye":{"kind":"orbit","body":699},"time":"2024-01-01T00:00:00Z"},"text":"b","hold_s":3,"travel_s":2},
{"view":"orrery://view?target=599&eye.kind=orbit&eye.body=599","text":"c","time_rate":60,"hold_s":1,"travel_s":0}]}"#;

/// Lunar height maps of 4 x 2 heights, 16 bits each: a PDS image with its label, a grey PNG, a TIFF. Two bytes precede each: the format, and the label's
/// length in units of 4 bytes (0 without a label).
pub fn lunar_heights() -> Vec<Vec<u8>> {
    let mut label = "PDS_VERSION_ID = PDS3\n^IMAGE = \"A.IMG\"\nOBJECT = IMAGE\nLINES = 2\nLINE_SAMPLES = 4\nSAMPLE_TYPE = LSB_INTEGER\nSAMPLE_BITS = 16\n\
        SCALING_FACTOR = 0.5\nOFFSET = 1737400.\nUNIT = METER\nEND_OBJECT = IMAGE\n\
        OBJECT = IMAGE_MAP_PROJECTION\nMAP_PROJECTION_TYPE = \"SIMPLE CYLINDRICAL\"\n\
        WESTERNMOST_LONGITUDE = 0. <DEG>\nEND_OBJECT = IMAGE_MAP_PROJECTION\nEND\n"
        .to_owned();
    label.push_str(&" ".repeat(label.len().next_multiple_of(4) - label.len()));
    let encoded = |format| {
        let mut bytes = Cursor::new(Vec::new());
        image::DynamicImage::new_luma16(4, 2).write_to(&mut bytes, format).expect("written");
        bytes.into_inner()
    };
    let tiff = {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).expect("a header");
        encoder.write_image::<tiff::encoder::colortype::Gray16>(4, 2, &[20_000; 8]).expect("heights");
        bytes.into_inner()
    };
    let label_length_in_fours = u8::try_from(label.len() / 4).expect("a short label");
    vec![
        [&[0, label_length_in_fours], label.as_bytes(), &[1; 16]].concat(),
        [&[1, 0], encoded(image::ImageFormat::Png).as_slice()].concat(),
        [&[2, 0], tiff.as_slice()].concat(),
    ]
}

/// The example queries of `probe`.
pub fn probe_queries() -> Vec<Vec<u8>> {
    // The help text has a line with an example query for each kind.
    let help = orrery::probe::queries_text();
    help.lines().filter(|l| l.trim().starts_with("{\"q\"")).map(|l| l.trim().as_bytes().to_vec()).collect()
}

/// A PNG of 4 x 4 pixels with a text chunk.
pub fn small_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 4);
    encoder.set_color(png::ColorType::Rgba);
    encoder.add_itxt_chunk("Request".into(), "{}".into()).expect("a chunk");
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[127; 64]).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

/// A JPEG of 16 x 8 pixels.
pub fn small_jpeg() -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image::DynamicImage::new_rgb8(16, 8).write_to(&mut bytes, image::ImageFormat::Jpeg).expect("written");
    bytes.into_inner()
}

/// A grey EXR image. `text`: the provenance that the program writes into the header of its images.
pub fn exr(width: u32, height: u32, text: Option<&str>) -> Vec<u8> {
    let (mut bytes, no_comments) = (Vec::new(), "");
    orrery::image::write_exr(&mut bytes, width, height, &vec![[0.5; 4]; (width * height) as usize], no_comments, text).expect("written");
    bytes
}

// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every claim of Cozzi (2007), in the document's own words and order, and how this study tests it.
//!
//! [`Claimed::words`] are quoted to the letter; a test compares them with the document where a copy of it
//! lies beside the repository. The document numbers five sections 4.5, so places have their titles.
//! Its tables are pictures that are not handed down: a claim without a figure may have had one there.

use terrafill_results::Claim;

/// What the document bases a claim on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Basis {
    /// It gives a figure, or says that it timed or counted.
    Measured,
    /// It saw it happen.
    Observed,
    /// It expects it.
    Anticipated,
    /// It names a possibility.
    Considered,
}

impl Basis {
    pub(crate) const ALL: [Self; 4] = [
        Self::Measured,
        Self::Observed,
        Self::Anticipated,
        Self::Considered,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Observed => "observed",
            Self::Anticipated => "anticipated",
            Self::Considered => "considered",
        }
    }
}

/// What draws instead of volumes, of the techniques of this run: its name, and the value of its knob.
pub(crate) type Rival = (&'static str, (&'static str, &'static str));

/// Views in which a claim is tested.
pub(crate) type Views = &'static [&'static str];

/// The document's three views: all regions small, one from above (as scenes call it, by two names), along
/// the horizon.
pub(crate) const EVERY_VIEW: Views = &["globe", "top-down", "fill", "horizon"];
const HORIZON: Views = &["horizon"];
const GLOBE: Views = &["globe"];

/// How a claim is tested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Test {
    /// By the gain of a step of the vertex shader's ladder: time without it over time with it.
    Step(&'static str, Claim, Views),
    /// The same, only where the frustum holds every region.
    StepWithAllInSight(&'static str, Claim),
    /// The same, only where the step changes how many vertices are drawn: an eye inside every volume needs
    /// its caps, and says nothing of leaving them out.
    StepWhereItActs(&'static str, Claim, Views),
    /// By a counter of that ladder: its value without the step over that with it.
    Counter(&'static str, &'static str, Claim, Views),
    /// The step gains more than any other of the document's own steps.
    LargestGain(&'static str, Views),
    /// The step's picture is right.
    RightPicture(&'static str, Views),
    /// By the share of the second pass in the GPU time of the document's fill.
    SecondPass(Views),
    /// By the exponents of time over vertices and over fragments.
    FillRate,
    /// By the ratio of two textured fills: an index of the textured section's comparisons.
    Textured(usize, Claim),
    /// Largest texel error by angles about the body's centre beside that by barycentric coordinates.
    FlatMesh,
    /// Textured over plain is more along the horizon than elsewhere.
    TexturedWorstAtHorizon,
    /// By a formula alone: the sum, and what it should give.
    Sum {
        /// The formula with its figures.
        formula: &'static str,
        /// What it gives.
        gives: u64,
        /// What the document says.
        says: u64,
    },
    /// By the bytes of a geometry shader's layout over those of the vertex shader's.
    GeometryShaderBytes(Claim),
    /// Centric normals give right pictures on terrain.
    CentricNormals,
    /// Every plain picture is right on surfaces of more than one kind.
    SurfaceIndependence,
    /// By the fills of the coarsest and the finest mesh.
    Subdivision,
    /// By figures of a rival over those of volumes, all of them more than 1.
    CostsMore(Rival, &'static [&'static str]),
    /// By the time of a rival over that of volumes.
    TimeOverVolumes(Rival, Claim),
    /// By pixels of a rival that are wrong farther than a pixel from a boundary: there are some.
    WrongPixels(Rival),
    /// Not at all, and why.
    No(&'static str),
}

/// A claim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Claimed {
    /// To the letter.
    pub(crate) words: &'static str,
    /// Section and its title.
    pub(crate) place: &'static str,
    /// What it is based on.
    pub(crate) basis: Basis,
    /// The document's figure; empty without one in its text.
    pub(crate) figure: &'static str,
    /// What is tried here.
    pub(crate) experiment: &'static str,
    /// How.
    pub(crate) test: Test,
}

const fn claimed(
    words: &'static str,
    place: &'static str,
    basis: Basis,
    figure: &'static str,
    experiment: &'static str,
    test: Test,
) -> Claimed {
    Claimed {
        words,
        place,
        basis,
        figure,
        experiment,
        test,
    }
}

const ABSTRACT: &str = "abstract";
const ALGORITHMS: &str = "2.1.2 Potential Algorithms";
const CPU: &str = "2.1.4 CPU Implementation";
const GS: &str = "2.1.5 GS-based Implementation";
const MAPPING: &str = "2.1.6 Texture Mapping";
const OPTIMIZATIONS: &str = "2.1.7 Optimizations";
const SILHOUETTE: &str = "2.1.7.1 Silhouette Edges";
const TRADE: &str = "2.1.7.2 CPU Time and Main Memory vs. Fill Rate";
const MAIN_MEMORY: &str = "2.1.7.3 Main Memory";
const VS_ALGORITHM: &str = "4.2 Vertex Shader Algorithm";
const GS_ALGORITHM: &str = "4.3 Geometry Shader Algorithm";
const TEXTURED_FILL: &str = "4.4 Textured Fill";
const MEMORY: &str = "4.5 Memory Usage";
const PERFORMANCE: &str = "4.5 Performance";
const TEXTURED: &str = "4.5 Textured Fill Performance";
const FUTURE: &str = "4.5 Future Performance Ideas";
const IDEAS: &str = "4.6 Future Implementation Ideas";

/// A factor that the document gives in whole frames a second or as a word, and by how much it may be off.
const fn factor(of: f64, within: f64) -> Claim {
    Claim::Factor { of, within }
}

use Basis::{Anticipated, Considered, Measured, Observed};
use Claim::{AtLeast, Faster, NoDifference, NotFaster};
use Test::{
    CentricNormals, CostsMore, Counter, FillRate, FlatMesh, GeometryShaderBytes, LargestGain, No,
    RightPicture, SecondPass, Step, StepWhereItActs, StepWithAllInSight, Subdivision, Sum,
    SurfaceIndependence, Textured, TexturedWorstAtHorizon, TimeOverVolumes, WrongPixels,
};

const NO_MOTION: &str = "nothing moves in this study: the study moving times regions that do";

/// The region's triangles at one height: the “original fill”.
const FLAT: Rival = ("flat-mesh", ("height-m", "top"));
/// The region cut along the surface's triangles, with room between both, and without.
const DRAPED: Rival = ("draped-mesh", ("depth-offset", "2^-10"));
const DRAPED_ONTO: Rival = ("draped-mesh", ("depth-offset", "0"));
/// All regions in the smallest texture.
const SMALL_MASK: Rival = ("mask-texture", ("size", "1024"));
const NO_PICTURE: &str = "it is about how a fill looks, which no figure here says";

/// Every claim, in the document's order.
pub(crate) const CLAIMS: [Claimed; 63] = [
    claimed(
        "independent of the terrain rendering algorithm",
        ABSTRACT,
        Observed,
        "",
        "all plain fills on scenes whose surfaces are made in different ways",
        SurfaceIndependence,
    ),
    claimed(
        "reduces preprocessing, main memory, and CPU-GPU bandwidth",
        ABSTRACT,
        Anticipated,
        "",
        "bytes of the geometry shader's layouts over the vertex shader's; preprocessing is not timed, and \
         kept buffers need no bandwidth by either",
        GeometryShaderBytes(Claim::LessThan(1.0)),
    ),
    claimed(
        "Since preprocessing is kept minimal, the regions can be dynamic.",
        ABSTRACT,
        Observed,
        "",
        "",
        No(NO_MOTION),
    ),
    claimed(
        "creating the mesh and its LODs will be slow and potentially consume a lot of memory",
        ALGORITHMS,
        Anticipated,
        "",
        "draped-mesh, cut on the CPU along the surface as drawn, ÷ volumes: time to prepare, and bytes",
        CostsMore(DRAPED, &["prepare_cpu_ms", "geometry_bytes"]),
    ),
    claimed(
        "z-fighting is likely to become an issue between the mesh and the terrain",
        ALGORITHMS,
        Anticipated,
        "",
        "draped-mesh without room between it and the surface: pixels that are wrong away from boundaries",
        WrongPixels(DRAPED_ONTO),
    ),
    claimed(
        "If it is too small, it will be pixellated when zoomed in and will not represent the true boundary.",
        ALGORITHMS,
        Observed,
        "",
        "mask-texture of 1,024 texels: pixels that are wrong more than a pixel away from the true boundary",
        WrongPixels(SMALL_MASK),
    ),
    claimed(
        "this does not work when the viewer is in the shadow volume",
        CPU,
        Observed,
        "",
        "",
        No(
            "a picture that is wrong on purpose is no row of a run; the tests draw it, and it is wrong \
             (`counting_in_front_is_wrong_from_inside_and_the_automatic_rule_knows`)",
        ),
    ),
    claimed(
        "with use of the double sided stencil buffer, they can be rendered in a single pass",
        CPU,
        Observed,
        "",
        "the step two-sided: its picture",
        RightPicture("two-sided", EVERY_VIEW),
    ),
    claimed(
        "The total memory requires are 31,986 bytes.",
        GS,
        Measured,
        "31,986 B",
        "the sum",
        Sum {
            formula: "1,056 vertices × 24 B + 3,321 indices × 2 B",
            gives: 1_056 * 24 + 3_321 * 2,
            says: 31_986,
        },
    ),
    claimed(
        "increases six fold times to a total of 90,540 bytes, near 3 times the original",
        GS,
        Measured,
        "90,540 B, 2.83 ×",
        "the sum",
        Sum {
            formula: "vertices × 2 and indices × 6: 1,056 × 48 B + 3,321 × 12 B",
            gives: 1_056 * 48 + 3_321 * 12,
            says: 90_540,
        },
    ),
    claimed(
        "Each volume is 8 triangles with 6 unique vertices and 24 indices.",
        GS,
        Observed,
        "24 indices: × 8, not × 6",
        "the sum with 24 indices for each of 1,107 triangles, beside the document's total of 90,540 B",
        Sum {
            formula: "1,056 × 48 B + 1,107 × 24 × 2 B",
            gives: 1_056 * 48 + 1_107 * 24 * 2,
            says: 90_540,
        },
    ),
    claimed(
        "Russia which has 50x the number of triangles than California",
        GS,
        Measured,
        "50 ×",
        "",
        No("its meshes are not published"),
    ),
    claimed(
        "is much more involved but should avoid precision problems",
        MAPPING,
        Considered,
        "",
        "angles by the device's arctangent ÷ barycentric coordinates in two triangles: largest error, texels",
        FlatMesh,
    ),
    claimed(
        "Creating a separate volume for each triangle is almost certainty unreasonable.",
        OPTIMIZATIONS,
        Anticipated,
        "",
        "the step one-volume: gain",
        Step("one-volume", Faster, EVERY_VIEW),
    ),
    claimed(
        "This should significantly reduce the fill rate.",
        SILHOUETTE,
        Anticipated,
        "",
        "the step one-volume along the horizon, where the document sees the problem: stencil fragments before ÷ \
         after, at least 2",
        Counter("one-volume", "stencil_fragments", AtLeast(2.0), HORIZON),
    ),
    claimed(
        "The primary boost in fill rate performance will be from the silhouette edge detection.",
        TRADE,
        Anticipated,
        "",
        "the step one-volume: its gain beside those of the document's other steps",
        LargestGain("one-volume", HORIZON),
    ),
    claimed(
        "the extra subdivision is not going to payoff",
        TRADE,
        Anticipated,
        "",
        "the sweep through the cap step: time of the finest mesh ÷ that of the coarsest",
        Subdivision,
    ),
    claimed(
        "make the wall even lower",
        TRADE,
        Considered,
        "",
        "walls over the heights drawn there, as everywhere here, beside ± 12 km (walls-global): stencil \
         fragments",
        Counter(
            "walls-global",
            "stencil_fragments",
            Claim::LessThan(1.0),
            HORIZON,
        ),
    ),
    claimed(
        "degrade performance for dynamic regions by making the application CPU bound",
        TRADE,
        Anticipated,
        "",
        "",
        No(NO_MOTION),
    ),
    claimed(
        "reduced by not storing any normals for the mesh",
        MAIN_MEMORY,
        Considered,
        "",
        "normals-stored, 12 bytes more a vertex, beside the same geodetic normal made in the shader, which \
         loses no precision: bytes of vertices without ÷ with",
        Counter(
            "normals-stored",
            "vertex_bytes",
            Claim::LessThan(1.0),
            EVERY_VIEW,
        ),
    ),
    claimed(
        "I will have to test this for earth to see if it is reasonable.",
        MAIN_MEMORY,
        Considered,
        "",
        "centric normals on terrain: reasonable where every picture is right; how far walls are off where \
         they meet it",
        CentricNormals,
    ),
    claimed(
        "Though you would think reducing their high would improve performance, I did not observe any differences.",
        VS_ALGORITHM,
        Observed,
        "",
        "walls-global, with walls of ± 12 km instead: time",
        Step("walls-global", NoDifference, EVERY_VIEW),
    ),
    claimed(
        "The VS-based algorithm requires much more memory than the original mesh",
        VS_ALGORITHM,
        Measured,
        "2 × the vertices, 16 B for 12, 4 × the indices",
        "bytes of the geometry shader's layouts, which hold the mesh and its boundary, over those of the \
         vertex shader's: less than two thirds",
        GeometryShaderBytes(Claim::LessThan(0.67)),
    ),
    claimed(
        "then it is used to extrude the vertex downwards",
        VS_ALGORITHM,
        Observed,
        "2 px",
        "walls-pixels, with that rule: its picture",
        RightPicture("walls-pixels", EVERY_VIEW),
    ),
    claimed(
        "Virtually no preprocessing is required other than preparing the index buffer.",
        GS_ALGORITHM,
        Observed,
        "",
        "",
        No("how long scenes take to prepare is not timed in this run"),
    ),
    claimed(
        "The GS algorithm uses only about 40% of the memory as the VS algorithm",
        MEMORY,
        Measured,
        "about 40 %; 0.496 by the document's own layouts",
        "bytes of the geometry shader's layouts over those of the vertex shader's",
        GeometryShaderBytes(factor(0.40, 1.125)),
    ),
    claimed(
        "using less memory gives the VBOs a better chance of staying in video memory",
        MEMORY,
        Anticipated,
        "",
        "",
        No("no scene here is larger than the device's memory"),
    ),
    claimed(
        "textured fill on terrain using the GS algorithm gets a blazing 1 frame every 7 seconds",
        PERFORMANCE,
        Measured,
        "7 s",
        "",
        No("that emulation is not available"),
    ),
    claimed(
        "The performance goals were to match the original fill in STK which does not conform to terrain.",
        PERFORMANCE,
        Anticipated,
        "",
        "flat-mesh ÷ volumes: time; matched where it is 1 or more",
        TimeOverVolumes(FLAT, AtLeast(1.0)),
    ),
    claimed(
        "view frustum culling improved performance even when everything was visible",
        PERFORMANCE,
        Measured,
        "",
        "the step culling, where the frustum holds every region: gain",
        StepWithAllInSight("culling", Faster),
    ),
    claimed(
        "a small increase by culling backfaces during the final rendering pass",
        PERFORMANCE,
        Measured,
        "",
        "the step back-faces: gain",
        Step("back-faces", Faster, EVERY_VIEW),
    ),
    claimed(
        "a nice boost by switching vertex arrays to interleaved VBOs",
        PERFORMANCE,
        Measured,
        "",
        "the step buffers: gain. Vertex arrays do not exist here; the nearest is to hand over what is drawn \
         in every frame",
        Step("buffers", Faster, EVERY_VIEW),
    ),
    claimed(
        "have just one set of color data for all the meshes",
        PERFORMANCE,
        Considered,
        "",
        "shared-flags, beside interleaved vertices of 16 bytes: gain",
        Step("shared-flags", Faster, EVERY_VIEW),
    ),
    claimed(
        "did not change the frame rate",
        PERFORMANCE,
        Measured,
        "",
        "the step strips, for walls: gain",
        Step("strips", NoDifference, EVERY_VIEW),
    ),
    claimed(
        "This reduced the amount of memory",
        PERFORMANCE,
        Measured,
        "",
        "the step strips, for walls: bytes before ÷ after",
        Counter("strips", "geometry_bytes", AtLeast(1.001), HORIZON),
    ),
    claimed(
        "I also optimized the vertex data layout for the pre-VS cache",
        PERFORMANCE,
        Measured,
        "",
        "vertex-order, by first use: gain; the document adds “As I expected, this didn’t do anything.”",
        Step("vertex-order", NoDifference, EVERY_VIEW),
    ),
    claimed(
        "This did not result in any performance gains.",
        PERFORMANCE,
        Measured,
        "20 to 16 bytes",
        "the step vertex-size: gain",
        Step("vertex-size", NotFaster, EVERY_VIEW),
    ),
    claimed(
        "This resulted in a modest performance gain from 92 to 97 fps for the worst case of looking out along the horizon.",
        PERFORMANCE,
        Measured,
        "1.054 ×",
        "the step bottom-cap, in the colouring pass alone: gain, to half a frame a second of both figures",
        StepWhereItActs(
            "bottom-cap",
            factor(97.0 / 92.0, 97.5 / 91.5 * 92.0 / 97.0),
            HORIZON,
        ),
    ),
    claimed(
        "two texture reads (dependent) and two atan() calls which are very expensive",
        TEXTURED_FILL,
        Observed,
        "",
        "its fill ÷ the same with a texture of spherical coordinates, without an atan: time",
        Textured(10, Faster),
    ),
    claimed(
        "The textured fill is much slower than the plain fill",
        TEXTURED,
        Measured,
        "",
        "its textured fill as it was ÷ plain: time, at least 1.5",
        Textured(0, AtLeast(1.5)),
    ),
    claimed(
        "especially in the worst case of looking out along the horizon",
        TEXTURED,
        Measured,
        "",
        "its textured fill as it was ÷ plain along the horizon beside the other views",
        TexturedWorstAtHorizon,
    ),
    claimed(
        "was no faster than using a different 512x512 texture for each mesh!",
        TEXTURED,
        Measured,
        "",
        "a picture for each region ÷ one for all: time",
        Textured(5, NotFaster),
    ),
    claimed(
        "Even changing the texture size to 32x32 did not matter.",
        TEXTURED,
        Measured,
        "",
        "the scene's picture ÷ one of 32²: time",
        Textured(6, NoDifference),
    ),
    claimed(
        "Removing an unneeded normalize from the fragment shader provided a modest gain without much effort.",
        TEXTURED,
        Measured,
        "",
        "the position normalised ÷ not: time",
        Textured(7, Faster),
    ),
    claimed(
        "Even changing a vec2(v) to v.xy brought a small performance gain unless this is just an anomaly.",
        TEXTURED,
        Measured,
        "",
        "",
        No("today's compilers make one program of both"),
    ),
    claimed(
        "much more expensive than the two texture reads",
        TEXTURED,
        Observed,
        "",
        "its fill without the normalize ÷ depth and picture read alone: time, at least twice",
        Textured(11, AtLeast(2.0)),
    ),
    claimed(
        "If the atan calls can be eliminated, the performance could double.",
        TEXTURED,
        Anticipated,
        "2 ×",
        "its fill ÷ the same with a texture of spherical coordinates, without an atan: time",
        Textured(10, AtLeast(2.0)),
    ),
    claimed(
        "Approximate it with a 1D texture.",
        TEXTURED,
        Considered,
        "",
        "its fill ÷ the same with a table of 256 texels: time",
        Textured(8, Faster),
    ),
    claimed(
        "Approximate with a series.",
        TEXTURED,
        Considered,
        "",
        "its fill ÷ the same with a series of degree 7: time",
        Textured(9, Faster),
    ),
    claimed(
        "it is unclear how to create this texture efficiently",
        TEXTURED,
        Considered,
        "",
        "",
        No("one about the body's centre is made once instead: see the first claim about atan()"),
    ),
    claimed(
        "this algorithm is fill rate limited",
        TEXTURED,
        Observed,
        "",
        "exponent of time over fragments at equal vertices, beside that over vertices at equal fragments",
        FillRate,
    ),
    claimed(
        "it takes the performance hit on the 2nd pass of the algorithm when the color buffer is written to",
        TEXTURED,
        Observed,
        "",
        "the step bottom-cap: GPU time of the second pass ÷ that of both, more than half",
        SecondPass(EVERY_VIEW),
    ),
    claimed(
        "if you enable writes to the color buffer during the 1st pass, performance cuts in half",
        TEXTURED,
        Measured,
        "0.5 ×",
        "first-pass-colour: time without ÷ time with, 0.4 to 0.625",
        Step("first-pass-colour", factor(0.5, 1.25), EVERY_VIEW),
    ),
    claimed(
        "it will not run when writing to the color buffer is disabled",
        TEXTURED,
        Observed,
        "",
        "first-pass-program, a costly program whose writes are disabled: fragments that the driver counts as \
         shaded, without ÷ with; no difference where it does not run",
        Counter(
            "first-pass-program",
            "fragment_shader_invocations",
            NoDifference,
            EVERY_VIEW,
        ),
    ),
    claimed(
        "actually slowed things down!",
        TEXTURED,
        Measured,
        "",
        "first-pass-program: faster than no program in the first pass",
        Step("first-pass-program", Faster, EVERY_VIEW),
    ),
    claimed(
        "I anticipate a modest performance gain.",
        FUTURE,
        Anticipated,
        "",
        "the step z-pass, with the bottom cap gone from both passes: gain",
        Step("z-pass", Faster, EVERY_VIEW),
    ),
    claimed(
        "optimizing the triangle layout for the post vertex shader cache",
        FUTURE,
        Considered,
        "",
        "the step cache-order: gain; the document does not “expect much improvement”",
        Step("cache-order", NotFaster, EVERY_VIEW),
    ),
    claimed(
        "the algorithm is not vertex limited so the same argument as above can be made",
        FUTURE,
        Considered,
        "",
        "mesh-lod: gain",
        Step("mesh-lod", NotFaster, EVERY_VIEW),
    ),
    claimed(
        "Once the camera is far away the mesh could just be drawn at altitude above the terrain.",
        FUTURE,
        Considered,
        "",
        "far-level, flat meshes of regions whose volumes are lower than half a pixel: the picture",
        RightPicture("far-level", EVERY_VIEW),
    ),
    claimed(
        "Rendering a simple mesh is much faster than a multi-pass shadow volume.",
        FUTURE,
        Anticipated,
        "",
        "far-level where all regions are far away: gain, at least 1.5",
        Step("far-level", AtLeast(1.5), GLOBE),
    ),
    claimed(
        "A view dependent per pixel fade.",
        IDEAS,
        Considered,
        "",
        "",
        No(NO_PICTURE),
    ),
    claimed(
        "A constant pixel to texel ratio for fills.",
        IDEAS,
        Considered,
        "",
        "",
        No(NO_PICTURE),
    ),
    claimed(
        "This would allow multiple meshes to share the same texture",
        IDEAS,
        Considered,
        "",
        "",
        No(
            "scenes place one picture over each region or over all of them; the former are timed above",
        ),
    ),
];

/// Quotations within experiments.
#[cfg(test)]
pub(crate) const QUOTED_ELSEWHERE: [(&str, &str); 4] = [
    ("original fill", PERFORMANCE),
    ("As I expected, this didn’t do anything.", PERFORMANCE),
    ("expect much improvement", FUTURE),
    ("the performance could double", TEXTURED),
];

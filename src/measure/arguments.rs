//! What `pneuval measure` is told.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

/// Measure in photographs, each with its standard uncertainty, and draw what was measured on them.
///
/// A picture that cannot be decoded or measured is told with the reason; the others go on. PNG, JPEG and TIFF, 8 and 16 bits, turned as
/// the camera was held. `camera` of a session's reader takes the same.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval measure scale disc coin.png --diameter 23.25mm+-0.02\n  pneuval measure lens boards --corners 9x6 --square 25mm --out lens.yml\n  pneuval measure diameter photos --scale 0.05mm --distance 300mm+-1 --names 'p{pressure:kPa}.png' --out seen"
)]
pub struct Measure {
    #[command(subcommand)]
    pub what: Measured,
}

/// What is measured.
#[derive(Subcommand)]
pub enum Measured {
    /// The largest width of a round body across its axis
    Diameter(MeasureDiameter),
    /// The angle by which a finger bends, its tip, its curvature
    Angle(MeasureAngle),
    /// The area of an imprint: paint on paper
    Area(MeasureArea),
    /// How long a pixel is: of a disc, a ruler, a known length or a chessboard
    Scale(MeasureScale),
    /// A lens: focal lengths, centre and distortion, from pictures of a chessboard
    Lens(MeasureLens),
}

/// The largest width of a round body across its axis, to a few hundredths of a pixel.
#[derive(Args)]
pub struct MeasureDiameter {
    #[command(flatten)]
    pub job: Job,
    #[command(flatten)]
    pub camera: Camera,
    /// Whether the body is darker or brighter than what is around
    #[arg(long)]
    pub body: Option<BodyArgument>,
    /// How the axis lies, where it is not seen
    #[arg(long)]
    pub axis: Option<AxisArgument>,
}

/// The angle by which a finger bends, seen from the side; its tip from its root; its length and curvature.
///
/// The finger begins where it leaves a mount that is wider, or the picture. What has an outline on one side only cannot be seen to bend: a
/// round end goes on straight from half a width before the tip. With `--markers` it is told by markers of one colour instead.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval measure angle film --scale 0.25mm --sense counterclockwise --out seen\n  pneuval measure angle film --scale 0.25mm --markers 220,40,30 --count 5 --root 180,160 --out seen"
)]
pub struct MeasureAngle {
    #[command(flatten)]
    pub job: Job,
    #[command(flatten)]
    pub camera: Camera,
    /// Whether the body is darker or brighter than what is around
    #[arg(long)]
    pub body: Option<BodyArgument>,
    /// Where the finger leaves its mount, in px, where that is not seen
    #[arg(long, value_name = "X,Y")]
    pub root: Option<String>,
    /// The direction of the finger at its root in degrees, where the rig knows it: 0 to the right, 90 down
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub heading: Option<f64>,
    /// Which way a bend counts as positive, as one looks at the picture
    #[arg(long, default_value = "clockwise")]
    pub sense: SenseArgument,
    /// Red, green and blue of round markers along the centreline: the first is the root, the last the tip
    #[arg(long, value_name = "R,G,B", requires_all = ["count", "root"], conflicts_with = "body")]
    pub markers: Option<String>,
    /// How many markers there are
    #[arg(long, value_name = "N", requires = "markers", value_parser = clap::value_parser!(u8).range(3..=12))]
    pub count: Option<u8>,
}

/// Which way a bend counts as positive.
#[derive(Clone, Copy, ValueEnum)]
pub enum SenseArgument {
    /// As the hands of a clock go
    Clockwise,
    /// The other way
    Counterclockwise,
}

/// The area of an imprint, in colour, with its holes; what is not painted within does not count.
#[derive(Args)]
#[command(after_help = "Example:\n  pneuval measure area imprint.png --scale 0.1mm --paint 170,40,45 --out seen")]
pub struct MeasureArea {
    #[command(flatten)]
    pub job: Job,
    #[command(flatten)]
    pub camera: Camera,
    /// Red, green and blue of the paint, 0 to 255, where there are other colours than its and the paper's
    #[arg(long, value_name = "R,G,B")]
    pub paint: Option<String>,
    /// Specks of fewer px² are told, and do not count
    #[arg(long, value_name = "PX2", default_value_t = 30.0)]
    pub specks: f64,
    /// Holes count, too
    #[arg(long)]
    pub fill_holes: bool,
}

/// Pictures, and what becomes of them.
#[derive(Args)]
pub struct Job {
    /// Pictures, or folders of them
    #[arg(required = true)]
    pub pictures: Vec<PathBuf>,
    /// Numbers in the names of the pictures: 'p{pressure:kPa}_{k}.png'
    #[arg(long, value_name = "PATTERN")]
    pub names: Option<String>,
    /// Write each picture with edges, axis and value drawn on it, and its profile along the body as CSV
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Camera, scale, and where the body is.
#[derive(Args)]
pub struct Camera {
    /// How long a pixel is in the plane of the axis, with its standard uncertainty: `0.05mm`, `0.05mm+-0.00002`
    #[arg(long, value_name = "LENGTH")]
    pub scale: Option<String>,
    /// From the camera (the entrance pupil of its lens) to the axis: a round body looks wider than it is by its nearness
    #[arg(long, value_name = "LENGTH")]
    pub distance: Option<String>,
    /// How far the scale's plane lies before the axis, towards the camera; negative: behind it
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub offset: Option<String>,
    // clap prints backticks as they are.
    #[allow(clippy::doc_markdown)]
    /// Calibration of the lens: a YAML file of OpenCV or ROS, or of 'measure lens'
    #[arg(long, value_name = "FILE")]
    pub lens: Option<PathBuf>,
    /// Where it is looked for, in px
    #[arg(long, value_name = "LEFT,TOP,WIDTH,HEIGHT")]
    pub region: Option<String>,
    /// How the camera stores light: linear (taken if nothing is said), srgb (most JPEGs), or its exponent
    #[arg(long, value_name = "TONE")]
    pub tone: Option<String>,
}

/// How an axis lies.
#[derive(Clone, Copy, ValueEnum)]
pub enum AxisArgument {
    /// Up and down
    Vertical,
    /// Across
    Horizontal,
}

/// What a body looks like.
#[derive(Clone, Copy, ValueEnum)]
pub enum BodyArgument {
    /// Darker than what is around
    Dark,
    /// Brighter
    Bright,
}

/// How long a pixel is, with its standard uncertainty: printed as `scale` of a session's camera has it.
///
/// It holds in the plane of what was measured, parallel to the picture. A body before or behind that plane is seen at another scale: give
/// `--offset` and `--distance` where it is measured.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  pneuval measure scale disc coin.png --diameter 23.25mm+-0.02\n  pneuval measure scale ruler ruler.jpg --from 120,400 --to 1800,420 --pitch 1mm\n  pneuval measure scale length rig.png --from 101.5,300 --to 1402,301.2 --length 65mm+-0.05\n  pneuval measure scale board board.png --corners 9x6 --square 5mm"
)]
pub struct MeasureScale {
    #[command(subcommand)]
    pub of: ScaleOf,
}

/// What is known of the plane.
#[derive(Subcommand)]
pub enum ScaleOf {
    /// A disc or a coin of a known diameter
    Disc(ScaleOfDisc),
    /// A ruler: marks that lie evenly along a line
    Ruler(ScaleOfRuler),
    /// A known length between two places
    Length(ScaleOfLength),
    /// A chessboard of squares of a known side
    Board(ScaleOfBoard),
}

/// The picture of a scale.
#[derive(Args)]
pub struct ScalePicture {
    /// The picture
    pub picture: PathBuf,
    // clap prints backticks as they are.
    #[allow(clippy::doc_markdown)]
    /// Calibration of the lens: a YAML file of OpenCV or ROS, or of 'measure lens'
    #[arg(long, value_name = "FILE")]
    pub lens: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A disc or a coin of a known diameter, anywhere in the picture.
#[derive(Args)]
pub struct ScaleOfDisc {
    #[command(flatten)]
    pub of: ScalePicture,
    /// Its diameter, with its standard uncertainty: `23.25mm+-0.02`
    #[arg(long, value_name = "LENGTH")]
    pub diameter: String,
    /// Where it is looked for, in px
    #[arg(long, value_name = "LEFT,TOP,WIDTH,HEIGHT")]
    pub region: Option<String>,
}

/// A ruler: the pitch of its marks along a line across them.
#[derive(Args)]
pub struct ScaleOfRuler {
    #[command(flatten)]
    pub of: ScalePicture,
    /// One end of the line, in px
    #[arg(long, value_name = "X,Y")]
    pub from: String,
    /// The other
    #[arg(long, value_name = "X,Y")]
    pub to: String,
    /// How far marks are apart
    #[arg(long, value_name = "LENGTH")]
    pub pitch: String,
    /// Brightness is the mean over so many px along the marks
    #[arg(long, value_name = "PX", default_value_t = 11.0)]
    pub across: f64,
    /// About how many px marks are apart, where every fifth or tenth is longer
    #[arg(long, value_name = "PX")]
    pub about: Option<f64>,
}

/// A known length between two places.
#[derive(Args)]
pub struct ScaleOfLength {
    #[command(flatten)]
    pub of: ScalePicture,
    /// One end, in px; the middle of the first pixel is 0,0
    #[arg(long, value_name = "X,Y")]
    pub from: String,
    /// The other
    #[arg(long, value_name = "X,Y")]
    pub to: String,
    /// The length between them, with its standard uncertainty: `65mm+-0.05`
    #[arg(long, value_name = "LENGTH")]
    pub length: String,
    /// Standard uncertainty of each place, in px
    #[arg(long, value_name = "PX", default_value_t = 0.5)]
    pub std_px: f64,
}

/// A chessboard of squares of a known side.
#[derive(Args)]
pub struct ScaleOfBoard {
    #[command(flatten)]
    pub of: ScalePicture,
    #[command(flatten)]
    pub board: BoardArguments,
}

/// A chessboard.
#[derive(Args)]
pub struct BoardArguments {
    /// Inner corners in a row and rows of them: `9x6`
    #[arg(long, value_name = "COLUMNSxROWS")]
    pub corners: String,
    /// The side of a square
    #[arg(long, value_name = "LENGTH")]
    pub square: String,
}

/// A lens, from pictures of a chessboard that is held at different tilts: focal lengths, centre, distortion (k1, k2, k3, p1, p2).
///
/// Five pictures and more, of the same camera, zoom and focus, with the board once in every corner of the picture and tilted by 20 to 40
/// degrees. Printed as `lens` of a session's camera has it; `--out` writes what `OpenCV` reads.
#[derive(Args)]
#[command(
    after_help = "Example:\n  pneuval measure lens boards --corners 9x6 --square 25mm --out lens.yml\n\nExit codes: 0 calibrated, 3 some pictures show no board, 4 no calibration."
)]
pub struct MeasureLens {
    /// Pictures, or folders of them
    #[arg(required = true)]
    pub pictures: Vec<PathBuf>,
    #[command(flatten)]
    pub board: BoardArguments,
    // clap prints backticks as they are.
    #[allow(clippy::doc_markdown)]
    /// Write the lens as OpenCV does, in YAML
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

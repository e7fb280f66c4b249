//! Method and glossary: what every number on a page is, and where its formula comes from.

use serde::Serialize;

use crate::metrics::Metric;
use crate::results::Comparison;
use crate::verdict::Basis;

/// A word of the page.
#[derive(Serialize)]
pub struct Term {
    pub name: String,
    pub formula: &'static str,
    pub text: &'static str,
    pub source: &'static str,
}

/// Metrics of the comparisons, then what their intervals and verdicts are.
pub fn terms(mine: &[&Comparison]) -> Vec<Term> {
    let is_shown = |metric: &Metric| mine.iter().any(|c| c.metric(*metric).is_some_and(|m| m.value.is_some()));
    let mut terms: Vec<Term> = Metric::ALL.into_iter().filter(is_shown).map(metric).collect();
    let has = |basis: Basis| mine.iter().any(|c| c.basis == basis);
    let published = has(Basis::PublishedPoint);
    let kept = TERMS.iter().filter(|(about, ..)| match about {
        About::All => true,
        About::Print => published,
        About::Sessions => has(Basis::Session),
        About::Alignment => mine.iter().any(|c| c.alignment.is_some()),
    });
    terms.extend(kept.map(|(_, name, formula, text, source)| Term { name: (*name).to_owned(), formula, text, source }));
    terms
}

fn metric(metric: Metric) -> Term {
    let (formula, text, source) = match metric {
        Metric::Bias => {
            ("mean e", "Over the points used; positive where the model is too high.", "JCGM 200:2012, 2.18")
        }
        Metric::Mae => ("mean |e|", "Over the points used.", "Willmott and Matsuura, Clim. Res. 30 (2005) 79"),
        Metric::Rmse => (
            "√(mean e²)",
            "Over the points used. Of sessions it is that of the mean response: what the scatter of its points adds is taken off, and \
             stored beside it as `uncorrected`.",
            "wave-contour finger, Eq. 30; the same for every other type",
        ),
        Metric::MaxAbsError => (
            "max |e|",
            "Over the points used; of a position the maximum position error.",
            "wave-contour finger, Eq. 30",
        ),
        Metric::RelativeToMeasuredMax => {
            ("max (|e| / |measured|)", "Over the points used.", "internal-support gripper, comparison of its table")
        }
        Metric::RelativeToMeasuredMean => {
            ("mean (|e| / |measured|)", "Over the points used.", "internal-support gripper, comparison of its table")
        }
        Metric::RelativeToPredictedMax => (
            "max (|e| / |predicted|)",
            "Over the points used; it is not the same number as over the measured value.",
            "dual-chamber finger, its 5.74 %",
        ),
        Metric::RelativeToPredictedMean => {
            ("mean (|e| / |predicted|)", "Over the points used.", "dual-chamber finger, its 5.74 %")
        }
        Metric::RelativeToRangeMax => {
            ("max |e| / (max − min of measured)", "For quantities that cross zero.", "this program's choice")
        }
        Metric::RelativeToRangeRmse => {
            ("RMSE / (max − min of measured)", "For quantities that cross zero.", "this program's choice")
        }
        Metric::ResidualAtZero => (
            "e at zero pressure",
            "The reference is not among the points used; of several the largest in size.",
            "this program's choice",
        ),
        Metric::R2 => (
            "1 − Σ e² / Σ (measured − its mean)²",
            "Shown, never judged: it says how much of the range is followed, not how near.",
            "Draper and Smith, Applied Regression Analysis",
        ),
        Metric::LoopArea => (
            "∮ predicted dp − ∮ measured dp",
            "Area between unloading and loading over pressure, trapezoidal rule at the measured pressures; shown, never judged.",
            "this program's choice",
        ),
        Metric::LoopAreaShare => (
            "|e of the loop area| / (range of pressure × range of measured)",
            "The same as a share of the box around the loop; shown, never judged.",
            "this program's choice",
        ),
    };
    Term { name: metric.title().to_owned(), formula, text, source }
}

/// Where a word is needed.
enum About {
    All,
    Print,
    Sessions,
    Alignment,
}

const TERMS: [(About, &str, &str, &str, &str); 17] = [
    (
        About::All,
        "residual e",
        "e = predicted − measured",
        "At equal pressure; of a position the distance between both points, which has no sign.",
        "wave-contour finger, Eq. 30",
    ),
    (
        About::All,
        "n used / available",
        "",
        "Points in the metrics, of all that were measured or printed. The zero-pressure reference, holes in print, points of a fit and \
         points without a prediction are not in them, and are counted beside.",
        "this program's choice",
    ),
    (
        About::Print,
        "interval of published points",
        "printed value ± ½ of its last digit",
        "Every metric runs over all values it can take while each printed value moves within its own interval, all at once. No \
         measurement uncertainty is published, so this is the least that can be said.",
        "interval arithmetic: Moore, Kearfott and Cloud, Introduction to Interval Analysis (2009)",
    ),
    (
        About::Sessions,
        "95 % interval of a value",
        "mean ± k √(s²/n + u²)",
        "s² from n repeats, u the standard uncertainty of the instrument, common to all repeats; k between 1.96 and Student's factor \
         with n − 1 degrees of freedom, by the share of the repeats.",
        "JCGM 100:2008 (GUM), 4.2, 5.1 and G.3",
    ),
    (
        About::Sessions,
        "95 % interval of a metric",
        "Σ over sources (∂metric/∂source · u)²",
        "Sources are repeats, instruments, the pressures at which values were read, and the model's inputs; what one instrument adds to \
         one point it adds to all. From 20 repeats on the part of the repeats in the bias is a bootstrap.",
        "JCGM 100:2008 (GUM), 5.2; Efron, J. Am. Stat. Assoc. 82 (1987) 171",
    ),
    (
        About::Sessions,
        "interval of a residual",
        "",
        "In figures: of each residual by itself, from the intervals of the measured and the predicted value at its point.",
        "JCGM 100:2008 (GUM), 5.1",
    ),
    (
        About::Sessions,
        "E and u_val",
        "u_val² = u_num² + u_input² + u_D²",
        "Comparison error and validation uncertainty: the model's own error lies within E ± u_val, as a standard uncertainty.",
        "ASME V&V 20-2009",
    ),
    (
        About::Sessions,
        "point, repeat, plateau",
        "",
        "A point is a state held: the mean over the steady window of a plateau. Points of several runs or conditioned cycles at one \
         pressure, on one branch, are repeats of one station.",
        "session.toml, `points` and `cycles`",
    ),
    (
        About::Sessions,
        "loading, unloading",
        "",
        "The way the pressure came: up or down to a point. A model has one branch, and is compared with both. The first cycle of a \
         specimen stands apart from conditioned ones.",
        "Mullins, Rubber Chem. Technol. 42 (1969) 339",
    ),
    (
        About::Sessions,
        "lag, offset, drift",
        "",
        "Lag: the shift under which motion correlates best with pressure. Offset and drift: what events that two devices recorded say of \
         their clocks. A lag is removed only where the session says whose it is.",
        "normalised cross-correlation; least squares on event times",
    ),
    (
        About::Sessions,
        "channels over time",
        "lowest and highest of each stretch",
        "Drawn logs are thinned so that no extreme disappears; every number is computed from all samples.",
        "this program's choice",
    ),
    (
        About::Alignment,
        "aligned to the measurement",
        "min Σ |R x + t − y|²",
        "A rotation and a shift that bring the predicted path nearest to the measured one; what they took away is told beside the \
         verdict.",
        "Umeyama, IEEE Trans. Pattern Anal. Mach. Intell. 13 (1991) 376",
    ),
    (
        About::All,
        "bound",
        "",
        "The largest acceptable value of a metric, from a paper's claim or an application's need, with its reason; not a tolerance of a \
         part and not an uncertainty.",
        "bounds.toml",
    ),
    (
        About::All,
        "verdict",
        "",
        "pass: the whole interval of the metric lies within the bound. fail: it lies wholly beyond, or the model gives no prediction \
         where there is a measurement. inconclusive: it reaches over the bound, or is not a number. unjudged: nobody wrote a bound. \
         calibration: the model was fitted on these very data. A bound may expect a failure: the day it passes is news.",
        "JCGM 106:2012, 8",
    ),
    (
        About::All,
        "forms",
        "",
        "published: the paper's own numbers. printed: the equation exactly as printed. consistent: the same idea with units, sign and \
         the limit at rest put right. reading: one way to read what the paper leaves open. assumed: a law that nobody printed. \
         imported: a table that a user brought.",
        "`pneuval models`",
    ),
    (
        About::All,
        "origin of an input",
        "",
        "published, measured, assumed or calibrated: a comparison that stands on assumed or calibrated inputs says so.",
        "actuator.toml",
    ),
    (
        About::All,
        "lines in figures",
        "",
        "Curves are evaluated over the whole range and thinned by less than can be seen.",
        "Douglas and Peucker, Cartographica 10 (1973) 112",
    ),
];

"""Whether numpy forms the metrics that results hold, and scipy the bootstrap intervals.

usage: metrics.py PNEUVAL BOOTSTRAP (the built binary, and the built example `bootstrap` of pneuval-analysis)

Every metric of the embedded papers and of rehearsed sessions (repeats, positions, a condition beside the pressure) is formed anew from
the points in results.json. A metric that is not defined here is an error, so that none goes unchecked.

Both bootstraps draw at random: the mean of an end over some seeds must lie within three standard errors of scipy's.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy import stats

PNEUVAL, BOOTSTRAP = sys.argv[1:]

# Residual = predicted - measured; of a position, the distance.
NEAR = 1e-12


class Points:
    """Points as arrays of one row a point, one column a component."""

    def __init__(self, points):
        def array(key):
            width = max((len(p[key]) for p in points if p[key] is not None), default=1)
            rows = [p[key] if p[key] is not None else [math.nan] * width for p in points]
            return np.array(rows, dtype=np.float64).reshape(len(points), width)

        self.points = points
        self.n = len(points)
        self.predicted, self.measured = array("predicted"), array("measured")
        # Where nothing is known of how sure a value is, no digit of it is left open either.
        self.of_predicted, self.of_measured = array("predicted_half_width"), np.nan_to_num(array("measured_half_width"))
        difference = self.predicted - self.measured
        self.is_position = difference.shape[1] > 1
        self.residual = np.linalg.norm(difference, axis=1) if self.is_position else difference[:, 0]
        self.size = np.abs(self.residual)

    def share(self, base, half_width):
        """|r| / |base|; nothing where a base may be zero within its digits."""
        nearest = np.linalg.norm(np.maximum(np.abs(base) - half_width, 0.0), axis=1)
        return None if not np.all(nearest > 0.0) else self.size / np.linalg.norm(base, axis=1)

    def of_measured_range(self, value):
        if self.is_position:
            return None
        measured, half = self.measured[:, 0], self.of_measured[:, 0]
        surely = np.max(measured - half) - np.min(measured + half)
        return value / np.ptp(measured) if surely > 0.0 else None

    def rmse(self):
        return np.sqrt(np.mean(self.size**2))


def if_known(values, reduce):
    return None if values is None else reduce(values)


def r2(points):
    total = np.sum((points.measured[:, 0] - np.mean(points.measured[:, 0])) ** 2)
    return None if points.is_position or total == 0.0 else 1.0 - np.sum(points.residual**2) / total


def largest(points):
    return points.residual[np.argmax(points.size)]


def loop_area(points, as_share=False):
    """Area between unloading and loading, predicted - measured: straight lines over the pressures that both branches reach."""
    usable = [p for p in points.points if p["status"] != "cycle_apart"]
    settings = {tuple(p["conditions_si"]) for p in points.points}
    if points.is_position or len(settings) != 1 or any(len(p["pressures_gauge_pa"]) != 1 for p in usable):
        return None
    branch = lambda name: sorted((p["pressures_gauge_pa"][0], i) for i, p in enumerate(usable) if p["branch"] == name)
    up, down = branch("loading"), branch("unloading")
    if not up or not down:
        return None
    if down[-1][0] < up[-1][0]:
        down.append(up[-1])
    low, high = max(up[0][0], down[0][0]), up[-1][0]
    if len(up) < 2 or len(down) < 3 or low >= high:
        return None
    used, total = set(), {"predicted": 0.0, "measured": 0.0}
    for sign, way in ((1.0, down), (-1.0, up)):
        near = [k for k in range(len(way)) if low <= way[k][0] <= high]
        near = range(max(near[0] - 1, 0) if way[near[0]][0] > low else near[0], near[-1] + 1)
        used |= {way[k][1] for k in near}
        for key in total:
            if any(usable[way[k][1]][key] is None for k in near):
                return None
            x, y = [way[k][0] for k in near], [usable[way[k][1]][key][0] for k in near]
            grid = np.unique([low, high, *(v for v in x if low < v < high)])
            total[key] += sign * np.trapezoid(np.interp(grid, x, y), grid)
    error = total["predicted"] - total["measured"]
    span = np.ptp([usable[i]["measured"][0] for i in used])
    return abs(error) / (span * (high - low)) if as_share else error


# By id: over the points used. `residual_at_zero` is over the references.
DEFINITIONS = {
    "bias": lambda p: None if p.is_position else np.mean(p.residual),
    "mae": lambda p: np.mean(p.size),
    "rmse": lambda p: p.rmse(),
    "max_abs_error": lambda p: np.max(p.size),
    "relative_to_measured_max": lambda p: if_known(p.share(p.measured, p.of_measured), np.max),
    "relative_to_measured_mean": lambda p: if_known(p.share(p.measured, p.of_measured), np.mean),
    "relative_to_predicted_max": lambda p: if_known(p.share(p.predicted, p.of_predicted), np.max),
    "relative_to_predicted_mean": lambda p: if_known(p.share(p.predicted, p.of_predicted), np.mean),
    "relative_to_range_max": lambda p: p.of_measured_range(np.max(p.size)),
    "relative_to_range_rmse": lambda p: p.of_measured_range(p.rmse()),
    "residual_at_zero": largest,
    "r2": r2,
    "loop_area": loop_area,
    "loop_area_share": lambda p: loop_area(p, as_share=True),
}


def check_metrics(name, results):
    """Metrics that are numbers, metrics that are none, and comparisons of `results`."""
    numbers = undefined = 0
    for comparison in results["comparisons"]:
        place = f"{name}, {comparison['id']}"
        # Errors that a paper states without its data.
        if comparison["metrics_printed"]:
            continue
        of = lambda *status: Points([p for p in comparison["points"] if p["status"] in status])
        used, at_zero = of("used", "not_finite"), of("zero_reference")
        everything = Points(comparison["points"])
        assert used.n == comparison["n_used"], place
        assert len(comparison["metrics"]) == len({m["metric"] for m in comparison["metrics"]}), place
        for metric in comparison["metrics"]:
            which = metric["metric"]
            assert which in DEFINITIONS, f"{place}: the metric `{which}` is not defined in this script"
            points = at_zero if which == "residual_at_zero" else everything if which.startswith("loop") else used
            expected = DEFINITIONS[which](points) if points.n > 0 else None
            if expected is not None and not math.isfinite(expected):
                expected = None
            # Where the model has no value at some point, it is shown over the others.
            found = metric["value"] if metric["value"] is not None else metric["over_predicted_points"]
            # The RMSE of a session is without what the scatter of repeats adds; numpy's is not.
            if metric["uncorrected"] is not None:
                assert found <= metric["uncorrected"] * (1 + NEAR), f"{place}: {which} grew by its correction"
                found = metric["uncorrected"]
            assert (found is None) == (expected is None), f"{place}: {which} is {found}, numpy says {expected}"
            if found is None:
                assert metric["undefined"], f"{place}: {which} is no number and does not say why"
                undefined += 1
                continue
            scale = max(abs(expected), np.nanmax(points.size))
            if which == "loop_area":
                scale *= max(p["pressures_gauge_pa"][0] for p in points.points)
            # A mean of residuals that cancel is as exact as they are.
            scale = max(scale, 1e-3 * np.max(np.abs(points.measured))) if metric["metric"] == "bias" else scale
            assert abs(found - expected) <= NEAR * scale, f"{place}: {which} is {found}, numpy says {expected}"
            if metric["lower"] is not None and metric["value"] is not None:
                assert metric["lower"] <= metric["value"] <= metric["upper"], f"{place}: {which}"
            numbers += 1
    return numbers, undefined, len(results["comparisons"])


def validate(*paths):
    said = subprocess.run([PNEUVAL, "validate", *paths, "--no-report", "--json"], capture_output=True, text=True)
    assert said.returncode in (0, 1, 3), said.stderr
    return json.loads(said.stdout)


checked = {"the embedded papers": check_metrics("papers", validate())}
with tempfile.TemporaryDirectory() as name:
    for actuator in ["internal-support", "wave-finger", "fruit-finger"]:
        out = pathlib.Path(name) / actuator
        subprocess.run([PNEUVAL, "rehearse", actuator, "--out", out, "--seed", "3"], check=True, capture_output=True)
        checked[f"{actuator}, rehearsed"] = check_metrics(actuator, validate(out))
for what, (numbers, undefined, comparisons) in checked.items():
    assert numbers > 0, what
    print(f"{what}: {numbers} metrics of {comparisons} comparisons as in numpy, {undefined} undefined in both")


def ours(columns, statistic, resamples, seed):
    text = "".join(",".join(repr(float(v)) for v in row) + "\n" for row in zip(*columns))
    arguments = [BOOTSTRAP, statistic, str(resamples), str(seed)]
    return json.loads(subprocess.run(arguments, input=text, check=True, capture_output=True, text=True).stdout)


def jackknife_acceleration(columns, statistic):
    rows = len(columns[0])
    left = np.array([statistic(*(np.delete(c, i) for c in columns), axis=0) for i in range(rows)])
    difference = np.mean(left) - left
    return np.sum(difference**3) / (6.0 * np.sum(difference**2) ** 1.5)


STATISTICS = {
    "mean": lambda x, axis: np.mean(x, axis=axis),
    "rmse": lambda x, axis: np.sqrt(np.mean(x**2, axis=axis)),
    "ratio": lambda x, y, axis: np.mean(x, axis=axis) / np.mean(y, axis=axis),
}
draw = np.random.default_rng(7)
CASES = [
    ("mean of 8, skewed", "mean", [draw.exponential(size=8)]),
    # Eighths, whose sums are exact: scipy takes resamples that equal the data's mean but for rounding as less or more.
    ("mean of 10 repeats with equal values among them", "mean", [np.round(8 * draw.normal(5.0, 1.0, size=10)) / 8]),
    ("RMSE of 40 residuals", "rmse", [draw.normal(0.3, 1.0, size=40)]),
    ("ratio of two means of 25 pairs", "ratio", [draw.normal(5.0, 1.0, size=25), draw.exponential(2.0, size=25)]),
    ("RMSE of 2000 residuals", "rmse", [draw.standard_t(4, size=2000)]),
]
RESAMPLES, SEEDS = 9_999, 16
for name, id, columns in CASES:
    statistic = STATISTICS[id]
    found = [ours(columns, id, RESAMPLES, seed) for seed in range(SEEDS)]
    expected = [
        stats.bootstrap(
            columns, statistic, method="BCa", paired=len(columns) > 1, n_resamples=RESAMPLES, batch=500,
            vectorized=True, rng=np.random.default_rng(seed),
        ).confidence_interval
        for seed in range(SEEDS)
    ]  # fmt: skip
    assert abs(found[0]["value"] - statistic(*columns, axis=0)) < 1e-12, name
    assert abs(found[0]["acceleration"] - jackknife_acceleration(columns, statistic)) < 1e-10, name
    ends = []
    for end, theirs in [("lower", "low"), ("upper", "high")]:
        a = np.array([interval[end] for interval in found])
        b = np.array([getattr(interval, theirs) for interval in expected])
        error = math.hypot(np.std(a, ddof=1), np.std(b, ddof=1)) / math.sqrt(SEEDS)
        apart = abs(np.mean(a) - np.mean(b))
        assert apart <= 3.0 * error, f"{name}: {end} {np.mean(a)}, scipy says {np.mean(b)}, standard error {error}"
        ends.append(f"{end} {np.mean(a):.5f} and {np.mean(b):.5f} ({apart / error:.1f} standard errors)")
    print(f"{name}: ours and scipy's {'; '.join(ends)}")

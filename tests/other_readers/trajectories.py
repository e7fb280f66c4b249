"""Whether a trajectory is compared as evo and numpy compare it: python trajectories.py PNEUVAL FOLDER.

FOLDER holds freiburg1_xyz-groundtruth.txt and freiburg1_xyz-rgbdslam.txt (TUM RGB-D). They are taken into a session of their own:
the ground truth is what was measured, the estimate an imported model over time.
"""

import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from evo.core import metrics, sync
from evo.tools import file_interface

TRUTH, ESTIMATE = "freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt"
WITHIN_S = 0.01
# What evo gave when this was written, in m.
RMSE, MAX = 0.020079, 0.043289

ACTUATOR = f"""schema = 1
id = "camera"
title = "Hand-held camera"
[[model]]
kind = "imported"
form = "slam"
title = "RGB-D SLAM"
quantity = {{ id = "position", title = "Position", unit = "m", components = ["x", "y", "z"] }}
file = "{ESTIMATE}"
reader = {{ format = "csv" }}
time = {{ column = 1, unit = "s" }}
predicted = [2, 3, 4]
unit = "m"
"""

SESSION = f"""schema = 1
id = "fr1-xyz"
actuator = "camera"
[clock]
column = "timestamp"
unit = "s"
[[channel]]
id = "x"
column = "tx"
unit = "m"
[[channel]]
id = "y"
column = "ty"
unit = "m"
[[channel]]
id = "z"
column = "tz"
unit = "m"
[[run]]
file = "{TRUTH}"
[[response]]
quantity = {{ id = "position", title = "Position", unit = "m", components = ["x", "y", "z"] }}
measured = {{ channel = ["x", "y", "z"], method = "motion capture" }}
points = {{ from = "trajectory", at = "time", POINTS }}
[[comparison]]
quantity = "position"
form = "slam"
[[comparison]]
quantity = "position"
form = "slam-rigid"
model = "slam"
align = "rigid"
"""


def compared(pneuval, data, points):
    """The comparisons of one session, by form."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name in (TRUTH, ESTIMATE):
            shutil.copy(data / name, folder / name)
        (folder / "actuator.toml").write_text(ACTUATOR)
        (folder / "session.toml").write_text(SESSION.replace("POINTS", points))
        said = subprocess.run([pneuval, "validate", ".", "--out", "report"], cwd=folder, capture_output=True, text=True)
        # Without a bound everything is open.
        assert said.returncode == 3, said.stdout + said.stderr
        results = json.loads((folder / "report/results/results.json").read_text())
        return {comparison["form"]: comparison for comparison in results["comparisons"]}


def metric(comparison, name):
    return next(m["value"] for m in comparison["metrics"] if m["metric"] == name)


def same(what, ours, theirs, within):
    assert math.isclose(ours, theirs, rel_tol=0.0, abs_tol=within), f"{what}: {ours} here, {theirs} there"
    print(f"  {what}: {ours:.9f}, {theirs:.9f}")


def by_evo(truth, estimate, is_aligned):
    truth, estimate = sync.associate_trajectories(truth, estimate, max_diff=WITHIN_S)
    rotation = None
    if is_aligned:
        rotation, _, _ = estimate.align(truth)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((truth, estimate))
    return ape.get_all_statistics(), estimate.num_poses, rotation


def interpolated(truth, estimate):
    """The ground truth on straight lines at the estimate's stamps, never across more than five usual steps."""
    t, wanted = truth.timestamps, estimate.timestamps
    gap = 5.0 * np.median(np.diff(t))
    right = np.searchsorted(t, wanted, side="right")
    inside = (right > 0) & (right < len(t))
    left = np.clip(right - 1, 0, len(t) - 2)
    on_sample = (right > 0) & (t[np.clip(right - 1, 0, len(t) - 1)] == wanted)
    inside &= (t[left + 1] - t[left] <= gap + 4 * np.finfo(float).eps * wanted) | on_sample
    inside |= on_sample
    at = np.stack([np.interp(wanted, t, truth.positions_xyz[:, i]) for i in range(3)], axis=1)
    distance = np.linalg.norm(estimate.positions_xyz - at, axis=1)[inside]
    return math.sqrt(np.mean(distance**2)), distance.max(), len(distance)


def main():
    pneuval, data = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    read = file_interface.read_tum_trajectory_file

    print("nearest stamps within 0.01 s, against evo")
    ours = compared(pneuval, data, 'match = "nearest", within = { value = 0.01, unit = "s" }')
    for form, is_aligned in (("slam", False), ("slam-rigid", True)):
        theirs, n, rotation = by_evo(read(data / TRUTH), read(data / ESTIMATE), is_aligned)
        same(f"{form}, RMSE", metric(ours[form], "rmse"), theirs["rmse"], 1e-12)
        same(f"{form}, max", metric(ours[form], "max_abs_error"), theirs["max"], 1e-12)
        same(f"{form}, mean", metric(ours[form], "mae"), theirs["mean"], 1e-12)
        assert ours[form]["n_used"] == n == ours[form]["meeting"]["runs"][0]["n_matched"], (ours[form]["n_used"], n)
        print(f"  {form}, matched: {n} of {ours[form]['n_available']}")
        if rotation is not None:
            angle = math.degrees(math.acos((np.trace(rotation) - 1.0) / 2.0))
            same(f"{form}, angle of the rotation / deg", ours[form]["alignment"]["rotation_deg"], angle, 1e-6)
    same("RMSE as once given", round(metric(ours["slam"], "rmse"), 6), RMSE, 0.0)
    same("max as once given", round(metric(ours["slam"], "max_abs_error"), 6), MAX, 0.0)

    print("interpolated, against numpy")
    ours = compared(pneuval, data, 'match = "interpolate"')["slam"]
    rmse, largest, n = interpolated(read(data / TRUTH), read(data / ESTIMATE))
    same("RMSE", metric(ours, "rmse"), rmse, 1e-12)
    same("max", metric(ours, "max_abs_error"), largest, 1e-12)
    assert ours["n_used"] == n, (ours["n_used"], n)
    run = ours["meeting"]["runs"][0]
    print(f"  matched: {n} of {ours['n_available']}, {run['n_in_gaps']} in gaps, overlap {run['overlap']:.4f}")


main()

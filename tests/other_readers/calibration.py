"""Whether OpenCV calibrates as we do, on the same pictures: python calibration.py RESULT.json PICTURES

RESULT.json holds `columns` and `rows` of inner corners, the lens (`focal_px`, `centre_px`, `radial` k1 k2 k3, `tangential` p1 p2), `rms_px` and
`mean_px`, and `pictures`: each with `file` and `corners`, row by row. PICTURES is the folder of the files.

Two comparisons. OpenCV's own corners (findChessboardCorners, cornerSubPix): focal lengths within 0.3 %, and our mean reprojection error within
0.15 px, and every corner within a pixel of one of OpenCV's. OpenCV's calibrateCamera on our corners: the same minimum, so the same numbers.
"""

import json
import math
import pathlib
import sys

import cv2
import numpy as np

# As the target says.
FOCAL = 0.003
MEAN_PX = 0.15
# Two searches for one minimum end within their own tolerance.
SAME_FOCAL = 1e-5
SAME_RMS_PX = 1e-5
# A corner is another one where it is further away.
CORNER_PX = 1.0
# Half of the window of cornerSubPix, in px: the spread between them is OpenCV's own.
WINDOWS = (5, 7, 9, 11)

CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 300, 1e-15)


def board(columns, rows):
    return np.array([[x, y, 0] for y in range(rows) for x in range(columns)], dtype=np.float32)


def calibrated(points, corners, size):
    """Intrinsics, distortion, rms, and distances of all corners."""
    rms, matrix, distortion, turns, shifts = cv2.calibrateCamera(
        [points] * len(corners), corners, size, None, None, criteria=CRITERIA
    )
    distances = []
    for seen, turn, shift in zip(corners, turns, shifts):
        predicted, _ = cv2.projectPoints(points, turn, shift, matrix, distortion)
        distances.append(np.linalg.norm(predicted.reshape(-1, 2) - seen.reshape(-1, 2), axis=1))
    return matrix, distortion.ravel(), rms, np.concatenate(distances)


def theirs(grey, shape, window):
    found, corners = cv2.findChessboardCorners(grey, shape)
    if not found:
        return None
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    return cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), criteria)


def share(a, b):
    return abs(a / b - 1.0)


def main(result, folder):
    ours = json.loads(pathlib.Path(result).read_text())
    shape = (ours["columns"], ours["rows"])
    points = board(*shape)
    greys = [cv2.imread(str(pathlib.Path(folder) / one["file"]), cv2.IMREAD_GRAYSCALE) for one in ours["pictures"]]
    corners = [np.array(one["corners"], dtype=np.float32).reshape(-1, 1, 2) for one in ours["pictures"]]
    size = greys[0].shape[::-1]
    focal, bad = ours["focal_px"], []

    def check(holds, text):
        print(("     " if holds else "BAD  ") + text)
        if not holds:
            bad.append(text)

    check(ours["mean_px"] <= MEAN_PX, f"our mean reprojection error {ours['mean_px']:.4f} px, at most {MEAN_PX}")
    matrix, distortion, rms, distances = calibrated(points, corners, size)
    for axis, ours_px, theirs_px in zip("xy", focal, (matrix[0, 0], matrix[1, 1])):
        text = f"on our corners: focal length {axis} {ours_px:.4f} px, OpenCV {theirs_px:.4f}"
        check(share(ours_px, theirs_px) <= SAME_FOCAL, text)
    # calibrateCamera takes corners as floats of 32 bits: 3e-5 px at 500 px.
    check(abs(ours["rms_px"] - rms) <= SAME_RMS_PX, f"on our corners: rms {ours['rms_px']:.6f} px, OpenCV {rms:.6f}")
    mean = float(np.mean(distances))
    check(abs(ours["mean_px"] - mean) <= SAME_RMS_PX, f"on our corners: mean {ours['mean_px']:.6f} px, OpenCV {mean:.6f}")
    (k1, k2, k3), (p1, p2) = ours["radial"], ours["tangential"]
    apart = np.max(np.abs(np.array([k1, k2, p1, p2, k3]) - distortion[:5]))
    check(apart <= 1e-3, f"on our corners: coefficients differ by {apart:.1e} at most")
    centre = math.dist(ours["centre_px"], (matrix[0, 2], matrix[1, 2]))
    check(centre <= 0.01, f"on our corners: principal point differs by {centre:.4f} px")

    for window in WINDOWS:
        found = [theirs(grey, shape, window) for grey in greys]
        if any(one is None for one in found):
            print("OpenCV does not find the board")
            return 1
        for one, other, picture in zip(found, corners, ours["pictures"]):
            # OpenCV's order is another one: each with the nearest.
            off = np.linalg.norm(one.reshape(-1, 1, 2) - other.reshape(1, -1, 2), axis=2).min(axis=1).max()
            check(off <= CORNER_PX, f"window {window}: {picture['file']}: corners differ by {off:.2f} px at most")
        matrix, _, rms, distances = calibrated(points, found, size)
        for axis, ours_px, theirs_px in zip("xy", focal, (matrix[0, 0], matrix[1, 1])):
            by = share(ours_px, theirs_px)
            text = f"window {window}: focal length {axis} {ours_px:.2f} px, OpenCV {theirs_px:.2f}: {100 * by:.3f} % apart"
            check(by <= FOCAL, text)
        print(f"     window {window}: OpenCV's rms {rms:.4f} px, mean {np.mean(distances):.4f} px")
    print(f"OpenCV {cv2.__version__}, {len(greys)} pictures of {size[0]} x {size[1]} px: {len(bad)} disagreements")
    return len(bad) != 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

"""What `dump` reads from TDMS files is what npTDMS reads, channel by channel and value by value.

usage: read_tdms.py DUMP FILE.tdms.. (DUMP: the built example of pneuval-ingest)

A file that npTDMS refuses, or of which it gives raw numbers for want of a scale, must be refused or told. Times are compared as stored,
to the fraction of 2^-64 s.
"""

import collections
import json
import logging
import math
import subprocess
import sys

import numpy as np
from nptdms import TdmsFile

logging.disable(logging.WARNING)
S_1904_TO_1970 = 2_082_844_800


def lines_of(dump, files):
    """What the example prints, by file: its first line and its columns."""
    out = subprocess.run([dump, *files], check=True, capture_output=True, text=True).stdout
    heads, columns = {}, collections.defaultdict(dict)
    for line in map(json.loads, out.splitlines()):
        if "column" in line:
            columns[line["file"]][line["table"], line["column"]] = line
        else:
            heads[line["file"]] = line
    return heads, columns


def numbers(column):
    return np.array([math.nan if x is None else x for x in column["numbers"]], dtype=np.float64)


def same(ours, theirs):
    """Equal, but for holes behind the last value of a channel that the end of the file cuts off. JSON has no infinity: it is a hole."""
    theirs = np.where(np.isfinite(theirs), theirs, math.nan)
    ours, rest = ours[: len(theirs)], ours[len(theirs) :]
    return np.array_equal(ours, theirs, equal_nan=True) and np.isnan(rest).all()


def origin_of(head):
    return int(np.datetime64(head["origin"].rstrip("Z"), "s").astype(np.int64)) + S_1904_TO_1970


def channel(head, columns, group, name, of, scaled):
    """Whether a channel is read alike."""
    counts = {} if scaled else of.read_data(scaled=False)
    if isinstance(counts, dict) and counts:
        for scaler, values in counts.items():
            one = columns.get((group, name)) or columns[group, f"{name}[{scaler}]"]
            if not same(numbers(one), values.astype(np.float64)):
                return False
        return True
    values = of[:]
    if np.iscomplexobj(values):
        parts = [columns[group, f"{name}.{part}"] for part in ("re", "im")]
        return same(numbers(parts[0]), values.real.astype(float)) and same(numbers(parts[1]), values.imag.astype(float))
    column = columns[group, name]
    if values.dtype == object:
        return len(values) == 0 or column["text"][: len(values)] == list(values)
    if hasattr(values, "second_fractions"):
        if len(values) == 0:
            return True
        origin = origin_of(head)
        # One rounding: the sum is exact in Python's integers.
        stored = zip(values.seconds.tolist(), values.second_fractions.tolist())
        return same(numbers(column), np.array([((s - origin) * 2**64 + f) / 2**64 for s, f in stored]))
    if values.dtype.kind == "V":
        return len(values) == 0
    return same(numbers(column), values.astype(np.float64))


def main(dump, files):
    heads, columns = lines_of(dump, files)
    bad = compared = values = refused = 0
    for file in files:
        head = heads[file]
        try:
            theirs = TdmsFile.read(file, raw_timestamps=True)
            channels = [(g.name, c.name, c) for g in theirs.groups() for c in g.channels()]
            for _, _, of in channels:
                if any("Scale_Type" in key for key in of.properties) or of.dtype.kind != "V":
                    of[:]
        except Exception as error:  # Whatever it is: it does not read the file.
            print(f"{file}: npTDMS says {error!r}; here: {head.get('error', 'READ').splitlines()[-2:]}")
            bad += "error" not in head
            refused += 1
            continue
        if "error" in head:
            print(f"{file}: {head['error']}")
            bad += 1
            continue
        for group, name, of in channels:
            raw = bool(of.scaler_data_types) and not any("NI_Number_Of_Scales" in k for k in of.properties)
            try:
                alike = channel(head, columns[file], group, name, of, scaled=not raw)
            except KeyError as error:
                print(f"{file}: no column {error}")
                alike = False
            compared, values = compared + 1, values + len(of)
            if not alike:
                bad += 1
                print(f"{file}: {group}/{name} differs")
    print(f"{len(files)} files, {compared} channels, {values} values compared, {refused} refused by both; {bad} differ")
    return bad


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]) != 0)

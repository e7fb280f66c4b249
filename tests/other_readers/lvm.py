"""Whether lvm_read and pandas read what our writer of LabVIEW measurement files writes, value by value:
python lvm.py FOLDER, or python lvm.py PROGRAM, the example `write_lvm` of pneuval-ingest."""

import csv
import datetime
import math
import pathlib
import subprocess
import sys
import tempfile

import lvm_read
import pandas


def truth_of(path):
    """Names and columns as they should be read; a shorter column ends with NaN."""
    with path.open(newline="") as file:
        names, *rows = list(csv.reader(file))
    return names, [[row[i] for row in rows] for i in range(len(names))]


def same(read, true):
    return read == true or (math.isnan(read) and math.isnan(true))


def start_of(segment, channel):
    if "Date" not in segment:
        return None
    at = [i for i, cell in enumerate(segment["Date"]) if cell][channel]
    time = segment["Time"][at].replace(",", ".").split(".")[0]
    return datetime.datetime.strptime(f"{segment['Date'][at]} {time}", "%Y/%m/%d %H:%M:%S")


def check_lvm_read(path):
    names, columns = truth_of(path.with_suffix(".csv"))
    kind = path.name.split("_")[0]
    lvm = lvm_read.read(str(path), read_from_pickle=False, dump_file=False)
    assert lvm["X_Columns"].lower() == kind, lvm["X_Columns"]
    origin, row, compared = None, 0, 0
    for number in range(lvm["Segments"]):
        segment = lvm[number]
        heads, data = segment["Channel names"], segment["data"]
        if kind == "no":
            heads = ["X_Value", *heads]
        start = start_of(segment, 0)
        origin = origin or start
        offset = (start - origin).total_seconds() if start else 0.0
        true_of = {}
        x_seen = 0
        for column, head in enumerate(heads):
            if head == "X_Value":
                # The X of the second table stands before its channels.
                at = [i for i, name in enumerate(names) if name == "X_Value"]
                true_of[column] = at[0 if column < 2 * 2 or kind != "multi" else 1]
                x_seen += 1
            elif head != "Comment":
                true_of[column] = names.index(head)
        for i, line in enumerate(data):
            for column, index in true_of.items():
                if kind == "no" and column == 0:
                    x0, step = segment["X0"][0], segment["Delta_X"][0]
                    read, true = offset + x0 + i * step, float(columns[index][row])
                    assert abs(read - true) < 1e-9, (path.name, row, read, true)
                    continue
                read = float(line[column - 1 if kind == "no" else column])
                true = float(columns[index][row] or "nan")
                if heads[column] == "X_Value":
                    read += offset
                assert same(read, true), (path.name, row, heads[column], read, true)
                compared += 1
            if "comments" in segment:
                said = columns[names.index("Comment")][row]
                assert segment["comments"][i] == said, (path.name, row, segment["comments"][i], said)
            row += 1
    assert row == len(columns[0]), (path.name, row, len(columns[0]))
    return compared


def check_pandas(path):
    """Files of one segment are a table behind the line of names."""
    names, columns = truth_of(path.with_suffix(".csv"))
    lines = path.read_text().split("\n")
    at = next(i for i, line in enumerate(lines) if line.startswith("X_Value"))
    _, parting, *_ = path.name.split("_")
    word, sign = parting.split("-")
    separator = {"tab": "\t", "comma": ",", "semicolon": ";"}[word]
    frame = pandas.read_csv(
        path, sep=separator, decimal="," if sign == "comma" else ".", skiprows=at
    )
    compared = 0
    for name in ["a", "b [2]"]:
        for read, true in zip(frame[name], columns[names.index(name)], strict=True):
            assert same(float(read), float(true or "nan")), (path.name, name, read, true)
            compared += 1
    return compared


def check(folder):
    files = sorted(pathlib.Path(folder).glob("*.lvm"))
    assert files, f"no files in {folder}"
    by_lvm_read = sum(check_lvm_read(path) for path in files)
    alone = [path for path in files if "_all_" in path.name or "_header_" in path.name]
    by_pandas = sum(check_pandas(path) for path in alone)
    print(f"{len(files)} files: {by_lvm_read} values by lvm_read {lvm_read.__version__}, {by_pandas} by pandas, all equal")


if pathlib.Path(sys.argv[1]).is_dir():
    check(sys.argv[1])
else:
    with tempfile.TemporaryDirectory() as name:
        subprocess.run([sys.argv[1], name], check=True)
        check(name)

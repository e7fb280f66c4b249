"""Whether what `pneuval export` writes is read by others, value by value: python export.py PNEUVAL.

MCAP by mcap with mcap-ros2-support and by rosbags, CSV by pandas, Parquet by pyarrow, pandas and polars.
"""

import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import pandas
import polars
import pyarrow.parquet
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

ROWS = 5_000
SYNTHETIC = "SYNTHETIC: written by a program, not by an instrument"

SESSION = """schema = 1
id = "2026-monday"
actuator = "bellows"
title = "A title; with = signs # and\\u0009tabs"
synthetic = true
excluded_max = { value = 50, unit = "%" }
[clock]
column = "t"
[[channel]]
id = "pressure"
column = "p"
unit = "kPa"
reference = "gauge"
commanded = true
[[channel]]
id = "tip-x"
column = "x"
unit = "mm"
[[channel]]
id = "tip-z"
column = "z"
unit = "mm"
[[channel]]
id = "share"
column = "s"
unit = "%"
[[channel]]
id = "lambda"
column = "l"
unit = "1"
[[derived]]
id = "way"
rule = "displacement"
from = ["tip-x", "tip-z"]
unit = "mm"
[[run]]
file = "run 1.csv"
[[run]]
file = "2.csv"
[[response]]
quantity = { id = "tip", title = "Tip", unit = "mm", components = ["x", "z"] }
pressure = [{ channel = "pressure", chamber = "air" }]
measured = { channel = ["tip-x", "tip-z"] }
points = { from = "plateaus", tolerance = { value = 0.1, unit = "kPa" }, hold = { value = 1, unit = "s" }, window = { value = 0.5, unit = "s" } }
"""

ACTUATOR = """schema = 1
id = "bellows"
title = "Bellows"
[chamber.air]
pressure_gauge_max = { value = 40, unit = "kPa", source = "measured" }
[[model]]
kind = "imported"
form = "fea"
title = "FEA"
quantity = { id = "tip", title = "Tip", unit = "mm", components = ["x", "z"] }
file = "fea.csv"
pressure = { column = "p", chamber = "air", reference = "gauge" }
predicted = ["x", "z"]
"""

# What the table says at the pressures of the steps; beyond 40 kPa it says nothing.
FEA = {0: (0.0, 100.0), 20: (31.4, 80.3), 40: (61.7, 40.1), 50: (math.nan, math.nan)}


def stamp(i):
    return f"2026-05-04 09:13:{i // 100 % 60:02}.{i % 100:02}0"


def truth():
    """Columns of the first run, as they should be read; NaN is a hole."""
    steps = [[0, 20, 40, 50][i * 4 // ROWS] for i in range(ROWS)]
    x = [math.nan if i == 7 else float(f"{i % 97 * 0.157:.3f}") for i in range(ROWS)]
    z = [float(f"{i % 89 * 0.314:.3f}") for i in range(ROWS)]
    origin = (x[0], z[0])
    return {
        "time_s": [i / 100 for i in range(ROWS)],
        "pressure_commanded_kPa": [float(p) for p in steps],
        "tip_x_mm": x,
        "tip_z_mm": z,
        "share_percent": [float(f"{i % 1000 / 10:.1f}") for i in range(ROWS)],
        "lambda": [float(f"{1 + i / 1e4:.4f}") for i in range(ROWS)],
        "way_mm": [math.hypot(a - origin[0], b - origin[1]) for a, b in zip(x, z)],
        "tip_x_predicted_fea_mm": [FEA[p][0] for p in steps],
        "tip_z_predicted_fea_mm": [FEA[p][1] for p in steps],
    }


def write(folder, columns):
    (folder / "session.toml").write_text(SESSION)
    (folder / "actuator.toml").write_text(ACTUATOR)
    rows = [f"{p},{x},{z}" for p, (x, z) in FEA.items() if p <= 40]
    (folder / "fea.csv").write_text("\n".join(["p,x,z", "kPa,mm,mm", *rows]) + "\n")
    names = ["pressure_commanded_kPa", "tip_x_mm", "tip_z_mm", "share_percent", "lambda"]
    cells = zip(*(columns[name] for name in names))
    lines = [f"{stamp(i)}," + ",".join("" if math.isnan(v) else repr(v) for v in row) for i, row in enumerate(cells)]
    (folder / "run 1.csv").write_text("\n".join(["t,p,x,z,s,l", *lines]) + "\n")
    (folder / "2.csv").write_text("\n".join(["t,p,x,z,s,l", *lines[: ROWS // 2]]) + "\n")


def check(reader, read, columns):
    """Asserts that columns are what they should be; what is computed may differ in the last digits."""
    assert list(read) == list(columns), (reader, list(read))
    for name, values in columns.items():
        assert len(read[name]) == len(values), (reader, name)
        exact = name != "way_mm"
        for row, (found, expected) in enumerate(zip(read[name], values)):
            hole = found is None or math.isnan(found)
            same = hole if math.isnan(expected) else not hole and (
                found == expected if exact else abs(found - expected) <= 1e-12 * (1 + abs(expected))
            )
            assert same, (reader, name, row, found, expected)
    print(f"{reader}: {len(columns)} columns of {len(values)} values")


def field(name):
    return name.lower()


def check_mcap(path, columns):
    fields = {field(name): values for name, values in columns.items()}
    expected_ns = [round(t * 1e9) + 1_777_885_980 * 10**9 for t in columns["time_s"]]
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2" and reader.get_header().library == "pneuval"
        (record,) = [m for m in reader.iter_metadata() if m.name == "pneuval"]
        assert record.metadata["synthetic"] == "true" and record.metadata["warning"] == SYNTHETIC
        topic = "/run_1"
        about = {name: json.loads(record.metadata[f"{topic}.{name}"]) for name in fields}
        assert about["pressure_commanded_kpa"]["unit"] == "kPa"
        assert about["pressure_commanded_kpa"]["origin"] == "commanded"
        assert about["tip_z_predicted_fea_mm"]["form"] == "fea"
        read, stamps = {name: [] for name in fields}, []
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert (channel.topic, schema.encoding, channel.message_encoding) == (topic, "ros2msg", "cdr")
            assert re.fullmatch(r"[a-z_]+/msg/[A-Z][A-Za-z0-9]*", schema.name), schema.name
            assert SYNTHETIC in schema.data.decode()
            at = decoded.header.stamp.sec * 10**9 + decoded.header.stamp.nanosec
            assert at == message.log_time == message.publish_time
            assert decoded.header.frame_id == "SYNTHETIC"
            stamps.append(at)
            for name in fields:
                read[name].append(getattr(decoded, name))
        assert stamps == expected_ns
        check("mcap", read, fields)
    for name in fields:
        assert re.fullmatch(r"[a-z](_?[a-z0-9]+)*", name), name
    with AnyReader([path]) as bag:
        read = {name: [] for name in fields}
        for connection, at, raw in bag.messages():
            message = bag.deserialize(raw, connection.msgtype)
            for name in fields:
                # What Python keeps for itself has another name there.
                read[name].append(getattr(message, name, getattr(message, f"{name}_", None)))
            assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == at
        check("rosbags", read, fields)


def check_csv(path, columns):
    assert path.read_text().splitlines()[0] == f"# {SYNTHETIC}"
    frame = pandas.read_csv(path, comment="#", skiprows=[2])
    check("pandas, CSV", {name: frame[name].tolist() for name in frame}, columns)
    units = pandas.read_csv(path, comment="#", header=[0, 1], nrows=1).columns
    assert [unit for _, unit in units][:4] == ["s", "kPa", "mm", "mm"], units


def check_parquet(path, columns):
    table = pyarrow.parquet.read_table(path)
    words = polars.read_parquet_metadata(path)
    assert {k.decode(): v.decode() for k, v in pyarrow.parquet.read_metadata(path).metadata.items()} == words
    assert words["pneuval.synthetic"] == "true" and words["pneuval.warning"] == SYNTHETIC
    assert json.loads(words["pneuval.column.tip_x_mm"])["unit"] == "mm"
    assert table["tip_x_mm"].null_count == 1, "a hole is null, which is no number"
    check("pyarrow", {name: table[name].to_pylist() for name in table.column_names}, columns)
    frame = polars.read_parquet(path)
    check("polars", {name: frame[name].to_list() for name in frame.columns}, columns)
    frame = pandas.read_parquet(path)
    check("pandas, Parquet", {name: frame[name].tolist() for name in frame}, columns)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    columns = truth()
    write(folder, columns)
    checks = {"mcap": check_mcap, "csv": check_csv, "parquet": check_parquet}
    for form, of in checks.items():
        out = folder / f"out-{form}"
        command = [sys.argv[1], "export", str(folder), "--out", str(out), "--format", form, "--json"]
        told = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        assert json.loads((out / "pneuval_export.json").read_text()) == told
        of(out / "2026-monday" / f"run-1.{form}", columns)
        if form != "mcap":
            points = out / "2026-monday" / f"points.{form}"
            frame = pandas.read_csv(points, comment="#", skiprows=[2]) if form == "csv" else pandas.read_parquet(points)
            assert list(frame["pressure_air_kPa"]) == [0, 20, 40, 50]
            assert list(frame["runs"]) == ["run 1.csv, 2.csv", "run 1.csv, 2.csv", "run 1.csv", "run 1.csv"]
            assert list(frame["tip_status_fea"])[1:] == ["used", "used", "no_prediction"], frame["tip_status_fea"]
            assert list(frame["tip_x_predicted_fea_mm"])[:3] == [0, 31.4, 61.7]

"""Whether npTDMS reads what the TDMS writer writes, value by value: python tdms.py FOLDER.

FOLDER is what `cargo run -p pneuval-ingest --example write_tdms -- FOLDER` makes. Each file is read by itself and by its index.
"""

import csv
import io
import math
import pathlib
import sys
from fractions import Fraction

import numpy
from nptdms import TdmsFile

ORIGIN = Fraction(3_873_400_000) + Fraction(0xC000_0000_0000_0001, 2**64)


def check(tdms, rows):
    """Asserts that a file holds these rows, and gives how many values were compared."""
    compared = 0
    clocks = {row[1]: row for row in rows if row[0] == "waveform"}
    expected = {(row[1], row[2]) for row in rows if row[0] not in ("waveform", "property")}
    assert {(c.group_name, c.name) for g in tdms.groups() for c in g.channels()} == expected
    kinds = {"text": str, "bool": lambda text: text == "true", "single": float, "double": float, "int": int, "uint": int}
    stated = [row for row in rows if row[0] == "property"]
    assert len(tdms.properties) == len(stated)
    for _, kind, name, value in stated:
        found = tdms.properties[name]
        if kind == "time":
            assert [found.seconds, found.second_fractions] == [int(part) for part in value.split()]
        else:
            assert found == kinds[kind](value), (name, found, value)
    assert tdms["rig"].properties == {"specimen": "A-3"}
    assert tdms["rig"]["p"].properties["sensor"] == "MPX5100"
    for kind, group, name, unit, *values in rows:
        if kind in ("waveform", "property"):
            continue
        channel = tdms[group][name]
        assert channel.properties.get("unit_string", "") == ("" if kind == "instants" else unit)
        data = channel[:] if len(channel) else []
        assert len(channel) == len(data) == len(values), (group, name, len(data), len(values))
        if kind == "text":
            assert list(data) == values
        elif kind == "instants":
            for stamp, text in zip(data, values):
                at = stamp.seconds + Fraction(int(stamp.second_fractions), 2**64)
                assert abs(at - ORIGIN - Fraction(float(text))) <= Fraction(1, 2**65), (group, name)
        elif values:
            numbers = numpy.array([float(value) for value in values])
            if kind.startswith("within "):
                assert numpy.abs(data - numbers).max() <= float(kind[7:]) * (1 + 1e-12)
            else:
                kept = numbers.astype(numpy.float32) if kind == "single" else numbers
                assert data.dtype == kept.dtype and numpy.array_equal(data, kept, equal_nan=True), (group, name)
        if group in clocks:
            stamps = numpy.array([float(value) for value in clocks[group][4:]])
            assert numpy.abs(channel.time_track() - stamps).max() <= 4 * math.ulp(stamps.max())
            assert channel.properties["wf_samples"] == len(stamps)
            assert (channel.properties["wf_xname"], channel.properties["wf_xunit_string"]) == ("Time", "s")
            start = channel.properties.get("wf_start_time")
            has_origin = any(row[0] == "instants" for row in rows)
            assert (start is not None) == has_origin
            if has_origin:
                assert start.seconds + Fraction(int(start.second_fractions), 2**64) == ORIGIN
            compared += len(stamps)
        else:
            assert "wf_increment" not in channel.properties
        compared += len(values)
    return compared


files = sorted(pathlib.Path(sys.argv[1]).glob("*.tdms"))
compared = 0
for path in files:
    rows = list(csv.reader(io.StringIO(path.with_suffix(".csv").read_text(), newline="")))
    assert path.with_suffix(".tdms_index").exists()
    compared += check(TdmsFile.read(path, raw_timestamps=True), rows)
    compared += check(TdmsFile.read(io.BytesIO(path.read_bytes()), raw_timestamps=True), rows)
assert files
print(f"{len(files)} files, each with its index and without: {compared} values as written")

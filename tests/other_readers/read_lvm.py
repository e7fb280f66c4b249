"""What `dump` reads from measurement files of LabVIEW is what lvm_read reads, channel by channel and value by value.

usage: read_lvm.py DUMP FILE.lvm.. (DUMP: the built example of pneuval-ingest)

Y is compared bit by bit. X is compared with what lvm_read gives or with `X0 + i Delta_X`, and its place in time with `Date` and `Time`.
Where lvm_read fails, or is known to be wrong, a line says so and the file or the channel is left out.
"""

import collections
import datetime
import json
import math
import subprocess
import sys

import lvm_read
import numpy as np

NULL_STAMP = datetime.datetime(1904, 1, 1)


def lines_of(dump, files):
    """What the example prints, by file: its first line, and its columns, table by table."""
    out = subprocess.run([dump, *files], check=True, capture_output=True, text=True).stdout
    heads, tables = {}, collections.defaultdict(list)
    for line in map(json.loads, out.splitlines()):
        if "column" not in line:
            heads[line["file"]] = line
            continue
        of_file = tables[line["file"]]
        # The stamps are the first column of a table.
        if line["column"].split(" (")[0] == "X_Value" and (line["unit"] == "s" or line["unit"] is None):
            of_file.append([])
        of_file[-1].append(line)
    return heads, tables


def numbers(column):
    return np.array([math.nan if x is None else x for x in column["numbers"]], dtype=np.float64)


def start_of(header, at):
    """When a channel began, as its header states it; `None` where it does not, or not by year, month, day."""
    one = lambda key: next((v.strip() for v in [*header.get(key, [])[at : at + 1], *header.get(key, [])] if v.strip()), "")
    try:
        date, (time, _, rest) = one("Date"), one("Time").replace(",", ".").partition(".")
        start = datetime.datetime.strptime(f"{date} {time}", "%Y/%m/%d %H:%M:%S")
    except ValueError:
        return None
    # An empty stamp is LabVIEW's zero, in whatever zone.
    if abs(start - NULL_STAMP) < datetime.timedelta(days=2):
        return None
    return start, float(f"0.{rest or 0}")


class Segment:
    """A segment as lvm_read has it: its channels, each with its column of Y and, where the file has one, of X."""

    def __init__(self, lvm, segment):
        names = [name.strip().strip('"') for name in segment["Channel names"]]
        self.is_no = lvm.get("X_Columns") == "No"
        self.header = segment
        self.data = np.asarray(segment["data"], dtype=np.float64)
        if self.data.ndim < 2:
            self.data = self.data.reshape(len(self.data), -1 if self.data.size else len(names))
        if names and names[-1] == "Comment":
            names.pop()
        while names and not names[-1]:
            names.pop()
        self.channels = []
        x = None
        for column, name in enumerate(names):
            if not self.is_no and (column == 0 or name == "X_Value"):
                x = column
            else:
                # The header has no value for the first column of X.
                self.channels.append((name or f"column {column + 1 + self.is_no}", column, x, column - (not self.is_no)))
        units = [unit.strip() for unit in segment.get("Y_Unit_Label", [])]
        own = [(name, units[at] if at < len(units) else "") for name, _, _, at in self.channels]
        self.kind = (self.is_no, str(own), str(segment.get("X_Dimension")))

    def column(self, at):
        return self.data[:, at] if at < self.data.shape[1] else np.full(len(self.data), math.nan)

    def values_of(self, key, at):
        values = self.header.get(key, [])
        return values[at] if at < len(values) else math.nan

    def blank_end(self, members):
        """Rows at the end that hold nothing for these channels."""
        columns = [self.column(c) for _, y, x, _ in members for c in (y, x) if c is not None]
        filled = np.flatnonzero(~np.isnan(columns).all(axis=0)) if len(self.data) else []
        return len(self.data) - (filled[-1] + 1 if len(filled) else 0)


def names_of(segments):
    """What our columns are called: a name is that of one column, so a second of that name gets a number."""
    taken, names = set(), {}
    for segment in segments:
        if segment.kind not in names:
            given = []
            for base in ["X_Value", *(channel[0] for channel in segment.channels)]:
                name, copy = base, 1
                while name in taken:
                    copy += 1
                    name = f"{base} ({copy})"
                taken.add(name)
                given.append(name)
            names[segment.kind] = given[1:]
    return names


def same(ours, theirs):
    """Bit by bit, but for infinities, which are holes here."""
    return np.array_equal(ours, np.where(np.isfinite(theirs), theirs, math.nan), equal_nan=True)


def compare_x(ours, segment, channel, origin):
    """What differs in the stamps of a channel in a segment, or nothing."""
    _, _, x, at = channel
    dimension = next((d for d in segment.header.get("X_Dimension", ["Time"]) if d), "Time")
    is_implicit = x is None or np.isnan(segment.column(x)).all()
    if is_implicit:
        first, step = segment.values_of("X0", at), segment.values_of("Delta_X", at)
        first = 0.0 if math.isnan(first) else first
        theirs = first + np.arange(len(ours)) * step
        if not (step != 0):
            return None
    else:
        theirs = np.where(np.isfinite(segment.column(x)), segment.column(x), math.nan)[: len(ours)]
    if not np.array_equal(np.isnan(ours), np.isnan(theirs)):
        return "holes in X"
    added = (ours - theirs)[~np.isnan(ours)]
    if len(added) == 0:
        return None
    scale = max(1.0, np.nanmax(np.abs(ours)), np.nanmax(np.abs(theirs)))
    if np.ptp(added) > 4e-16 * scale * 4:
        return f"X is moved by {added.min()} to {added.max()}"
    start = start_of(segment.header, at)
    if start and origin and not origin.endswith("Z") and dimension == "Time" and abs(theirs[~np.isnan(theirs)][0]) < 1e9:
        second, fraction = start
        true = (second - datetime.datetime.fromisoformat(origin)).total_seconds() + fraction
        if abs(added[0] - true) > 1e-9 + 4e-16 * scale:
            return f"X begins {added[0]} s after the origin, by Date and Time {true} s"
    return None


def compare(file, head, tables, lvm):
    """What differs, and how many channels and values were compared."""
    segments = [Segment(lvm, lvm[i]) for i in range(lvm["Segments"])]
    names, odd, values = names_of(segments), [], 0
    table_of = {column["column"]: table for table in tables for column in table}
    channels = 0
    # A start that goes back is told and not used.
    is_back = any(kind == "time-reversed" for _, kind, _ in head["findings"])
    origin = None if is_back else head["origin"]
    # What a cut may have left of the last row, lvm_read takes for whole.
    is_cut = any(kind in ("truncated", "no-line-end") for _, kind, _ in head["findings"])
    for kind, of_kind in names.items():
        alike = [segment for segment in segments if segment.kind == kind]
        for index, name in enumerate(of_kind):
            table = table_of.get(name)
            if table is None and is_cut and not any(len(segment.data) for segment in alike):
                continue
            if table is None:
                odd.append(f"{name}: no such column")
                continue
            channels += 1
            mine = {column["column"] for column in table}
            members = [i for i, other in enumerate(of_kind) if other in mine]
            x, y = numbers(table[0]), numbers(next(column for column in table if column["column"] == name))
            at = 0
            for number, segment in enumerate(alike):
                theirs = segment.column(segment.channels[index][1])
                blank = segment.blank_end([segment.channels[i] for i in members])
                sure = len(theirs) - blank
                if is_cut and segment is segments[-1]:
                    sure, blank = max(sure - 1, 0), blank + 1
                if not same(y[at : at + sure], theirs[:sure]):
                    odd.append(f"{name}, segment {number}: Y differs, or rows are missing")
                    break
                wrong = compare_x(x[at : at + sure], segment, segment.channels[index], origin)
                if wrong:
                    odd.append(f"{name}, segment {number}: {wrong}")
                at += sure
                values += 2 * sure
                # Rows that hold nothing for all channels of a table end its segment here, unless something is said of them.
                of_rows = [numbers(column) for column in table if column["numbers"] is not None][segment.is_no :]
                while blank and at < len(y) and all(np.isnan(column[at]) for column in of_rows):
                    at, blank = at + 1, blank - 1
            else:
                if at + (is_cut and blank + 1) < len(y):
                    odd.append(f"{name}: {len(y)} rows, lvm_read has {at}")
    return odd, channels, values


def known_to_be_wrong(lines):
    """Why lvm_read does not read what the file says, if so."""
    has_comma = any(line.startswith(("Time", "X0", "Delta_X")) and "," in line for line in lines)
    is_stated = any(line.startswith("Decimal_Separator") for line in lines)
    if has_comma and not is_stated and not any(line.startswith("Separator,") for line in lines):
        return "takes the point for the decimal sign where none is stated"
    is_row = False
    for before, line in zip(lines, lines[1:]):
        is_row |= before.startswith("X_Value")
        if is_row and not before.strip(" \t,;\r\n"):
            is_row = not line.strip(" \t,;\r\n")
            if line[:1] in "\t,;-.0123456789" and line.strip(" \t,;\r\n"):
                return "drops rows behind a blank line that no header follows"
    return None


def main(dump, files):
    heads, tables = lines_of(dump, files)
    bad = channels = values = left_out = 0
    for file in files:
        head = heads[file]
        raw = open(file, "rb").read()
        try:
            try:
                text = raw.decode()
                lvm = lvm_read.read(file, read_from_pickle=False, dump_file=False)
            except UnicodeDecodeError:
                print(f"{file}: lvm_read drops bytes that are not UTF-8; it is given the text as Latin-1")
                text = raw.decode("latin-1")
                lvm = lvm_read.read_str(text)
            if not any("data" in lvm[i] for i in range(lvm["Segments"])):
                raise ValueError("no data")
        except Exception as error:  # Whatever it is: it does not read the file.
            print(f"{file}: lvm_read fails with {error!r}; here: {head.get('error', 'read').splitlines()[-1]}")
            left_out += 1
            continue
        if "error" in head:
            print(f"{file}: {head['error']}")
            bad += 1
            continue
        why = known_to_be_wrong(text.splitlines())
        if why:
            print(f"{file}: lvm_read {why}")
            left_out += 1
            continue
        odd, more_channels, more_values = compare(file, head, tables[file], lvm)
        channels, values, bad = channels + more_channels, values + more_values, bad + len(odd)
        for text in odd:
            print(f"{file}: {text}")
    print(f"{len(files)} files, {channels} channels, {values} values compared, {left_out} files left out; {bad} differ")
    return bad


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]) != 0)

"""Whether independent readers read every format of a rehearsed session with equal values.

usage: rehearsed.py PNEUVAL DUMP (the built binary, and the built example `dump` of pneuval-ingest)

The same seed logs the same numbers in every format. The reference is the delimited text as pandas reads it; npTDMS, lvm_read, mcap with
its ROS 2 and Protobuf decoders, rosbags and pandas must give the same numbers of every channel bit by bit, and so must our own reader
of each of these files. Force gauges and trackers, whose numbers other decimals round, are compared as they are written there.
"""

import collections
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile

import lvm_read
import numpy as np
import pandas
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2
from nptdms import TdmsFile
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

ACTUATORS = ["internal-support", "dual-chamber-finger", "wave-finger", "fruit-finger", "pdms-wall"]
# The recorder's origin: 2026-01-01 00:00 UTC.
ORIGIN_NS = 1_767_225_600 * 10**9


def rehearse(pneuval, actuator, folder, *more):
    out = folder / "-".join([actuator, *[word.lstrip("-") for word in more]])
    subprocess.run([pneuval, "rehearse", actuator, "--out", out, *more], check=True, capture_output=True)
    return out


def pandas_csv(path):
    frame = pandas.read_csv(path, comment="#", skiprows=[2])
    return {name: frame[name].to_numpy(dtype=np.float64) for name in frame.columns}


def serial(path):
    """Pandas reads lines of pairs once they are taken apart: `t=0.01 pressure=1.5kPa`."""
    rows = []
    for line in path.read_text().splitlines():
        if not line.startswith("#"):
            pairs = (pair.split("=") for pair in line.split(" "))
            rows.append({key: float(re.match(r"-?[0-9.]+", value).group()) for key, value in pairs})
    frame = pandas.DataFrame(rows)
    return {name: frame[name].to_numpy(dtype=np.float64) for name in frame.columns}


def lvm(path):
    read = lvm_read.read(str(path), read_from_pickle=False, dump_file=False)
    segment = read[0]
    names = [name for name in segment["Channel names"] if name and name != "Comment"]
    data = np.asarray(segment["data"], dtype=np.float64)
    columns = {name: data[:, at] for at, name in enumerate(names)}
    columns["t"] = columns.pop("X_Value")
    return columns


def tdms(path):
    columns = {}
    for group in TdmsFile.read(path).groups():
        for channel in group.channels():
            columns[channel.name] = channel[:].astype(np.float64)
    return columns


def mcap_columns(path, factory):
    columns = collections.defaultdict(list)
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[factory()] if factory else [])
        if factory:
            messages = ((message, decoded) for _, _, message, decoded in reader.iter_decoded_messages())
        else:
            messages = ((message, json.loads(message.data)) for _, _, message in reader.iter_messages())
        for _, decoded in messages:
            fields = decoded if isinstance(decoded, dict) else None
            if fields is None:
                names = [f.name for f in decoded.DESCRIPTOR.fields] if hasattr(decoded, "DESCRIPTOR") else decoded.__slots__
                fields = {name: getattr(decoded, name) for name in names}
            for name, value in fields.items():
                columns[name].append(value)
    return {name: np.array(values, dtype=np.float64) for name, values in columns.items()}


def rosbag(path):
    """The bag by the definitions that stand in it."""
    columns = collections.defaultdict(list)
    # A bag folder, as rosbag2 writes one around the file.
    folder = path.with_suffix(".bag")
    folder.mkdir()
    (folder / path.name).write_bytes(path.read_bytes())
    with open(path, "rb") as stream:
        summary = make_reader(stream).get_summary()
    topics = "".join(
        f"    - topic_metadata: {{name: {channel.topic}, type: {summary.schemas[channel.schema_id].name}, "
        f"serialization_format: cdr, offered_qos_profiles: ''}}\n      message_count: {summary.statistics.channel_message_counts[id]}\n"
        for id, channel in summary.channels.items()
    )
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n"
        f"  duration: {{nanoseconds: {summary.statistics.message_end_time - summary.statistics.message_start_time}}}\n"
        f"  starting_time: {{nanoseconds_since_epoch: {summary.statistics.message_start_time}}}\n"
        f"  message_count: {summary.statistics.message_count}\n  topics_with_message_count:\n{topics}"
        f"  compression_format: ''\n  compression_mode: ''\n  relative_file_paths: [{path.name}]\n"
    )
    store = get_typestore(Stores.EMPTY)
    with Reader(folder) as reader:
        for connection in reader.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            for _, _, raw in reader.messages(connections=[connection]):
                message = store.deserialize_cdr(raw, connection.msgtype)
                for name in message.__dataclass_fields__:
                    if name != "__msgtype__":
                        columns[name].append(getattr(message, name))
    return {name: np.array(values, dtype=np.float64) for name, values in columns.items()}


def gauge(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return {"force": np.array([float(line.split("\t")[1].split(" ")[0]) for line in lines])}


def trakstar(path):
    frame = pandas.read_csv(path, comment="#")
    frame["time1"] = pandas.to_timedelta(frame["time1"]).dt.total_seconds()
    return {name: frame[name].to_numpy(dtype=np.float64) for name in frame.columns}


def equal(a, b):
    return np.array_equal(a, b, equal_nan=True)


class Check:
    def __init__(self, dump):
        self.dump, self.channels, self.values, self.files, self.wrong = dump, 0, 0, 0, []

    def ours(self, path):
        out = subprocess.run([self.dump, path], check=True, capture_output=True, text=True).stdout
        columns = {}
        for line in map(json.loads, out.splitlines()):
            if "column" in line and line.get("numbers") is not None:
                name = line["column"].split(".")[-1]
                columns[name] = np.array([math.nan if x is None else x for x in line["numbers"]])
        return columns

    def __call__(self, reader, path, read, wanted):
        """`wanted` of the reference is in what a reader gives, and what it gives is what ours gives."""
        self.files += 1
        ours = self.ours(path)
        for name, values in wanted.items():
            for who, columns in [(reader, read), ("pneuval", ours)]:
                self.channels += 1
                self.values += len(values)
                if name not in columns or not equal(columns[name], values):
                    self.wrong.append(f"{path.parent.name}/{path.name}: {name} by {who}")


def columns_of_run(session, run):
    """The reference: all delimited files of a run."""
    columns = {}
    for path in sorted(session.glob(f"{run}*.csv")):
        columns |= {name: values for name, values in pandas_csv(path).items() if name != "t"}
    return columns


def main(pneuval, dump):
    check = Check(dump)
    bags = {
        ("cdr", "zstd"): [("mcap-ros2-support", lambda p: mcap_columns(p, Ros2)), ("rosbags", rosbag)],
        ("json", "lz4"): [("mcap", lambda p: mcap_columns(p, None))],
        ("protobuf", "none"): [("mcap-protobuf-support", lambda p: mcap_columns(p, Protobuf))],
        ("cdr", "none"): [("mcap-ros2-support", lambda p: mcap_columns(p, Ros2))],
    }
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for actuator in ACTUATORS:
            more = ["--repeats", "1"]
            reference = rehearse(pneuval, actuator, folder, *more, "--format", "csv")
            sessions = [path.parent.relative_to(reference) for path in reference.rglob("session.toml")]

            def runs(out, ending):
                for session in sessions:
                    for path in sorted((out / session).glob(f"*run-1*.{ending}")):
                        yield path, path.name.split("run-1")[0] + "run-1", reference / session

            for path, run, _ in runs(reference, "csv"):
                check("pandas", path, pandas_csv(path), pandas_csv(path))
            for name, ending, read in [("serial", "log", serial), ("lvm", "lvm", lvm)]:
                out = rehearse(pneuval, actuator, folder, *more, "--format", name)
                for path, _, session in runs(out, ending):
                    wanted = pandas_csv(session / path.with_suffix(".csv").name)
                    if name == "lvm":
                        # Ours calls it as the file does.
                        stamps = wanted.pop("t")
                        assert equal(read(path)["t"], stamps), path
                    check("lvm_read" if name == "lvm" else "pandas", path, read(path), wanted)
            out = rehearse(pneuval, actuator, folder, *more, "--format", "tdms")
            for path, run, session in runs(out, "tdms"):
                check("npTDMS", path, tdms(path), columns_of_run(session, run))
            for (encoding, compression), readers in bags.items():
                out = rehearse(
                    pneuval, actuator, folder, *more, "--format", "mcap", "--encoding", encoding, "--compression", compression
                )
                for path, run, session in runs(out, "mcap"):
                    for reader, read in readers:
                        check(reader, path, read(path), columns_of_run(session, run))
            own = rehearse(pneuval, actuator, folder, *more)
            for session in sessions:
                for path in sorted((own / session).glob("*run-1*-gauge.txt")):
                    wanted = pandas_csv(reference / session / path.with_suffix(".csv").name)
                    check("pandas", path, gauge(path), {"force": wanted["force"]})
                for path in sorted((own / session).glob("*run-1*-tracker.log")):
                    read = trakstar(path)
                    wanted = pandas_csv(reference / session / path.with_suffix(".csv").name)
                    shown = {"x1 (mm)": wanted["x"] if "x" in wanted else wanted["displacement"]}
                    if "z" in wanted:
                        shown["z1 (mm)"] = wanted["z"]
                    check("pandas", path, read, shown)
            for path in sorted(own.rglob("tensile/*.csv")):
                frame = pandas.read_csv(path, comment="#", skiprows=[3])
                check("pandas", path, {n: frame[n].to_numpy() for n in frame}, {n: frame[n].to_numpy() for n in frame})
    for line in check.wrong:
        print(f"DIFFERS {line}")
    print(f"{check.files} files, {check.channels} channels, {check.values} values compared, {len(check.wrong)} channels differ")
    return 1 if check.wrong or check.files == 0 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:3]))

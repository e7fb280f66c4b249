"""Whether DuckDB, pandas and polars read what `pneuval ingest` stores: python store.py PNEUVAL."""

import pathlib
import subprocess
import sys
import tempfile

import duckdb
import pandas
import polars

SESSION = """schema = 1
id = "monday"
actuator = "internal-support"
excluded_max = { value = 50, unit = "%" }
[clock]
column = "t"
unit = "ms"
[[channel]]
id = "pressure"
column = "p"
unit = "kPa"
reference = "gauge"
[[channel]]
id = "tip-force"
column = "F"
unit = "N"
[[run]]
file = "a.csv"
"""

with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    (folder / "session.toml").write_text(SESSION)
    rows = "".join(f"{i},{i / 4},{'' if i == 7 else i / 8}\n" for i in range(300_000))
    (folder / "a.csv").write_text("t,p,F\n" + rows)
    subprocess.run([sys.argv[1], "ingest", str(folder)], check=True)
    table = str(folder / ".pneuval" / "a.parquet")
    frames = {
        "duckdb": duckdb.sql(f"select * from '{table}'").df(),
        "pandas": pandas.read_parquet(table),
        "polars": polars.read_parquet(table).to_pandas(),
    }
    for reader, frame in frames.items():
        assert list(frame.columns) == ["time_s", "pressure_Pa", "tip_force_N"], (reader, frame.columns)
        assert len(frame) == 300_000 and frame["tip_force_N"].isna().sum() == 1, reader
        assert (frame["pressure_Pa"] == [i * 250.0 for i in range(300_000)]).all(), reader
        assert abs(frame["time_s"].iloc[-1] - 299.999) < 1e-9, reader
        print(f"{reader}: {len(frame)} rows, {list(frame.columns)}")

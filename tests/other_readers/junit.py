"""JUnit documents against the schema that Jenkins reads them by, and results.json against the schema beside it.

usage: junit.py PNEUVAL SCHEMA.xsd
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import jsonschema
from lxml import etree

STRICTER = """schema = 1
[[bound]]
actuator = "internal-support"
quantity = "outer-diameter"
model = "published-theory"
metric = "max_abs_error"
max = { value = 0.5, unit = "mm" }
reason = "<script>]]>&amp; \\u001b[31m \\u202e and \\"quotes\\""
"""


def main(pneuval, schema):
    schema = etree.XMLSchema(etree.parse(schema))
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "stricter.toml").write_text(STRICTER)
        (folder / "none.toml").write_text("schema = 1\n")
        session = folder / "lab"
        subprocess.run([pneuval, "rehearse", "internal-support", "--out", session, "--fault", "gap"], check=True, stdout=subprocess.DEVNULL)
        for arguments, code in [
            ([], 0),
            (["--bounds", "stricter.toml"], 1),
            (["--bounds", "none.toml"], 3),
            (["--bounds", "stricter.toml", "--report-only"], 0),
            (["lab"], None),
        ]:
            said = subprocess.run([pneuval, "validate", *arguments, "--out", "out", "--no-figures"], cwd=folder, capture_output=True)
            assert code is None or said.returncode == code, (arguments, said.returncode, said.stderr)
            results = folder / "out" / "results"
            document = etree.parse(str(results / "junit.xml"))
            assert schema.validate(document), (arguments, schema.error_log)
            suites = document.getroot()
            for name, tag in [("tests", "testcase"), ("failures", "failure"), ("errors", "error")]:
                assert int(suites.get(name)) == len(suites.findall(f".//{tag}")), (arguments, name)
            is_bad = suites.get("failures") != "0" or suites.get("errors") != "0"
            assert is_bad == (said.returncode != 0), (arguments, said.returncode)
            stored = json.loads((results / "results.json").read_text())
            jsonschema.validate(stored, json.loads((results / "results.schema.json").read_text()))
            print(f"{' '.join(arguments) or 'papers'}: {suites.get('tests')} cases, exit {said.returncode}, valid by both schemas")


main(*sys.argv[1:])

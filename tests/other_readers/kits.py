"""The action and the pre-commit hook, run as a runner of GitHub Actions and pre-commit run them.

usage: kits.py PNEUVAL
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
ACTION = ROOT / ".github" / "actions" / "validate"
HOOKS = ROOT / ".pre-commit-hooks.yaml"
EXPRESSION = re.compile(r"\$\{\{\s*(.*?)\s*\}\}")
LOOSE, TIGHT = "max = { value = 2.5,", "max = { value = 0.5,"
HOSTILE = "it's \"a $(touch x) `touch x`; touch x #"
COMMAND = "a\n::error::injected\n##[error]injected"


def copied(folder, tight=False):
    """The repository's data without its code, as somebody else would keep them; on demand with one bound that fails."""
    for part in ["actuators", "bounds", "published", "rigs"]:
        shutil.copytree(ROOT / "datasets" / part, folder / part)
    if tight:
        tighten(folder)
    return folder


def tighten(folder):
    bounds = folder / "bounds" / "internal-support.toml"
    text = bounds.read_text()
    assert LOOSE in text
    bounds.write_text(text.replace(LOOSE, TIGHT, 1))


class Action:
    """A composite action, and what a runner does with it."""

    def __init__(self, pneuval):
        self.pneuval = pneuval
        self.action = yaml.safe_load((ACTION / "action.yml").read_text())
        self.steps = self.action["runs"]["steps"]
        self.check()

    def check(self):
        """What a runner asks of an action before it runs it, and that no input becomes part of a script."""
        action = self.action
        assert set(action) == {"name", "description", "inputs", "outputs", "runs"}, set(action)
        assert action["runs"]["using"] == "composite"
        for name, given in action["inputs"].items():
            assert given["description"] and isinstance(given["default"], str), name
        for name in ["exit-code", "decision", "report"]:
            assert action["outputs"][name]["value"] == f"${{{{ steps.validate.outputs.{name} }}}}", name
        assert any(step.get("id") == "validate" for step in self.steps)
        used = set()
        for step in self.steps:
            assert ("run" in step) != ("uses" in step), step
            used |= {name for text in told_by(step) for name in re.findall(r"inputs\.([\w-]+)", text)}
            if "run" in step:
                assert step["shell"] == "bash" and "${{" not in step["run"], step
            else:
                assert re.fullmatch(r"actions/[\w-]+@v\d+", step["uses"]), step
        assert used == set(action["inputs"]), used ^ set(action["inputs"])
        script = (ACTION / "run.sh").read_text()
        assert "${{" not in script and "set -euo pipefail" in script and "eval" not in script
        subprocess.run(["bash", "-n", ACTION / "run.sh"], check=True)

    def run(self, workspace, **given):
        """Every step; what a workflow would see."""
        inputs = {name: one["default"] for name, one in self.action["inputs"].items()}
        inputs |= {"binary": self.pneuval} | {name.replace("_", "-"): value for name, value in given.items()}
        assert set(inputs) == set(self.action["inputs"]), given
        seen = Seen(workspace)
        outputs = {}

        def value(expression):
            where, _, name = expression.rpartition(".")
            if where == "inputs":
                return inputs[name]
            step = re.fullmatch(r"steps\.([\w-]+)\.outputs", where)
            assert step, expression
            return outputs.get(step[1], {}).get(name, "")

        def filled(text):
            return EXPRESSION.sub(lambda found: value(found[1]), str(text))

        def holds(condition):
            terms = [term.strip() for term in condition.split("&&")]
            if "always()" not in terms and seen.code != 0:
                return False
            compared = [re.fullmatch(r"(\S+) (==|!=) '(.*)'", term) for term in terms if term not in ["always()", "success()"]]
            assert all(compared), condition
            return all((value(term[1]) == term[3]) == (term[2] == "==") for term in compared)

        with tempfile.TemporaryDirectory() as runner:
            runner = pathlib.Path(runner)
            for number, step in enumerate(self.steps):
                if not holds(step.get("if", "success()")):
                    continue
                if "uses" in step:
                    seen.used[step["uses"].partition("@")[0]] = {name: filled(text) for name, text in step["with"].items()}
                    continue
                script, output, summary = (runner / f"{number}.{kind}" for kind in ["sh", "output", "summary"])
                script.write_text(step["run"])
                output.touch()
                summary.touch()
                said = subprocess.run(
                    ["bash", "--noprofile", "--norc", "-eo", "pipefail", script],
                    cwd=workspace,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    env={
                        "PATH": os.environ["PATH"],
                        "HOME": str(runner),
                        "GITHUB_ACTION_PATH": str(ACTION),
                        "GITHUB_OUTPUT": str(output),
                        "GITHUB_STEP_SUMMARY": str(summary),
                        "GITHUB_WORKSPACE": str(workspace),
                        "RUNNER_TEMP": str(runner),
                    }
                    | {name: filled(text) for name, text in step.get("env", {}).items()},
                )
                seen.code = seen.code or said.returncode
                seen.log += said.stdout
                seen.summary += summary.read_text()
                outputs[step.get("id")] = read_outputs(output.read_text())
            seen.outputs = {name: filled(one["value"]) for name, one in self.action["outputs"].items()}
            if seen.outputs["junit"]:
                seen.junit = ElementTree.parse(workspace / seen.outputs["junit"]).getroot()
        seen.commands = obeyed(seen.log)
        return seen


class Seen:
    """What a run of the action leaves behind."""

    def __init__(self, workspace):
        self.workspace, self.code, self.log, self.summary = workspace, 0, "", ""
        self.used, self.outputs, self.junit, self.commands = {}, {}, None, []

    def at(self, level):
        return [text for name, text in self.commands if name == level]

    def is_consistent(self):
        """What holds of every run that came to a decision."""
        report = self.workspace / self.outputs["report"]
        assert (report / "index.html").is_file() and (report / "results" / "junit.xml").is_file(), self.outputs
        assert self.summary.startswith("## pneuval: ") and "| verdict |" in self.summary, self.summary[:200]
        assert self.outputs["decision"] and "\n" not in self.outputs["decision"], self.outputs
        headline = self.summary.splitlines()[0].removeprefix("## pneuval: ")
        assert self.outputs["decision"].startswith(headline), self.outputs
        assert self.at("notice"), self.log
        is_bad = self.junit.get("failures") != "0" or self.junit.get("errors") != "0"
        assert is_bad == (self.code != 0), (self.code, self.junit.attrib)
        return self


def told_by(value):
    """Every text in a step."""
    if isinstance(value, dict):
        return [text for one in value.values() for text in told_by(one)]
    return [str(value)]


def read_outputs(text):
    """GITHUB_OUTPUT, with values of one line and of several."""
    outputs, lines = {}, iter(text.splitlines())
    for line in lines:
        name, end = re.fullmatch(r"([\w-]+)<<(.+)", line).groups()
        assert name not in outputs, name
        value = []
        for line in lines:
            if line == end:
                break
            value.append(line)
        else:
            raise AssertionError(f"{name} has no end")
        outputs[name] = "\n".join(value)
    return outputs


def obeyed(log):
    """The workflow commands that a runner would obey: `::name ..::text` at the start of a line, `##[name]text` anywhere in it."""
    commands, stopped = [], None
    for line in log.splitlines():
        found = re.match(r"\s*::([\w-]+)(?: [^:]*)?::(.*)", line) or re.search(r"##\[([\w-]+)[^]]*\](.*)", line)
        if stopped:
            stopped = None if found and found[1] == stopped else stopped
        elif found and found[1] == "stop-commands":
            stopped = found[2]
        elif found:
            commands.append((found[1], found[2]))
    assert stopped is None, log
    return commands


def actions(pneuval, folder):
    action = Action(pneuval)

    passes = action.run(ROOT, out=str(folder / "report")).is_consistent()
    assert (passes.code, passes.outputs["exit-code"]) == (0, "0"), passes.log
    assert not passes.at("error") and not passes.at("warning"), passes.log
    upload = passes.used["actions/upload-artifact"]
    assert upload["name"] == "pneuval-report" and upload["path"] == str(folder / "report"), upload
    tell("action, the repository's datasets", passes)

    own = folder / "own"
    copied(own / "datasets", tight=True)
    fails = action.run(own).is_consistent()
    assert (fails.code, fails.outputs["exit-code"], fails.outputs["report"]) == (1, "1", "report"), fails.log
    assert any("beyond the bound" in text for text in fails.at("error")), fails.log
    assert "actions/upload-artifact" in fails.used
    tell("action, a bound too tight", fails)

    told = action.run(own, report_only="true", upload="false").is_consistent()
    assert (told.code, told.outputs["exit-code"]) == (0, "1"), told.log
    assert not told.at("error") and told.at("warning") and "Only reported" in told.summary, told.log
    assert "actions/upload-artifact" not in told.used
    tell("action, the same with report-only", told)

    (own / "none.toml").write_text("schema = 1\n")
    opened = action.run(own, bounds="none.toml").is_consistent()
    assert (opened.code, opened.outputs["exit-code"]) == (3, "3"), opened.log
    tell("action, nothing judged", opened)

    (own / "a bound.toml").write_text((ROOT / "datasets" / "bounds" / "internal-support.toml").read_text())
    named = action.run(own, bounds="a bound.toml", paths="datasets/published/internal-support\n").is_consistent()
    assert (named.code, named.outputs["exit-code"]) == (0, "0"), named.log
    tell("action, bounds of its own for one dataset", named)

    held = hold(action, pneuval, own)
    for name, seen in held.items():
        tell(f"action, {name}", seen)

    strange = folder / "strange"
    copied(strange / HOSTILE)
    copied(strange / "-b", tight=True)
    reached = action.run(strange, paths=f"{HOSTILE}/published/wave-finger\n-b/published/internal-support\n", out=f"-{HOSTILE}").is_consistent()
    assert reached.code == 1 and reached.outputs["report"] == f"./-{HOSTILE}", reached.log
    assert reached.used["actions/upload-artifact"]["path"] == f"./-{HOSTILE}"
    assert sorted(path.name for path in strange.iterdir()) == sorted([HOSTILE, "-b", f"-{HOSTILE}"])
    tell("action, names with spaces, quotes and commands", reached)

    for name, given, expected in [
        ("a path that is missing", {"paths": "nowhere"}, "nowhere: no such file or folder"),
        ("no path", {"paths": "\n"}, "error: input `paths`"),
        ("bounds that are missing", {"bounds": "nowhere.toml"}, "nowhere.toml"),
        ("a baseline that is missing", {"baseline": "nowhere.json"}, "nowhere.json"),
        ("a program that is missing", {"binary": "no-such-program"}, "error: input `binary`"),
        ("neither true nor false", {"report_only": "yes"}, "error: input `report-only`"),
        ("a folder of somebody else's", {"out": "datasets"}, "not written over"),
        ("a name with commands", {"out": f"datasets/{COMMAND}", "bounds": COMMAND}, "error: "),
    ]:
        for report_only in ["false", "true"]:
            bad = action.run(own, **({"report_only": report_only} | given))
            assert (bad.code, bad.outputs["exit-code"], bad.outputs["junit"]) == (2, "2", ""), (name, bad.log)
            assert expected in bad.outputs["decision"] and "\n" not in bad.outputs["decision"], (name, bad.outputs)
            assert expected in bad.summary and "no decision" in bad.summary, (name, bad.summary)
            assert len(bad.commands) == 1 and expected in bad.at("error")[0], (name, bad.commands)
            # What was judged is kept, what was not is not: an earlier report is no result of this run.
            assert bad.outputs["report"] == ("report" if "baseline" in given else ""), (name, bad.outputs)
            assert ("actions/upload-artifact" in bad.used) == ("baseline" in given), (name, bad.used)
        tell(f"action, {name}, also with report-only", bad)

    broken = folder / "broken"
    subprocess.run([pneuval, "rehearse", "internal-support", "--out", broken / "datasets"], check=True, stdout=subprocess.DEVNULL)
    for log in (broken / "datasets").glob("run-*.csv"):
        head, rows = log.read_text().split("\n0.", 1)
        log.write_text(head + "\n" + re.sub(r"[\d.-]+", "x", "0." + rows))
    for report_only in ["false", "true"]:
        useless = action.run(broken, report_only=report_only)
        assert useless.code == 4 and useless.outputs["exit-code"] == "4", (useless.code, useless.log)
    tell("action, logs that cannot be used, also with report-only", useless)


def hold(action, pneuval, own):
    """Against a baseline that is the same, and one that was better."""
    good = own / "good"
    copied(good / "datasets")
    subprocess.run([pneuval, "validate", "datasets", "--out", "before", "--no-figures"], cwd=good, check=True, capture_output=True)
    accepted = [pneuval, "accept", "before", "--baseline", "a baseline.json", "--because", "kits.py"]
    subprocess.run(accepted, cwd=good, check=True, capture_output=True)
    seen = {"a baseline that is the same": action.run(good, baseline="a baseline.json").is_consistent()}
    assert seen["a baseline that is the same"].code == 0

    better = json.loads((good / "a baseline.json").read_text())
    (row,) = [row for row in better["comparisons"] if row["id"] == "internal-support/outer-diameter/published-theory"]
    for metric in row["metrics"]:
        metric["value"] /= 2
        metric["interval"] = metric["interval"] and [end / 2 for end in metric["interval"]]
    (good / "better.json").write_text(json.dumps(better))
    worse = action.run(good, baseline="better.json").is_consistent()
    assert (worse.code, worse.outputs["exit-code"]) == (1, "1"), worse.log
    assert "worse than the baseline" in worse.outputs["decision"] and worse.at("error"), worse.outputs
    again = subprocess.run([pneuval, "gate", "report"], cwd=good, capture_output=True)
    assert again.returncode == 0, "the report is whole after it was held against a baseline"
    told = action.run(good, baseline="better.json", report_only="true").is_consistent()
    assert (told.code, told.outputs["exit-code"]) == (0, "1"), told.log
    assert not told.at("error") and told.at("warning") and "Only reported" in told.summary, told.log
    return seen | {"a baseline that was better": worse, "the same with report-only": told}


def hooks(pneuval, folder):
    """A repository that uses the hooks: commits that pass, that are no concern of theirs, and that fail."""
    programs = folder / "bin"
    programs.mkdir()
    (programs / "pneuval").symlink_to(pneuval)
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("GIT_", "PRE_COMMIT"))} | {
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PRE_COMMIT_HOME": str(folder / "cache"),
        "HOME": str(folder),
        "GIT_CONFIG_NOSYSTEM": "1",
    } | {f"GIT_{who}_{what}": "kits@example.org" for who in ["AUTHOR", "COMMITTER"] for what in ["NAME", "EMAIL"]}

    def run(where, *command, code=0):
        said = subprocess.run(command, cwd=where, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert said.returncode == code, (command, said.returncode, said.stdout)
        return said.stdout

    pre_commit = [sys.executable, "-m", "pre_commit"]
    run(folder, *pre_commit, "validate-manifest", str(HOOKS))

    # The hooks as they are in this checkout, committed or not: what pre-commit clones.
    source = folder / "hooks"
    source.mkdir()
    shutil.copy(HOOKS, source)
    for command in [["init", "--quiet"], ["add", "--all"], ["commit", "--quiet", "--message", "hooks"]]:
        run(source, "git", *command)
    revision = run(source, "git", "rev-parse", "HEAD").strip()

    own = folder / "repository"
    copied(own / "datasets")
    (own / "datasets" / "README.md").write_text("Data.\n")
    ids = [hook["id"] for hook in yaml.safe_load(HOOKS.read_text())]
    config = {"repos": [{"repo": str(source), "rev": revision, "hooks": [{"id": one} for one in ids]}]}
    (own / ".pre-commit-config.yaml").write_text(yaml.safe_dump(config))
    run(own, "git", "init", "--quiet")
    said = run(own, *pre_commit, "install") + run(own, "git", "add", "--all")
    said = run(own, "git", "commit", "--message", "models and measurements")
    assert said.count("Passed") == len(ids) and "warn" not in said.lower(), said
    print(f"hook, first commit: {outcome(said)}")

    (own / "datasets" / "README.md").write_text("Data of papers.\n")
    said = run(own, "git", "commit", "--all", "--message", "words")
    assert said.count("Skipped") == len(ids), said
    print(f"hook, a commit of words alone: {outcome(said)}")

    before = run(own, "git", "rev-parse", "HEAD")
    tighten(own / "datasets")
    said = run(own, "git", "commit", "--all", "--message", "a bound too tight", code=1)
    assert "Failed" in said and "exit code: 1" in said and "differ from what was expected" in said, said
    assert run(own, "git", "rev-parse", "HEAD") == before and not (own / "report").exists()
    print(f"hook, a bound too tight: {outcome(said)}")

    (own / "datasets" / "bounds" / "internal-support.toml").write_text("schema = 1\n[[bond]]\n")
    said = run(own, "git", "commit", "--all", "--message", "a mistake", code=1)
    assert "exit code: 2" in said and "internal-support.toml:2" in said, said
    print(f"hook, a mistake in a file of bounds: {outcome(said)}")

    run(own, "git", "checkout", "--quiet", "HEAD", "--", "datasets")
    said = run(own, *pre_commit, "try-repo", str(source), ids[0], "--all-files")
    assert said.count("Passed") == 1, said
    print(f"hook, try-repo: {outcome(said)}")


def outcome(said):
    line = next(line for line in said.splitlines() if re.search(r"\.(Passed|Failed|Skipped)$|Skipped", line))
    codes = re.findall(r"exit code: \d+", said)
    return ", ".join([re.search(r"Passed|Failed|Skipped", line)[0], *codes])


def tell(name, seen):
    print(f"{name}: exit {seen.code}, {len(seen.commands)} annotations, decision `{seen.outputs['decision']}`")


def main(pneuval):
    pneuval = str(pathlib.Path(pneuval).resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder).resolve()
        for kit in [actions, hooks]:
            (folder / kit.__name__).mkdir()
            kit(pneuval, folder / kit.__name__)


main(*sys.argv[1:])

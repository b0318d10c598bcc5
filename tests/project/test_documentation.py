"""What docs/environment.md tabulates is what the code does, and links lead somewhere."""

import inspect
import re
import tomllib
from dataclasses import fields
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
import yaml

import jawenv
from eval.studies import design
from eval.studies.cells import cells_of
from eval.studies.metrics import METRICS
from jawenv.controls import CONTROLS
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.envs.configuration import Configuration
from jawenv.envs.observation import OBSERVATION_LAYOUT

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
TEXT = (ROOT / "docs" / "environment.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Cells of the rows of the first table that follows a heading."""
    lines = TEXT.split(f"\n## {heading}\n")[1].splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("|"))
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return rows


def named(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_arguments() -> None:
    own = {"render_mode"}
    assert {named(row[0])[0] for row in table("Arguments")} == {field.name for field in fields(Configuration)} | own
    stated = {named(row[0])[0]: row[2].strip("`").strip('"') for row in table("Arguments")}
    hz = {name: mode.steps_per_s for name, mode in CONTROLS.items()}
    rates = f"{hz['force']:g}; in targets control {hz['targets']:g}"
    assert stated.pop("control_hz") == rates and hz["trajectory"] == hz["force"]
    for field in (field for field in fields(Configuration) if field.name != "control_hz"):
        assert stated[field.name] == (f"{field.default:g}" if type(field.default) is float else str(field.default))


def test_what_an_action_means() -> None:
    stated = {named(row[0])[0].strip('"'): row[1].removesuffix(", see below") for row in table("Action")}
    assert stated == {name: mode.full_action for name, mode in CONTROLS.items()}


def test_observation() -> None:
    stated = {}
    for indices, name, _ in table("Observation"):
        first, _, last = indices.partition("–")
        stated[named(name)[0]] = slice(int(first), int(last or first) + 1)
    assert stated == OBSERVATION_LAYOUT


def test_info() -> None:
    env = gym.make("jawenv/Jaw-v2", track_bound=True, episode_s=1.0, control="force")
    _, info = env.reset(seed=0)
    stated = {name for row in table("Info") for name in named(row[0])}
    of_limits = {f"{kind}_{limit}" for kind in ("cost", "comfort") for limit in COMFORT_LIMITS}
    assert stated - {"cost_<limit>", "comfort_<limit>"} == set(info) - of_limits
    assert of_limits <= set(info)
    env.close()


def test_a_cohort_of_ones_own() -> None:
    """The example runs, and its file says the same."""
    section = re.split(r"\n##+ ", TEXT.split("\n### A cohort, a device, a patient of your own\n")[1])[0]
    (example,) = re.findall(r"```python\n(.*?)```", section, re.S)
    (file,) = re.findall(r"```toml\n(.*?)```", section, re.S)
    names = {"gym": gym, "jawenv": jawenv}
    exec(compile(example, "environment.md", "exec"), names)
    assert tomllib.loads(file) == names["mine"]


def test_comfort_limits() -> None:
    rows = table("Comfort")
    assert tuple(named(row[0])[0] for row in rows) == COMFORT_LIMITS
    hard = [getattr(jawenv.Comfort(), f"{name}_hard") for name in COMFORT_LIMITS]
    assert [float(row[3]) for row in rows] == hard


def test_numbers_of_comfort() -> None:
    """Those that are not hard limits, in the order of the class."""
    rows = [row.strip("| ").split(" | ") for row in TEXT.split("| field of `jawenv.Comfort` |")[1].splitlines()[2:7]]
    stated = {name: float(value) for row in rows for name, value in zip(named(row[0]), row[1].split(","), strict=True)}
    defaults = {each.name: each.default for each in fields(jawenv.Comfort) if not each.name.endswith("_hard")}
    assert list(stated.items()) == list(defaults.items())


def test_device() -> None:
    stated = {named(row[0])[0]: (float(row[1]), float(row[2].replace(",", ""))) for row in table("Device and sensors")}
    highest = {name: numeric.high for name, numeric in jawenv.Device.numeric_fields().items()}
    assert stated == {field.name: (field.default, highest[field.name]) for field in fields(jawenv.Device)}


def test_cohorts_and_parameters() -> None:
    (cohorts,) = (row[1] for row in table("Arguments") if row[0] == "`cohort`")
    assert set(named(cohorts)) == set(jawenv.COHORTS)
    assert np.array_equal(OBSERVATION_LAYOUT["belief_mean"], slice(0, len(jawenv.PARAMETER_NAMES)))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"


def test_readme_example_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.S)
    make = gym.make
    monkeypatch.setattr(gym, "make", lambda *given, **kwargs: make(*given, **kwargs, episode_s=1.0))
    exec(compile(inspect.cleandoc(example), "README.md", "exec"), {})
    assert len(capsys.readouterr().out.splitlines()) >= len(jawenv.PARAMETER_NAMES)


def test_studies() -> None:
    """Its tables name every study, key and metric, and its example can be played."""
    text = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| `")]
    stated = {name for row in rows for name in named(row[0])}
    files = {"study.md", "profiles.svg", "parts/", *(f"{name}.parquet" for name in ("cells", "pairs", "profiles"))}
    assert stated - files - {"patients.parquet"} == {*design.shipped(), *design.Design.model_fields, *METRICS}
    (example,) = re.findall(r"```yaml\n(.*?)```", text, re.S)
    assert len(cells_of(design.Design(**yaml.safe_load(example)))) == 2 * 2 * 2 + 2

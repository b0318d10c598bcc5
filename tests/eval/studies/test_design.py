"""A study's file: what it may say, and that everything else is one clear line."""

from pathlib import Path

import pytest

import jawenv
from eval.commands.app import main
from eval.studies import design
from eval.studies.design import Design
from eval.studies.grid import FACTORS, cells_of
from jawenv import COHORTS
from jawenv.base.errors import InputError
from jawenv.base.seeds import REPORTS
from jawenv.device.force_sensor import FORCE_SENSORS
from jawenv.ladder import MODELS
from jawenv.reality import Reality

SMALL = {"title": "Small", "entries": ["hold_still", "chirp"], "patients": 2, "seed": 5000, "episode_s": 1.0}


def named(cell):
    """The digest of its first patients."""
    return cell.parts(Path())[0].path.stem.split("-")[-1]


def cells(**changes):
    return cells_of(Design(**(SMALL | changes)))


def test_every_entry_is_played_under_every_setting():
    made = cells(
        environments=["Jaw", "portions"],
        controls=["force", "targets"],
        reality={"none": {}, "creep": {"creep_share": 0.3}},
        entries=["hold_still", {"agent": "clairvoyant", "controls": ["targets"], "patients": 1}],
    )
    assert len(made) == len({cell.name for cell in made}) == 2 * 2 * (2 + 1)
    planned = [cell for cell in made if cell.levels["entry"] == "clairvoyant"]
    assert {cell.levels["control"] for cell in planned} == {"targets"} and {len(cell.seeds) for cell in planned} == {1}
    assert {cell.levels["control_hz"] for cell in made} == {5.0, 20.0}
    assert {cell.levels["environment"] for cell in made} == {"Jaw", "JawPortions"}
    creeping = [cell.load().env_kwargs for cell in made if cell.levels["reality"] == "creep"]
    assert all(kwargs["reality"] == {"creep_share": 0.3} for kwargs in creeping)


def test_an_environment_may_be_played_in_some_controls_alone():
    made = cells(environments=["Jaw", {"env": "JawImaged", "controls": ["targets"]}], controls=["force", "targets"])
    played = {(cell.levels["environment"], cell.levels["control"]) for cell in made}
    assert played == {("Jaw", "force"), ("Jaw", "targets"), ("JawImaged", "targets")}
    assert {cell.load().env_id for cell in made} == {"jawenv/Jaw-v3", "jawenv/JawImaged-v3"}


def test_rates_reach_the_environment():
    made = cells(controls=["force"], control_hz=[10, 50], entries=["chirp"])
    assert [cell.levels["control_hz"] for cell in made] == [10.0, 50.0]
    assert [cell.load().env_kwargs["control_hz"] for cell in made] == [10.0, 50.0]


def test_the_fingerprint_changes_with_what_decides_a_row():
    prints = [named(cells(**changes)[0]) for changes in ({}, {"control_hz": [10]}, {"cohorts": ["wide"]})]
    assert len(set(prints)) == 3
    assert named(cells(patients=3)[0]) == prints[0]


@pytest.mark.parametrize("name", [name for name in design.shipped() if name != "thesis"])
def test_a_shipped_study_can_be_played_on_patients_for_reports(name):
    wanted = design.read(name)[1]
    made = cells_of(wanted)
    assert made and len({cell.name for cell in made}) == len(made)
    assert any(wanted.seed in seeds and wanted.seed + wanted.patients - 1 in seeds for seeds in REPORTS)
    assert all(len(cell.levels) == len(FACTORS) for cell in made)


def test_shipped_studies_are_of_all_that_they_are_about():
    studies = {name: design.read(name)[1] for name in design.shipped()}
    played = {entry.agent for entry in studies["headline"].entries}
    assert {*jawenv.maneuver_names(), "random"} <= played
    assert studies["headline"].patients == 200 and studies["headline"].seed == 20_000
    assert {environment.env for environment in studies["ladder"].environments} == {m.title for m in MODELS.values()}
    assert set(studies["cohorts"].cohorts) == set(COHORTS)
    effects = {field for fields in studies["robustness"].reality.values() for field in fields}
    assert effects == {name for name, field in Reality.__dataclass_fields__.items() if field.default == 0.0}
    assert studies["sensors"].sensors == ("pose", "point")
    assert studies["force_sensors"].force_sensors == FORCE_SENSORS


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"patient": 3}, "unknown key 'patient'; allowed: title, description, entries"),
        ({"entries": []}, "entries"),
        ({"entries": ["hold_still", "hold_still"]}, "allowed: each once"),
        ({"entries": [{"agents": "chirp"}]}, "unknown key 'entries.0.agents'; allowed: agent, controls"),
        ({"entries": [{"agent": "chirp", "controls": ["force"]}]}, "'chirp': controls force; allowed: the study's"),
        ({"entries": [{"agent": "chirp", "cohorts": ["wide"]}]}, "'chirp': cohorts wide; allowed: the study's"),
        ({"environments": [{"env": "Jaw", "controls": ["force"]}]}, "'Jaw': controls force; allowed: the study's"),
        ({"controls": ["thought"]}, "controls.0 is 'thought'"),
        ({"control_hz": [33]}, "control_hz is 33; allowed: 20 divided by a whole number"),
        ({"control_hz": [float("nan")]}, "control_hz.0"),
        ({"reality": {"slow": {"creep_share": float("nan")}}}, "reality.slow.creep_share"),
        ({"patients": 0}, "patients is 0; allowed: greater than or equal to 1"),
        ({"metrics": ["speed"]}, "names 'speed'; allowed: information_true"),
        ({"pairs": [["chirp", "nobody"]]}, "pairs: no two cells are 'chirp' and 'nobody' and alike in all"),
        ({"pairs": [["chirp", {"reality": "creep"}]]}, "and 'reality creep' and alike in all else"),
        ({"pairs": [["chirp"]]}, "pairs.0"),
    ],
)
def test_what_a_study_cannot_be_is_one_line(changes, said):
    with pytest.raises(InputError) as raised:
        cells(**changes)
    assert said in str(raised.value) and "\n" not in str(raised.value)


def test_two_entries_of_one_name_are_refused(tmp_path):
    from jawenv.playing.maneuvers.maneuver import FOLDER

    copy = tmp_path / "other.yaml"
    copy.write_text((FOLDER / "chirp.yaml").read_text())
    with pytest.raises(InputError):
        cells(entries=["chirp", str(copy)])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing"], "study is 'nothing'; allowed: agents, calibration, clinic, cohorts, force_sensors, headline"),
        (["nothing.yaml"], "nothing.yaml: no such file"),
        ([], "study is none; allowed: agents, calibration, clinic, cohorts, force_sensors, headline"),
        (["headline", "--workers", "0"], "--workers"),
        (["broken.yaml"], "broken.yaml: damaged YAML"),
    ],
)
def test_what_the_command_refuses_is_one_line(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "broken.yaml").write_text("entries: [")
    assert main(["study", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and said in error and error.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["broken.yaml"]


def test_the_list_names_every_study(capsys):
    assert main(["study", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(design.shipped())


@pytest.mark.parametrize("lacking", ["", "results: [linear]\nentries: [refined]\n"])
def test_a_study_has_entries_or_results(tmp_path, lacking):
    path = tmp_path / "study.yaml"
    path.write_text(f"title: None\npatients: 2\nseed: 0\n{lacking}")
    with pytest.raises(InputError, match="entries: has none, or results beside them"):
        design.read(str(path))

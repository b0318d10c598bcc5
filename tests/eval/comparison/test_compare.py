import shutil
from dataclasses import replace

import pandas as pd
import pytest
from rich.console import Console

from eval.commands.app import main
from eval.comparison import results
from eval.comparison.motion import play_patient
from eval.kept.cells import play_cells
from eval.kept.digest import fingerprint
from eval.kept.entries import Settings, env_of_runs, load_entries
from eval.kept.parts import Run
from eval.studies.design import Design
from eval.studies.grid import cells_of
from jawenv.base.errors import InputError
from jawenv.envs.configuration import configure
from jawenv.playing.policies.card import CARD, Environment
from tests.eval.runs import save_checkpoint
from tests.plain_policies import write_policy
from tests.recorded import BODY

SHORT = ["--patients", "2", "--episode-s", "0.5"]


def run(*arguments):
    return main(["compare", *arguments])


@pytest.fixture(autouse=True)
def undrawn(request, monkeypatch):
    """Leave out the report, which takes seconds, where a test does not look at it."""
    if "drawn" not in request.fixturenames:
        monkeypatch.setattr("eval.report.page.write", lambda study, ranking, path: path)
        monkeypatch.setattr("eval.comparison.motion.play_patient", lambda study, *given, **more: study)


@pytest.fixture
def drawn():
    """Asks for the report to be drawn."""


def test_a_comparison_writes_tables(tmp_path, capsys):
    assert run("hold_still", "slow_opening", *SHORT, "--output", str(tmp_path)) == 0
    assert "slow opening" in capsys.readouterr().out
    patients = pd.read_parquet(tmp_path / "patients.parquet")
    assert patients.groupby("entry")["seed"].apply(list).to_dict() == {"hold_still": [0, 1], "slow_opening": [0, 1]}
    truths = patients[[column for column in patients if column.startswith("truth/")]]
    assert (truths.iloc[:2].to_numpy() == truths.iloc[2:].to_numpy()).all()


def test_a_finished_entry_is_not_played_again(tmp_path, plays, capsys):
    output = ["--output", str(tmp_path)]
    assert run("hold_still", *SHORT, *output) == 0
    first = pd.read_parquet(tmp_path / "patients.parquet")
    assert run("hold_still", "chirp", *SHORT, *output) == 0
    assert plays.names == ["hold_still", "chirp"]
    assert "2 of 4 episodes kept from an earlier run" in capsys.readouterr().out
    second = pd.read_parquet(tmp_path / "patients.parquet")
    pd.testing.assert_frame_equal(second[second["entry"] == "hold_still"], first)
    assert run("hold_still", *SHORT, *output, "--fresh") == 0
    assert plays.names == ["hold_still", "chirp", "hold_still"]


def test_a_comfort_an_anatomy_and_a_force_sensor_of_ones_own_are_another_study(tmp_path, plays, drawn):
    """What the files said is kept: another patient is played with it when they have gone."""
    output = ["--output", str(tmp_path / "study")]
    assert run("slow_opening", *SHORT, *output) == 0
    own = {"comfort": tmp_path / "strict.toml", "anatomy": tmp_path / "jaw.yaml"}
    own["comfort"].write_text("force_N = 1.0\n")
    own["anatomy"].write_text("mandible: {mass_kg: 0.4}\n")
    body = tmp_path / "body.toml"
    body.write_text("".join(f"{name} = {value}\n" for name, value in BODY.items()))
    given = [text for name, file in own.items() for text in ("--set", f"{name}={file}")]
    sensors = [["--set", f"force_sensor={sensor}", "--knowledge", str(body)] for sensor in ("motors", "straps")]
    for each in (given[:2], given[2:4], *sensors, given[:4]):
        assert run("slow_opening", *SHORT, *output, *each) == 0
    assert len(plays.names) == 6
    assert run("slow_opening", *SHORT, *output, *given[:4]) == 0
    assert len(plays.names) == 6, "kept"
    page = (tmp_path / "study" / "report.html").read_text()
    assert "force_N = 1.0" in page and "mass_kg = 0.4" in page
    for file in (*own.values(), body):
        file.unlink()
    assert main(["report", str(tmp_path / "study"), "--patient", "1"]) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nobody"], "agent is 'nobody'; allowed"),
        ([], "nothing to compare"),
        (["hold_still", "--cohort", "nobody"], "nobody"),
        (["hold_still", "--patients", "0"], "patients is 0; allowed"),
        (["hold_still", "--patients", "some"], "--patients"),
        (["hold_still", "--set", "sensors=nose"], "sensors is 'nose'; did you mean pose? allowed: pose, point"),
        (["hold_still", "--reference", "chirp"], "reference is 'chirp'; allowed: hold_still"),
        (["hold_still", "--reality", "creep_share"], "reality is 'creep_share'; allowed: FIELD=VALUE"),
    ],
)
def test_bad_input_is_one_line(arguments, message, tmp_path, capsys):
    assert run(*arguments, "--output", str(tmp_path / "new")) == 2
    told = capsys.readouterr().err
    assert told.startswith("error: ")
    assert told.count("\n") == 1
    assert message in told
    assert not (tmp_path / "new").exists()


def test_an_entry_named_twice_counts_once():
    assert len(load_entries(["hold_still", "hold_still"], Settings().world)) == 1


def test_entries_with_the_same_name_are_told_apart(tmp_path):
    from jawenv.playing.maneuvers.maneuver import FOLDER

    copy = tmp_path / "other.yaml"
    copy.write_text((FOLDER / "hold_still.yaml").read_text())
    labels = [entry.label for entry in load_entries(["hold_still", str(copy)], Settings().world)]
    assert labels == ["hold_still (hold_still)", f"hold_still ({copy})"]


def test_the_fingerprint_changes_with_the_maneuvers_file(tmp_path):
    from jawenv.playing.maneuvers.maneuver import FOLDER

    text = (FOLDER / "slow_opening.yaml").read_text()
    copy = tmp_path / "slow_opening.yaml"
    copy.write_text(text)
    (entry,) = load_entries([str(copy)], Settings().world)
    before = fingerprint(entry, {"seed": 0})
    assert before == fingerprint(entry, {"seed": 0})
    assert before != fingerprint(entry, {"seed": 1})
    assert before != fingerprint(replace(entry, world=replace(entry.world, control="trajectory")), {"seed": 0})
    copy.write_text(text + "\n# another line\n")
    assert before != fingerprint(entry, {"seed": 0})


@pytest.fixture(scope="module")
def trained_run(tmp_path_factory):
    """A run folder with an untrained policy, said to have been trained under trajectory control."""
    folder = tmp_path_factory.mktemp("runs") / "ppo-test"
    world = configure({"control": "trajectory", "episode_s": 20.0})
    return write_policy(folder, environment=Environment.of(world).model_dump(mode="json"))


def test_a_trained_run_brings_its_environment_and_takes_part_in_no_other(trained_run, tmp_path, capsys):
    assert env_of_runs(["hold_still"]) == env_of_runs([str(trained_run)]) == "jawenv/Jaw-v3"
    other = tmp_path / "other"
    shutil.copytree(trained_run, other)
    text = (other / CARD).read_text()
    (other / CARD).write_text(text.replace("jawenv/Jaw-v3", "jawenv/JawPortions-v3"))
    assert env_of_runs(["hold_still", str(other), str(trained_run)]) == "jawenv/JawPortions-v3"
    output = tmp_path / "study"
    assert run(str(trained_run), "--env", "portions", *SHORT, "--output", str(output)) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"error: {trained_run} was trained in jawenv/Jaw-v3, but this comparison is in jawenv/J")
    assert told.count("\n") == 1
    assert not output.exists()


def test_a_bare_policy_of_another_environment_is_refused(tmp_path, capsys):
    save_checkpoint(tmp_path / "policy.zip")
    arguments = [str(tmp_path / "policy.zip"), "--env", "sides", *SHORT, "--output", str(tmp_path / "study")]
    assert run(*arguments) == 2
    told = capsys.readouterr().err
    assert "policy.zip" in told and "--trust" in told and told.count("\n") == 1
    assert run(*arguments, "--trust") == 2
    assert "observations of 75 values, jawenv/JawSides-v3 gives 47" in capsys.readouterr().err


def test_a_report_can_be_drawn_again_against_another_reference(tmp_path, monkeypatch, capsys):
    assert run("hold_still", "chirp", *SHORT, "--output", str(tmp_path)) == 0
    references = []
    monkeypatch.setattr("eval.report.page.write", lambda study, ranking, path: references.append(ranking.reference))
    for reference in ("chirp", "hold_still"):
        assert main(["report", str(tmp_path), "--reference", reference]) == 0
    assert references == ["chirp", "hold_still"]
    assert main(["report", str(tmp_path), "--reference", "nobody"]) == 2
    assert "reference is 'nobody'; allowed" in capsys.readouterr().err


def test_a_study_of_one_cell_has_the_same_figures(tmp_path, monkeypatch):
    """A comparison plays all patients together, a study some at a time."""
    settings = Settings.of(patients=3, seed=41, episode_s=1.0)
    compared = results.compare(load_entries(["chirp", "random"], settings.world), settings).patients
    monkeypatch.setattr("eval.studies.grid.PATIENTS_IN_A_PART", 2)
    design = Design(
        title="", entries=("chirp", "random"), patients=3, seed=41, episode_s=1.0, metrics=["worst_bound_sd"]
    )
    studied = play_cells(cells_of(design), tmp_path, Run(workers=1))
    columns = [column for column in compared if column != "patient"]
    pd.testing.assert_frame_equal(studied[columns], compared[columns], check_exact=True)


def test_another_patient_is_played_again_for_the_films(tmp_path):
    assert run("hold_still", "slow_opening", *SHORT, "--output", str(tmp_path)) == 0
    kept, quiet = results.load(tmp_path), Console(quiet=True)
    first, other = (play_patient(kept, kept.entries, quiet, seed) for seed in (None, 1))
    assert set(other.motions) == set(first.motions) == set(kept.entries)
    assert (first.about["played_seed"], other.about["played_seed"]) == (0, 1)
    assert other.motions["slow_opening"][-1].opening_mm != first.motions["slow_opening"][-1].opening_mm
    with pytest.raises(InputError):
        play_patient(kept, kept.entries, quiet, 2)
    assert main(["report", str(tmp_path), "--patient", "1"]) == 0

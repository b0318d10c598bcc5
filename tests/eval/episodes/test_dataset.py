"""Data sets of Minari: what is written is what is played, and is found again."""

import hashlib
import json
import sys

import numpy as np
import pytest

from agents import load_agent
from eval.commands.app import main
from eval.episodes.croissant import FILE, write_croissant
from jawenv.base.errors import InputError
from jawenv.playing.rollout import play

SMALL = ("--env", "JawHinge", "--patients", "2", "--episode-s", "1")


def test_without_minari_there_is_one_line(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "minari", None)
    assert main(["dataset", *SMALL, "--output", str(tmp_path)]) == 2
    assert "needs minari: .ci/setup dataset" in capsys.readouterr().err


def test_another_format_is_refused(tmp_path, capsys):
    assert main(["dataset", *SMALL, "--format", "csv", "--output", str(tmp_path)]) == 2
    assert "format is 'csv'; allowed: arrow, hdf5" in capsys.readouterr().err


# Minari leaves the removal of its temporary folder to the collector of garbage, which warns.
@pytest.mark.filterwarnings("ignore:Implicitly cleaning up:ResourceWarning")
def test_a_data_set_is_what_was_played(tmp_path, monkeypatch, capsys):
    minari = pytest.importorskip("minari")
    pytest.importorskip("jax")
    command = ["dataset", "refined", "random", *SMALL, "--seed", "3", "--output", str(tmp_path)]
    assert main(command) == 0
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    assert set(minari.list_local_datasets()) == {"jawenv/hinge/refined-v0", "jawenv/hinge/random-v0"}
    for name in ("refined", "random"):
        loaded = minari.load_dataset(f"jawenv/hinge/{name}-v0")
        assert "Seeds 3 to 4. Made by: python -m eval" in loaded.storage.metadata["description"]
        kwargs = {"control": "targets", "sensors": "pose", "cohort": "trismus", "episode_s": 1.0}
        assert loaded.recover_environment().spec.kwargs == {"model": "hinge", **kwargs}
        env_id = "jawenv/JawHinge-v3"
        agent = load_agent(name, control="targets", env_id=env_id)
        for seed, episode in zip((3, 4), loaded.iterate_episodes(), strict=True):
            played = play(agent, patients=1, seed=seed, env_id=env_id, env_kwargs=kwargs, agent_seed=seed - 3)
            assert len(episode.actions) == 5 and episode.truncations[-1]
            np.testing.assert_array_equal(episode.infos["belief_mean"], played.belief_mean[0])
            np.testing.assert_array_equal(episode.infos["truth"][0], played.truth[0])
    capsys.readouterr()
    assert main(command) == 2
    assert "exists; use --fresh" in capsys.readouterr().err
    assert main([*command, "--fresh", "--croissant"]) == 0
    described = json.loads((tmp_path / "jawenv/hinge/random-v0" / FILE).read_text())
    assert "Seeds 3 to 4" in described["description"] and len(described["distribution"]) == 5


@pytest.mark.filterwarnings("ignore:ConjunctiveGraph is deprecated:DeprecationWarning")  # mlcroissant's use of rdflib
def test_the_description_for_machines_is_valid_and_names_every_file(tmp_path):
    croissant = pytest.importorskip("mlcroissant")
    folder = tmp_path / "refined-v0"
    (folder / "data").mkdir(parents=True)
    (folder / "data" / "part-0.arrow").write_bytes(b"arrow")
    (folder / "data" / "metadata.json").write_text("{}")
    for _ in range(2):  # it does not describe itself
        path = write_croissant(folder, "jawenv/hinge/refined-v0", "Refined. Seeds 3 to 4.")
    metadata = croissant.Dataset(jsonld=path).metadata
    assert metadata.ctx.issues.errors == set()
    (warning,) = metadata.ctx.issues.warnings
    assert "datePublished" in warning
    assert [file.content_url for file in metadata.distribution] == ["data/metadata.json", "data/part-0.arrow"]
    assert metadata.distribution[1].sha256 == hashlib.sha256(b"arrow").hexdigest()
    assert metadata.personal_sensitive_information and len(metadata.data_limitations) == 2


def test_without_mlcroissant_there_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "mlcroissant", None)
    with pytest.raises(InputError, match="--croissant needs mlcroissant: .ci/setup dataset"):
        write_croissant(tmp_path, "jawenv/hinge/refined-v0", "Refined.")


def test_a_planner_is_refused(tmp_path, capsys):
    pytest.importorskip("minari")
    assert main(["dataset", "myopic", *SMALL, "--output", str(tmp_path)]) == 2
    assert "allowed: entries that decide by observation" in capsys.readouterr().err

"""``python -m training train``: what a run leaves behind, how it stops, goes on and refuses."""

import json
import os
import shutil
import signal
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from point_env import TINY_CONFIG
from stable_baselines3 import PPO

from agents.evaluations import read_evaluations
from jawenv.base.errors import InputError
from jawenv.base.locks import alone
from tests.eval.runs import make_it_run_code
from training.cli import main
from training.run.callbacks import Interrupt
from training.run.config import TrainingConfig
from training.run.folder import RunFolder, read_counts
from training.run.worlds import world_seed


def train(*arguments: object) -> int:
    return main(["train", *map(str, arguments)])


def latest(run: Path) -> Path:
    """Its latest checkpoint."""
    return max((run / "checkpoints").iterdir())


def weights(run: Path) -> dict[str, torch.Tensor]:
    return PPO.load(latest(run), device="cpu").policy.state_dict()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished tiny run; tests that change it make a copy."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "tiny.yaml").write_text(TINY_CONFIG)
    assert train(folder / "tiny.yaml", "--output", folder / "run", "--seed", 3) == 0
    return folder / "run"


@pytest.fixture
def run(finished: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return shutil.copytree(finished, tmp_path / "run")


def test_run_folder_holds_what_is_needed_to_repeat_it(finished: Path) -> None:
    assert [path.name for path in sorted((finished / "checkpoints").iterdir())] == [
        "step_0000000768.zip",
        "step_0000001024.zip",
    ]
    assert list((finished / "tensorboard").iterdir())
    repeat = json.loads((finished / "repeat.json").read_text())
    assert repeat["versions"]["gymnasium"]
    assert repeat["seeds"] == {"training": 3, "validation": [30000, 30003]}
    assert repeat["sessions"][0]["world_seed"] == world_seed(3, 0) >= 2**31
    assert not list(finished.rglob("*.unfinished"))


def test_policy_gets_better_and_the_best_is_kept(finished: Path) -> None:
    rows = read_evaluations(finished)
    assert [row["steps"] for row in rows] == [0, 256, 512, 1024]
    assert rows[-1]["return"] > rows[0]["return"] + 0.3
    assert rows[-1]["information_true"] == pytest.approx(0.5 * rows[-1]["information_claimed"], rel=1e-4)
    assert max(rows, key=lambda row: row["return"])["steps"] == 1024
    best = PPO.load(finished / "best_model.zip", device="cpu")  # in jawenv's own environments weights and a card
    assert all(torch.equal(best.policy.state_dict()[key], value) for key, value in weights(finished).items())
    action, _ = best.predict(np.array([0.8, 0.0, 0.0], np.float32), deterministic=True)
    assert action[0] < 0.0  # towards the origin


def test_tensorboard_holds_the_figures(finished: Path) -> None:
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    log = EventAccumulator(str(finished / "tensorboard"))
    log.Reload()
    tags = set(log.Tags()["scalars"])
    figures = {"information_claimed", "information_true", "discomfort_s", "worst_sd", "worst_sd_10s", "violation"}
    assert {f"rollout/{name}" for name in figures} | {f"evaluation/{name}" for name in figures} <= tags
    assert {"rollout/ep_rew_mean", "evaluation/return", "evaluation/return_sampled", "time/fps"} <= tags


def test_equal_seeds_give_equal_policies(finished: Path, tmp_path: Path) -> None:
    for seed in (3, 4):
        assert train(finished.parent / "tiny.yaml", "--output", tmp_path / str(seed), "--seed", seed) == 0
    first, again, other = weights(finished), weights(tmp_path / "3"), weights(tmp_path / "4")
    assert all(torch.equal(first[key], again[key]) for key in first)
    assert not all(torch.equal(first[key], other[key]) for key in first)
    assert read_evaluations(finished) == read_evaluations(tmp_path / "3")


def test_a_run_is_not_replaced_unasked(
    finished: Path, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("not a run")
    tiny = finished.parent / "tiny.yaml"
    for command in (["--output", run], ["--output", other, "--overwrite"]):
        assert train(tiny, *command, "--steps", 256) == 2
        assert capsys.readouterr().err.count("\n") == 1
    assert (other / "thesis.txt").exists()
    assert train(tiny, "--output", run, "--steps", 256, "--overwrite") == 0
    assert read_evaluations(run)[-1]["steps"] == 256


def test_resume_goes_on_from_model_optimiser_and_steps(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    command = [tiny_config, "--output", run, "--continue", "--steps"]
    assert train(*command, 512) == 0
    before = PPO.load(latest(run))
    for again in (["--resume", run], [*command, 512]):
        assert train(*again) == 0
        assert "nothing to do" in capsys.readouterr().out
    assert train(*command, 1024) == 0
    after = PPO.load(latest(run))
    assert after.num_timesteps == 1024
    assert after._n_updates == 2 * before._n_updates
    moments = after.policy.optimizer.state_dict()["state"][0]
    assert moments["step"] == 2 * before.policy.optimizer.state_dict()["state"][0]["step"]
    assert [row["steps"] for row in read_evaluations(run)] == [0, 256, 512, 1024]
    sessions = json.loads((run / "repeat.json").read_text())["sessions"]
    assert [session["from_step"] for session in sessions] == [0, 512]
    assert sessions[0]["world_seed"] != sessions[1]["world_seed"]
    assert train(*command, 2048, "--seed", 9) == 2
    assert "(seed)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [("policy:\n  - ", "policy:\n  - 9\n  - ", "network.policy"), ("kwargs: {}", "kwargs: {a: 1}", "env.kwargs.a")],
    ids=["network", "environment"],
)
def test_resume_refuses_another_network_or_task(
    run: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, named: str
) -> None:
    config = (run / "config.yaml").read_text()
    assert old in config
    (run / "config.yaml").write_text(config.replace(old, new))
    assert train("--resume", run, "--steps", 1280) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and named in error and "damaged" not in error


def test_resume_says_which_other_settings_were_changed(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = yaml.safe_load((run / "config.yaml").read_text())
    config["arguments"]["clip_range"] = 0.1
    (run / "config.yaml").write_text(yaml.safe_dump(config))
    assert train("--resume", run, "--steps", 1280) == 0
    assert "changed since the run began: arguments.clip_range\n" in capsys.readouterr().out


def test_resume_unpickles_nothing(run: Path, tmp_path: Path) -> None:
    make_it_run_code(run / "checkpoints" / "step_0000001024.zip", tmp_path / "ran")
    assert train("--resume", run, "--steps", 1280) == 0
    assert read_evaluations(run)[-1]["steps"] == 1280 and not (tmp_path / "ran").exists()


def test_a_best_policy_that_was_lost_is_kept_anew(run: Path) -> None:
    """A run may have been killed while it wrote a better one."""
    (run / "best_model.zip").unlink()
    with (run / "evaluations.csv").open("a") as file:
        file.write("1024,1e9" + ",0" * (len(read_evaluations(run)[0]) - 2) + "\n")
    assert train("--resume", run, "--steps", 1280) == 0
    assert (run / "best_model.zip").exists()


@pytest.mark.parametrize("content", [b"", None], ids=["empty", "cut"])
def test_damaged_checkpoint_is_named(run: Path, capsys: pytest.CaptureFixture[str], content: bytes | None) -> None:
    checkpoint = run / "checkpoints" / "step_0000001024.zip"
    checkpoint.write_bytes(checkpoint.read_bytes()[:5000] if content is None else content)
    assert train("--resume", run, "--steps", 2048) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "step_0000001024.zip is damaged" in error


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nowhere"], "apg_asked, plain_ppo, ppo"),
        (["--resume", "runs/a", "ppo"], "CONFIG"),
        (["--resume", "runs/a", "--set", "reward=worst"], "--reward"),
        (["--resume", "runs/a", "--env", "sides"], "--env"),
        (["--resume", "nowhere"], "nowhere"),
        (["ppo", "--residual-on", "wiggle"], "wiggle"),
        (["--device", "abacus"], "abacus"),
        (["--set", "colour=red"], "--set is 'colour'"),
    ],
)
def test_unusable_arguments_get_one_line(
    tiny_config: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    named = arguments[0] in ("nowhere", "ppo", "--resume")
    base = [] if named else [tiny_config]
    assert train(*base, *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1 and message in error
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("env", "message"),
    [
        ("{id: Nowhere-v0}", "Nowhere-v0"),
        ("{id: 'no_module:Point-v0'}", "no_module"),
        ("{id: 'point_env:Point-v0', kwargs: {colour: red}}", "colour"),
        ("{id: 'point_env:Point-v0', kwargs: {start: -1.0}}", "start is -1.0"),
        ("{id: 'jawenv/Jaw-v3', kwargs: {colour: red}}", "colour"),
    ],
)
def test_unusable_environment_is_named(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], env: str, message: str
) -> None:
    text = tiny_config.read_text().replace('{id: "point_env:Point-v0"}', env)
    tiny_config.write_text(text)
    assert train(tiny_config, "--output", tmp_path / "run") == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and message in error
    assert not (tmp_path / "run").exists()


@contextmanager
def signalled(number: signal.Signals, run: Path, after: int) -> Iterator[None]:
    """Sends a signal to this process once a run has saved more than ``after`` steps."""
    over = threading.Event()

    def watch() -> None:
        while steps_saved(run) <= after and not over.wait(0.01):
            pass
        if not over.is_set():
            os.kill(os.getpid(), number)

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def steps_saved(run: Path) -> int:
    files = list((run / "checkpoints").glob("step_*.zip"))
    return max((int(path.stem.removeprefix("step_")) for path in files), default=0)


def test_signals_save_a_checkpoint_that_resume_goes_on_from(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    with signalled(signal.SIGINT, run, after=0):
        assert train(tiny_config, "--output", run, "--steps", 10_000_000) == 130
    assert f"--resume {run}" in capsys.readouterr().out
    saved = steps_saved(run)
    assert saved % 256 == 0  # only whole rollouts, which a policy update has learned from, are counted
    with signalled(signal.SIGTERM, run, after=saved):
        assert train("--resume", run) == 130
    assert "SIGTERM" in capsys.readouterr().out and steps_saved(run) > saved


def test_second_signal_stops_at_once() -> None:
    before = signal.getsignal(signal.SIGINT)
    with Interrupt() as interrupt:
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupt.wanted()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1.0)
    assert signal.getsignal(signal.SIGINT) is before


def test_too_many_worlds_and_an_unusable_folder_get_one_line(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    assert train(tiny_config, "--output", tmp_path / "file" / "run") == 2
    assert capsys.readouterr().err == f"error: output {tmp_path / 'file' / 'run'}: cannot be made: Not a directory\n"

    def too_large(*given: object) -> None:
        np.empty(2**62, dtype=np.uint8)

    monkeypatch.setattr("training.run.train.worlds_for", too_large)
    assert train(tiny_config, "--output", tmp_path / "run") == 2
    error = capsys.readouterr().err
    assert error.startswith("error: too little memory: Unable to allocate 4.00 EiB; fewer worlds")
    assert error.count("\n") == 1


def test_an_output_in_use_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run"
    with alone(path):
        assert train("plain_ppo", "--steps", 256, "--overwrite", "--output", path) == 2
    assert f"{path}: in use" in capsys.readouterr().err
    assert not list(tmp_path.iterdir()), "nothing was begun"


def test_a_run_folder_is_made_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunFolder(tmp_path / "run")
    run.create(TrainingConfig(seed=1), 0)
    with monkeypatch.context() as patch:
        patch.setattr(TrainingConfig, "save", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            run.create(TrainingConfig(seed=2), 0)
    assert run.open().seed == 1 and run.repeat_file.is_file()
    run.create(TrainingConfig(seed=2), 0)
    assert run.open().seed == 2 and [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_linked_run_folder_stays_a_link_and_neighbours_stay(tmp_path: Path) -> None:
    (tmp_path / "scratch").mkdir()
    (tmp_path / ".scratch.old").mkdir()
    (tmp_path / "linked").symlink_to(tmp_path / "scratch")
    run = RunFolder(tmp_path / "linked")
    for seed in range(2):
        run.check_free(overwrite=True)
        run.create(TrainingConfig(seed=seed), 0)
        assert run.open().seed == seed
    assert sorted(path.name for path in tmp_path.iterdir()) == [".scratch.old", "linked", "scratch"]
    assert (tmp_path / "linked").is_symlink()


def test_a_run_folder_that_cannot_be_replaced_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunFolder(tmp_path / "run")
    run.create(TrainingConfig(seed=1), 0)
    rename = Path.rename

    def refused(path: Path, target: Path) -> Path:
        if path.name == "new":
            raise OSError("such a message has no number")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", refused)
    with pytest.raises(InputError, match="such a message has no number"):
        run.create(TrainingConfig(seed=2), 0)
    assert run.open().seed == 1


def test_a_large_text_in_a_checkpoint_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    checkpoint = tmp_path / "step_0000000001.zip"
    with zipfile.ZipFile(checkpoint, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("data", bytes(2**23 + 1))
    with pytest.raises(InputError, match=r"data: has 8,388,609 bytes; allowed: 8,388,608 at most"):
        read_counts(checkpoint)

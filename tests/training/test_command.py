"""``python -m training train``: what a run leaves behind, how it stops, goes on and refuses."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch
from point_env import TINY_CONFIG
from stable_baselines3 import PPO

from tests.eval.runs import make_it_run_code
from training.cli import main
from training.run.callbacks import Interrupt
from training.run.train import world_seed

ROOT = Path(__file__).parents[2]


def train(*arguments: object) -> int:
    return main(["train", *map(str, arguments)])


def evaluations(run: Path) -> list[dict[str, float]]:
    with (run / "evaluations.csv").open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def weights(model: Path) -> dict[str, torch.Tensor]:
    return PPO.load(model, device="cpu").policy.state_dict()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished tiny run; tests that change it make a copy."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "tiny.yaml").write_text(TINY_CONFIG)
    assert train(folder / "tiny.yaml", "--output", folder / "run", "--seed", 3) == 0
    return folder / "run"


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
    assert json.loads((finished / "env.json").read_text())["id"] == "Point-v0"
    assert not list(finished.rglob("*.unfinished"))


def test_policy_gets_better_and_the_best_is_kept(finished: Path) -> None:
    rows = evaluations(finished)
    assert [row["steps"] for row in rows] == [0, 512, 1024]
    assert rows[-1]["return"] > rows[0]["return"] + 0.3
    assert rows[-1]["information_true"] == pytest.approx(0.5 * rows[-1]["information_claimed"], rel=1e-4)
    best = max(rows, key=lambda row: row["return"])
    same = weights(finished / "best_model.zip")
    assert best["steps"] == 1024
    assert all(torch.equal(same[key], value) for key, value in weights(finished / "final_model.zip").items())
    observation = np.array([0.8, 0.0, 0.0], np.float32)
    action, _ = PPO.load(finished / "best_model.zip").predict(observation, deterministic=True)
    assert action[0] < 0.0  # towards the origin


def test_tensorboard_holds_the_figures(finished: Path) -> None:
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    log = EventAccumulator(str(finished / "tensorboard"))
    log.Reload()
    tags = set(log.Tags()["scalars"])
    figures = {"information_claimed", "information_true", "discomfort_s", "worst_sd", "worst_sd_10s", "violation"}
    assert {f"rollout/{name}" for name in figures} | {f"evaluation/{name}" for name in figures} <= tags
    assert {"rollout/ep_rew_mean", "evaluation/return", "evaluation/return_sampled", "time/fps"} <= tags


def test_equal_seeds_give_equal_policies(tiny_config: Path, tmp_path: Path) -> None:
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        run = tmp_path / name
        assert train(tiny_config, "--output", run, "--seed", seed, "--steps", 512) == 0
    a, b, c = (weights(tmp_path / name / "final_model.zip") for name in "abc")
    assert all(torch.equal(a[key], b[key]) for key in a)
    assert not all(torch.equal(a[key], c[key]) for key in a)
    assert evaluations(tmp_path / "a") == evaluations(tmp_path / "b")


def test_run_is_not_replaced_silently(tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = tmp_path / "run"
    assert train(tiny_config, "--output", run, "--steps", 256) == 0
    capsys.readouterr()
    assert train(tiny_config, "--output", run) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and "--resume" in error and "--overwrite" in error
    assert train(tiny_config, "--output", run, "--steps", 512, "--overwrite") == 0
    assert evaluations(run)[-1]["steps"] == 512
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("not a run")
    assert train(tiny_config, "--output", other, "--overwrite") == 2
    assert (other / "thesis.txt").exists()


def test_resume_goes_on_from_model_optimiser_and_steps(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    assert train(tiny_config, "--output", run, "--steps", 512) == 0
    before = PPO.load(run / "final_model.zip")
    assert train("--resume", run) == 0
    assert "nothing to do" in capsys.readouterr().out
    assert train("--resume", run, "--steps", 1024) == 0
    after = PPO.load(run / "final_model.zip")
    assert after.num_timesteps == 1024
    assert after._n_updates == 2 * before._n_updates
    moments = after.policy.optimizer.state_dict()["state"][0]
    assert moments["step"] == 2 * before.policy.optimizer.state_dict()["state"][0]["step"]
    assert [row["steps"] for row in evaluations(run)] == [0, 512, 1024]
    sessions = json.loads((run / "repeat.json").read_text())["sessions"]
    assert [session["from_step"] for session in sessions] == [0, 512]
    assert sessions[0]["world_seed"] != sessions[1]["world_seed"]


def test_resume_unpickles_nothing(finished: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    make_it_run_code(run / "checkpoints" / "step_0000001024.zip", tmp_path / "ran")
    assert train("--resume", run, "--steps", 1280) == 0
    assert evaluations(run)[-1]["steps"] == 1280 and not (tmp_path / "ran").exists()


def test_continue_starts_or_goes_on_but_never_mixes_settings(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    command = [tiny_config, "--output", run, "--continue", "--steps"]
    assert train(*command, 256) == 0
    assert train(*command, 512) == 0
    assert [row["steps"] for row in evaluations(run)] == [0, 256, 512]
    assert train(*command, 512) == 0
    assert "nothing to do" in capsys.readouterr().out
    assert train(*command, 1024, "--seed", 9) == 2
    assert "has other settings (seed)" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"", b"not a zip", None], ids=["empty", "text", "cut"])
def test_damaged_checkpoint_is_named(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], content: bytes | None
) -> None:
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    checkpoint = run / "checkpoints" / "step_0000001024.zip"
    checkpoint.write_bytes(checkpoint.read_bytes()[:5000] if content is None else content)
    assert train("--resume", run, "--steps", 2048) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "step_0000001024.zip is damaged" in error
    checkpoint.unlink()
    assert train("--resume", run, "--steps", 1024) == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--steps", "0"], "command line: steps = 0 must be greater than 0"),
        (["--steps", "many"], "Invalid value for '--steps'"),
        (["--n-envs", "3"], "must be a multiple of ppo.batch_size"),
        (["--seed", "-1"], "command line: seed = -1"),
        (["nowhere.yaml"], "nowhere.yaml: no such file"),
        (["nowhere"], "configuration 'nowhere': unknown; allowed: demo, distilled, plain_ppo, ppo, recurrent_ppo, "),
        (["--resume", "runs/a", "sac"], "CONFIG cannot be combined with --resume"),
        (["--resume", "runs/a", "--seeds", "1"], "--seeds cannot be combined with --resume"),
        (["--seeds", "0-2", "--seed", "1"], "--seed cannot be combined with --seeds"),
        (["--seeds", "3-1"], "seeds '3-1': 3-1 must be a range upwards"),
        (["--seeds", "a"], "seeds 'a': allowed are numbers and ranges such as 0-4 or 0,1,2"),
        (["--target-discomfort", "-1"], "comfort.target_discomfort_s = -1.0 must be greater than 0"),
        (["--control", "thought", "--residual-on", "chirp"], "{'control': 'thought'}"),
        (["sac", "--residual-on", "wiggle"], "maneuver 'wiggle': unknown; allowed: chirp"),
        (["--device", "abacus"], "device 'abacus' cannot be used"),
        (["--comfort", "nowhere.toml"], "nowhere.toml: no such file"),
        (["--resume", "runs/a", "--knowledge", "imaged"], "--knowledge cannot be combined with --resume"),
        (["--resume", "nowhere"], "nowhere holds no run"),
        (
            ["--env", "knee"],
            "env is 'knee'; allowed: jawenv/JawHinge-v2, jawenv/JawSagittal-v2, jawenv/JawSides-v2",
        ),
        (["--resume", "runs/a", "--env", "sides"], "--env cannot be combined with --resume"),
        (["--resume", "runs/a", "--seed", "1"], "--seed cannot be combined with --resume"),
        (["--colour", "red"], "No such option: --colour"),
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
    named = arguments[0] in ("nowhere.yaml", "nowhere", "sac", "--resume")
    base = [] if named else [tiny_config]
    assert train(*base, *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1 and message in error
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("env", "message"),
    [
        ("{id: Nowhere-v0}", "env.id 'Nowhere-v0'"),
        ("{id: 'no_module:Point-v0'}", "no_module"),
        ("{id: 'point_env:Point-v0', kwargs: {colour: red}}", "unexpected keyword argument 'colour'"),
        ("{id: 'point_env:Point-v0', kwargs: {start: -1.0}}", "start is -1.0: must be > 0"),
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


def signalled_run(number: signal.Signals, arguments: list[str], run: Path, after: int) -> str:
    """Output of a run in a process of its own, signalled once it has saved more than ``after`` steps."""
    environment = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{Path(__file__).parent}"}
    command = [sys.executable, "-m", "training", "train", *arguments]
    process = subprocess.Popen(
        command, env=environment, cwd=run.parent, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        for _ in range(1800):
            if steps_saved(run) > after:
                break
            assert process.poll() is None, process.stdout.read() if process.stdout else ""
            time.sleep(0.1)
        process.send_signal(number)
        output, _ = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, output
    return output


def steps_saved(run: Path) -> int:
    files = list((run / "checkpoints").glob("step_*.zip"))
    return max((int(path.stem.removeprefix("step_")) for path in files), default=0)


def test_signals_save_a_checkpoint_that_resume_goes_on_from(tiny_config: Path, tmp_path: Path) -> None:
    run = tmp_path / "run"
    first = [str(tiny_config), "--output", str(run), "--steps", "10000000"]
    output = signalled_run(signal.SIGINT, first, run, after=0)
    assert "stopped by SIGINT" in output and f"--resume {run}" in output and "Traceback" not in output
    saved = steps_saved(run)
    assert saved % 256 == 0  # only whole rollouts, which a policy update has learned from, are counted
    output = signalled_run(signal.SIGTERM, ["--resume", str(run)], run, after=saved)
    assert "stopped by SIGTERM" in output
    assert steps_saved(run) > saved
    assert not (run / "final_model.zip").exists()


def test_second_signal_stops_at_once() -> None:
    with Interrupt() as interrupt:
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupt.wanted()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1.0)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_too_many_worlds_and_an_unusable_folder_get_one_line(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    assert train(tiny_config, "--output", tmp_path / "file" / "run") == 2
    assert capsys.readouterr().err == f"error: output {tmp_path / 'file' / 'run'}: cannot be made: Not a directory\n"

    def too_large(*given: object) -> None:
        np.empty(2**62, dtype=np.uint8)

    monkeypatch.setattr("training.run.train.make_worlds", too_large)
    assert train(tiny_config, "--output", tmp_path / "run") == 2
    error = capsys.readouterr().err
    assert error.startswith("error: too little memory: Unable to allocate 4.00 EiB; fewer worlds")
    assert error.count("\n") == 1

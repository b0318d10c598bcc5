"""The examples run as their first lines say, in a process of their own; what they refuse is seen in this one."""

import importlib.util
import json
import runpy
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jawenv
from tests.processes import python

ROOT = Path(__file__).parents[2]


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return python(*arguments, cwd=ROOT, env={"OMP_NUM_THREADS": "1"}, check=False)


@pytest.fixture
def refusal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Runs an example that ends with status 2 and one line on stderr, which it returns."""

    def run_here(script: str, *arguments: str) -> str:
        monkeypatch.setattr(sys, "argv", [script, *arguments])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(ROOT / "examples" / script), run_name="__main__")
        assert ended.value.code == 2
        told = capsys.readouterr().err
        assert told.startswith("error: ") and len(told.splitlines()) == 1
        return told

    return run_here


@pytest.mark.parametrize(
    ("script", "arguments", "told"),
    [
        ("slow_device", ("--patients", "1", "--episode-s", "1", "--every", "0"), "thinned: every is 0"),
        ("importance_posterior", ("--samples", "1"), "samples is 1; allowed: 50 or more\n"),
        ("own_filter", ("--patients", "0"), "patients is 0; allowed: 1 or more\n"),
        ("own_patient", ("--seconds", "0"), "seconds is 0; allowed: 1 or more\n"),
        ("real_time", ("--seconds", "nan"), "seconds is nan; allowed: more than 0\n"),
        ("device_loop", ("--seconds", "0"), "seconds is 0; allowed: 1 to 600\n"),
        ("my_own_learner", ("--generations", "0"), "generations is 0; allowed: 1 or more\n"),
    ],
)
def test_an_example_names_what_is_not_allowed(refusal, script: str, arguments: tuple[str, ...], told: str) -> None:
    assert refusal(f"{script}.py", *arguments).startswith(f"error: {told}")


def test_estimate_from_a_recording(tmp_path: Path, refusal) -> None:
    file = tmp_path / "recording.csv"
    made = run("examples/estimate_from_a_recording.py", "--make", str(file), "--seconds", "2")
    assert made.returncode == 0, made.stderr
    done = run("examples/estimate_from_a_recording.py", str(file))
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert "2 s at 100 Hz" in lines[0]
    assert sum(line.startswith(("F_o/", "b/")) for line in lines) == 12

    file.write_text(file.read_text().replace("pitch_deg", "pitch"))
    assert "'pitch'" in refusal("estimate_from_a_recording.py", str(file))


def test_slow_device() -> None:
    short = ("--patients", "2", "--episode-s", "3")
    done = run("examples/slow_device.py", "hold_still", *short, "--every", "1", "5")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("hold_still, 2 patients, 3 s\n")
    rows = [line.split()[:4] for line in done.stdout.splitlines() if " Hz" in line]
    assert [row[:3] for row in rows] == [["100", "Hz", "tension"], ["20", "Hz", "tension"]]


def test_importance_posterior() -> None:
    done = run("examples/importance_posterior.py", "--patients", "2", "--seconds", "2", "--samples", "100")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    effective = [float(line.split()[-4]) for line in lines if line.startswith("posterior")]
    apart = [float(line.split()[-3]) for line in lines if line.startswith("filter")]
    assert len(effective) == len(apart) == 2
    assert min(effective) > 40 and max(apart) < 0.7  # a mean that is one sd off is 0.5 nats apart
    assert lines[-1].startswith("NEES/2 of 2 patients: posterior ")


def test_own_filter() -> None:
    done = run("examples/own_filter.py", "--patients", "2", "--seconds", "4")
    assert done.returncode == 0, done.stderr
    sds = np.array([[float(row.split()[k]) for k in (3, 7)] for row in done.stdout.splitlines() if "F_o" in row])
    np.testing.assert_allclose(sds[:2], sds[2:], rtol=0.5)  # of the same patients and readings, by the environment's
    assert done.stdout.count("mean NEES/2") == 2


def test_own_patient() -> None:
    done = run("examples/own_patient.py", "--patients", "2", "--seconds", "4")
    assert done.returncode == 0, done.stderr
    inside, own, rough = (float(line.split()[-1]) for line in done.stdout.splitlines())
    assert own == pytest.approx(inside, rel=0.3)  # of the same patients and noise
    assert rough > 2.0 * own


def test_real_time(tmp_path: Path) -> None:
    done = run("examples/real_time.py")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line.split(" s: all within ")[0].strip() for line in lines[:5]] == ["1", "2", "3", "4", "5"]
    assert all("misfit" in line for line in lines[:5])
    assert lines[5].startswith("501 updates: median ") and lines[6].startswith("a reading was taken ")

    file = tmp_path / "recording.csv"
    assert run("examples/estimate_from_a_recording.py", "--make", str(file), "--seconds", "2").returncode == 0
    fast = run("examples/real_time.py", str(file), "--fast", "--seconds", "1")
    assert fast.returncode == 0, fast.stderr
    assert len(fast.stdout.splitlines()) == 2 and "101 updates" in fast.stdout


def test_device_loop() -> None:
    done = run("examples/device_loop.py", "--seconds", "2")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "201 readings, 0 without a reply"
    p50, p99 = (float(lines[1].split()[i]) for i in (2, 5))
    assert 0.0 < p50 <= p99
    assert lines[2].startswith("deadlines of 10 ms missed: ") and lines[3].startswith("all within ")


def packets_of(loop: Any, seconds: float) -> tuple[Any, list[bytes]]:
    record = jawenv.play(
        loop.Player(loop.MANEUVER), patients=1, seed=0, env_kwargs={"record": True, "episode_s": seconds}
    ).records[0]
    readings = np.zeros(len(record.measured), loop.READING)
    readings["tick"], readings["measured"] = np.arange(len(readings)), record.measured
    readings["samples"][1:] = record.samples
    return record, [reading.tobytes() for reading in readings]


class Link:
    """A socket on which these packets have arrived, most from the device."""

    def __init__(self, packets: list[Any]) -> None:
        self.packets, self.replies = packets, 0

    def recvfrom(self, size: int) -> tuple[bytes, str]:
        if not self.packets:
            raise TimeoutError
        packet = self.packets.pop(0)
        packet, sender = packet if isinstance(packet, tuple) else (packet, "device")
        return packet[:size], sender

    def sendto(self, data: bytes, sender: str) -> None:
        assert sender == "device"
        self.replies += 1

    def send(self, data: bytes) -> None:
        self.replies += 1


def test_device_loop_takes_packets_as_a_network_treats_them(capsys) -> None:
    spec = importlib.util.spec_from_file_location("device_loop", ROOT / "examples" / "device_loop.py")
    loop = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loop)
    record, packets = packets_of(loop, 3.0)

    def of_tick(tick: int) -> bytes:
        reading = np.frombuffer(packets[100], loop.READING)[0].copy()
        reading["tick"] = tick
        return reading.tobytes()

    def served(sent: list[Any]) -> Any:
        end = np.zeros((), loop.READING)
        end["tick"] = loop.END
        return loop.serve(Link([*sent, end.tobytes()]), jawenv.OnlineFilter.of_record(record))

    whole = served(list(packets))
    odd = [b"", b"x", packets[9][:-1], packets[9] + b"x", of_tick(10**9), of_tick(2**62), of_tick(-5), of_tick(3000)]
    strange = [(of_tick(101), "stranger"), (of_tick(loop.END), "stranger")]
    for extra in ([packets[99]], [packets[0]] * 20, odd, strange, [*odd, *strange]):
        capsys.readouterr()
        belief = served([*packets[:100], *extra, *packets[100:]])
        np.testing.assert_array_equal(belief.log_mean, whole.log_mean)
        assert belief.time_s == whole.time_s
        assert f"{len(extra)} packets were no next reading" in capsys.readouterr().out
    end = np.zeros((), loop.READING)
    end["tick"] = loop.END
    np.testing.assert_array_equal(served([(end.tobytes(), "stranger"), *packets]).log_mean, whole.log_mean)
    flipped = [*packets[:50], of_tick(2000), *packets[50:100], of_tick(2040), *packets[100:]]
    assert served(flipped).time_s == whole.time_s
    outage = served([*packets[:20], *packets[150:]])  # two packets have to agree that the link was down so long
    assert outage.time_s == whole.time_s and np.isfinite(outage.log_mean).all()
    late = served([*packets[:100], *packets[101:130], packets[100], *packets[130:]])
    assert late.time_s == whole.time_s
    assert loop.serve(Link([]), jawenv.OnlineFilter.of_record(record)) is None
    capsys.readouterr()
    flood = [(of_tick(50), "stranger")] * 99
    said = loop.serve(Link([*flood, *packets]), jawenv.OnlineFilter.of_record(record), "device")
    np.testing.assert_array_equal(said.log_mean, whole.log_mean)
    assert "99 packets were no next reading" in capsys.readouterr().out


def test_experimenter() -> None:
    """An agent moves, reads and answers; what is no request gets one line; too sure an answer scores less."""
    spec = importlib.util.spec_from_file_location("experimenter", ROOT / "examples" / "experimenter.py")
    experimenter = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(experimenter)
    experiment = experimenter.Experiment(7, "anyone", 4.0, True)
    path = [[1, 0.8, 0.9, 0, -1], [1, 0.2, -0.9, 0.3, 1], [1, 0.9, -0.9, 0, 1], [1e9, 0.2, 0.9, 0.3, -1]]
    asked = ["?", "3", '{"jump": 1}', '{"move": 3}', '{"answer": {}}', json.dumps({"move": path}), '{"identify": true}']
    task, *errors, moved, found = experimenter.talk(experiment, asked)
    assert len(task["prior"]) == 12 and all(set(reply) == {"error"} for reply in errors) and len(errors) == 5
    assert moved["seconds_left"] == 0.0 and len(moved["rows"]) == 20 and moved["rows"][-1]["time_s"] == 4.0
    told = found["estimate"]
    scores = [experiment.answer({n: [m, f * s] for n, (m, s) in told.items()})["nats"] for f in (1.0, 0.1)]
    assert scores[0] > 10.0 and scores[1] < scores[0] and experiment.answer(task["prior"]) == {"nats": 0.0}
    silent = experimenter.Experiment(7, "anyone", 4.0, False)
    assert list(experimenter.talk(silent, ['{"identify": true}']))[1] == {"error": "identify is not allowed here"}
    done = run("examples/experimenter.py", "--marks", "--seconds", "1")
    assert done.returncode == 0 and done.stdout.count("nats") == 2, done.stderr


def test_train_with_torchrl() -> None:
    pytest.importorskip("torchrl", exc_type=ImportError)
    done = run("-W", "ignore", "examples/train_with_torchrl.py", "--steps", "4096", "--episode-s", "3")
    assert done.returncode == 0, done.stderr
    rounds = [
        line.split(":")[0] for line in done.stdout.splitlines() if "nats a step" in line
    ]  # TorchRL logs there too
    assert rounds == ["round 1", "round 2"]


def test_sbi_posterior() -> None:
    """Those who cannot be treated are NaN, and left out by training and diagnostics."""
    pytest.importorskip("sbi")
    done = run("-W", "ignore", "examples/sbi_posterior.py", "--simulations", "110", "--tests", "120", "--epochs", "2")
    assert done.returncode == 0, done.stderr
    assert "13 NaN simulations" in done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "110 of 120 patients can be treated"
    assert [line.split(":")[0] for line in lines[2:]] == ["coverage of 50%", "coverage of 80%", "coverage of 95%"]


@pytest.mark.parametrize("algorithm", ["ppo", "apg"])
def test_train_in_one_file(algorithm: str) -> None:
    done = run("examples/train_in_one_file.py", algorithm, "--updates", "1", "--worlds", "4")
    assert done.returncode == 0, done.stderr
    before, after = (float(line.split()[-1]) for line in done.stdout.splitlines())
    assert np.isfinite(after) and before != after


def test_my_own_learner() -> None:
    script = "examples/my_own_learner.py"
    done = run(script, "--generations", "1", "--patients", "2", "--episode-s", "2")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["refined_one_sided", "generation", "my_own_learner"]
    assert lines[0].split()[4] != lines[2].split()[4]


def test_environments_of_others_methods() -> None:
    first, other = (float(word) for word in run("examples/linear_design_env.py").stdout.strip("[]\n").split())
    assert first > other
    bounds = run("examples/location_finding.py", "--rollouts", "8", "--contrasts", "2000").stdout.splitlines()
    assert [float(line.split()[-3]) > 3.0 for line in bounds] == [True, True]
    done = run("examples/bayesflow_simulator.py")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["theta     (8, 2)", "readings  (8, 21, 12)"]


def test_the_jaw_of_mujoco_by_its_own_identification() -> None:
    pytest.importorskip("tabulate", reason='tabulate is not installed: pip install "mujoco[sysid]"')
    done = run("-W", "ignore", "examples/mujoco_sysid.py", "--seconds", "0.3")
    assert done.returncode == 0, done.stderr
    misfit, *rows = done.stdout.splitlines()[-13:]
    assert 0.2 < float(misfit.removeprefix("misfit ")) < 1.5, "the fit has the noise's size"
    found = [[float(word) for word in row.replace("truth", "±").split(maxsplit=1)[1].split("±")] for row in rows]
    far = [abs(at - truth) > 2.0 * half + 0.1 for at, half, truth in found]
    assert sum(far) <= 3, done.stdout


def test_learned_designs_are_trained_and_play(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.setattr("sys.argv", ["deep_adaptive_design.py", "--updates", "12"])
    example = import_module("examples.deep_adaptive_design")
    example.main()
    model, *bounds = capsys.readouterr().out.splitlines()
    assert float(model.split()[4]) < 0.6, "N between the model of the reading and the simulator"
    assert all(2.0 < float(line.split(": ")[1].split()[0]) < 6.93 for line in bounds) and len(bounds) == 2
    for agent in (example.DeepAdaptiveDesign(), example.RLBOED(), example.AtOnce()):
        played = jawenv.play(agent, patients=2, seed=0, env_id=example.ENV, env_kwargs={"episode_s": 3.0})
        assert played.belief_sd[:, -1].max() < 0.1, agent.name

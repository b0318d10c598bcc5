"""Films of episodes: what is in them, what is said, and what is refused."""

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from eval.cli import main

SHORT = ["--episode-s", "1", "--seed", "5000"]
FORCE = ["--control", "force"]  # 20 steps per second


def test_a_film_has_a_picture_for_every_step_that_is_shown(tmp_path, capsys):
    path = tmp_path / "film.mp4"
    assert main(["play", "chirp", *SHORT, *FORCE, "--video", str(path), "--every", "4", "--width", "640"]) == 0
    assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (20 // 4 + 1, pytest.approx(6 / 5.0, abs=0.02))
    said = capsys.readouterr().out
    assert "chirp: after 1 s " in said and "least known is " in said and str(path.name) in said.replace("\n", "")
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]


def test_a_gif_moves_and_begins_where_asked(tmp_path):
    path = tmp_path / "film.gif"
    assert main(["play", "chirp", *SHORT, *FORCE, "--video", str(path), "--start-s", "0.5", "--width", "320"]) == 0
    with Image.open(path) as film:
        assert film.n_frames == 11 and film.info["duration"] == 50
        first = np.asarray(film.convert("RGB"))
        film.seek(10)
        assert (np.asarray(film.convert("RGB")) != first).any()
    assert path.stat().st_size < 400_000


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--video", "film.avi"], "video: film.avi given, allowed is a file that ends in .mp4 or .gif"),
        (["--video", "nowhere/film.gif"], "video: nowhere/film.gif given, allowed is a file in a folder that exists"),
        (["--video", "film.gif", "--width", "333"], "width: 333 given"),
        (["--video", "film.gif", "--every", "0"], "every: 0 given"),
        (["--video", "film.gif", "--start-s", "7"], "start_s: 7 given"),
        (["--video", "film.gif", "--patient", "nobody.json"], "nobody.json"),
        (["--video", "film.gif", "--cohort", "knees"], "knees"),
    ],
)
def test_what_cannot_be_filmed_is_named(tmp_path, monkeypatch, capsys, options, said):
    monkeypatch.chdir(tmp_path)
    assert main(["play", "chirp", *SHORT, *options]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("error: ") and said in error
    assert not list(tmp_path.iterdir())

"""Films of episodes: what is in them, what is said, and what is refused."""

from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from eval.commands.app import main
from eval.episodes.film import Film
from eval.kept.entries import Settings, load_entries
from jawenv.rendering.palette import knowledge

SHORT = ["--episode-s", "1", "--seed", "5000"]
FORCE = ["--control", "force"]  # 20 steps per second


def test_a_film_has_a_picture_for_every_step_that_is_shown(tmp_path, capsys):
    path = tmp_path / "film.mp4"
    assert main(["play", "chirp", *SHORT, *FORCE, "--video", str(path), "--every", "4", "--width", "640"]) == 0
    assert imageio_ffmpeg.count_frames_and_secs(str(path)) == (20 // 4 + 1, pytest.approx(6 / 5.0, abs=0.02))
    said = capsys.readouterr().out
    assert "chirp: after 1 s " in said and "least known is " in said and str(path.name) in said.replace("\n", "")
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]


def test_a_webp_moves(tmp_path):
    path = tmp_path / "film.webp"
    assert main(["play", "chirp", *SHORT, *FORCE, "--video", str(path), "--width", "320"]) == 0
    with Image.open(path) as film:
        assert film.n_frames == 21 and film.info["loop"] == 0
        first = np.asarray(film.convert("RGB"))
        film.seek(20)
        assert (np.asarray(film.convert("RGB")) != first).any()
    assert path.stat().st_size < 800_000


def test_two_are_filmed_beside_each_other(tmp_path, capsys):
    path = tmp_path / "film.webp"
    assert main(["play", "hold_still", "refined", *SHORT, "--video", str(path), "--width", "640"]) == 0
    said = capsys.readouterr().out
    assert said.index("hold_still: after 1 s ") < said.index("refined: after 1 s ")
    with Image.open(path) as film:
        assert film.n_frames == 6
        film.seek(5)
        picture = np.asarray(film.convert("RGB")).astype(int)
    blue = (np.abs(picture - knowledge(0.05)).max(axis=-1) < 40)[220:325]  # the bars
    assert blue[:, 320:].sum() > 100 + blue[:, :320].sum()


def test_pictures_name_maneuver_patient_and_control():
    entry = load_entries(["chirp"], Settings.of(1, 5000, cohort="severe", control="force", episode_s=1.0).world)[0]
    assert Film(entry, seed=5000).title == "chirp: Jaw, severe patient, seed 5000, force control"
    named = Film(entry, seed=5000, patient=Path("aunt.json"))
    assert named.title == "chirp: Jaw, patient aunt, seed 5000, force control"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--video", "film.avi"], "video is film.avi; allowed: a file that ends in .mp4 or .webp"),
        (["--video", "nowhere/film.webp"], "video is nowhere/film.webp; allowed: a file in a folder that exists"),
        (["--video", "film.webp", "--width", "333"], "width is 333; allowed"),
        (["--video", "film.webp", "--every", "0"], "every is 0; allowed"),
        (["--video", "film.webp", "--patient", "nobody.json"], "nobody.json"),
    ],
)
def test_what_cannot_be_filmed_is_named(tmp_path, monkeypatch, capsys, options, said):
    monkeypatch.chdir(tmp_path)
    assert main(["play", "chirp", *SHORT, *options]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.startswith("error: ") and said in error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("entries", "said"),
    [(["chirp"] * 3, "allowed: one, or two beside each other"), (["chirp", "prbs"], "use --video FILE")],
)
def test_a_window_shows_one_entry_and_a_film_two_at_most(capsys, entries, said):
    assert main(["play", *entries, *SHORT]) == 2
    assert said in capsys.readouterr().err

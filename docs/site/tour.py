"""A page to send a link to: three maneuvers on one patient in 3-D, beside each other or below, and the patient's page.

``python docs/site/tour.py`` writes runs/site/tour.html, one file that opens from disk.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT)]

from jawenv.base.files import write_text  # noqa: E402
from jawenv.live.jaw3d import Jaw3D  # noqa: E402
from jawenv.live.outcome import learned_agents  # noqa: E402
from jawenv.live.server import serving  # noqa: E402
from jawenv.live.session import DriveSession  # noqa: E402
from jawenv.live.setup import Setup  # noqa: E402
from jawenv.metrics.precision import for_good  # noqa: E402
from jawenv.rendering import palette  # noqa: E402
from jawenv.rendering.scene import Scene  # noqa: E402

PAGE, KEPT = ROOT / "runs" / "site" / "tour.html", Path("runs") / "tour"
COHORT, SEED, SHOWN_S = "one_sided", 500, 30.0
DRIVERS = {
    "slow_opening": "Slow opening, by hand",
    "opening_with_swings_and_fore_aft": "Opening with swings and a push, by hand",
    "apg_anyone": "Learned, adapts",
}
"""Name of each of the three, from left to right -> its title."""
EVERY = 2  # of the control steps one is shown
RIGHT, UP = np.array([0.707, 0.707, 0.0]), np.array([0.0, 0.0, 1.0])  # of the viewer
LOOK_AT = np.array([0.4, 0.0, -0.75])
LAYOUTS = {"wide": (2.5 * RIGHT, 13.0), "narrow": (-3.75 * UP, 41.0)}
"""Steps on a page: from one jaw to the next, units of the scene, and the angle of view, degrees."""
CAMERA = np.array([12.4, -12.0, 1.2])
BAR, GAP, TALLEST, BARS_AT, BARS_RIGHT = 0.2, 0.3, 0.8, -2.25, 0.25
BEST_SD, KNOWN_SD = 0.01, 0.05
LETTERS = 0.11  # height, units of the scene
MARKS_S = (3, 10)


class Bars:
    """A bar for each muscle below a jaw, that fills as the less known of its two parameters becomes known."""

    def __init__(self, server: Any, scene: Scene, root: str) -> None:
        corners = np.array([[-0.5, 0.0], [0.5, 0.0], [0.5, 1.0], [-0.5, 1.0]])
        vertices = (corners[:, :1] * BAR * RIGHT + corners[:, 1:] * TALLEST * UP).astype(np.float32)
        faces, self._bars = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), []
        for i in range(len(scene.muscles)):
            place = (BARS_RIGHT + (i - (len(scene.muscles) - 1) / 2) * GAP) * RIGHT + BARS_AT * UP
            for name, back, colour in (("track", 0.02, palette.TRACK), ("bar", 0.0, palette.KNOWLEDGE[0])):
                handle = server.scene.add_mesh_simple(
                    f"{root}/{name}_{i}", vertices, faces, color=colour, side="double",
                    position=place + back * np.array([-0.7, 0.7, 0.0]),
                )  # fmt: skip
            self._bars.append(handle)
            *words, side = scene.muscles[i].split("_")
            initials = "".join(word[0] for word in words).upper()
            _label(server, f"{root}/name_{i}", f"{initials} {side[0].upper()}", place - 0.06 * UP, "top-center")
        end = BARS_RIGHT + (len(scene.muscles) / 2 - 0.5) * GAP + 0.16
        for sd in (KNOWN_SD, BEST_SD):
            height = (BARS_AT + TALLEST * self._share(float(scene.prior_sd.max()), sd)) * UP
            ends = np.array([[(BARS_RIGHT * 2 - end) * RIGHT + height, end * RIGHT + height]], dtype=np.float32)
            server.scene.add_line_segments(f"{root}/line_{sd}", ends, palette.SOFT_INK, thickness=0.012)
            _label(server, f"{root}/scale_{sd}", f"{100 * sd:g} %", end * RIGHT + height + 0.05 * RIGHT, "center-left")

    @staticmethod
    def _share(worst: float, sd: float) -> float:
        """How full a bar is."""
        return float(min(max(np.log(worst / sd) / np.log(worst / BEST_SD), 0.02), 1.0))

    def show(self, scene: Scene) -> None:
        """Fill them to a moment."""
        worst = float(scene.prior_sd.max())
        for muscle, bar in zip(scene.muscles, self._bars, strict=True):
            rows = [scene.parameter_names.index(f"{parameter}/{muscle}") for parameter in ("log_F_o", "log_b")]
            sd = float(scene.belief_sd[rows].max())
            share = round(self._share(worst, sd), 2)
            if np.ravel(bar.scale)[-1] != share:
                bar.scale, bar.color = (1.0, 1.0, share), palette.knowledge(sd)


def _label(server: Any, name: str, words: str, place: Any, anchor: str) -> None:
    server.scene.add_label(
        name, words, position=tuple(place), anchor=anchor, font_size_mode="scene", font_scene_height=LETTERS
    )


def drives_html(seconds: float, layout: str) -> tuple[str, dict[str, str]]:
    """The page of viser that shows the three drives, with a slider over their time, and each one's verdict clock.

    Args:
        seconds: length of the drives.
        layout: a key of ``LAYOUTS``.
    """
    apart, angle_deg = LAYOUTS[layout]
    setup = Setup.of(seed=SEED, cohort=COHORT, episode_s=seconds)
    with serving(0) as server:
        shown = []
        for number, name in enumerate(DRIVERS):
            session, root = DriveSession(setup, learned_agents()), f"/{name}"
            session.hand_over(name)
            server.scene.add_frame(root, show_axes=False, position=(number - 1) * apart)
            first = session.shown().scene
            if layout == "narrow":
                _label(server, f"{root}/title", DRIVERS[name], 0.85 * UP, "bottom-center")
            shown.append((session, Jaw3D(server, first, root, named=False), Bars(server, first, root)))
        server.initial_camera.position = tuple(CAMERA)
        server.initial_camera.look_at = tuple(LOOK_AT)
        server.initial_camera.fov = float(np.radians(angle_deg))
        recorded, stands = server.get_scene_serializer(), []
        for _ in range(round(seconds * setup.world.steps_per_s / EVERY)):
            moments = [[session.drive() for _ in range(EVERY)][-1] for session, _, _ in shown]
            scenes = [moment.scene for moment in moments]
            for scene, (_, jaw, bars) in zip(scenes, shown, strict=True):
                jaw.show(scene)
                bars.show(scene)
            stands.append([moment.stands.all() for moment in moments])
            recorded.insert_sleep(EVERY / setup.world.steps_per_s)
        html = _as_the_reader_prefers(str(recorded.as_html()), seconds)
    times = np.arange(1, len(stands) + 1) * EVERY / setup.world.steps_per_s
    clocks = map(clock, for_good(np.array(stands).T, times))
    return html, dict(zip(DRIVERS, clocks, strict=True))


def clock(seconds: float) -> str:
    """When all six verdicts stand, in words."""
    return f"all six verdicts stand after {seconds:.1f} s" if np.isfinite(seconds) else "a verdict is open at the end"


def _as_the_reader_prefers(html: str, seconds: float) -> str:
    """Viser's page, dark where the browser's reader prefers dark pages, with names for readers and marks of times."""
    dark = "matchMedia('(prefers-color-scheme: dark)').matches"
    assert "darkMode:false" in html and "<head>" in html, "viser writes its page otherwise"
    head = f"<head>{_marks(seconds)}{_NAMES}{_NO_BANNER}"
    return html.replace("darkMode:false", f"darkMode:{dark}", 1).replace("<head>", head, 1)


def _marks(seconds: float) -> str:
    """A script that draws the marks of times on viser's slider, which it makes anew when it likes."""
    return _MARKS.replace("SECONDS", f"{seconds:g}").replace("TIMES", repr([s for s in MARKS_S if s < seconds]))


def patient_html(seconds: float, folder: Path) -> str:
    """The patient's page after a treatment by the last of the three; ``folder`` keeps the treatment."""
    driver = list(DRIVERS)[-1]
    asked = ["--cohort", COHORT, "--seed", str(SEED), "--episode-s", f"{seconds:g}", "--output", str(folder)]
    command = [sys.executable, "-m", "eval", "patient", driver, *asked, "--show-truth"]
    subprocess.run(command, check=True, cwd=ROOT)
    (page,) = (ROOT / folder).glob("patient-*.html")
    return page.read_text(encoding="utf-8")


def tour(seconds: float, folder: Path) -> str:
    """All of it as one HTML file."""
    drives = {name: drives_html(seconds, name) for name in LAYOUTS}
    frames = {name: html for name, (html, _) in drives.items()} | {"patient": patient_html(seconds, folder)}
    clocks = drives["wide"][1]
    titles = "".join(f"<div><b>{escape(DRIVERS[name])}</b><br>{clocks[name]}</div>" for name in DRIVERS)
    return _TEMPLATE.format(titles=titles, **{name: escape(html, quote=True) for name, html in frames.items()})


_NAMES = """<script>
setInterval(() => {
  const name = (chosen, words) => document.querySelectorAll(chosen).forEach(
    (field) => (field.closest("button") || field).setAttribute("aria-label", words));
  name(".mantine-Notification-closeButton", "Close");
  name("[class*=tabler-icon-player]", "Play or pause");
  name(".mantine-NumberInput-input, .mantine-Slider-thumb", "Time, s");
  name(".mantine-Select-input", "Speed");
}, 500);
</script>"""
# Viser's notice that the processor draws would cover a jaw.
_NO_BANNER = "<style>.mantine-Notification-root { display: none !important; }</style>"
_MARKS = """<script>
setInterval(() => document.querySelectorAll(".mantine-Slider-trackContainer").forEach((track) => {
  if (track.querySelector("[data-mark]")) return;
  for (const time of TIMES) {
    const mark = document.createElement("span");
    mark.dataset.mark = time;
    mark.textContent = time + " s";
    mark.style.cssText = `position:absolute; left:${100 * time / SECONDS}%; bottom:60%; font:10px system-ui;
      border-left:1px solid; padding-left:2px; pointer-events:none`;
    track.append(mark);
  }
}), 500);
</script>"""
_TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>jawenv: how stiff is each jaw muscle?</title>
<style>
:root {{ color-scheme: light dark; }}
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 0 auto; padding: 1rem;
  color: light-dark(#222a35, #e6e8ea); background: light-dark(#fff, #1b1d21); }}
iframe {{ width: 100%; border: 1px solid light-dark(#e2ded5, #3d4147); border-radius: 8px;
  background: light-dark(#fff, #141414); }}
#titles {{ display: grid; grid-template-columns: repeat(3, 1fr); gap: .5rem; text-align: center; line-height: 1.25; }}
#drives {{ aspect-ratio: 1.9; }}
@media (max-width: 40em) {{
  #drives {{ aspect-ratio: 0.42; }}
  #titles {{ grid-template-columns: 1fr; }}
}}
#patient {{ height: 72rem; }}
small {{ color: light-dark(#5b636e, #a9b0b8); }}
</style></head><body><main>
<h1>How stiff is each jaw muscle, and how soon is that known?</h1>
<p>Four seconds of the right movement tell as much as half a minute of slow opening. (In simulation.)</p>
<p>One patient, three movements. Below each jaw a bar fills as a muscle becomes known: masseter (M), temporalis (T) and
medial pterygoid (MP), left (L) and right (R). The lines are error bars of 5 % and 1 %. Muscles turn from clay to blue.
Drag to orbit; the slider moves the time, with marks at 3 and 10 s.</p>
<div id="titles">{titles}</div>
<iframe id="drives" title="Three drives in 3-D" data-wide="{wide}" data-narrow="{narrow}"></iframe>
<script>
const drives = document.getElementById("drives");
drives.srcdoc = drives.dataset[matchMedia("(max-width: 40em)").matches ? "narrow" : "wide"];
</script>
<p><b>Try it:</b> in a clone of jawenv, <code>make live</code> opens a page on which you move this jaw yourself;
anywhere else <code>pip install "jawenv[live]"</code>, then <code>jawenv live --open</code>.</p>
<h2>The patient's page</h2>
<p>What a therapist reads after the movement on the right, if the anatomy is known as a scan shows it.</p>
<iframe id="patient" title="The patient's page" srcdoc="{patient}"
  onload="this.style.height = this.contentDocument.documentElement.scrollHeight + 4 + 'px'"></iframe>
<p><small>jawenv. Simulated, for research, not a medical device.</small></p></main>
</body></html>
"""


def main() -> None:
    """Write the page, and say how large it is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=PAGE, metavar="FILE")
    parser.add_argument("--seconds", type=float, default=SHOWN_S, help="length of the drives")
    asked = parser.parse_args()
    asked.output.parent.mkdir(parents=True, exist_ok=True)
    write_text(asked.output, tour(asked.seconds, KEPT))
    print(f"{asked.output}: {asked.output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()

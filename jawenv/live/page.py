"""The page: a viser server that shows one session to all browsers, and drives it in real time."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.anatomy import COHORTS
from jawenv.anatomy.knowledge import LEVELS
from jawenv.controls import CONTROLS
from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.errors import InputError
from jawenv.ladder import MODELS
from jawenv.live import panels
from jawenv.live.keys import Keys, keys_html, moved
from jawenv.live.outcome import DriveOutcome, outcomes_of_rivals
from jawenv.live.saving import Saves
from jawenv.live.session import BY_HAND, DriveSession
from jawenv.live.setup import LONGEST_S, SHORTEST_S, Setup
from jawenv.live.view import View
from jawenv.playing.maneuvers import maneuver_names
from jawenv.playing.protocol import Agent, Array
from jawenv.playing.rollout import LARGEST_SEED

_SLIDERS = ("Opening", "Side, left +", "Fore-aft force", "Roll, right +")
_STEP = 0.005
_NOBODY = "nobody"
_MOST_WISHES = 100  # between two steps; more are dropped
_BEGIN = "Hold S to open the jaw: with the first key or slider the time begins. The aim is to make every muscle blue."
_AGAIN = "Again: the same patient once more. Patient and model: another one."


class Page:
    """A page of sliders, keys, posteriors and a jaw, with one session behind it.

    Callbacks of viser run in threads of their own; they only leave wishes, which ``run`` fulfils between two steps.

    Args:
        server: a ``viser.ViserServer``.
        setup: of the first session.
        folder: where drives are saved.
        driver: who drives at first: ``you``, an agent or a maneuver.
        agents: who may drive beside the maneuvers, and is in the score; see `jawenv.live.session.DriveSession`.

    Raises:
        InputError: the setup or the driver is refused.
    """

    def __init__(
        self,
        server: Any,
        setup: Setup,
        folder: Path,
        driver: str = BY_HAND,
        agents: Mapping[str, Agent] | None = None,
    ) -> None:
        self._saves = Saves(folder)
        self._wishes: queue.Queue[Callable[[], None]] = queue.Queue(_MOST_WISHES)
        self._stopped = threading.Event()
        self._paused, self._waiting, self._remark, self._rivals = False, True, "", list[DriveOutcome]()
        self.steps = 0
        self._ghost: DriveSession | None = None
        self.session = DriveSession(setup, agents)
        self.session.hand_over(driver)
        self._shown = self.session.shown()
        self._view = View(server, self._shown)
        self._keys = Keys(server)
        self._lay_out(self._view.gui)
        self._wait()
        self._show()

    def run(self) -> None:
        """Drive in real time until ``stop``; what was driven is saved where an error ends it."""
        try:
            self._run()
        except Exception:
            with contextlib.suppress(InputError):  # nothing was driven, or it cannot be written
                self._saves.save(self.session)
            raise

    def _run(self) -> None:
        due = time.perf_counter()
        while not self._stopped.is_set():
            while not self._wishes.empty():
                self._fulfil(self._wishes.get())
            if self._drives():
                self.step()
            due = max(due + self.period_s, time.perf_counter() - self.period_s)
            self._stopped.wait(max(0.0, due - time.perf_counter()))

    def stop(self) -> None:
        """End ``run``, from any thread."""
        self._stopped.set()

    @property
    def period_s(self) -> float:
        """Time from one step to the next, s."""
        return 1.0 / self.session.setup.world.steps_per_s

    def _wait(self) -> None:
        """Hold time until somebody steers, or a maneuver shows itself."""
        self._waiting = True
        self._remark = _BEGIN if self.session.driver == BY_HAND else ""

    def _drives(self) -> bool:
        """Whether time passes."""
        if self._waiting and not self._paused and (self._keys.used or self._shown_maneuver()):
            self._start()
        return not (self._paused or self._waiting or self.session.ended)

    def _shown_maneuver(self) -> bool:
        return self.session.driver != BY_HAND and self._view.watched

    def _start(self) -> None:
        if self._waiting:
            self._waiting, self._remark = False, ""

    def step(self) -> None:
        """One control step, by keys and sliders or by the maneuver that drives."""
        down = self._keys.take()
        if down and self.session.driver != BY_HAND:
            self._hand_over(BY_HAND)
        hand = self._slider_targets()
        if down:
            hand = moved(hand, down, self.period_s)
        self._shown = self.session.drive(hand)
        self.steps += 1
        if self._ghost is not None:
            self._view.show_ghost(self._ghost.drive())
        if down or self.session.driver != BY_HAND:
            self._set_sliders(hand if down else self._shown.targets)
        self._show()
        if self.session.ended:
            self._end()

    def _show(self) -> None:
        self._view.show(self._shown, self._remark)

    def _end(self) -> None:
        """Save what was driven, and say what the rivals reach on this patient."""
        saved: list[str] = []
        try:
            saved = self._saved()
        except InputError as error:
            self._say(str(error))
        else:
            self._say(_AGAIN)
        if not self._rivals:
            self._rivals = outcomes_of_rivals(self.session.setup, self.session.agents)
        self._score.content = panels.score_html([self._shown.outcome, *self._rivals], saved)

    def _saved(self) -> list[str]:
        return [str(path) for path in self._saves.save(self.session)]

    def _begin(self) -> None:
        """The same patient again."""
        self._saves.begin()
        self._score.content = ""
        self._paused = False
        self._keys.take()
        self._wait()
        self._set_sliders(np.zeros(len(CHANNELS)))
        self._shown = self.session.begin()
        self._show()
        if self._ghost is not None:
            self._view.show_ghost(self._ghost.begin())

    def _change(self) -> None:
        """Another patient, model, control or knowledge."""
        values = {name: handle.value for name, handle in self._choices.items()}
        seed = int(values.pop("seed"))
        patient = {"cohort": self._cohorts[values["cohort"]], "knowledge": self._levels[values["knowledge"]]}
        setup = Setup(replace(self.session.setup.world, **(values | patient)), seed)
        self._say("making the environment: the first of a model compiles for up to a minute")
        session = DriveSession(setup, self.session.agents)
        session.hand_over(self._driver.value)
        self.session, self._rivals = session, []
        self._view.renew(session.shown())
        self._call_ghost()
        self._begin()

    def _call_ghost(self) -> None:
        """Let another driver move the same patient beside, as far as this drive has come."""
        self._ghost, name = None, self._ghosts.value
        self._view.show_ghost(None)
        if name == _NOBODY:
            return
        ghost = DriveSession(self.session.setup, self.session.agents)
        ghost.hand_over(name)
        shown = ghost.shown()
        for _ in range(self.session.steps):
            shown = ghost.drive()
        self._ghost = ghost
        self._view.show_ghost(shown)

    def _hand_over(self, name: str) -> None:
        self.session.hand_over(name)
        if self._driver.value != name:
            self._driver.value = name
        self._set_sliders(self.session.steering.asked)

    def _fulfil(self, wish: Callable[[], None]) -> None:
        """Do what a browser asked for; what is refused is said in one line on the page."""
        try:
            wish()
        except InputError as error:
            self._say(str(error))

    def _say(self, remark: str) -> None:
        self._remark = remark
        self._view.say(self._shown, remark)

    def _pause(self) -> None:
        self._paused = not self._paused
        self._say("paused" if self._paused else "")

    def _single_step(self) -> None:
        if not self._paused:
            self._pause()
        self._start()
        if not self.session.ended:
            self.step()

    def _save(self) -> None:
        self._say("saved: " + ", ".join(self._saved()))

    def _slider_targets(self) -> Array:
        targets: Array = np.clip([slider.value for slider in self._sliders], LOWEST, HIGHEST)
        return targets

    def _set_sliders(self, targets: Array) -> None:
        for slider, value in zip(self._sliders, np.clip(targets, LOWEST, HIGHEST).tolist(), strict=True):
            rounded = round(value, 4)
            if slider.value != rounded:
                slider.value = rounded

    def _wish(self, wish: Callable[[], None]) -> Callable[[Any], None]:
        """A callback of viser's that leaves a wish, if a browser is behind it."""

        def leave(event: Any) -> None:
            if event.client is not None:
                with contextlib.suppress(queue.Full):
                    self._wishes.put_nowait(wish)

        return leave

    def _lay_out(self, gui: Any) -> None:
        self._sliders = [
            gui.add_slider(name, low, HIGHEST, _STEP, 0.0) for name, low in zip(_SLIDERS, LOWEST, strict=True)
        ]
        for slider in self._sliders:
            slider.on_update(self._wish(self._hand_over_to_slider))
        gui.add_html(keys_html())
        self._driver = gui.add_dropdown("Driver", self._drivers(), initial_value=self._first_driver())
        self._driver.on_update(self._wish(lambda: self._hand_over(self._driver.value)))
        self._ghosts = gui.add_dropdown("Ghost", (_NOBODY, *self._drivers()[1:]), initial_value=_NOBODY)
        self._ghosts.on_update(self._wish(self._call_ghost))
        self._buttons = gui.add_button_group("Drive", tuple(self._button_wishes()))
        self._buttons.on_click(self._wish(lambda: self._button_wishes()[self._buttons.value]()))
        self._score = gui.add_html("")
        self._add_choices(gui)

    def _button_wishes(self) -> dict[str, Callable[[], None]]:
        return {"Pause": self._pause, "Step": self._single_step, "Again": self._begin, "Save": self._save}

    def _first_driver(self) -> str:
        driver = self.session.driver
        return driver if driver in self._drivers() else BY_HAND

    def _drivers(self) -> tuple[str, ...]:
        return (BY_HAND, *self.session.agents, *maneuver_names())

    def _hand_over_to_slider(self) -> None:
        """A slider that is moved takes over from a maneuver, and keeps where it was moved to."""
        self._start()
        if self.session.driver != BY_HAND:
            self.session.hand_over(BY_HAND)
            self._driver.value = BY_HAND

    def _add_choices(self, gui: Any) -> None:
        setup, world = self.session.setup, self.session.setup.world
        cohort, knowledge = world.build_cohort(), world.build_knowledge()
        self._cohorts = {**COHORTS, cohort.name: cohort}
        level = next((name for name, level in LEVELS.items() if level == knowledge), "as given")
        self._levels = {**LEVELS, level: knowledge}
        with gui.add_folder("Patient and model", expand_by_default=False):
            self._choices = {
                "seed": gui.add_number("Patient seed", setup.seed, min=0, max=LARGEST_SEED, step=1),
                "cohort": gui.add_dropdown("Cohort", tuple(self._cohorts), initial_value=cohort.name),
                "model": gui.add_dropdown("Model", tuple(MODELS), initial_value=world.model),
                "control": gui.add_dropdown("Control", tuple(CONTROLS), initial_value=world.control),
                "knowledge": gui.add_dropdown("Knowledge", tuple(self._levels), initial_value=level),
                "episode_s": gui.add_number("Episode, s", world.episode_s, min=SHORTEST_S, max=LONGEST_S, step=0.5),
            }
            gui.add_button("New episode").on_click(self._wish(self._change))

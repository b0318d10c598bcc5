"""The page: a viser server that shows one session to all browsers, and drives it in real time."""

from __future__ import annotations

import contextlib
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.errors import InputError
from jawenv.device.channels import CHANNELS, HIGHEST, LOWEST
from jawenv.live import panels
from jawenv.live.choices import Choices
from jawenv.live.keys import Keys, keys_html, moved
from jawenv.live.outcome import DriveOutcome, learned_agents, outcomes_of_rivals
from jawenv.live.saving import Saves
from jawenv.live.session import BY_HAND, DriveSession
from jawenv.live.setup import Setup
from jawenv.live.view import View
from jawenv.playing.agents import Agent, Array
from jawenv.playing.maneuvers import maneuver_names

_SLIDERS = ("Opening", "Side, left +", "Fore-aft force", "Roll, right +")
_STEP = 0.005
_NOBODY = "nobody"
_BUTTONS = ("Pause", "Step", "Again", "Next", "Save")
_BEGIN = "The time begins with the first key or slider. The aim: every muscle blue, within 5 %, soon and in comfort."
_AGAIN = "Again: the same patient once more. Next: another one."


class Page:
    """A page of sliders, keys, posteriors and a jaw, with one session behind it.

    Callbacks of viser run in threads of their own; they only leave wishes, which ``run`` fulfils between two steps.

    Args:
        server: a ``viser.ViserServer``.
        setup: of the first session.
        folder: where drives are saved.
        driver: who drives at first: ``you``, an agent or a maneuver.
        agents: who may drive beside the maneuvers and jawenv's own policies, and is in the score; see
            `jawenv.live.session.DriveSession`.
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
        self._wishes: OrderedDict[Any, Callable[[], None]] = OrderedDict()  # what it is for -> what to do
        self._stopped = False
        self._paused, self._waiting, self._remark, self._rivals = False, True, "", list[DriveOutcome]()
        self.steps = 0
        self._ghost: DriveSession | None = None
        self.session = DriveSession(setup, learned_agents() | dict(agents or {}))
        self.session.hand_over(driver)
        self._shown = self.session.shown()
        self._view = View(server, self._shown)
        self._keys = Keys(server)
        self._lay_out(self._view.gui)
        self._wait()
        self._show()

    def run(self) -> None:
        """Drive in real time until ``stop``; what was driven is saved, whatever ends it."""
        try:
            self._run()
        finally:
            with contextlib.suppress(InputError):  # nothing was driven, or it cannot be written
                self._saves.save(self.session)

    def _run(self) -> None:
        due = time.perf_counter()
        while not self._stopped:
            while self._wishes:
                self._fulfil(self._wishes.popitem(last=False)[1])
            if self._drives():
                self.step()
            due = max(due + self.period_s, time.perf_counter() - self.period_s)
            time.sleep(max(0.0, due - time.perf_counter()))

    def stop(self) -> None:
        """End ``run``, from any thread or a signal's handler."""
        self._stopped = True

    @property
    def period_s(self) -> float:
        """Time from one step to the next, s."""
        return 1.0 / self.session.setup.world.steps_per_s

    def _wait(self) -> None:
        """Hold time until somebody steers, or a maneuver shows itself."""
        self._waiting = True
        by_hand = self.session.driver == BY_HAND
        self._remark, self._steps_card.content = (_BEGIN, panels.STEPS) if by_hand else ("", "")

    def _drives(self) -> bool:
        """Whether time passes."""
        shows_itself = self.session.driver != BY_HAND and self._view.watched
        if self._waiting and not self._paused and (self._keys.used or shows_itself):
            self._start()
        return not (self._paused or self._waiting or self.session.ended)

    def _start(self) -> None:
        if self._waiting:
            self._waiting, self._remark, self._steps_card.content = False, "", ""

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
        try:
            saved, remark = self._saved(), _AGAIN
        except InputError as error:
            saved, remark = list[str](), str(error)
        self._say(remark)
        if not self._rivals:
            self._rivals = outcomes_of_rivals(self.session.setup, self.session.agents)
        self._score.content = panels.score_html([self._shown.outcome, *self._rivals], self.session.forces(), saved)

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
        setup = self._choices.setup()
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
        """A callback of viser's that leaves a wish, if a browser is behind it; one of a kind waits at a time."""

        def leave(event: Any) -> None:
            if event.client is not None:
                self._wishes.setdefault(wish, wish)

        return leave

    def _lay_out(self, gui: Any) -> None:
        self._steps_card = gui.add_html("", order=self._view.below_status)
        self._view.on_colour(self._wish(self._show))
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
        self._buttons = gui.add_button_group("Drive", _BUTTONS)
        self._buttons.on_click(lambda event: self._buttons_clicked(event.target.value, event.client))
        self._score = gui.add_html("")
        self._choices = Choices(gui, self.session.setup, self._wish, self._change)

    def _buttons_clicked(self, button: str, client: Any) -> None:
        """Leave the wish of the button that was clicked, whichever is clicked next."""
        if client is not None:
            self._wishes.setdefault(button, self._button_wishes()[button])

    def _button_wishes(self) -> dict[str, Callable[[], None]]:
        wishes = (self._pause, self._single_step, self._begin, self._choices.next_patient, self._save)
        return dict(zip(_BUTTONS, wishes, strict=True))

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

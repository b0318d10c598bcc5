"""The controls of the question of a drive: which muscles are stiff?"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from jawenv.live import panels
from jawenv.live.question import AnsweredMuscle, answered
from jawenv.live.session import Shown

QUESTION_S = 30.0
"""Time of a drive after which the question is asked, or at its end if that is sooner."""


class Question:
    """Asks once in a drive, and sets the answer beside truth and estimates.

    Args:
        gui: of a ``viser.ViserServer``.
        leave: makes a callback of viser's that hands a wish to the page.
        order: where it stands among the controls.
        answered: called when the player has answered.

    Attributes:
        answer: (M,) of the player; empty before, and where the scene has no truth.
    """

    def __init__(
        self, gui: Any, leave: Callable[[Callable[[], None]], Any], order: float, answered: Callable[[], None]
    ) -> None:
        self._gui, self._leave, self._order, self._answered = gui, leave, order, answered
        self._card = gui.add_html("", order=order)
        self._folder: Any = None
        self._shown: Shown | None = None
        self.begin()

    def begin(self) -> None:
        """Another drive."""
        self._close()
        self._card.content, self._asked = "", False
        self.answer: list[AnsweredMuscle] = []

    @property
    def open(self) -> bool:
        """Whether it stands on the page."""
        return self._folder is not None

    @property
    def unanswered(self) -> bool:
        """Whether it will be asked, or is; not of a scene without truth."""
        return not self.answer and (self._shown is None or self._shown.scene.truth is not None)

    def follow(self, shown: Shown) -> None:
        """Ask as soon as it is time."""
        self._shown = shown
        if not self._asked and (shown.scene.time_s >= QUESTION_S or shown.ended):
            self._asked = True
            self._ask(shown)

    def _ask(self, shown: Shown) -> None:
        if shown.scene.truth is None:
            return
        self._folder = self._gui.add_folder("Which muscles are stiff?", order=self._order)
        with self._folder:
            names = [muscle.replace("_", " ") for muscle in shown.scene.muscles]
            self._boxes = [self._gui.add_checkbox(name, False) for name in names]
            self._gui.add_button("Answer").on_click(self._leave(self._take))

    def _take(self) -> None:
        """Show how right the player is, by the estimates of this moment."""
        if self._folder is not None and self._shown is not None:
            self.answer = answered(self._shown.scene, [bool(box.value) for box in self._boxes])
            self._card.content = panels.answer_html(self.answer)
            self._close()
            self._answered()

    def _close(self) -> None:
        if self._folder is not None:
            self._folder.remove()
        self._folder = None

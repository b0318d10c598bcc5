"""Figures are the same in every run."""

import io

from matplotlib.figure import Figure

from eval.report import drawing


def drawn() -> str:
    with drawing.style():
        figure, text = Figure(), io.StringIO()
        figure.subplots().plot([0, 1], [1, 0])
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


def test_a_figure_drawn_again_is_the_same_to_the_letter() -> None:
    assert drawn() == drawn()

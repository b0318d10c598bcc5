"""Terms that are explained where they stand on a page."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

TERMS = {
    "NEES": (
        "Normalised estimation error squared: the squared error in units of what the filter states, summed over the "
        "parameters. On average it is their number if the filter is honest; more means too sure."
    ),
    "nats": "The unit of information: one more nat, and all sds together have shrunk by a factor of e = 2.72.",
    "sd": "Standard deviation that the filter states: it is probably within so much of the truth.",
    "sds": "Standard deviations that the filter states: it is probably within so much of the truth.",
    "RMSE": "Root mean square error: the typical distance of the estimates from the truth.",
    "bound": "Posterior Cramér–Rao bound: the least error that any unbiased estimator could reach with that maneuver.",
    "misfit": "How badly the readings fit the model that the filter believes in; where it is large, the alarm rings.",
    "alarm": "It rings where the misfit is large: then nothing that the filter knows of explains the readings.",
}

_TERM = re.compile(rf"\b(?:{'|'.join(TERMS)})\b(?![\w_/-])")


def term(word: str) -> Markup:
    """A term as an element that explains it under the pointer.

    Raises:
        KeyError: a word that is not among ``TERMS``.
    """
    return Markup('<abbr title="{}">{}</abbr>').format(TERMS[word], word)


def explained(text: str) -> Markup:
    """A text as HTML whose terms are explained where they first stand."""
    seen: set[str] = set()

    def once(match: re.Match[str]) -> str:
        word = match.group()
        if word in seen:
            return word
        seen.add(word)
        return term(word)

    return Markup(_TERM.sub(once, str(escape(text))))  # noqa: S704  (escaped above)

"""Write the model's tables of numbers from the data files and the code: ``python docs/figures/tables.py``.

Each table of docs/model.md and docs/tables/model.md stands between ``<!-- table: NAME -->`` and
``<!-- end of table -->``. A test fails when one is out of date.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable
from importlib import import_module
from operator import attrgetter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
for folder in (ROOT, Path(__file__).parent):
    if str(folder) not in sys.path:
        sys.path.append(str(folder))

from field_tables import fields_table  # noqa: E402

from jawenv.anatomy import COHORTS, attachment_rows, load_quantities, muscle_set  # noqa: E402
from jawenv.anatomy.knowledge import LEVELS, Knowledge  # noqa: E402
from jawenv.device.comfort_settings import Comfort  # noqa: E402
from jawenv.device.device import Device  # noqa: E402
from jawenv.ladder import MODELS  # noqa: E402
from jawenv.reality import Reality  # noqa: E402
from tests.passive_opening import passive_opening, pull_to_open  # noqa: E402

PAGES = (ROOT / "docs" / "model.md", ROOT / "docs" / "tables" / "model.md")
_BLOCK = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end of table -->)", re.S)


def number(value: float) -> str:
    """A number with a real minus sign."""
    return f"{value:g}".replace("-", "−")


def values(value: object) -> str:
    """A number, a point or a matrix."""
    if isinstance(value, list):
        inner = "; " if isinstance(value[0], list) else ", "
        text = inner.join(values(one).strip("()") for one in value)
        return f"({text})"
    return number(float(value))  # type: ignore[arg-type]


def plus_minus(text: str) -> str:
    """The data files' ASCII as typography."""
    return text.replace("+-", "±").replace("|", "/")


def rows_of(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A Markdown table."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def quantities(name: str) -> str:
    """All quantities of a data file."""
    head = ("quantity", "value", "unit", "range", "grade", "source")
    return rows_of(
        head,
        (
            (
                f"`{key}`",
                values(one.value),
                one.unit,
                "–" if one.range is None else f"{number(one.range[0])} … {number(one.range[1])}",
                one.grade,
                plus_minus(one.source),
            )
            for key, one in load_quantities(name).items()
        ),
    )


def attachments() -> str:
    """Every row of the attachment table, the rejected one too."""

    def spread(point: tuple[float, ...], sd: tuple[float, ...]) -> str:
        return ", ".join(f"{number(a)} ± {number(b)}" for a, b in zip(point, sd, strict=True))

    head = ("portion", "origin x, y, z (mm)", "insertion x, y, z (mm)", "length (mm)", "grade", "source and remark")
    rows = []
    for row in attachment_rows():
        length = float(np.linalg.norm(np.subtract(row.origin, row.insertion)))
        name = row.portion.replace("_", " ") + (" — **rejected**" if row.status == "rejected" else "")
        text = row.source + (f"; {row.remark}" if row.remark else "")
        rows.append(
            (
                name,
                spread(row.origin, row.origin_sd),
                spread(row.insertion, row.insertion_sd),
                f"{length:.1f}",
                row.grade,
                plus_minus(text),
            )
        )
    return rows_of(head, rows)


def whole_muscles() -> str:
    """The lines of the whole muscles, right side."""
    muscles = muscle_set()
    rows = []
    for i, name in enumerate(muscles.names):
        if name.endswith("_right"):
            ends = [", ".join(f"{1e3 * c:.1f}".replace("-", "−") for c in p[i])
                    for p in (muscles.origin_m, muscles.insertion_m)]  # fmt: skip
            rows.append((name.removesuffix("_right").replace("_", " "), *ends, f"{1e3 * muscles.l_o_m[i]:.1f}", "D"))
    return rows_of(("muscle", "origin x, y, z (mm)", "insertion x, y, z (mm)", "$l_o$ (mm)", "grade"), rows)


def cohorts() -> str:
    """Medians and spreads of the cohorts."""
    rows = []
    for cohort in COHORTS.values():
        left, right = cohort.groups[0]
        one = [f"{number(s.F_o_N)}; {number(s.F_o_sd)}; {number(s.b)}; {number(s.b_sd)}" for s in (left, right)]
        text = one[0] if one[0] == one[1] else f"{one[0]} on one side, {one[1]} on the other"
        text = text if len(cohort.groups) < 3 else "a mixture"
        rows.append((f"`{cohort.name}`", text, plus_minus(cohort.basis)))
    head = ("cohort", "median $F_o$ (N); sd of its log; median $b$; sd of its log", "basis (grade)")
    return rows_of(head, rows)


_CLINICAL = {
    "healthy": "rests 2–4 mm open (R); opens 45 mm and more: 48.8 mm (140 adults, Zawawi 2003, M)",
    "trismus": "opens at most 35 mm (Dijkstra 2006, M) by own openers of 19–48 N (Otago 2022, M)",
    "severe": "opens at most 20–25 mm (van der Geer 2019, M)",
    "one_sided": "no published group; the midline model, which resists no roll, opens further than two condyles would",
    "patchy": "no published group; by 18.5 N, the pull of patients' own openers, nine of ten open less than 35 mm",
    "blockage": "opens at most 35 mm with a soft start; no published group",
    "wide": "none: the spread is that of what is not known",
    "anyone": "a sixth of each of the six first",
}


def clinical() -> str:
    """Openings of each cohort under slow pulls, beside what is published."""
    rows = []
    for name, published in _CLINICAL.items():
        people = COHORTS[name].sample(30, seed=5)
        figures = np.hstack([passive_opening(people, (0.0, 18.5, 32.0)), pull_to_open(people, (35.0,))])
        low, middle, high = np.nanquantile(figures, (0.1, 0.5, 0.9), axis=0)
        cells = (
            f"{number(round(m, 1))} ({number(round(a, 1))} … {number(round(b, 1))})"
            for a, m, b in zip(low, middle, high, strict=True)
        )
        rows.append((f"`{name}`", *cells, published))
    head = ("cohort", "rests open (mm)", "under 18.5 N (mm)", "under 32 N (mm)", "35 mm needs (N)", "published")
    return rows_of(head, rows)


# module, name, factor to the unit shown, unit, meaning, grade
_CONSTANTS = (
    ("jawenv.mechanics.building", "CONDYLE_STIFFNESS", 1, "N/m", "the capsule's stops, soft enough for the step", "G"),
    ("jawenv.mechanics.building", "STOP_WIDTH", 1e3, "mm", "quadratic onset $w$ of teeth and capsule", "G"),
    ("jawenv.mechanics.equilibrium", "HOLD_STIFFNESS", 1, "N/m", "spring that holds the mouth open", "numerical"),
    ("jawenv.mechanics.dynamics", "REST_TOLERANCE", 1, "m/s2, rad/s2", "acceleration left over at rest", "numerical"),
    ("jawenv.device.comfort_settings", "Comfort.painless_force_N", 1, "N", "pull that ends the painless range", "G"),
    ("jawenv.device.comfort_settings", "Comfort.painless_range_mm", 1, "mm", "its largest extent above rest", "G"),
    ("jawenv.device.comfort_settings", "Comfort.largest_opening_mm", 1, "mm", "its largest opening in all", "G"),
    (
        "jawenv.envs.world.reset_kernel",
        "CREST_SHARE",
        1,
        "1",
        "soft limit of the condyle, share of the way to the crest",
        "G",
    ),
    (
        "jawenv.device.comfort_settings",
        "Comfort.condyle_free_mm",
        1,
        "mm",
        "the painless range ends so far before that limit",
        "G",
    ),
    ("jawenv.envs.world.plants", "TICK", 1e3, "ms", "sensors, filter, motor commands; the filter's step", "numerical"),
    (
        "jawenv.envs.world.plants",
        "SUBSTEPS",
        1,
        "1",
        "Runge–Kutta steps of the true motion per tick, at least",
        "numerical",
    ),
    ("jawenv.mechanics.sagittal", "STEP", 1e3, "ms", "step in the plane", "numerical"),
    ("jawenv.mechanics.sagittal", "SEGMENT", 1e3, "mm", "segments of the fossa in the plane", "numerical"),
    ("jawenv.mechanics.sagittal", "ITERATIONS", 1, "1", "of the contact solver", "numerical"),
    ("jawenv.mechanics.sagittal", "OVERLAP_TIME", 1e3, "ms", "decay of overlap in the plane", "numerical"),
    ("jawenv.mechanics.sagittal_shapes", "SLOP", 1, "mm", "overlap that contact rests on", "numerical"),
    ("jawenv.mechanics.sagittal_shapes", "END", 1, "1", "crests from the roof to the front wall", "numerical"),
)


def constants() -> str:
    """Numbers that stand in the code."""
    return rows_of(
        ("constant", "value", "unit", "meaning", "grade"),
        (
            (f"`{module.removeprefix('jawenv.')}.{name}`",
             number(factor * attrgetter(name)(import_module(module))), unit, meaning, grade)
            for module, name, factor, unit, meaning, grade in _CONSTANTS
        ),
    )  # fmt: skip


def ladder() -> str:
    """The models, simplest first."""
    symbols = ("$x$", "$y$", "$\\theta$", "$\\psi$", "$\\alpha$")
    rows = []
    for model in MODELS.values():
        muscles = model.muscles
        free = ", ".join(s for s, moves in zip(symbols, model.free, strict=True) if moves)
        count = f"{len(muscles.muscle)} → {len(muscles)} → {len(muscles.parameter_names)}"
        rows.append((f"`{model.name}`", free, count, model.plant, model.shows, model.hides))
    head = ("model", "the filter's coordinates", "lines → muscles → parameters", "plant", "shows", "cannot show")
    return rows_of(head, rows)


TABLES: dict[str, Callable[[], str]] = {
    "ladder": ladder,
    "mandible": lambda: quantities("mandible.toml"),
    "fossa": lambda: quantities("fossa.toml"),
    "attachments": attachments,
    "whole_muscles": whole_muscles,
    "strengths": lambda: quantities("strengths.toml"),
    "cohorts": cohorts,
    "clinical": clinical,
    "constants": constants,
    "device": lambda: fields_table(Device, {"default": Device()}),
    "comfort": lambda: fields_table(Comfort, {"default": Comfort()}),
    "reality": lambda: fields_table(Reality, {"default": Reality()}),
    "knowledge": lambda: fields_table(Knowledge, dict(LEVELS)),
}


def renewed(text: str) -> str:
    """The page with every table as the data and the code have it."""
    return _BLOCK.sub(lambda block: block[1] + TABLES[block[2]]() + block[3], text)


if __name__ == "__main__":
    for page in PAGES:
        page.write_text(renewed(page.read_text(encoding="utf-8")), encoding="utf-8")

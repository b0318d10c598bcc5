"""What docs/model.md says is so: its tables are the data's, its tests and figures exist, its own numbers come out."""

import ast
import re
import sys
from pathlib import Path

import newton_euler as twin
import numpy as np
import pytest
import two_condyles
from scipy.spatial.transform import Rotation

import jawenv
from jawenv.anatomy import default_mandible, known_muscle_sets
from jawenv.filter.readings.encoders import measure
from jawenv.ladder import MODELS
from jawenv.mechanics import build_jaw
from jawenv.mechanics.bilateral import condyle_pressures, put_on_fossa, settle_bilateral, split_body
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.linearisation import linear_dtype

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "model.md"
TEXT = PAGE.read_text(encoding="utf-8")
FIGURES = ROOT / "docs" / "figures"


@pytest.fixture(autouse=True)
def paths(monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in (ROOT / "tests" / "validation", FIGURES):
        monkeypatch.syspath_prepend(str(folder))


def assert_stated_in_order(text: str, *numbers: float) -> None:
    """The page states these numbers, rounded, one after the other, in the row or sentence that begins with ``text``."""
    assert TEXT.count(text) == 1, text
    rest = TEXT.split(text)[1]
    stated = re.findall(r"(?<![\w.])−?\d+(?:\.\d+)?(?:e-\d+)?", rest)[: len(numbers)]
    for found, expected in zip(stated, numbers, strict=True):
        decimals = len(found.partition(".")[2])
        assert abs(float(found.replace("−", "-")) - expected) <= 0.501 * 10**-decimals, (text, found, expected)


# The page as a whole


def defined(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_every_test_that_is_named_exists() -> None:
    file, named = "", 0
    for path, name in re.findall(r"`(tests/[\w/]+\.py)?::(\w+)`", TEXT):
        file = path or file
        assert name.startswith("test_") and name in defined(ROOT / file), f"{file}::{name}"
        named += 1
    assert named > 30
    for path in re.findall(r"(?:tests|docs|jawenv)/[\w/]+\.py", TEXT):
        assert (ROOT / path).exists(), path


def test_every_correction_has_a_test_and_a_number() -> None:
    rows = [line for line in TEXT.split("| no. |")[1].split("\n\n")[0].splitlines() if re.match(r"\| \d+ \|", line)]
    assert [int(row.split("|")[1]) for row in rows] == list(range(1, len(rows) + 1))
    tested = r"`tests/[\w/]+\.py::test_\w+`|the same|as 3"
    assert all(len(row.split(" | ")) == 6 and re.search(tested, row.split(" | ")[5]) for row in rows)


def test_tables_are_those_of_the_data_and_the_code() -> None:
    import tables

    assert set(re.findall(r"<!-- table: (\w+) -->", TEXT)) == set(tables.TABLES)
    assert tables.renewed(TEXT) == TEXT, "run: python docs/figures/tables.py"


def test_all_data_are_in_the_tables() -> None:
    """Not through the generator: every name and every number of the data files is on the page."""
    for name in ("mandible.toml", "fossa.toml", "strengths.toml"):
        for key, one in jawenv.anatomy.load_quantities(name).items():
            (row,) = [line for line in TEXT.splitlines() if line.startswith(f"| `{key}` |")]
            cells = [cell.strip() for cell in row.strip("|").split(" | ")]
            stated = [float(n.replace("−", "-")) for n in re.findall(r"[−\d.]+(?:e[−+]?\d+)?", cells[1])]
            np.testing.assert_allclose(stated, np.ravel(one.value), rtol=1e-5)
            assert (cells[2], cells[4]) == (one.unit, one.grade) and cells[5]
    for one in jawenv.anatomy.attachment_rows():
        name = one.portion.replace("_", " ") + (" — **rejected**" if one.status == "rejected" else "")
        (row,) = [line for line in TEXT.splitlines() if line.startswith(f"| {name} |") and " ± " in line]
        cells = [cell.strip() for cell in row.strip("|").split(" | ")]
        for cell, point, sd in ((cells[1], one.origin, one.origin_sd), (cells[2], one.insertion, one.insertion_sd)):
            stated = [float(n) for n in cell.replace("−", "-").replace("±", ",").split(",")]
            assert (tuple(stated[0::2]), tuple(stated[1::2])) == (point, sd)
        assert cells[4] == one.grade and one.source.split(":")[0] in cells[5]
    assert all(f"| `{name}` |" in TEXT for name in MODELS)


def test_the_page_shows_every_figure_in_order() -> None:
    import make

    shown = re.findall(r"!\[[^\]]+\]\(figures/(\w+)\.svg\)", TEXT)
    assert sorted(shown) == sorted(make.FIGURES)
    numbers = [int(n) for n in re.findall(r"^\*Figure (\d+)\.", TEXT, re.M)]
    assert numbers == list(range(1, len(shown) + 1))
    for name in shown:
        assert (FIGURES / f"{name}.svg").stat().st_size < 300_000


def test_every_figure_can_be_made(tmp_path: Path) -> None:
    import make

    for name in make.FIGURES:
        drawn = make.make(name, tmp_path).read_bytes()
        assert b"<svg" in drawn and b"<dc:date>" not in drawn, name


def test_the_same_sources_give_the_same_bytes(tmp_path: Path) -> None:
    import make

    first, second = (make.make("condyle_path", tmp_path / folder).read_bytes() for folder in "ab")
    assert first == second


# Its numbers


def test_errors_of_the_printed_equations() -> None:
    from printed_equations import errors_of_printed_equations

    block = TEXT.split("<!-- printed equations -->")[1].strip().split("\n\n")[0].splitlines()[2:]
    stated = [[cell.strip() for cell in line.strip("|").split("|")] for line in block]
    rows = errors_of_printed_equations()
    assert [(cells[0], cells[1], cells[4]) for cells in stated] == [(r.equation, r.fault, r.unit) for r in rows]
    for cells, row in zip(stated, rows, strict=True):
        assert float(cells[2]) == pytest.approx(row.median, rel=0.01)
        assert float(cells[3]) == pytest.approx(row.largest, rel=0.01)


def test_stretch_of_the_muscles_when_open() -> None:
    import draw_anatomy

    stretches = 100 * np.array([draw_anatomy.stretches_when_open(1e-3 * opening) for opening in (10, 20, 35)])
    sentence = re.search(r"a masseter is stretched by(.*?)\(median jaw", TEXT, re.S)
    assert sentence
    stated = [float(n) for n in re.findall(r"\d+\.\d", sentence[1])]
    np.testing.assert_allclose(stated, stretches.T.ravel(), atol=0.051)


def test_rest_folds_and_painless_range() -> None:
    import draw_rests

    for name, F_o in (("healthy", 0.25), ("trismus", 1.2), ("severe", 4.0)):
        branch = draw_rests.opened_slowly(F_o, 7.0)
        fold, other, end = (
            draw_rests.first_fold(branch[:, 2]),
            draw_rests.first_fold(branch[:, 1]),
            draw_rests.painless_end(branch),
        )
        rest, x = abs(1e3 * branch[0, 1]), 1e3 * branch[0, 0]
        numbers = (branch[fold, 2], 1e3 * branch[fold, 1], 1e3 * branch[other, 1], 1e3 * branch[end, 1])
        assert_stated_in_order(f"| `{name}`: {F_o:g} N, 7 |", rest, x, *numbers)
        assert (branch[0, 1] < 0) == (name != "healthy")
        if name == "trismus":
            assert_stated_in_order("pulled straight down slides less:", 1e3 * branch[end, 0], 1e3 * branch[end, 1])


def rest_of(jaw, log_parameters):
    """Pose (5) of the midline model at rest, or None."""
    pose, scratch = np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), np.zeros(1, dtype=linear_dtype(6))[0]
    muscles = np.exp(log_parameters).reshape(6, 2)
    _, found = settle(jaw, muscles, pose, 0.0, False, scratch, np.empty((5, 5)), np.empty(5))
    return pose if found else None


def opening_of(jaw, pose):
    return jaw["mouthpiece"][2] - twin.measurement(jaw, np.concatenate([pose, np.zeros(5)]))[2]


def test_without_teeth_the_jaw_closes_too_far(jaw) -> None:
    jaw["tooth_stiffness"] = 1e-6
    poses = [rest_of(jaw, np.log(np.tile([F_o, 7.0], 6))) for F_o in (1.2, 4.0)]
    assert_stated_in_order("rests with the incisors", *(-1e3 * opening_of(jaw, pose) for pose in poses))


def rests_apart(jaw, cohort, number):
    """Angle (degrees), distance of the mouthpieces (mm) and lift-off of both models' rests, of treatable patients."""
    rng, rows = np.random.default_rng(0), []
    while len(rows) < number:
        log_parameters = jawenv.cohort(cohort).draw_log_parameters(rng)
        pose = rest_of(jaw, log_parameters)
        if pose is None:
            continue
        place = twin.measurement(jaw, np.concatenate([pose, np.zeros(5)]))[:3]
        if opening_of(jaw, pose) > 35e-3 or abs(place[1]) > 5e-3:
            continue
        state, muscles = np.empty(12), np.exp(log_parameters).reshape(6, 2)
        put_on_fossa(jaw, pose, state)
        assert settle_bilateral(jaw, muscles, (0.0,) * 6, state, np.empty((6, 6)), np.empty(6))
        turn = Rotation.from_euler("YZX", pose[2:]).inv() * Rotation.from_euler("YZX", state[3:6])
        lifted = min(condyle_pressures(jaw, *split_body(state))) == 0.0
        apart = 1e3 * np.linalg.norm(place - two_condyles.mouthpiece(jaw, state[:6]))
        rows.append((np.degrees(turn.magnitude()), apart, lifted))
    return np.array(rows)


def test_how_far_apart_the_models_rest(jaw) -> None:
    found = rests_apart(jaw, "one_sided", 200)
    numbers = np.median(found[:, 0]), 90.0, np.percentile(found[:, 0], 90), np.median(found[:, 1])
    assert_stated_in_order("treatable patients of `one_sided` | – |", *numbers)
    assert_stated_in_order("one condyle lifted in", 100 * found[:, 2].mean())
    others = [rests_apart(jaw, name, 200) for name in ("trismus", "severe", "healthy")]
    medians = [np.median(rows[:, 0]) for rows in others]
    assert_stated_in_order(
        "the same, `trismus`; `severe`; `healthy` | – |", *medians, *(100 * rows[:, 2].mean() for rows in others)
    )


def test_elimination_of_the_normal_force_divides_by_a_large_number_in_therapy() -> None:
    """Equations 4.30-4.35 with Q, the normal and the axes corrected: v = Q^-1 C n, of which v_x is divided by."""
    from printed_equations import cross_matrix, therapy_states

    shares = []
    for s in therapy_states():
        m, rho = s.twin.mandible.mass_kg, cross_matrix(s.twin.mandible.centre_of_mass_m)
        slope = s.twin.height(s.q[0])[1]
        Q = np.eye(3) + m * rho @ np.linalg.solve(s.M[3:, 3:], rho)
        v = s.R @ np.linalg.solve(Q, s.R.T @ [-slope, 0.0, 1.0])
        shares.append(v[0] / np.linalg.norm(v))
    assert_stated_in_order("harmless in therapy: $v_x \\ge$", min(shares))


def test_how_far_the_linearised_law_is_off() -> None:
    for b, strain in ((8, 0.30), (7, 0.182)):
        text = {8: "at $b$ = 8 and 30 % of stretch", 7: "at $b$ = 7 and the masseter's 18 % at 35 mm"}[b]
        assert_stated_in_order(text, 1 + b * strain, np.exp(b * strain))


def test_one_point_does_not_determine_five_coordinates(jaw, rng) -> None:
    for _ in range(20):
        state = np.concatenate([[rng.uniform(1e-3, 1e-2)], rng.uniform(-0.2, 0.4, 4), rng.uniform(-0.1, 0.1, 5)])
        rows, expected = np.empty((12, 10)), np.empty(12)
        measure(jaw, state, rows, expected)
        assert np.linalg.matrix_rank(rows[:3, :5]) == 3
        assert np.linalg.matrix_rank(rows[:6, :5]) == 5
        assert np.linalg.matrix_rank(rows[[0, 1, 2, 6, 7, 8]]) == 6 < 10


def test_the_hinge_is_one_moment_balance() -> None:
    """(I_*)_22 theta'' = moment of device and weight less that of the muscle and of damping; Young, eqs. A.25-A.26.

    As printed, the muscle's line at theta = 0 would be |r_o - r_m| long.
    """
    muscles, mandible = known_muscle_sets()["closers"], default_mandible()
    jaw = build_jaw(muscles, free=MODELS["hinge"].free)
    origin, insertion, l_o = muscles.origin_m[0], muscles.insertion_m[0], muscles.l_o_m[0]
    F_o, b, theta, rate, down = 7.0, 7.0, 0.3, 0.2, 9.0
    turn = Rotation.from_euler("y", theta)
    arm, centre, mouth = (
        turn.apply(np.array(p)) for p in (insertion, mandible.centre_of_mass_m, mandible.mouthpiece_m)
    )
    line = origin - arm
    tension = F_o * np.exp(b * (np.linalg.norm(line) / l_o - 1))
    muscle = np.cross(arm, tension * line / np.linalg.norm(line))[1]
    weight = np.cross(centre, [0, 0, -mandible.mass_kg * mandible.gravity])[1]
    device = np.cross(mouth, [0, 0, -down])[1]
    assert muscle < 0 < device, "they oppose each other"
    m, rho = mandible.mass_kg, mandible.centre_of_mass_m
    inertia = mandible.inertia_kg_m2[1, 1] + m * rho @ rho
    expected = (device + weight + muscle - mandible.damping_rotation * rate) / inertia
    wrench = turn.inv().apply([0, 0, -down])
    found = jawenv.acceleration(jaw, [0, 0, theta, 0, 0], [0, 0, 0, rate, 0], np.log([F_o, b]), wrench)
    np.testing.assert_allclose(found, [0, 0, 0, expected, 0], rtol=1e-12)
    printed = abs(np.linalg.norm(origin) - np.linalg.norm(insertion))
    assert_stated_in_order("of all closers as one line:", 1e3 * printed, 1e3 * l_o)


def test_the_page_names_no_place_outside_the_repository() -> None:
    assert "/tmp" not in TEXT and str(Path.home()) not in TEXT.replace("/root", "") and sys.prefix not in TEXT

"""The numbers that docs/bench.md derives or takes from the code."""

import re
from math import log, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2, norm

import jawenv
from jawenv.anatomy import default_fossa, default_mandible
from jawenv.anatomy.knowledge import IMAGED
from jawenv.mechanics import build_jaw
from jawenv.metrics.calibration import nees_band

DOCS = Path(__file__).parents[2] / "docs"
TEXT = " ".join((DOCS / "bench.md").read_text(encoding="utf-8").split())
PAGES = [DOCS / "calibration.md", *sorted((DOCS / "tables").glob("calibration*.md"))]
CALIBRATION = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
LOW, HIGH = 0.8, 1.3
MUSCLES = ("masseter", "temporalis", "medial pterygoid")


def stated(*phrases: str) -> None:
    for phrase in phrases:
        assert phrase in TEXT, phrase


def inside(ratio: float, mountings: int) -> float:
    """Chance that the mean NEES/12 lies in the band where the errors' variance is ``ratio`` of the claimed one."""
    freedom = 12 * mountings
    return float(chi2.cdf(freedom * HIGH / ratio, freedom) - chi2.cdf(freedom * LOW / ratio, freedom))


def test_how_many_mountings() -> None:
    def fits(mountings: int) -> bool:
        low, high = np.array(nees_band(mountings, 12)) / 12
        return bool(low >= LOW and high <= HIGH)

    honest = next(n for n in range(1, 100) if fits(n))
    simulated = next(n for n in range(1, 100) if inside(1.17, n) >= 0.95)
    stated(f"takes **n = {honest}**", f"95 % from **n = {simulated}** on")
    assert 1.0 - inside(1.17, honest) == pytest.approx(1 / 7, abs=0.01)
    for n in (15, 20, 40):
        low, high = np.array(nees_band(n, 12)) / 12
        chances = [f"{100 * inside(ratio, n):.1f} %" for ratio in (1.17, 1.5, 2.0)]
        stated(f"| {n} | {low:.3f}–{high:.3f} | {' | '.join(chances)} |")
    sd = sqrt(2 / 12)
    sizes = [round((1.96 * s / 0.2) ** 2) for s in (sd, 0.6)]
    stated(f"({sd:.2f} if honest)", f"n = (1.96 s/h)²: {sizes[0]} for h = 0.2, and {sizes[1]} if s is 0.6")
    stated(f"40 with m = 5 and r = 0.2 count as {40 / (1 + 4 * 0.2):.0f}")


def test_what_is_allowed_of_what_is_taken_for_exactly_known() -> None:
    """The table of realistic errors, whose excess is taken to grow with the square."""
    told = re.findall(r"\| ([^|]+) \| ([\d.]+) ?(?:%|mN|mm|°) \| ([\d,]+) \| ([\d.]+) ?(?:%|mN|mm|°) \|", TEXT)
    assert len(told) == 5
    for name, tried, nees, allowed in told:
        assert f"| {nees} |" in CALIBRATION, name
        exact = float(tried) * sqrt(0.1 / (float(nees.replace(",", "")) - 1.05))
        assert float(allowed) == pytest.approx(exact, rel=0.06), name


def fit_of_a_coil_spring(b: float, strain: float) -> tuple[float, float, float]:
    """Fitted b, and rms and largest residual of log F, of a linear spring whose tangent at l_o is that of ``b``."""
    e = np.linspace(0.0, strain, 2001)
    tension = np.log1p(b * e)
    fitted = np.polynomial.Polynomial.fit(e, tension, 1).convert()
    residual = tension - fitted(e)
    return float(fitted.coef[1]), 100 * float(np.sqrt(np.mean(residual**2))), 100 * float(np.abs(residual).max())


def test_the_springs() -> None:
    ten, eighteen = fit_of_a_coil_spring(7.0, 0.10), fit_of_a_coil_spring(7.0, 0.18)
    stated(
        f"by {ten[1]:.1f} % rms and {ten[2]:.1f} % at most", f"by {eighteen[1]:.1f} and {eighteen[2]:.1f} % over 18 %"
    )
    stated(f"not 7 but {ten[0]:.1f} and {eighteen[0]:.1f}")
    lengths = 1e3 * build_jaw()["l_o"][:3]
    stated(*(f"{length:.1f} mm for the {name}" for length, name in zip(lengths, MUSCLES, strict=True)))
    f_o, b = np.exp(jawenv.cohort("trismus").prior.mean[:2])
    stated(f"F_o = {f_o:.1f} N and b = {b:.0f}")
    slope = 0.01 * sqrt(12 / 100) / 0.1
    stated(f"this is {slope:.3f}, or {100 * slope / b:.1f} % of b", f"and {100 * 2 * 0.01 / sqrt(100):.1f} % of F_o")
    stated(f"wanted to {3.7 / 4:.1f} %: {f_o * 0.009:.3f} N at F_o")
    stated(f"0.1 mm of {lengths[2]:.1f} mm is {100 * b * 0.1 / lengths[2]:.1f} %")


def test_a_fit_of_log_tension_is_as_exact_as_stated(rng: np.random.Generator) -> None:
    e = np.linspace(0.0, 0.1, 100)
    fits = [np.polyfit(e, 7.0 * e + log(1.2) + 0.01 * rng.normal(size=100), 1) for _ in range(2000)]
    np.testing.assert_allclose(np.std(fits, axis=0), [0.01 * sqrt(12 / 100) / 0.1, 0.002], rtol=0.06)


def test_sensors_and_mounting() -> None:
    device, mandible = jawenv.Device(), default_mandible()
    stated(f"{device.cell_force_N:g} N, {device.cell_moment_N_m:g} N m | `cell_force_N`")
    stated(f"{IMAGED.cell_offset_N:g} N, {IMAGED.cell_offset_N_m:g} N m | `knowledge")
    stated(f"{IMAGED.mouthpiece_mm:g} mm, {IMAGED.mouthpiece_deg:g} degrees | `knowledge")
    stated(
        f"{device.force_cap_N:g} N is the cap",
        f"arms of {device.vertical_arm_mm:g} and {device.horizontal_arm_mm:g} mm",
    )
    stated(f"(G) {device.force_cap_N * device.horizontal_arm_mm / 1e3:.1f} N m (D)")
    stated(f"{device.encoder_position_mm:g} mm (G), {device.encoder_angle_deg:g} degrees")
    stated(f"at {device.slew_N_s:g} N/s", f"1 ms is {1e-3 * device.slew_N_s:g} N")
    stated(f"at {device.max_rate_mm_s:g} mm/s it is {1e-3 * device.max_rate_mm_s:g} mm")
    stated(f"change a component by {0.05 * mandible.gravity * sin(radians(20)):.2f} N")
    stated(f"600 samples leaves {device.cell_force_N / sqrt(600):.3f} N")
    stated(
        f"| {mandible.mass_kg:.2f} kg |", f"{mandible.damping_rotation:g} N m s/rad, {mandible.damping_sliding:g} N s/m"
    )
    fossa = default_fossa()
    stated(f"{2e3 * fossa.drop_m:.1f} mm", f"{fossa.spatial_frequency:g} rad/m, crest at {1e3 * np.pi / 245:.1f} mm")


def test_figures_that_convince() -> None:
    assert 1.0 - 0.05 ** (1 / 59) < 0.05 < 1.0 - 0.05 ** (1 / 58)
    stated(f"rate is above {100 * 0.05 ** (1 / 16):.0f} %")
    stated(f"below about {norm.ppf(0.75) * 3.7:.1f} % ({norm.ppf(0.75):.3f} of 3.7 %")
    freedom = (40 - 8) * 12
    stated(f"below {chi2.ppf(0.95, freedom) / freedom:.2f}: the 95 % point of 32 × 12 degrees")


def test_figures_of_the_simulation() -> None:
    """As the page of calibration has them."""
    row = next(line for line in CALIBRATION.splitlines() if line.startswith("| refined | 1.05"))
    assert "1.05 (1.00 … 1.11)" in row and "67.8 / 95.3 / 99.8" in row and "7.1 / 3.7 %" in row
    assert any(line.startswith("| slow opening | 1.38 ") for line in CALIBRATION.splitlines())
    for number in (
        "28928",
        "| reflex gain of 0.5 | 4.6 | 3 |",
        "| creep of 0.2 | 413 | 100 |",
        "| play of 0.3 mm | 13 | 100 |",
    ):
        assert number in CALIBRATION

"""Numbers from 0 to 1 to a maneuver: two sines on each channel, and how long they take to fade in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.device.channels import CHANNELS
from jawenv.playing.maneuvers import Maneuver

Array = NDArray[np.float64]

LOWEST_HZ, HIGHEST_HZ = 0.03, 1.2
LARGEST_SHARE = 0.5  # of the second sine in a channel's amplitude
LARGEST_LOW = 0.45  # lowest opening
SHORTEST_FADE_S, LONGEST_FADE_S = 0.4, 4.0
PEAKS = {"opening": (0.5, 1.0), "side": (0.2, 1.0), "fore_aft": (0.0, 0.6), "roll": (0.0, 1.0)}


class Wave(NamedTuple):
    """Two sines of a channel.

    Attributes:
        hz: their frequencies.
        share: of the second in the amplitude.
        phase_deg: their phases.
        peak: sum of their amplitudes; of the opening, the highest value.
        low: of the opening, the lowest value.
    """

    hz: tuple[float, float]
    share: float
    phase_deg: tuple[float, float]
    peak: float
    low: float = 0.0


START = {
    "opening": Wave((0.1, 0.2), 0.1, (-90.0, 0.0), 0.9, 0.05),
    "side": Wave((0.3, 0.45), 0.15, (0.0, 0.0), 0.75),
    "fore_aft": Wave((0.17, 0.4), 0.3, (0.0, 0.0), 0.2),
    "roll": Wave((0.25, 0.5), 0.3, (90.0, 0.0), 0.7),
}
"""Where a search begins: swings as a hand-made maneuver has them, quicker, and some roll."""
START_FADE_S = 1.5
SIZES = {name: 7 if name == "opening" else 6 for name in CHANNELS}
N_NUMBERS = sum(SIZES.values()) + 1


def numbers_of(waves: dict[str, Wave], fade_s: float) -> Array:
    """The numbers (N_NUMBERS,) of which ``waves_of`` makes these waves; the other way round."""
    parts: list[float] = []
    for name in CHANNELS:
        wave, (least, most) = waves[name], PEAKS[name]
        parts += [_share_of_log(hz, LOWEST_HZ, HIGHEST_HZ) for hz in wave.hz]
        parts += [wave.share / LARGEST_SHARE, *(np.mod(phase, 360.0) / 360.0 for phase in wave.phase_deg)]
        parts.append((wave.peak - least) / (most - least))
        parts += [wave.low / LARGEST_LOW] if name == "opening" else []
    return np.array([*parts, _share_of_log(fade_s, SHORTEST_FADE_S, LONGEST_FADE_S)])


def waves_of(numbers: Array) -> tuple[dict[str, Wave], float]:
    """Waves of the channels, and the fade-in (s), from any real numbers (N_NUMBERS,), folded into 0 to 1."""
    folded = _folded(numbers)
    waves, first = {}, 0
    for name, size in SIZES.items():
        raw, value = numbers[first : first + size], folded[first : first + size]
        least, most = PEAKS[name]
        waves[name] = Wave(
            hz=(_on_log(value[0], LOWEST_HZ, HIGHEST_HZ), _on_log(value[1], LOWEST_HZ, HIGHEST_HZ)),
            share=float(LARGEST_SHARE * value[2]),
            phase_deg=(float(np.mod(360.0 * raw[3], 360.0)), float(np.mod(360.0 * raw[4], 360.0))),
            peak=float(least + (most - least) * value[5]),
            low=float(LARGEST_LOW * value[6]) if name == "opening" else 0.0,
        )
        first += size
    return waves, _on_log(folded[-1], SHORTEST_FADE_S, LONGEST_FADE_S)


class Sines:
    """Maneuvers of two sines on each channel.

    Attributes:
        start: (N_NUMBERS,) where a search begins.
    """

    def __init__(self) -> None:
        self.start = numbers_of(START, START_FADE_S)

    def maneuver(self, numbers: Array, about: dict[str, str]) -> Maneuver:
        """The maneuver of numbers (N_NUMBERS,), which are rounded, so that a file is what was judged.

        Args:
            numbers: any real ones.
            about: name, title, description and source.
        """
        waves, fade_s = waves_of(numbers)
        channels = {name: _channel(name, waves[name]) for name in CHANNELS}
        return Maneuver.model_validate({**about, "fade_in_s": round(fade_s, 2), "channels": channels})


def _channel(name: str, wave: Wave) -> dict[str, object]:
    # The sum of the amplitudes bounds the wave, so that a channel never leaves its range.
    scale, extra = wave.peak, {}
    if name == "opening":
        scale = 0.5 * (wave.peak - wave.low)
        extra = {"offset": round(0.5 * (wave.peak + wave.low), 4)}
    amplitudes = (scale * (1.0 - wave.share), scale * wave.share)
    harmonics = [
        {"frequency_hz": round(hz, 5), "amplitude": float(np.floor(1e4 * amplitude) / 1e4), "phase_deg": round(phase)}
        for hz, amplitude, phase in zip(wave.hz, amplitudes, wave.phase_deg, strict=True)
    ]
    return {"kind": "harmonics", **extra, "harmonics": harmonics}


def _folded(numbers: Array) -> Array:
    wrapped = np.mod(numbers, 2.0)
    return np.where(wrapped > 1.0, 2.0 - wrapped, wrapped)


def _on_log(share: float, low: float, high: float) -> float:
    return float(low * (high / low) ** share)


def _share_of_log(value: float, low: float, high: float) -> float:
    return float(np.log(value / low) / np.log(high / low))

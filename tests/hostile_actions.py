"""Actions as policies make them, and hostile ones: a filter has to stay honest under whatever an agent does."""

import numpy as np

from jawenv.playing.excitation import ACTION_SIZE, Excitation, ornstein_uhlenbeck, uniform


def _switching(stream, last, step, dt):
    """Each motor at 1 or -1, thrown over after times with a mean of 0.5 s."""
    drawn = stream.choice([-1.0, 1.0], ACTION_SIZE)
    thrown = stream.random(ACTION_SIZE) < 1.0 - np.exp(-dt / 0.5)
    return np.where(thrown | (step == 0), drawn, last)


class RandomHarmonics(Excitation):
    """Four sines in each motor, of random amplitudes that add up to at most 1, random phases, and 0.1 to 2 Hz."""

    SINES = 4

    def __init__(self, name="harmonics", control_hz=20.0):
        super().__init__(name, self._sum, control_hz)
        self._coefficients = {}

    def _sum(self, stream, last, step, dt):
        if step == 0:
            weights = stream.random((self.SINES, ACTION_SIZE))
            weights *= stream.random(ACTION_SIZE) / weights.sum(axis=0)
            frequencies = 0.1 * 20.0 ** stream.random((self.SINES, ACTION_SIZE))
            phases = 2.0 * np.pi * stream.random((self.SINES, ACTION_SIZE))
            self._coefficients[id(stream)] = np.stack([weights, frequencies, phases])
        weights, frequencies, phases = self._coefficients[id(stream)]
        return np.sum(weights * np.sin(2.0 * np.pi * frequencies * step * dt + phases), axis=0)


EXCITATIONS = {
    "random": Excitation("random", uniform),
    "ou_quick": Excitation("ou_quick", ornstein_uhlenbeck(0.3, 0.5)),
    "ou_slow": Excitation("ou_slow", ornstein_uhlenbeck(0.15, 2.0)),
    "ou_strong": Excitation("ou_strong", ornstein_uhlenbeck(0.6, 1.0)),
    "harmonics": RandomHarmonics(),
    "switching": Excitation("switching", _switching),
}
"""Each by its name, for 20 control steps a second."""

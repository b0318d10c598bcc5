"""Worth of two recordings of one patient: the belief of both, beside each alone and the plain sum of informations.

    python -m research.pairs --patients 24

Told ``bench``, 10 s of each movement. Both have the anatomy of the patient, each a mounting of its own. *p* is that of
their agreement. *Another*: the second recording is of the next patient.
"""

from __future__ import annotations

import argparse

import numpy as np

import jawenv
from agents import load_agent
from eval.figures import statistics, words
from jawenv.base.errors import InputError
from jawenv.recordings.identification import Identification
from jawenv.recordings.record import Record
from jawenv.recordings.several.together import agreement, combined, together
from jawenv.recordings.untold.learnt import identified_with_errors

_MOVEMENTS = ("opening_with_swings_and_fore_aft", "refined")
_HEADINGS = ("cohort", "first alone", "second alone", "plain sum", "together", "smallest p", "p, another")


def _recorded(cohort: str, number: int, seed: int) -> list[list[Record]]:
    """Two recordings of each patient."""
    rng, tried = np.random.default_rng(seed), 0
    found: list[list[Record]] = []
    kwargs = {"record": True, "episode_s": 10.0, "cohort": cohort, "knowledge": "bench", "track_bound": False}
    while len(found) < number:
        tried += 1
        patient = jawenv.cohort(cohort).draw(rng).model_copy(update={"anatomy_seed": seed + tried})
        pair: list[Record] = []
        for k, movement in enumerate(_MOVEMENTS, 1):
            try:
                played = jawenv.play(
                    load_agent(movement), patients=[patient], seed=seed + 1000 * k + tried, env_kwargs=kwargs
                )
            except InputError:  # the device cannot treat him
                break
            pair += played.records or ()
        if len(pair) == len(_MOVEMENTS):
            found.append(pair)
    return found


def _nees(mean: object, cov: object, truth: object) -> float:
    """NEES over the number of parameters."""
    error = np.asarray(mean) - np.asarray(truth)
    return float(error @ np.linalg.solve(np.asarray(cov), error)) / len(error)


def _row(pair: list[Record], found: list[Identification], other: Identification) -> list[float]:
    """Figures of a patient, as ``_HEADINGS`` has them."""
    prior, truth = pair[0].prior, pair[0].truth
    means, covs = (np.array([getattr(one.estimate, name)[-1] for one in (*found, other)]) for name in ("mean", "cov"))
    alone = [_nees(mean, cov, truth) for mean, cov in zip(means[:2], covs[:2], strict=True)]
    mean, cov = (part[0] for part in combined((means[0], covs[0]), prior, means[1:2], covs[1:2]))
    both = _nees(*together(pair, mean), truth)
    agree, apart = (agreement(prior, means[[0, k]], covs[[0, k]]).p for k in (1, 2))
    return [*alone, _nees(mean, cov, truth), both, agree, apart]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patients", type=int, default=24, help="of a cohort (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=660_000, help="of the first (default: %(default)s)")
    parser.add_argument("--cohorts", nargs="+", default=["trismus", "one_sided"])
    arguments = parser.parse_args()
    print(f"| {' | '.join(_HEADINGS)} |\n|---{'|--:' * (len(_HEADINGS) - 1)}|", flush=True)
    for cohort in arguments.cohorts:
        pairs = _recorded(cohort, arguments.patients, arguments.seed)
        found = [[identified_with_errors(record)[0] for record in pair] for pair in pairs]
        others = [found[(i + 1) % len(found)][1] for i in range(len(found))]
        rows = np.array([_row(*each) for each in zip(pairs, found, others, strict=True)])
        nees = [words.with_interval(statistics.mean(column), 2) for column in rows.T[:4]]
        print(f"| {' | '.join((cohort, *nees, f'{rows[:, 4].min():.2g}', f'{rows[:, 5].max():.2g}'))} |", flush=True)


if __name__ == "__main__":
    main()

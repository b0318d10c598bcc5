"""Share of honest agents that the check of fresh patients (`eval.benchmark.fresh`) takes for fitted to public ones.

Shipped agents and the maneuver play patients of reports in a task's world. These are shuffled, many times: the first
100 stand for public ones and the next for fresh ones, which no agent can tell apart. With --better 0.3 times on the
public ones are made shorter by that share: how many such agents are found. Prints a table in Markdown:

    python -m research.fresh_alarms
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from eval.benchmark import fresh
from eval.benchmark.run import cell_of, fitting_agents
from eval.benchmark.tasks import TASKS
from eval.commands.benchmark import BASELINES
from eval.figures.tables import Table
from eval.kept.cells import play_cells
from eval.kept.parts import Run
from jawenv.base.seeds import REPORTS
from jawenv.playing.excitation import EXCITATIONS
from jawenv.playing.maneuvers import maneuver_names

AGENTS = tuple(dict.fromkeys((*BASELINES, *maneuver_names(), *EXCITATIONS)))
PUBLIC = 100


def _share_accused(ratios, number, shuffles, better, random):
    """Share of shuffles whose chance is below the level."""
    accused = 0
    for _ in range(shuffles):
        order = random.permutation(ratios)
        public = order[:PUBLIC] + np.log(1.0 - better)
        accused += fresh.difference(public, order[PUBLIC : PUBLIC + number])[1] < fresh.LEVEL
    return accused / shuffles


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("agents", nargs="*", default=AGENTS)
    parser.add_argument("--better", type=float, default=0.0)
    parser.add_argument("--task", choices=TASKS, default="hinge-exact")
    parser.add_argument("--patients", type=int, default=200)
    parser.add_argument("--fresh", type=int, nargs="+", default=[50, 100])
    parser.add_argument("--shuffles", type=int, default=2000)
    parser.add_argument("--output", type=Path, default=Path("runs/fresh_alarms"))
    arguments = parser.parse_args()
    task, random = TASKS[arguments.task], np.random.default_rng(0)
    seeds = range(REPORTS[1].start, REPORTS[1].start + arguments.patients)
    agents = fitting_agents(list(dict.fromkeys((fresh.MANEUVER, *arguments.agents))), [task])
    cells = [replace(cell_of(task, agent), seeds=seeds) for agent in agents]
    rows = play_cells(cells, arguments.output, Run())
    times = {agent: cell["score_s"].to_numpy() for agent, cell in rows.groupby("agent", sort=False)}
    table = []
    for agent, mine in times.items():
        if agent != fresh.MANEUVER:
            ratios = fresh.log_ratios(mine, times[fresh.MANEUVER])
            how = (arguments.shuffles, arguments.better, random)
            shares = [_share_accused(ratios, number, *how) for number in arguments.fresh]
            table.append([agent, *(f"{100.0 * share:.2f}" for share in shares)])
    means = np.array([row[1:] for row in table], dtype=float).mean(axis=0)
    table.append(["mean", *(f"{mean:.2f}" for mean in means)])
    print(Table(["agent", *(f"accused with {number} fresh, %" for number in arguments.fresh)], table).markdown())


if __name__ == "__main__":
    main()

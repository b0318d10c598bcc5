"""The commands ``python -m eval compare``, ``report`` and ``replay``."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from eval.commands import options
from eval.commands.options import terminal, typed
from jawenv.base.errors import InputError
from jawenv.base.files import write_text
from jawenv.base.locks import alone
from jawenv.base.seeds import REPLAYS

if TYPE_CHECKING:
    from eval.comparison.admission import AdmissionLimits
    from eval.comparison.results import Results


@options.takes_world()
@options.takes_together
def _compare_command(
    world: dict[str, Any],
    entries: Annotated[
        list[str] | None,
        typer.Argument(metavar="[MANEUVER|FILE|RUN|MODULE:NAME]...", help=options.ENTRIES),
    ] = None,
    all_maneuvers: Annotated[
        bool, typer.Option("--all-maneuvers", help="Add every hand-made maneuver and the random policy.")
    ] = False,
    ranked: options.Ranked = options.Ranked(),
    with_replay: Annotated[
        bool,
        typer.Option(
            "--with-replay",
            help="Add what each trained or planned entry does on average over other patients, replayed without "
            "looking: an entry that adapts to its patient does better.",
        ),
    ] = False,
    played: options.Played = options.Played(Path("runs/compare")),
) -> None:
    """Play every entry on the same patients with the same noise, rank them and write a report.

    Ranked is what is within comfort, by the time until all parameters are within 5 %. Writes report.html,
    patients.parquet and curves.parquet. Ctrl-C keeps the entries that are finished: the same command goes on from
    there.
    """
    from eval.comparison.admission import AdmissionLimits
    from eval.comparison.motion import play_patient
    from eval.comparison.results import compare
    from eval.kept.entries import Settings, env_of_runs, load_entries
    from jawenv.playing.maneuvers import maneuver_names

    admission, output = AdmissionLimits(ranked.largest_discomfort_s, ranked.largest_violation), played.output
    specs = [*(entries or []), *((*maneuver_names(), "random") if all_maneuvers else [])]
    settings = Settings.of(played.patients, played.seed, **{"env": env_of_runs(specs)} | world)
    loaded = load_entries(specs, settings.world, trust=played.trust)
    if ranked.reference is not None and ranked.reference not in [entry.label for entry in loaded]:
        allowed = ", ".join(entry.label for entry in loaded)
        raise InputError(f"reference is {ranked.reference!r}; allowed: {allowed}")
    console = terminal()
    if with_replay:
        from eval.episodes.replays import add_replays

        loaded = add_replays(loaded, settings, output / "replays", fresh=played.fresh, console=console)
    study = compare(loaded, settings, output, command=typed(), fresh=played.fresh, console=console)
    play = partial(play_patient, trust=played.trust, own_modules=True)
    _present(study, output, ranked.reference, admission, console, play)


@options.takes_together
def _report_command(
    folder: Annotated[Path, typer.Argument(help="Folder of a finished comparison.", metavar="FOLDER")],
    ranked: options.Ranked = options.Ranked(),
    patient: Annotated[
        int | None,
        typer.Option(help="Seed of the patient whose motion is shown; the first by default.", metavar="SEED"),
    ] = None,
    trust: options.Trust = False,
) -> None:
    """Print the tables of a finished comparison and write its report again."""
    from eval.comparison import results
    from eval.comparison.admission import AdmissionLimits
    from eval.comparison.motion import play_patient

    admission = AdmissionLimits(ranked.largest_discomfort_s, ranked.largest_violation)
    study = results.load(folder)
    play = partial(play_patient, seed=patient, trust=trust)
    _present(study, folder, ranked.reference, admission, terminal(), play)


@options.takes_world("control")
def _replay_command(
    world: dict[str, Any],
    agent: Annotated[str, typer.Argument(metavar="AGENT", help="A planner, a training run or any other entry.")],
    output: Annotated[Path, typer.Option(help="Maneuver file to write.", metavar="FILE.yaml")],
    patients: options.Patients = 64,
    seed: options.Seed = REPLAYS.start,
    trust: options.Trust = False,
) -> None:
    """Write an agent's targets, averaged over patients, as a maneuver file.

    The maneuver is the agent without its eyes: what the agent does better on other patients, it owes to adapting.
    """
    from eval.episodes.replays import replay_of_entry
    from eval.kept.entries import Settings, load_entries

    settings = Settings.of(patients, seed, **world | {"control": "targets"})
    entry = load_entries([agent], settings.world, trust=trust)[0]
    replay_of_entry(entry, settings, output, terminal())
    print(f"maneuver: {output}")


def _present(
    study: Results,
    output: Path,
    reference: str | None,
    admission: AdmissionLimits,
    console: Console,
    play: Callable[[Results, Collection[str], Console], Results],
) -> None:
    from eval.comparison.ranking import rank
    from eval.comparison.trainings import gains
    from eval.report import films, page, table

    ranking = rank(study, reference, admission)
    table.show(ranking, console)
    study_gains = gains(study, reference)
    if study_gains:
        table.gains_table(study_gains, table.GAINS_SHOWN).show(console)
    with alone(output):
        study = play(study, films.candidates(ranking), console)
        console.print("drawing the report")
        written = page.write(study, ranking, output / "report.html")
        if study_gains:
            write_text(output / "gains.md", table.gains_table(study_gains).markdown() + "\n")
    table.show_verdict(ranking, console)
    console.print(
        f"results: {output / 'patients.parquet'}, {output / 'curves.parquet'}\nreport:  {written}",
        soft_wrap=True,
    )

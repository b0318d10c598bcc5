"""The leaderboard's points follow from the scores of the baselines and of merged submissions."""

from pathlib import Path

import pytest

from eval.benchmark import fresh
from eval.benchmark.submission import PAGE, PATIENTS, Submission, SubmittedAgent, SubmittedScore
from eval.benchmark.tasks import VERSION, digest
from jawenv.base.files import write_json

ROOT = Path(__file__).parents[2]


@pytest.fixture
def leaderboard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    import leaderboard

    monkeypatch.setattr(leaderboard, "TABLE", tmp_path / "benchmark.md")
    monkeypatch.setattr(leaderboard, "SUBMISSIONS", tmp_path / "submissions")
    return leaderboard


def write(path: Path, version: str, scores: dict[str, tuple[str, ...]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = "\n".join(f"| {name} | {' | '.join(cells)} |" for name, cells in scores.items())
    path.write_text(
        f"# Benchmark {version}\n\n| agent | jaw-exact | hinge-exact |\n|---|--:|--:|\n{rows}\n\n| task |\n"
    )


MADE_WITH = {
    "command": "python -m eval benchmark",
    "versions": {"jawenv": "0.1.0"},
    "git": None,
    "machine": {"processor": "x", "cores": 2, "system": "y"},
    "finished": "today",
}


def submit(folder: Path, scores: dict[str, dict[str, float]]) -> Path:
    """A submission of agents with scores by task."""
    folder.mkdir(parents=True)
    agents = tuple(SubmittedAgent(agent=agent, spec="slow_opening") for agent in scores)
    given = tuple(
        SubmittedScore(task=task, agent=agent, patients=100, score_s=score, low_s=score, high_s=score)
        for agent, times in scores.items()
        for task, score in times.items()
    )
    write_json(
        folder / "submission.json",
        Submission(benchmark=VERSION, tasks_digest=digest(), agents=agents, scores=given, made_with=MADE_WITH),
    )
    (folder / PAGE).write_text("# a page\n")
    (folder / PATIENTS).write_bytes(b"rows")
    return folder


def write_checked(folder: Path, agent: str, times: dict[str, float]) -> None:
    """What a check on fresh patients leaves."""
    scores = tuple(
        fresh.FreshScore(task=task, agent=agent, public_s=0.1, fresh_s=time, low_s=time, high_s=time)
        for task, time in times.items()
    )
    write_json(
        folder / fresh.CHECKED,
        fresh.Checked(submission=fresh.digest_of(folder), key="00", patients=50, scores=scores, made_with=MADE_WITH),
    )


def rows_of(page: str) -> dict[str, list[str]]:
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in page.splitlines() if line[:1] == "|"]
    return {cells[0]: cells[1:] for cells in lines}


def test_points_lie_between_holding_still_and_the_best(leaderboard, tmp_path: Path) -> None:
    baselines = {
        "hold still": ("25.00", "10.00"),
        "refined": ("5.00 (4.00 … 6.00)", "1.00"),
        "slow opening": ("15.00", "5.50"),
        "ppo trismus": ("10.00", "–"),
    }
    write(tmp_path / "benchmark.md", VERSION, baselines)
    submit(tmp_path / "submissions" / "team", {"mine": {"jaw-exact": 20.0, "hinge-exact": 0.1}})
    page = leaderboard.page()
    rows = rows_of(page)
    assert rows["*0 points*"][3:] == ["25.00 s", "10.00 s"]
    assert rows["*100 points*"][3:] == ["5.00 s", "1.00 s"]
    assert rows["refined"] == ["Searched", "100", "2", "100", "100"]
    assert rows["slow opening"] == ["Made by hand", "50", "2", "50", "50"]
    assert rows["ppo trismus"] == ["Learned", "38", "1", "75", "–"], "a task that is not played counts 0"
    assert rows["mine (team)"] == ["From elsewhere, not checked", "68", "2", "25", "110"]
    assert "hold still" not in rows and "Left out" not in page and "Older patients" not in page
    assert list(rows)[4:] == ["refined", "slow opening", "ppo trismus", "mine (team)"], "the unchecked stand last"


def test_scores_are_those_of_fresh_patients_where_a_check_played_them(leaderboard, tmp_path: Path) -> None:
    write(tmp_path / "benchmark.md", VERSION, {"hold still": ("25.00", "10.00"), "refined": ("5.00", "1.00")})
    public = {"jaw-exact": 1.0, "hinge-exact": 0.1}
    folder = submit(tmp_path / "submissions" / "team", {"mine": public})
    write_checked(folder, "mine", {"jaw-exact": 15.0, "hinge-exact": 5.5})
    assert rows_of(leaderboard.page())["mine (team)"] == ["From elsewhere", "50", "2", "50", "50"]
    (folder / PATIENTS).write_bytes(b"other rows")
    page = leaderboard.page()
    assert "mine (team)" not in rows_of(page)
    assert "\n- team/checked.json: is of other files; check the submission again" in page


def test_a_submission_that_cannot_be_read_is_left_out_by_name(leaderboard, tmp_path: Path) -> None:
    write(tmp_path / "benchmark.md", VERSION, {"refined": ("5.00", "1.00")})
    for name in ("empty", "binary", "old", "text", "long", "label", "<b>x", "a|b", "x\ny"):
        folder = submit(tmp_path / "submissions" / name, {"mine": {"jaw-exact": 1.0}})
        path = folder / "submission.json"
        text = path.read_text()
        changed = {
            "empty": b"",
            "binary": b"\xff\xfe\x00",
            "old": text.replace(VERSION, "jawenv-1").encode(),
            "text": text.replace('"score_s": 1.0', '"score_s": "x"').encode(),
            "long": text.replace('"score_s": 1.0', '"score_s": -1e9').encode(),
            "label": text.replace('"mine"', '"<script>alert(1)</script>"').encode(),
        }
        path.write_bytes(changed.get(name, text.encode()))
    (tmp_path / "submissions" / "nothing").mkdir()
    page = leaderboard.page()
    left_out = page.partition("## Left out")[2]
    for name in ("empty", "binary", "old", "text", "long", "label", "nothing"):
        assert f"- {name}/submission.json: " in left_out
    assert not {"<b>", "<script>", "a|b"} & {part for part in ("<b>", "<script>", "a|b") if part in page}
    rows = rows_of(page)
    assert {"mine (&#60;b&#62;x)", "mine (a&#124;b)", "mine (x y)"} <= set(rows)
    assert str(tmp_path) not in page


def test_older_patients_are_said_and_submissions_left_out(leaderboard, tmp_path: Path) -> None:
    write(tmp_path / "benchmark.md", "jawenv-1", {"refined": ("5.00", "1.00")})
    submit(tmp_path / "submissions" / "team", {"mine": {"jaw-exact": 1.0}})
    page = leaderboard.page()
    assert "of `jawenv-1`; tasks are now `jawenv-2`" in page and "mine (team)" not in rows_of(page)
    assert "- mine (team): is of jawenv-2, the scores above of jawenv-1" in page


def test_one_task_of_many_does_not_lead(leaderboard, tmp_path: Path) -> None:
    scores = {"apg asked": ("–", "0.10"), "refined": ("5.00", "1.00"), "hold still": ("25.00", "10.00")}
    write(tmp_path / "benchmark.md", VERSION, scores)
    assert list(rows_of(leaderboard.page()))[4:] == ["refined", "apg asked"]


def test_the_planner_that_knows_the_truth_has_100_points(leaderboard, tmp_path: Path) -> None:
    scores = {"refined": ("20.00", "30.00"), "clairvoyant myopic": ("10.00", "15.00"), "random": ("5.00", "0.00")}
    write(tmp_path / "benchmark.md", leaderboard.VERSION, scores)
    page = leaderboard.page()
    assert rows_of(page)["clairvoyant myopic"] == ["Planned", "100", "2", "100", "100"]
    assert rows_of(page)["refined"] == ["Searched", "25", "2", "50", "0"], "an episode's length has 0 points"
    assert "Older patients" not in page and "the whole episode in all tasks" in page
    assert "100 points: a planner that knows the truth." in page


def test_both_ends_are_what_the_table_has_of_them(leaderboard, tmp_path: Path) -> None:
    """`clairvoyant` plays one model alone; an agent better than it has more than 100 points."""
    scores = {
        "hold still": ("28.00", "20.00"),
        "clairvoyant": ("8.00", "–"),
        "refined": ("18.00", "5.00"),
        "apg trismus": ("6.00", "–"),
    }
    write(tmp_path / "benchmark.md", leaderboard.VERSION, scores)
    page = leaderboard.page()
    rows = rows_of(page)
    assert rows["*100 points*"][3:] == ["8.00 s", "5.00 s"]
    assert rows["refined"][3:] == ["50", "100"] and rows["apg trismus"][3:] == ["110", "–"]
    assert "0 points: holding still. 100 points: a planner that knows the truth; the best" in page
    assert "baseline in hinge-exact (refined), where" in page

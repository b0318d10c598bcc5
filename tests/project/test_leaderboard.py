"""The leaderboard's points follow from the scores of the baselines and of merged submissions."""

from pathlib import Path

import pytest

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
    write(tmp_path / "benchmark.md", "jawenv-1", baselines)
    write(tmp_path / "submissions" / "team" / "benchmark.md", "jawenv-1", {"mine": ("20.00", "0.10")})
    write(tmp_path / "submissions" / "late" / "benchmark.md", "jawenv-2", {"other": ("1.00", "0.10")})
    page = leaderboard.page()
    rows = rows_of(page)
    assert rows["*0 points*"][3:] == ["25.00 s", "10.00 s"]
    assert rows["*100 points*"][3:] == ["5.00 s", "1.00 s"]
    assert rows["refined"] == ["Searched", "100", "2", "100", "100"]
    assert rows["slow opening"] == ["Made by hand", "50", "2", "50", "50"]
    assert rows["ppo trismus"] == ["Learned", "75", "1", "75", "–"]
    assert rows["mine (team)"] == ["From elsewhere", "68", "2", "25", "110"]
    assert "hold still" not in rows and not any("late" in name for name in rows)
    assert "of `jawenv-1`; tasks are now `jawenv-2`" in page


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

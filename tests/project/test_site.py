"""The documentation's site is built without a warning, and everything that its pages name is there."""

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import gymnasium as gym
import nbformat
import pytest
from axe_playwright_python.sync_playwright import Axe

import jawenv
from jawenv.envs.configuration import Configuration
from jawenv.envs.registration import ENVIRONMENTS
from jawenv.ladder import KNOWN_WITHIN_SDS
from tests.browser import new_page
from tests.processes import python

ROOT = Path(__file__).parents[2]
SECTIONS = (
    "Description",
    "Action Space",
    "Observation Space",
    "Rewards",
    "Starting State",
    "Episode End",
    "Arguments",
    "Version History",
)


class Places(HTMLParser):
    """What a page links to and loads, and the places in it that can be linked to."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.wanted: list[str] = []
        self.anchors: set[str] = set()
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src") and value:
                self.wanted.append(value)
            elif name == "id" and value:
                self.anchors.add(value)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    source, built = folder / "source", folder / "built"
    config = folder / "mkdocs.yml"
    theme = f"theme: {{custom_dir: {ROOT / 'docs/site/theme'}}}"
    config.write_text(
        f"INHERIT: {ROOT / 'mkdocs.yml'}\ndocs_dir: {source}\nsite_dir: {built}\n{theme}\n", encoding="utf-8"
    )
    made = ["docs/site/build.py", "--output", str(source)]
    for words in (made, ["-m", "mkdocs", "build", "--strict", "-f", str(config)]):
        python(*words, cwd=ROOT)
    return built


def test_every_link_leads_somewhere_without_a_server(site: Path) -> None:
    pages = {page: Places(page) for page in site.rglob("*.html") if page.name != "404.html"}
    assert len(pages) > 15
    for page, places in pages.items():
        for link in places.wanted:
            if re.match(r"(https?|data|mailto|javascript):", link):
                continue
            path, _, anchor = link.partition("#")
            target = (page.parent / unquote(path)).resolve() if path else page
            target = target / "index.html" if target.is_dir() else target
            assert target.exists(), f"{page.relative_to(site)} names {link}"
            if anchor and target.suffix == ".html" and not anchor.startswith("__"):
                assert unquote(anchor) in pages[target].anchors, f"{page.relative_to(site)} names {link}"


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        assert not re.search(r'<(?:script|img|iframe)[^>]* src="https?:|<link[^>]*stylesheet[^>]*https?:', text), page


@pytest.mark.parametrize("env_id", [*ENVIRONMENTS, KNOWN_WITHIN_SDS])
def test_an_environment_has_its_page(site: Path, env_id: str) -> None:
    text = (site / "environments" / f"{env_id.removeprefix('jawenv/')}.html").read_text(encoding="utf-8")
    headings = re.findall(r"<h2[^>]*>([^<]+)<", text)
    assert [heading for heading in headings if heading in SECTIONS] == list(SECTIONS)
    assert all(f"<code>{name}</code>" in text for name in Configuration.__dataclass_fields__)
    assert "<code>float or None</code>" in text
    still, film = re.search(r'srcset="([^"]*)"[^<]*<img src="([^"]*)"', text.split("<h2")[0]).groups()
    assert all((site / "environments" / place).stat().st_size < 500e3 for place in (still, film))
    env = gym.make(env_id)
    assert f"({env.observation_space.shape[0]},)" in text
    assert f"–{env.observation_space.shape[0] - 2}<" in text  # the last part but the time
    env.close()


@pytest.mark.parametrize("name", ["404.html", "index.html", "environments/Jaw-v3.html"])
def test_no_element_of_a_page_breaks_an_accessibility_rule_seriously(site: Path, name: str) -> None:
    tab = new_page(viewport={"width": 480, "height": 800}, color_scheme="dark")
    tab.goto((site / name).as_uri())
    tab.wait_for_function("document.readyState === 'complete'")
    assert tab.complaints == [] and all(url.startswith(("file:", "data:", "blob:")) for url in tab.requests)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 480
    found = Axe().run(tab).response["violations"]
    assert [rule["id"] for rule in found if rule["impact"] in ("serious", "critical")] == []
    tab.context.close()


def test_a_tab_has_one_name_and_the_search_leads_to_the_glossary(site: Path) -> None:
    tab = new_page()
    tab.goto((site / "index.html").as_uri())
    assert tab.title() == "jawenv"
    tab.goto((site / "questions.html").as_uri())
    assert tab.title() == "Questions and words - jawenv"
    tab.locator(".md-search__input").click(force=True)
    tab.locator(".md-search__input").press_sequentially("what is NEES")
    first = tab.locator(".md-search-result__link").first
    first.wait_for()
    assert "questions.html" in first.get_attribute("href")
    tab.context.close()


def test_formulas_need_no_script(site: Path) -> None:
    text = (site / "model.html").read_text(encoding="utf-8")
    assert text.count("<math") > 100 and "$" not in re.sub(r"<script.*?</script>", "", text, flags=re.S)


def test_every_public_name_is_in_the_reference(site: Path) -> None:
    anchors = Places(site / "api.html").anchors
    for name in jawenv.__all__:
        assert any(anchor.endswith(f".{name}") for anchor in anchors), name


def test_a_notebooks_outputs_are_on_its_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is printed stays one block, blank lines too, and is no HTML; the kernel's warnings are left out."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "site"))
    import notebook_pages

    new = nbformat.v4
    outputs = [
        new.new_output("stream", name="stdout", text="a < b\n\nend\n"),
        new.new_output("stream", name="stderr", text="a warning"),
        new.new_output("execute_result", data={"text/markdown": "**44 %**", "text/plain": "<Markdown>"}),
    ]
    notebook = new.new_notebook(cells=[new.new_code_cell("1 + 1", outputs=outputs)])
    path = tmp_path / "small.ipynb"
    path.write_text(nbformat.writes(notebook), encoding="utf-8")
    page = notebook_pages._page(path)
    assert "```python\n1 + 1\n```" in page
    assert "a &lt; b\n&nbsp;\nend" in page and "a warning" not in page
    assert "<strong>44 %</strong>" in page and "&lt;Markdown&gt;" not in page

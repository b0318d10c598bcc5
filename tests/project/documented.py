"""The code blocks of the documentation's pages, and what they need."""

import ast
import builtins
import sys
from dataclasses import dataclass
from pathlib import Path

from markdown_it import MarkdownIt

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted(ROOT.glob("[!.]*/README.md"))]
OF_THE_WHEEL = {"jawenv", "gymnasium", "numpy", *sys.stdlib_module_names}
OF_EXTRAS = ("jawenv.live", "jawenv.sb3")


@dataclass(frozen=True)
class Block:
    """A fenced block, and where it begins."""

    page: Path
    line: int
    language: str
    text: str

    @property
    def place(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def blocks(page: Path, *languages: str) -> list[Block]:
    """The blocks of a page in these languages, in their order."""
    tokens = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    fences = (token for token in tokens if token.type == "fence" and token.map)
    found = [Block(page, token.map[0] + 1, token.info.strip(), token.content) for token in fences]
    return [block for block in found if block.language in languages]


def needs_only_the_wheel(page: Path) -> list[Block]:
    """Python blocks that import nothing else, and use nothing that a block made that does."""
    chosen, known = [], set(dir(builtins))
    for block in blocks(page, "python"):
        tree = ast.parse(block.text)
        nodes = list(ast.walk(tree))
        imports = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
        imports += [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
        names = [node for node in nodes if isinstance(node, ast.Name)]
        bound = {node.id for node in names if not isinstance(node.ctx, ast.Load)}
        bound |= {alias.asname or alias.name for node in nodes if hasattr(node, "names") for alias in _aliases(node)}
        bound |= {node.arg for node in nodes if isinstance(node, ast.arg)}
        used = {node.id for node in names if isinstance(node.ctx, ast.Load)}
        alone = {name.split(".")[0] for name in imports} <= OF_THE_WHEEL and not any(map(of_an_extra, imports))
        if alone and used <= known | bound:
            chosen.append(block)
            known |= bound
    return chosen


def of_an_extra(module: str) -> bool:
    """Whether the module is jawenv's and needs a package that only an extra brings."""
    return any(module == extra or module.startswith(f"{extra}.") for extra in OF_EXTRAS)


def _aliases(node: ast.AST) -> list[ast.alias]:
    return node.names if isinstance(node, ast.Import | ast.ImportFrom) else []

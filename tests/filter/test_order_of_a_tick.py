"""The table of a tick's steps is in the order of the code, and names rows that the ablation has."""

import inspect
import re

from jawenv.filter import tick
from research.ablation import BODY_ROWS, LASTING_ROWS, ROWS


def test_the_table_has_the_order_of_the_code_and_rows_of_the_ablation():
    rows = [re.split(r" \| ", line.strip("| ")) for line in tick.__doc__.splitlines() if re.match(r"\| \d", line)]
    names = [name for row in rows for name in re.findall(r"``(\w+)``", row[1])]
    code = inspect.getsource(tick.take.py_func)
    places = [code.index(f"{name}(") for name in names if name not in ("bite_of", "bite_read", "weight_of_stay")]
    assert len(rows) == 13 and all(f"{name}(" in code for name in names) and places == sorted(places)
    known = {variant.what for variant in (*ROWS, *BODY_ROWS, *LASTING_ROWS)}
    told = {row[-1] for row in rows if row[-1] != "-"} | set(re.findall(r'"([^"]+)"', tick.__doc__.replace("\n", " ")))
    assert told <= known

"""The table of a tick's steps is in the order of the code."""

import inspect
import re

from jawenv.filter import tick


def test_the_table_has_the_order_of_the_code():
    rows = [re.split(r" \| ", line.strip("| ")) for line in tick.__doc__.splitlines() if re.match(r"\| \d", line)]
    names = [name for row in rows for name in re.findall(r"``(\w+)``", row[1])]
    code = inspect.getsource(tick.take.py_func)
    places = [code.index(f"{name}(") for name in names if name not in ("bite_of", "bite_read", "weight_of_stay")]
    assert len(rows) == 13 and all(f"{name}(" in code for name in names) and places == sorted(places)

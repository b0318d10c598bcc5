"""Entry point of ``python -m eval``."""

import sys

from jawenv.commands.extra import installed

if __name__ == "__main__":
    with installed("python -m eval", "eval"):
        from eval.cli import main

        sys.exit(main())

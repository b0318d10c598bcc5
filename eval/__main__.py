"""Entry point of ``python -m eval``."""

import sys

from training.extra import installed

if __name__ == "__main__":
    with installed("python -m eval", "eval"):
        from eval.commands.app import main

        sys.exit(main())

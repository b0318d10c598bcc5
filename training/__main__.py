"""Entry point of ``python -m training``."""

import sys

from jawenv.commands.extra import installed

if __name__ == "__main__":
    with installed("python -m training", "train"):
        from training.cli import main

        sys.exit(main())

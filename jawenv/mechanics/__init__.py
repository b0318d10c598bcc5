"""Motion of the jaw: condyle on fossa, muscles, mandible dynamics, stops, equilibrium."""

from jawenv.mechanics.building import build_jaw

__all__ = ["build_jaw"]

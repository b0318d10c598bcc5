"""How the jaw moves: condyle on fossa, muscles, mandible dynamics, stops, equilibrium."""

from jawenv.mechanics.acceleration import acceleration
from jawenv.mechanics.jaw import build_jaw

__all__ = ["acceleration", "build_jaw"]

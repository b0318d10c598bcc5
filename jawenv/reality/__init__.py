"""Effects of a real jaw and a real device beyond the thesis, on the truth alone: the filter lacks them.

Every effect is off by default, and one that is off changes no bit of a result.
"""

from jawenv.reality.options import REALITY, Reality, check_reality
from jawenv.reality.state import reality_state_dtype

__all__ = ["REALITY", "Reality", "check_reality", "reality_state_dtype"]

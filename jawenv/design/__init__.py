"""Design environments: what an experiment that learns must give beside Gymnasium's interface."""

from jawenv.design.interface import DesignEnv
from jawenv.design.jaw import JawDesign

__all__ = ["DesignEnv", "JawDesign"]

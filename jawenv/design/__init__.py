"""Design environments: what an experiment that learns must give beside Gymnasium's interface, and a checker of it."""

from jawenv.design.check import check_design_env
from jawenv.design.interface import DesignEnv
from jawenv.design.jaw import JawDesign

__all__ = ["DesignEnv", "JawDesign", "check_design_env"]

"""Expected information gain of maneuvers and agents, in the units of Bayesian experimental design."""

"""Episodes of maneuvers and agents as data sets of Minari."""

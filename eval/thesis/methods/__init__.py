"""The estimators of Young (2016): inverse kinematics, balance of moments, least squares in one and two stages."""

"""What can be known: the extended Kalman filter and the bound that shares its recursion."""

"""The filter's model: tensions as sums of fixed functions, the motion's step and derivative, what encoders read."""

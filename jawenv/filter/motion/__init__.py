"""The filter's model of the motion: its step with the derivative, what the muscles do to it, what is not modelled."""

"""Time update and measurement update of the belief, with what is not modelled and what the past alone predicts."""

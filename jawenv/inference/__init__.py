"""What Bayesian design and simulation-based inference call: who can be treated, simulation in batches, likelihoods."""

"""Tools for Bayesian design and simulation-based inference: treatable patients, simulation in batches, likelihoods."""

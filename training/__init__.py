"""Training of agents on jawenv from the command line: ``python -m training train ppo``.

Run it from a clone of the project; this package is not part of the installed library. The files, from the
outside in: `cli` (commands), `train` (one run from start to end), `config` (what can be set), `run` (the
folder a run leaves behind), `callbacks` (what happens during a run), `evaluate` (how good a policy is), `vec_env`
(Gymnasium's native vector environments for stable-baselines3), `export` (a policy to be shared) and `network` (its
layers).
"""

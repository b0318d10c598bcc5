"""Ray's cores for joblib: those of this machine, or of the cluster that RAY_ADDRESS names."""

from __future__ import annotations

import logging
import os
from pathlib import Path

from joblib import register_parallel_backend

from jawenv.errors import InputError, shown
from jawenv.extras import needs


def connect(workers: int | None = None) -> int:
    """Connect to the cluster once, and let joblib know of it.

    Args:
        workers: processes on this machine, where no cluster is named; one per core by default.

    Returns:
        How many cores it has.

    Raises:
        MissingPackageError: ray is not installed.
        InputError: the cluster cannot be reached.
    """
    with needs("--backend ray", "ray", group="cluster"):
        import ray
        from ray.util.joblib.ray_backend import RayBackend

    if not ray.is_initialized():
        root = str(Path(__file__).parents[2])
        path = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))
        threads = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        address = os.environ.get("RAY_ADDRESS")
        try:
            ray.init(
                num_cpus=None if address else workers,
                runtime_env={"env_vars": {"PYTHONPATH": path, **threads}},
                log_to_driver=False,
                logging_level=logging.ERROR,
                include_dashboard=None if address else False,
            )
        except (ConnectionError, ValueError, RuntimeError) as error:
            reason = " ".join(str(error).split())[:120]
            raise InputError(f"ray cannot be reached (RAY_ADDRESS is {shown(address)}): {reason}") from None

    class Backend(RayBackend):
        """Hands over what is finished while the rest goes on, as Ray's pool can."""

        supports_return_generator = True

    register_parallel_backend("ray", Backend)
    return int(ray.cluster_resources()["CPU"])

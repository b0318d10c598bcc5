"""The versions of the packages that decide what is computed."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

__all__ = ["PACKAGES", "package_versions"]

PACKAGES = (
    "jawenv",
    "gymnasium",
    "numpy",
    "numba",
    "llvmlite",
    "scipy",
    "pymunk",
    "filterpy",
    "torch",
    "stable-baselines3",
    "sb3-contrib",
)


def package_versions() -> dict[str, str]:
    """The installed version of each package, by its name."""
    installed = {}
    for package in PACKAGES:
        try:
            installed[package] = version(package)
        except PackageNotFoundError:
            installed[package] = "not installed"
    return installed

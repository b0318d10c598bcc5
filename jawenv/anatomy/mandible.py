"""The lower jaw as a rigid body, and the surface along which its condyle slides."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.anatomy.quantities import load_quantities
from jawenv.base.errors import InputError

__all__ = ["Fossa", "Mandible", "default_fossa", "default_mandible"]


@dataclass(frozen=True, eq=False)
class Mandible(FrozenArrays):
    """Mass properties, contact points and damping of the mandible; points in the closed-jaw frame, SI units."""

    mass_kg: float  # with the attached soft tissue
    centre_of_mass_m: NDArray[np.float64]  # (3,)
    inertia_kg_m2: NDArray[np.float64]  # (3, 3) inertia tensor about the centre of mass (matrix elements, body axes)
    mouthpiece_m: NDArray[np.float64]  # (3,) where the device holds the jaw: between the lower incisors' edges
    teeth_m: NDArray[np.float64]  # (3, 3) contact points incisor, left first molar, right first molar
    damping_rotation: float  # N m s/rad, on the angular velocity
    damping_sliding: float  # N s/m, on the condyle's sliding velocity
    tooth_stiffness: float  # N/m per contact point
    closing_tone_N: float  # Constant active tension of each of the six whole closing muscles, beside the passive one
    condyle_half_width_m: float  # from the midline to the centre of a condyle
    disc_stiffness: float  # N/m, of the disc and cartilage over one condyle, across the surface of the fossa
    disc_damping: float  # N s/m, of the same
    gravity: float  # m/s2

    def __post_init__(self) -> None:
        """Check that this is a body that can exist."""
        super().__post_init__()
        for name, shape in _SHAPES.items():
            self._require_shape(name, shape)
        for name in ("mass_kg", "tooth_stiffness", "condyle_half_width_m", "disc_stiffness"):
            if getattr(self, name) <= 0:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: numbers above 0")
        for name in ("damping_rotation", "damping_sliding", "disc_damping", "gravity", "closing_tone_N"):
            if getattr(self, name) < 0:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: numbers from 0 on")
        if not np.allclose(self.inertia_kg_m2, self.inertia_kg_m2.T, rtol=1e-9, atol=0):
            raise InputError(f"inertia_kg_m2 is {self.inertia_kg_m2.tolist()}; allowed: a symmetric matrix")
        moments = np.linalg.eigvalsh(self.inertia_kg_m2)
        if moments[0] <= 0:
            raise InputError(f"inertia_kg_m2 has the principal moments {moments.tolist()}; allowed: numbers above 0")
        if moments[0] + moments[1] < moments[2]:
            raise InputError(
                f"inertia_kg_m2 has the principal moments {moments.tolist()}; "
                "allowed: the largest up to the sum of the others"
            )


_SHAPES: dict[str, tuple[int, ...]] = {
    "mass_kg": (),
    "centre_of_mass_m": (3,),
    "inertia_kg_m2": (3, 3),
    "mouthpiece_m": (3,),
    "teeth_m": (3, 3),
    "damping_rotation": (),
    "damping_sliding": (),
    "tooth_stiffness": (),
    "closing_tone_N": (),
    "condyle_half_width_m": (),
    "disc_stiffness": (),
    "disc_damping": (),
    "gravity": (),
}


@cache
def default_mandible() -> Mandible:
    """The adult mandible of the data file `mandible.toml`; vary it with `dataclasses.replace`."""
    quantities = load_quantities("mandible.toml")
    incisor, molar = quantities["incisor"].si(), quantities["first_molar_right"].si()
    return Mandible(
        mass_kg=float(quantities["mass"].si()),
        centre_of_mass_m=quantities["centre_of_mass"].si(),
        inertia_kg_m2=quantities["inertia"].si(),
        mouthpiece_m=incisor,
        teeth_m=np.array([incisor, molar * [1.0, -1.0, 1.0], molar]),
        damping_rotation=float(quantities["damping_rotation"].si()),
        damping_sliding=float(quantities["damping_sliding"].si()),
        tooth_stiffness=float(quantities["tooth_stiffness"].si()),
        closing_tone_N=float(quantities["closing_tone"].si()),
        condyle_half_width_m=float(quantities["condyle_half_width"].si()),
        disc_stiffness=float(quantities["disc_stiffness"].si()),
        disc_damping=float(quantities["disc_damping"].si()),
        gravity=float(quantities["gravity"].si()),
    )


@dataclass(frozen=True)
class Fossa(FrozenArrays):
    """The condyle centre's path `z = d (cos f x - 1)`, from the roof of the fossa over the eminence."""

    drop_m: float  # d; the crest of the eminence lies 2 d below the roof
    spatial_frequency: float  # f, rad/m; the crest lies at x = pi/f

    def __post_init__(self) -> None:
        """Check that there is a path."""
        super().__post_init__()
        for name in ("drop_m", "spatial_frequency"):
            self._require_shape(name, ())
            if getattr(self, name) <= 0:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: numbers above 0")

    @property
    def crest_m(self) -> float:
        """The crest of the eminence, where the path is lowest: its x."""
        return float(np.pi / self.spatial_frequency)


@cache
def default_fossa() -> Fossa:
    """The adult fossa of the data file `fossa.toml`."""
    quantities = load_quantities("fossa.toml")
    return Fossa(float(quantities["drop"].si()), float(quantities["spatial_frequency"].si()))

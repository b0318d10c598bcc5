"""A jaw whose numbers are changed by nuisances: by a small share of one for a derivative, or to the belief's mean."""

from __future__ import annotations

from math import pi

from jawenv.filter.belief.state import Nuisances
from jawenv.kernels.compiled import njit
from jawenv.kernels.vec3 import cross, dot, norm, row3, subtract, vector3
from jawenv.mechanics.jaw import N_TEETH, Jaw


@njit
def _change_body(jaw: Jaw, nuisances: Nuisances, j, share, changed: Jaw):
    """Mass, centre of mass and inertia about it, with mass, first moment and inertia about the contact point changed.

    The equations of motion are linear in the latter, so that what they say of a sum of nuisances is no curved ridge.
    """
    mass, rho = jaw.mass, vector3(jaw.centre_of_mass)
    changed_mass = mass + share * nuisances.mass[j]
    changed_rho = (
        (mass * rho[0] + share * nuisances.first_moment[j, 0]) / changed_mass,
        (mass * rho[1] + share * nuisances.first_moment[j, 1]) / changed_mass,
        (mass * rho[2] + share * nuisances.first_moment[j, 2]) / changed_mass,
    )
    square, changed_square = dot(rho, rho), dot(changed_rho, changed_rho)
    for i in range(3):
        before = _contact_row(jaw, mass, rho, square, i)
        for k in range(3):
            inertia = before[k] + share * nuisances.inertia[j, 3 * i + k]
            there = (changed_square if i == k else 0.0) - changed_rho[i] * changed_rho[k]
            changed.inertia[i, k] = inertia - changed_mass * there
    changed.mass = changed_mass
    for i in range(3):
        changed.centre_of_mass[i] = changed_rho[i]


@njit
def change_jaw(jaw: Jaw, nuisances: Nuisances, j, share, changed: Jaw):
    """``changed`` = ``jaw`` with nuisance j at ``share`` sds."""
    _change_body(jaw, nuisances, j, share, changed)
    changed.fossa_drop = jaw.fossa_drop + share * nuisances.fossa_drop[j]
    changed.fossa_frequency = jaw.fossa_frequency + share * nuisances.fossa_frequency[j]
    changed.crest = pi / changed.fossa_frequency
    changed.damping_rotation = jaw.damping_rotation + share * nuisances.damping_rotation[j]
    changed.damping_sliding = jaw.damping_sliding + share * nuisances.damping_sliding[j]
    changed.tone = jaw.tone + share * nuisances.tone[j]
    for i in range(3):
        changed.gravity[i] = jaw.gravity[i] + share * nuisances.gravity[j, i]
        shift = share * nuisances.mouthpiece[j, i]
        changed.mouthpiece[i] = jaw.mouthpiece[i] + shift
        changed.zero[i] = jaw.zero[i] + share * nuisances.zero[j, i]
        for tooth in range(N_TEETH):
            changed.teeth[tooth, i] = jaw.teeth[tooth, i] + shift
    for line in range(jaw.l_o.shape[0]):
        changed.l_o[line] = jaw.l_o[line] + share * nuisances.l_o[j, line]
        for i in range(3):
            changed.origin[line, i] = jaw.origin[line, i] + share * nuisances.origin[j, 3 * line + i]
            changed.insertion[line, i] = jaw.insertion[line, i] + share * nuisances.insertion[j, 3 * line + i]


@njit
def copy_rest(jaw: Jaw, changed: Jaw):
    """Copy the jaw's fields without nuisances."""
    changed.free_x, changed.free_y = jaw.free_x, jaw.free_y
    changed.tooth_stiffness, changed.condyle_stiffness = jaw.tooth_stiffness, jaw.condyle_stiffness
    changed.stop_width = jaw.stop_width


@njit
def copy_jaw(jaw: Jaw, copied: Jaw):
    """``copied`` = ``jaw`` in all that the filter's kernels read."""
    copy_rest(jaw, copied)
    copied.crest, copied.tone = jaw.crest, jaw.tone
    copied.mass, copied.fossa_drop, copied.fossa_frequency = jaw.mass, jaw.fossa_drop, jaw.fossa_frequency
    copied.damping_rotation, copied.damping_sliding = jaw.damping_rotation, jaw.damping_sliding
    copied.condyle_mobility, copied.mouthpiece_mobility = jaw.condyle_mobility, jaw.mouthpiece_mobility
    copied.centre_of_mass[:] = jaw.centre_of_mass
    copied.gravity[:] = jaw.gravity
    copied.mouthpiece[:] = jaw.mouthpiece
    copied.zero[:] = jaw.zero
    copied.teeth[:, :] = jaw.teeth
    copied.l_o[:] = jaw.l_o
    copied.mobility[:] = jaw.mobility
    copied.tooth_mobility[:] = jaw.tooth_mobility
    copied.muscle[:] = jaw.muscle
    copied.inertia[:, :] = jaw.inertia
    copied.inertia_contact_inverse[:, :] = jaw.inertia_contact_inverse
    copied.origin[:, :] = jaw.origin
    copied.insertion[:, :] = jaw.insertion


@njit
def move_jaw(jaw: Jaw, nuisances: Nuisances, steps, first):
    """Change ``jaw`` by so many sds of each nuisance, ``steps`` from ``first`` on."""
    for j in range(nuisances.mass.shape[0]):
        change_jaw(jaw, nuisances, j, steps[first + j], jaw)
    mass, rho = jaw.mass, vector3(jaw.centre_of_mass)
    square = dot(rho, rho)
    inertia = (
        _contact_row(jaw, mass, rho, square, 0),
        _contact_row(jaw, mass, rho, square, 1),
        _contact_row(jaw, mass, rho, square, 2),
    )
    for line in range(jaw.l_o.shape[0]):
        jaw.l_o[line] = norm(subtract(row3(jaw.origin, line), row3(jaw.insertion, line)))
    _set_inverse(inertia, jaw.inertia_contact_inverse)


@njit
def _contact_row(jaw: Jaw, mass, rho, square, i):
    """Row i of the inertia about the contact point."""
    return (
        jaw.inertia[i, 0] + mass * ((square if i == 0 else 0.0) - rho[i] * rho[0]),
        jaw.inertia[i, 1] + mass * ((square if i == 1 else 0.0) - rho[i] * rho[1]),
        jaw.inertia[i, 2] + mass * ((square if i == 2 else 0.0) - rho[i] * rho[2]),
    )


@njit
def _set_inverse(matrix, inverse):
    """Into ``inverse`` (3, 3) that of a matrix as three rows; of pitch alone where yaw and roll are held."""
    if inverse[2, 2] == 0.0:
        inverse[1, 1] = 1.0 / matrix[1][1]
        return
    first, second, third = cross(matrix[1], matrix[2]), cross(matrix[2], matrix[0]), cross(matrix[0], matrix[1])
    determinant = dot(matrix[0], first)
    for i in range(3):
        inverse[i, 0], inverse[i, 1], inverse[i, 2] = (
            first[i] / determinant,
            second[i] / determinant,
            third[i] / determinant,
        )

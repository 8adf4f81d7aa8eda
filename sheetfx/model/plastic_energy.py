"""Energy that plastic points store and have dissipated, by their strains and history: closed forms, whatever the steps.

Plastic work is done by the back stress b and the yield stress s_y + H a. With linear hardening b dp is the change of
b^2 / 2 K, and (s_y + H a) da that of s_y a + H a^2 / 2: what the yield stress of the virgin material takes is
dissipated, what hardening adds is stored (Simo and Hughes 1998, sections 1.4 and 2.7). What softens dissipates all.
"""

from __future__ import annotations

import numpy as np

SHAPE = np.array((1 / 3, 1.0, 2.0))  # von Mises's norm for (11 + 22) / sqrt 2, (22 - 11) / sqrt 2 and 12


def isotropic_energies(hardened: np.ndarray, strength: float, isotropic: float) -> tuple[np.ndarray, np.ndarray]:
    """Energy per volume that is stored, and dissipated, by equivalent plastic strains."""
    if isotropic >= 0:
        return isotropic * hardened**2 / 2, strength * hardened
    flowed = np.minimum(hardened, -strength / isotropic)
    return np.zeros_like(hardened), strength * flowed + isotropic * flowed**2 / 2


def fibre_energies(strains, history, arms, areas, elastic, modulus, strength, isotropic, kinematic):
    """Energies per length of fibres at many points, see `plasticity.Fibres`."""
    plastic, back, hardened = np.moveaxis(history.reshape(len(history), -1, 3), 2, 0)
    stored, dissipated = isotropic_energies(hardened, strength, isotropic)
    stored = stored + modulus / 2 * (strains @ arms.T - plastic) ** 2
    if kinematic:
        stored = stored + back**2 / (2 * kinematic)
    return stored @ areas + quadratic(strains, elastic), dissipated @ areas


def layer_energies(strains, history, places, weights, elastic, modulus, poisson, strength, isotropic, kinematic):
    """Energies per area of layers at many points, see `plasticity.Layers`."""
    layers = history.reshape(len(history), len(places), -1)
    stored, dissipated = isotropic_energies(layers[..., 6], strength, isotropic)
    plane = modulus / (1 - poisson**2) * np.array([(1, poisson, 0), (poisson, 1, 0), (0, 0, (1 - poisson) / 2)])
    within = strains[:, None, :3] + places[:, None] * strains[:, None, 3:6] - layers[..., :3]
    stored = stored + quadratic(within, plane)
    if kinematic:
        one, two, shear = np.moveaxis(layers[..., 3:6], -1, 0)
        stored = stored + 3 / (4 * kinematic) * (np.stack(((one + two) ** 2, (two - one) ** 2, 2 * shear**2), -1) / 2
                                                 @ SHAPE)
    return stored @ weights + quadratic(strains[:, 6:], elastic[6:, 6:]), dissipated @ weights


def quadratic(values: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Half the product of values (..., n) with themselves by a matrix."""
    return np.einsum("...i,ij,...j->...", values, matrix, values) / 2

"""J2 plasticity at a point: return mapping in plane stress and along one axis, with consistent moduli.

Linear isotropic and kinematic hardening. The moduli are the derivatives of the stresses that the mapping returns, and
where a stress lies on the yield surface already those of loading, so that the state of a converged step answers with
the tangent of the comparison solid (Hill 1958).
"""

from __future__ import annotations

import numba
import numpy as np

ON_SURFACE = 1e-10  # distance from the yield surface, over its size, that is rounding
MOST, EXACT = 50, 1e-14  # iterations for the plastic multiplier, and their relative error
LEAST = 1e-6  # modulus of a fibre that flows perfectly, over Young's
REMEMBERED = 7  # plastic strains (e11, e22, 2 e12), back stress (11, 22, 12), equivalent plastic strain


@numba.njit(cache=True)
def plane_stress(strain, history, modulus, poisson, strength, isotropic, kinematic, stress, moduli, after):
    """Stress, moduli and history by radial return in the eigenvectors of elasticity and of von Mises's norm.

    Simo and Taylor (1986); Simo and Hughes (1998, box 3.3). With the multiplier g, backward Euler divides the
    components of the relative stress by 1 + g (c p + 2 H / 3), c and p being the eigenvalues, and g is the root of an
    increasing concave function.

    Parameters
    ----------
    strain : (e11, e22, 2 e12)
    history : REMEMBERED values
    isotropic, kinematic : hardening, increase of the yield stress and of the back stress by plastic strain, of one axis
    stress, moduli, after : filled here, shapes (3,), (3, 3), (REMEMBERED,)

    Returns
    -------
    whether the point flows
    """
    root = np.sqrt(0.5)
    c = np.array((modulus / (1 - poisson), modulus / (1 + poisson), modulus / (1 + poisson) / 2))
    p = np.array((1 / 3, 1.0, 2.0))
    back = 2 / 3 * kinematic
    e0, e1, e2 = strain[0] - history[0], strain[1] - history[1], strain[2] - history[2]
    elastic = np.array((root * (e0 + e1), root * (e1 - e0), e2))
    shift = np.array((root * (history[3] + history[4]), root * (history[4] - history[3]), history[5]))
    trial = c * elastic - shift
    size = np.sqrt(2 / 3) * (strength + isotropic * history[6])
    norm = np.sqrt(np.sum(p * trial * trial))
    after[:] = history
    flows = norm > size * (1 - ON_SURFACE)
    multiplier = 0.0
    along = np.zeros(3)
    spread = np.ones(3)
    share = 0.0
    relative = trial.copy()
    if flows:
        rate = c * p + back
        for _ in range(MOST):
            relative = trial / (1 + multiplier * rate)
            norm = np.sqrt(np.sum(p * relative * relative))
            slope = np.sum(p * relative * relative * rate / (1 + multiplier * rate)) / norm**3
            change = ((1 - 2 / 3 * isotropic * multiplier) / size - 1 / norm) / (slope + 2 / 3 * isotropic / size)
            multiplier = max(0.0, multiplier + change)
            if abs(change) <= EXACT * multiplier or multiplier == 0.0:
                break
        spread = 1 + multiplier * rate
        relative = trial / spread
        norm2 = np.sum(p * relative * relative)
        along = p * relative * c / spread
        share = 1 / (2 / 3 * isotropic * norm2 / (1 - 2 / 3 * isotropic * multiplier)
                     + np.sum(p * relative * relative * rate / spread))
        flow = multiplier * p * relative
        after[0] += root * (flow[0] - flow[1])
        after[1] += root * (flow[0] + flow[1])
        after[2] += flow[2]
        shift = shift + multiplier * back * relative
        after[3], after[4], after[5] = root * (shift[0] - shift[1]), root * (shift[0] + shift[1]), shift[2]
        after[6] += multiplier * np.sqrt(2 / 3 * norm2)
    total = relative + shift
    stress[0], stress[1], stress[2] = root * (total[0] - total[1]), root * (total[0] + total[1]), total[2]
    own = c * (1 + multiplier * back) / spread
    for i in range(3):
        for j in range(3):
            left, right = own[0] * 0.5, own[1] * 0.5
            value = 0.0
            if i < 2 and j < 2:
                value = left + right if i == j else left - right
            elif i == j:
                value = own[2]
            moduli[i, j] = value
    n = np.array((root * (along[0] - along[1]), root * (along[0] + along[1]), along[2]))
    for i in range(3):
        for j in range(3):
            moduli[i, j] -= share * n[i] * n[j]
    return flows


@numba.njit(cache=True)
def one_axis(strain, plastic, back, hardened, modulus, strength, isotropic, kinematic):
    """Stress, modulus, plastic strain, back stress and equivalent plastic strain of a fibre.

    Simo and Hughes (1998, box 1.5). Softening ends where the yield stress is zero. The modulus of perfect flow is LEAST
    instead of zero: a section of which all fibres flow would have none, though half of them resist when its axis moves.
    Stresses are not changed by it.
    """
    trial = modulus * (strain - plastic) - back
    size = strength + isotropic * hardened
    if size <= ON_SURFACE * strength:
        size, isotropic = 0.0, 0.0
    excess = abs(trial) - size
    if size > 0 and excess <= -ON_SURFACE * size:
        return trial + back, modulus, plastic, back, hardened
    sign = 1.0 if trial > 0 else -1.0
    excess = max(excess, 0.0)
    flow = excess / (modulus + isotropic + kinematic)
    if size + isotropic * flow < 0:
        isotropic = 0.0
        flow = abs(trial) / (modulus + kinematic)
    tangent = modulus * (isotropic + kinematic) / (modulus + isotropic + kinematic)
    if 0 <= tangent < LEAST * modulus:
        tangent = LEAST * modulus
    return (trial - sign * modulus * flow + back, tangent, plastic + sign * flow, back + sign * kinematic * flow,
            hardened + flow)

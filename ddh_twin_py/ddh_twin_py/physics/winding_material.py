"""Conductivity of a wound slot across its wires, as a two-phase material."""

from __future__ import annotations


def hashin_shtrikman(matrix: float, inclusion: float, share: float) -> float:
    """Conductivity across parallel round fibres of volume share `share` in a matrix, W/(m*K).

    k = k_m ((1 + f) k_i + (1 - f) k_m) / ((1 - f) k_i + (1 + f) k_m), k_m ``matrix``, k_i ``inclusion``, f ``share``.
    Hashin and Shtrikman, J. Appl. Phys. 33 (1962) 3125, in two dimensions; the lower bound where the
    fibres conduct better than the matrix. Holds at any share that round wires reach (below 0.9); Simpson et al.
    (IEEE PEDES 2012) found it within the scatter of measured windings.
    """
    return matrix * ((1.0 + share) * inclusion + (1.0 - share) * matrix) / (
        (1.0 - share) * inclusion + (1.0 + share) * matrix
    )


def potting(varnish: float, air: float, impregnation: float) -> float:
    """Conductivity of what lies between the wires: voids of air (share 1 - impregnation) in varnish, W/(m*K)."""
    return hashin_shtrikman(varnish, air, 1.0 - impregnation)


def wound_slot(copper: float, varnish: float, air: float, copper_share: float, impregnation: float) -> float:
    """Conductivity of the winding across its wires, W/(m*K): copper fibres, `copper_share`, in `potting`; conductivities in W/(m*K)."""
    return hashin_shtrikman(potting(varnish, air, impregnation), copper, copper_share)

"""What follows from a machine's dimensions without any temperature: areas, flux, resistance, masses, losses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import pi

from ddh_twin_py.rig.machine import Machine

MU_0 = 4e-7 * pi
"""V*s/(A*m)"""


@dataclass(frozen=True)
class Design:
    """Sizes and magnetic state of a machine, SI.

    Attributes:
        slot_area: between the iron, without the tooth tips, of one slot. winding_area: without the liner.
        copper_area: bare copper in one slot. wire_area: of one conductor.
        pitch_angle: of one slot, rad. yoke_height. slot_mid_radius.
        end_turn_length: wire outside of the core at one end of one coil side. mean_turn_length.
        gap_flux_density, tooth_flux_density, yoke_flux_density: T, no load.
        flux_per_pole: of the fundamental, Wb. winding_factor: with a skew of one slot.
        voltage_constant: V rms line to line per 1/min.
        resistance_20C: of one phase, ohm. end_share: of the copper loss at even temperature.
        tooth_mass, yoke_mass, copper_mass, magnet_mass, core_mass (rotor's, with shaft), housing_mass, flange_mass: kg.
        friction_coulomb: N*m. friction_viscous: N*m*s.
    """

    slot_area: float
    winding_area: float
    copper_area: float
    wire_area: float
    pitch_angle: float
    yoke_height: float
    slot_mid_radius: float
    end_turn_length: float
    mean_turn_length: float
    gap_flux_density: float
    tooth_flux_density: float
    yoke_flux_density: float
    flux_per_pole: float
    winding_factor: float
    voltage_constant: float
    resistance_20C: float
    end_share: float
    tooth_mass: float
    yoke_mass: float
    copper_mass: float
    magnet_mass: float
    core_mass: float
    housing_mass: float
    flange_mass: float
    friction_coulomb: float
    friction_viscous: float


def winding_factor(slots: int, pole_pairs: int) -> float:
    """Fundamental winding factor of a three-phase winding of full pitch, skewed by one slot.

    k_d k_p k_s with k_d = sin(pi/6)/(n sin(pi/6n)), n the numerator of slots per pole and phase; coils
    span the whole slots of a pole, k_p = sin(pi/2 span/pole pitch); k_s = sin(g/2)/(g/2), g the slot's electrical angle.
    ``slots`` of the stator, ``pole_pairs`` of the rotor, both whole numbers. Pyrhonen et al., Design of Rotating Electrical Machines.
    """
    per_pole = slots / (2.0 * pole_pairs)
    n = slots // math.gcd(slots, 6 * pole_pairs)
    span = max(1, int(per_pole))
    electrical = pi / per_pole
    return (
        math.sin(pi / 6.0) / (n * math.sin(pi / (6.0 * n)))
        * math.sin(0.5 * pi * min(span / per_pole, 1.0))
        * math.sin(0.5 * electrical) / (0.5 * electrical)
    )


def carter_factor(pitch: float, opening: float, gap: float) -> float:
    """By how much slots lengthen the magnetic gap (Carter): t/(t - (b/g)^2/(5 + b/g) g), ``pitch`` t, ``opening`` b, ``gap`` g in m."""
    ratio = opening / gap
    return pitch / (pitch - ratio**2 / (5.0 + ratio) * gap)


def design(m: Machine, pole_pairs: float) -> Design:
    """Sizes, flux densities, resistance, masses and friction of a machine with that many ``pole_pairs``.

    Gap: B = B_r h/(k_C (g + h)), h = h_m/mu_r; tooth: B t_s/(b_t k_fe); yoke: half a pole's flux over h_y L k_fe.
    Turns, resistance: paper, eq. 1 and 2 with the end turns' length in place of the end region's factor.
    Friction of both bearings: 0.5 mu P d and rubbing seals; M = f_0 1e-7 (nu n)^(2/3) d_m^3 N*mm (Palmgren; d_m in mm, nu in
    cSt, n in 1/min, nu n from 2000, below it 160 for the power), M over the reference speed taken as the viscous coefficient.
    """
    slots, length = int(m["stator.slots"]), m["stator.stack_length"]
    pole_pairs = int(pole_pairs)
    inner, depth, tip, tooth = 0.5 * m["stator.bore"], m["stator.slot_depth"], m["stator.tooth_tip_height"], m["stator.tooth_width"]
    outer, stacking = 0.5 * m["stator.outer_diameter"], m["stator.stacking_factor"]
    angle = 2.0 * pi / slots
    below, above = inner + tip, inner + depth
    slot_area = 0.5 * angle * (above**2 - below**2) - tooth * (above - below)
    liner = m["winding.liner_thickness"]
    winding_area = sum(winding_widths(m, 64)) * 2.0 * (above - below - 2.0 * liner) / 64
    copper_area = m["winding.fill"] * slot_area
    conductors = 6.0 * m["winding.turns_per_phase"] / slots
    wire = copper_area / conductors
    middle = 0.5 * (below + above)
    span = max(1, int(slots / (2 * pole_pairs))) * angle * middle
    end_turn = m["winding.end_turn_factor"] * span + m["winding.end_turn_straight"]
    turn = 2.0 * (length + end_turn)
    resistance = m["materials.copper_resistivity_20C"] * m["winding.turns_per_phase"] * turn / wire

    gap, magnet = m["rotor.air_gap"], m["rotor.magnet_thickness"]
    pitch = angle * inner
    thin = magnet / m["rotor.recoil_permeability"]
    k_c = carter_factor(pitch, m["stator.slot_opening"], gap + thin)
    b_gap = m["rotor.remanence"] * thin / (k_c * (gap + thin))
    pole = pi * (inner - 0.5 * gap) / pole_pairs
    yoke = outer - above
    b_tooth = b_gap * pitch / (tooth * stacking)
    b_yoke = 0.5 * b_gap * m["rotor.magnet_arc"] * pole / (yoke * stacking)
    fundamental = 4.0 / pi * b_gap * math.sin(0.5 * pi * m["rotor.magnet_arc"])
    flux = 2.0 / pi * fundamental * pole * length
    factor = winding_factor(slots, pole_pairs)
    voltage = math.sqrt(3.0) * math.sqrt(2.0) * pi * pole_pairs / 60.0 * m["winding.turns_per_phase"] * factor * flux

    iron = m["materials.core_density"] * stacking * length
    shoe = pitch - m["stator.slot_opening"]
    rotor = inner - gap
    core = rotor - magnet
    shaft = 0.25 * pi * m["rotor.shaft_diameter"] ** 2 * m["rotor.shaft_length"]
    aluminium = m["materials.housing_density"]
    d_mean = 500.0 * (m["bearings.bore"] + m["bearings.outer_diameter"])  # mm
    rpm = max(m["reference.speed"], 1.0)
    product = 1e6 * m["bearings.grease_viscosity"] * rpm
    drag = m["bearings.grease_factor"] * d_mean**3 * (1e-7 * product ** (2.0 / 3.0) if product >= 2000.0 else 160e-7) * 1e-3
    return Design(
        slot_area=slot_area, winding_area=winding_area, copper_area=copper_area, wire_area=wire, pitch_angle=angle,
        yoke_height=yoke, slot_mid_radius=middle, end_turn_length=end_turn, mean_turn_length=turn,
        gap_flux_density=b_gap, tooth_flux_density=b_tooth, yoke_flux_density=b_yoke, flux_per_pole=flux,
        winding_factor=factor, voltage_constant=voltage, resistance_20C=resistance, end_share=end_turn / (length + end_turn),
        tooth_mass=iron * slots * (tooth * (depth - tip) + shoe * tip),
        yoke_mass=iron * pi * (outer**2 - above**2),
        copper_mass=m["materials.copper_density"] * copper_area * slots * (length + end_turn),
        magnet_mass=m["materials.magnet_density"] * m["rotor.magnet_arc"] * pi * (rotor**2 - core**2) * length,
        core_mass=m["materials.steel_density"] * (pi * core**2 * length + shaft),
        housing_mass=aluminium * housing_volume(m),
        flange_mass=aluminium * m["flange.thickness"] * (
            m["flange.side"] ** 2 - 0.25 * pi * m["bearings.outer_diameter"] ** 2
        ),
        friction_coulomb=2.0 * (
            0.5 * m["bearings.load_friction"] * m["bearings.preload"] * m["bearings.bore"] + m["bearings.seal_torque"]
        ),
        friction_viscous=2.0 * drag / (rpm * pi / 30.0),
    )


def winding_widths(m: Machine, rows: int) -> list[float]:
    """Half width of the winding, liner taken off, at the middle of each of `rows` rows from the tip outwards, m."""
    liner = m["winding.liner_thickness"]
    low = 0.5 * m["stator.bore"] + m["stator.tooth_tip_height"] + liner
    high = 0.5 * m["stator.bore"] + m["stator.slot_depth"] - liner
    step = (high - low) / rows
    return [
        pi * (low + (i + 0.5) * step) / m["stator.slots"] - 0.5 * m["stator.tooth_width"] - liner for i in range(rows)
    ]


def body_section(m: Machine) -> float:
    """Aluminium in a cut through the body, m2."""
    flats, chamfer = m["housing.across_flats"], m["housing.corner_chamfer"]
    ribs = m["housing.rib_count"] * m["housing.rib_height"] * m["housing.rib_width"]
    return flats**2 - 2.0 * chamfer**2 - 0.25 * pi * m["stator.outer_diameter"] ** 2 + ribs


def housing_volume(m: Machine) -> float:
    """Aluminium of body, rear shield and rear cover, m3."""
    shield = m["housing.across_flats"] ** 2 - 2.0 * m["housing.corner_chamfer"] ** 2
    shield -= 0.25 * pi * m["bearings.outer_diameter"] ** 2
    diameter, wall = m["housing.rear_cover_diameter"], m["housing.rear_cover_wall"]
    cover = wall * (pi * diameter * m["housing.rear_cover_length"] + 0.25 * pi * diameter**2)
    return body_section(m) * m["housing.body_length"] + shield * m["housing.shield_thickness"] + cover


def body_perimeters(m: Machine) -> tuple[float, float]:
    """Circumference of the body along its ribs, and of the hull around them, m."""
    chamfer = m["housing.corner_chamfer"] * (4.0 * math.sqrt(2.0) - 8.0)
    flats, height = m["housing.across_flats"], m["housing.rib_height"]
    ribs = m["housing.rib_count"] * 2.0 * height
    hull = 4.0 * (flats + (2.0 * height if ribs else 0.0)) + chamfer
    return 4.0 * flats + chamfer + ribs, hull


def housing_areas(m: Machine) -> tuple[float, float]:
    """Surface of the housing that air touches, and that of its hull, which radiates, m2; the flange left out."""
    along, hull = body_perimeters(m)
    length = m["housing.body_length"]
    rear = m["housing.across_flats"] ** 2 - 2.0 * m["housing.corner_chamfer"] ** 2
    rear += pi * m["housing.rear_cover_diameter"] * m["housing.rear_cover_length"]
    return along * length + rear, hull * length + rear

"""The mesh of one slot: cells of winding, tooth and yoke, and what conducts between them.

By symmetry half a slot pitch and half the stack stand for the machine (4 x slots of them); every
number here is already that of the whole machine. Rows run outwards (tip, slot, yoke), columns from
the middle of the slot to the middle of the tooth, planes from the middle of the stack to its end.
A face conducts by its two half cells and what lies between them in series (the paper's eq. 4 read
as a resistance, l/(k A)).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

import numpy as np

from ddh_twin_py.physics.machine_design import Design, winding_widths
from ddh_twin_py.physics.surface_heat import air
from ddh_twin_py.physics.winding_material import wound_slot
from ddh_twin_py.rig.machine import Machine

WINDING, TEETH, YOKE = "slot_winding", "teeth", "yoke"


@dataclass
class SlotMesh:
    """Cells and faces of one slot, times its number in the machine.

    Attributes:
        region: of each cell, `WINDING`, `TEETH` or `YOKE`, (n,).
        capacity: J/K, (n,). volume: m3 of the region's material, (n,). copper: m2 of copper cut by a plane, (n,).
        place: middle of each cell: radius, angular distance from the slot's middle as a length, distance from the
            middle of the stack, m, (n, 3).
        corners: of each cell in the cut, (n, 4, 2): radius and length across, m, for a picture.
        faces: pairs of cells and the conductance between them, W/K.
        to_housing, to_gap: (cell, conductance W/K up to the interface's outer side; area m2 at the gap).
        end_faces: (cell, m2) of iron that looks into the end space.
        end_plane: (cell, m2 of copper, half length m) of the winding where it leaves the core.
    """

    region: list[str] = field(default_factory=list)
    capacity: list[float] = field(default_factory=list)
    volume: list[float] = field(default_factory=list)
    copper: list[float] = field(default_factory=list)
    place: list[tuple[float, float, float]] = field(default_factory=list)
    corners: list[np.ndarray] = field(default_factory=list)
    faces: list[tuple[int, int, float]] = field(default_factory=list)
    to_housing: list[tuple[int, float]] = field(default_factory=list)
    to_gap: list[tuple[int, float]] = field(default_factory=list)
    end_faces: list[tuple[int, float]] = field(default_factory=list)
    end_plane: list[tuple[int, float, float]] = field(default_factory=list)

    def add(self, region: str, capacity: float, volume: float, copper: float, place, corners) -> int:
        """Append a cell of a region: J/K, m3, m2 of copper, place (3,) and corners (4, 2), m; returns its number."""
        self.region.append(region)
        self.capacity.append(capacity)
        self.volume.append(volume)
        self.copper.append(copper)
        self.place.append(place)
        self.corners.append(np.asarray(corners))
        return len(self.region) - 1


@dataclass(frozen=True)
class Divisions:
    """How fine: winding layers, columns across half a slot, tooth columns, yoke rows, planes, end-turn cells."""

    layers: int
    columns: int
    tooth_columns: int
    yoke_rows: int
    planes: int
    end_cells: int


def divisions(layers: int) -> Divisions:
    """All divisions in proportion to the layers of the slot."""
    half, quarter = max(2, (layers + 1) // 2), max(1, (layers + 2) // 4)
    return Divisions(layers, half, quarter, max(2, quarter), half, half)


def winding_conductivity(m: Machine, d: Design, temperature: float) -> tuple[float, float]:
    """Of the winding across its wires and along them, W/(m*K), voids at a ``temperature`` in K; see `winding_material`."""
    share = d.copper_area / d.winding_area
    across = wound_slot(
        m["materials.copper_conductivity"], m["materials.varnish_conductivity"], air(temperature).conductivity, share,
        m["winding.impregnation"],
    )
    return across, m["materials.copper_conductivity"] * share


def winding_heat(m: Machine, d: Design) -> tuple[float, float]:
    """Volumetric heat of winding (copper, varnish, voids), J/(m3*K), and the liner's of one metre of slot, J/(m*K)."""
    share = d.copper_area / d.winding_area
    copper = m["materials.copper_density"] * m["materials.copper_heat"]
    varnish = m["materials.varnish_density"] * m["materials.varnish_heat"]
    liner = (d.slot_area - d.winding_area) * varnish
    return share * copper + (1.0 - share) * m["winding.impregnation"] * varnish, liner


def slot_mesh(m: Machine, d: Design, layers: int, temperature: float) -> SlotMesh:
    """Mesh of one slot; interface gaps conduct as air at `temperature`, K.

    Args:
        layers: of the winding along the radius, 1 or more; everything else is refined in proportion.

    Raises:
        ValueError: fewer than one layer.
    """
    if layers < 1:
        raise ValueError(f"layers is {layers}, 1 or more are needed")
    n = divisions(layers)
    mesh = SlotMesh()
    many = 4.0 * m["stator.slots"]
    step_z = 0.5 * m["stator.stack_length"] / n.planes
    stacking = m["stator.stacking_factor"]
    k_iron, k_axial = m["materials.core_conductivity"] * stacking, m["materials.core_conductivity_axial"]
    iron_heat = m["materials.core_density"] * m["materials.core_heat"] * stacking
    k_wind, k_along = winding_conductivity(m, d, temperature)
    wind_heat, liner_heat = winding_heat(m, d)
    gas = air(temperature).conductivity
    liner = m["winding.liner_thickness"] / m["materials.liner_conductivity"] + m["winding.liner_contact_gap"] / gas

    bore = 0.5 * m["stator.bore"]
    below, above = bore + m["stator.tooth_tip_height"], bore + m["stator.slot_depth"]
    outer = 0.5 * m["stator.outer_diameter"]
    thick = m["winding.liner_thickness"]
    step_w = (above - below - 2.0 * thick) / n.layers
    step_t, step_y, tip = (above - below) / n.layers, d.yoke_height / n.yoke_rows, below - bore
    widths = winding_widths(m, n.layers)
    tooth = 0.5 * m["stator.tooth_width"] / n.tooth_columns
    shoe = 0.5 * (d.pitch_angle * bore - m["stator.slot_opening"]) / n.tooth_columns
    angle_slot = (0.5 * d.pitch_angle * above - 0.5 * m["stator.tooth_width"]) / above
    angles = [angle_slot / n.columns] * n.columns + [(0.5 * d.pitch_angle - angle_slot) / n.tooth_columns] * n.tooth_columns
    share = d.copper_area / d.winding_area
    liner_share = liner_heat / (wind_heat * d.winding_area)

    def face(a: int, b: int, area: float, resistance: float) -> None:
        mesh.faces.append((a, b, many * area / resistance))

    planes: list[dict[tuple[str, int, int], int]] = []
    for k in range(n.planes):
        z = (k + 0.5) * step_z
        cell: dict[tuple[str, int, int], int] = {}

        def box(r0, r1, x0, x1):  # lower and upper radius, left and right
            return np.array([[r0, x0], [r0, x1], [r1, x1], [r1, x0]])

        def put(key, region, area, heat, copper, r, x, corners, cell=cell, z=z):
            volume = many * area * step_z
            cell[key] = mesh.add(region, volume * heat, volume, many * copper, (r, x, z), corners)

        for j in range(n.tooth_columns):
            x = 0.5 * m["stator.slot_opening"] + (j + 0.5) * shoe
            corners = box(bore, below, x - shoe / 2, x + shoe / 2)
            put(("tip", 0, j), TEETH, shoe * tip, iron_heat, 0.0, bore + 0.5 * tip, x, corners)
        for i in range(n.layers):
            r_w, r_t = below + thick + (i + 0.5) * step_w, below + (i + 0.5) * step_t
            for j in range(n.columns):
                w = widths[i] / n.columns
                corners = box(r_w - step_w / 2, r_w + step_w / 2, j * w, (j + 1) * w)
                put(
                    ("wind", i, j), WINDING, w * step_w, wind_heat * (1.0 + liner_share), share * w * step_w, r_w,
                    (j + 0.5) * w, corners,
                )
            for j in range(n.tooth_columns):
                x = 0.5 * d.pitch_angle * r_t - 0.5 * m["stator.tooth_width"] + (j + 0.5) * tooth
                corners = box(r_t - step_t / 2, r_t + step_t / 2, x - tooth / 2, x + tooth / 2)
                put(("tooth", i, j), TEETH, tooth * step_t, iron_heat, 0.0, r_t, x, corners)
        for i in range(n.yoke_rows):
            r = above + (i + 0.5) * step_y
            start = 0.0
            for j, angle in enumerate(angles):
                a, b, r0, r1 = start, start + angle, r - step_y / 2, r + step_y / 2
                put(
                    ("yoke", i, j), YOKE, angle * r * step_y, iron_heat, 0.0, r, 0.5 * (a + b) * r,
                    np.array([[r0, a * r0], [r0, b * r0], [r1, b * r1], [r1, a * r1]]),
                )
                start = b
        _faces_of_plane(cell, face, m, n, (k_iron, k_wind), liner, (step_w, step_t, step_y, tip), widths, tooth, shoe, angles,
                        above, step_z)
        for j, angle in enumerate(angles):
            area = angle * outer * step_z
            wall = 0.25 * (m["housing.across_flats"] - 2.0 * outer) / m["materials.housing_conductivity"]
            through = 0.5 * step_y / k_iron + m["housing.interface_gap"] / gas + wall
            mesh.to_housing.append((cell["yoke", n.yoke_rows - 1, j], many * area / through))
        for j in range(n.tooth_columns):
            mesh.to_gap.append((cell["tip", 0, j], many * pi * bore / m["stator.slots"] / n.tooth_columns * step_z))
        if planes:
            for key, index in cell.items():
                area = mesh.volume[index] / step_z
                along = k_along if key[0] == "wind" else k_axial
                mesh.faces.append((planes[-1][key], index, along * area / step_z))
        planes.append(cell)
    for key, index in planes[-1].items():
        if key[0] == "wind":
            mesh.end_plane.append((index, mesh.copper[index], 0.5 * step_z))
        else:
            mesh.end_faces.append((index, mesh.volume[index] / step_z))
    return mesh


def _faces_of_plane(cell, face, m, n, conductivities, liner, steps, widths, tooth, shoe, angles, above, step_z) -> None:
    """Faces within one plane: inside the winding, winding to iron through the liner, inside the iron."""
    k_iron, k_wind = conductivities
    step_w, step_t, step_y, tip = steps
    for i in range(n.layers):
        w = widths[i] / n.columns
        for j in range(n.columns - 1):
            face(cell["wind", i, j], cell["wind", i, j + 1], step_w * step_z, w / k_wind)
        side = 0.5 * w / k_wind + liner + 0.5 * tooth / k_iron
        face(cell["wind", i, n.columns - 1], cell["tooth", i, 0], step_w * step_z, side)
        for j in range(n.tooth_columns - 1):
            face(cell["tooth", i, j], cell["tooth", i, j + 1], step_t * step_z, tooth / k_iron)
        if i + 1 < n.layers:
            middle = 0.5 * (widths[i] + widths[i + 1]) / n.columns
            for j in range(n.columns):
                face(cell["wind", i, j], cell["wind", i + 1, j], middle * step_z, step_w / k_wind)
            for j in range(n.tooth_columns):
                face(cell["tooth", i, j], cell["tooth", i + 1, j], tooth * step_z, step_t / k_iron)
    overhang = 0.5 * m["stator.slot_opening"]
    w = widths[0] / n.columns
    for j in range(n.columns):  # winding on the tooth's shoe
        area = max(0.0, (j + 1) * w - max(j * w, overhang)) * step_z
        if area > 0.0:
            face(cell["wind", 0, j], cell["tip", 0, 0], area, 0.5 * step_w / k_wind + liner + 0.5 * tip / k_iron)
    for j in range(n.tooth_columns):
        if j + 1 < n.tooth_columns:
            face(cell["tip", 0, j], cell["tip", 0, j + 1], tip * step_z, shoe / k_iron)
        face(cell["tip", 0, j], cell["tooth", 0, j], tooth * step_z, 0.5 * (tip + step_t) / k_iron)
        root = cell["yoke", 0, n.columns + j]
        face(cell["tooth", n.layers - 1, j], root, tooth * step_z, 0.5 * (step_t + step_y) / k_iron)
    for j in range(n.columns):
        area = widths[-1] / n.columns * step_z
        face(cell["wind", n.layers - 1, j], cell["yoke", 0, j], area, 0.5 * step_w / k_wind + liner + 0.5 * step_y / k_iron)
    for i in range(n.yoke_rows):
        r = above + (i + 0.5) * step_y
        for j in range(len(angles) - 1):
            face(cell["yoke", i, j], cell["yoke", i, j + 1], step_y * step_z, 0.5 * (angles[j] + angles[j + 1]) * r / k_iron)
        if i + 1 < n.yoke_rows:
            for j, angle in enumerate(angles):
                face(cell["yoke", i, j], cell["yoke", i + 1, j], angle * (r + 0.5 * step_y) * step_z, step_y / k_iron)

"""What the symbols of the catalogue's laws mean."""

from __future__ import annotations

import re

SYMBOLS = {
    "A": "area", "A_A": "piston area", "A_B": "ring area", "A_i": "area of a part", "C": "convection coefficient", "F": "force",
    "F_c": "Coulomb friction", "F_f": "friction force", "G": "conductance", "G_0": "conductance of the sheet", "K": "bulk modulus",
    "K_liquid": "bulk modulus without air", "K_t": "torque constant", "K_t0": "torque constant of the sheet",
    "L_1": "leakage coefficient of pump 1", "L_2": "leakage coefficient of pump 2", "P": "power", "P_cu": "copper loss",
    "P_fe": "iron loss", "Q": "flow", "Q_B": "flow of the rod side", "Q_leak": "leakage flow", "R_20": "phase resistance at 20 °C",
    "S": "quadratic coefficient", "T_a": "temperature of the air", "T_added": "added torque", "T_ambient": "ambient temperature",
    "T_housing": "temperature of the motor's housing", "T_pump_1_case": "temperature of the case of pump 1", "T_read": "temperature read",
    "T_rotor": "rotor temperature", "T_wall": "temperature of the tank's wall", "V": "oil volume", "V_B": "volume of the rod side",
    "alpha": "temperature coefficient of copper", "b": "viscous friction", "c": "heat capacity", "dp": "pressure difference",
    "dp_B": "change of the rod side's pressure", "delay": "delay of the hydraulic stamps", "f": "electrical frequency",
    "f_500": "frequency at 500 rpm", "g": "gravity", "i": "current", "i_read": "current read", "k": "friction by pressure", "m": "mass",
    "mu": "viscosity", "mu_0": "viscosity at 23 °C", "n": "exponent", "nu": "kinematic viscosity in mm²/s", "offset": "zero error",
    "omega": "shaft speed", "p": "pressure", "p_0": "ambient pressure", "p_1": "pressure at pump 1", "p_2": "pressure at pump 2",
    "p_A": "piston-side pressure", "p_B": "rod-side pressure", "p_crack": "cracking pressure", "p_open": "opening pressure",
    "p_read": "pressure read", "phi": "volume share of air", "q": "heat flow", "q_i": "heat into a part",
    "r": "ratio to the rig as built, or to its sheet", "r_s": "static over Coulomb friction", "rho": "density", "s": "slope",
    "stroke": "full stroke", "t": "time", "t_stamp": "stamp",
    "tau": "time constant", "v": "rod velocity", "v_s": "Stribeck velocity", "w": "speed", "w_command": "commanded speed",
    "x": "rod position", "x_read": "rod position read",
}
"""Symbol to meaning, the same in every law but for those of `_OWN`."""
_OWN = {  # where a letter means something else: beginning of the law, symbol, meaning
    ("T = T_added", "T"): "torque", ("log10 log10", "A"): "first constant of the oil", ("log10 log10", "B"): "slope over temperature",
    ("dp_B/dt", "C"): "volume expansion of the line", ("i_read", "g"): "gain", ("p_read = g", "g"): "gain", ("x_read", "g"): "gain",
    ("C = rho", "C"): "heat capacity of the oil", ("q = G", "q"): "heat flow", ("T_read = (1 - f)", "f"): "share of ambient",
}
_PLAIN = {"T": "temperature"}
_NAME = re.compile(r"[A-Za-z]\w*")
_WORDS = {"max", "sign", "exp", "log10", "sum", "between", "pump", "port", "and", "cylinder", "to", "tank", "viscosity", "at", "degC",
          "kept", "heat", "into", "the", "case", "rotor", "housing", "teeth", "yoke", "all", "times", "rpm"}


def legend(law: str) -> str:
    """The law's symbols with their meanings, in the order in which they occur; those without one are left out."""
    meant = {}
    for name in _NAME.findall(law):
        symbol = name
        if symbol in _WORDS:
            continue
        if symbol not in SYMBOLS and symbol.startswith("d") and symbol[1:] in {**SYMBOLS, **_PLAIN}:
            symbol = symbol[1:]  # a derivative or a difference
        own = next((said for (begin, letter), said in _OWN.items() if letter == symbol and law.startswith(begin)), "")
        said = own or SYMBOLS.get(symbol) or _PLAIN.get(symbol)
        if said:
            meant[symbol] = said
    return ", ".join(f"{symbol}: {said}" for symbol, said in meant.items())

"""The one model of the unit: oil, pumps, cylinder, valves, motor and thermal network, compiled."""

"""Truths and gap reports made by hand."""


def truth(name="case_0001", suite="single", level="clear", effects=("pump_1.leakage",), commissioning=True, listed=True):
    expected = {"none": "no_gap", "tolerance": "no_gap", "left_out": "unknown", "outside": "unknown"}.get(suite, "explained")
    return {
        "name": name, "suite": suite, "level": level, "expected": expected, "commissioning": commissioning,
        "effects": [{"effect": e, "listed": listed, "component": e.split(".")[0], "parameter": "ratio", "value": 1.5, "nominal": 1.0}
                    for e in effects],
    }


def report(verdict="explained", why=(), classes=(), hypotheses=None, where="pump_1", closed=0.9, unknown=None, value=1.4, std=0.1):
    return {
        "verdict": verdict, "gap": {"as_is": 3.0, "before": 3.0, "after": 1.1, "closed_fraction": closed},
        "where": [{"component": where}] if where else [],
        "why": [{"effect": e, "probability": p, "parameters": {"ratio": {"value": value, "std": std}}} for e, p in why],
        "classes": [list(c) for c in classes],
        "hypotheses": hypotheses or [{"effects": [why[0][0]] if why else [], "probability": 0.9, "gap_after": 1.1}],
        "unknown": unknown, "checks": [{"effects": [], "check": "drifted", "measured": 0.5, "limit": 8.0}],
    }


def result(given):
    return {"report": given, "seconds": 2.0, "megabytes": 300.0}

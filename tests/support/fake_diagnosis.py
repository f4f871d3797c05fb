"""Stands in for the process of a diagnosis: keeps its protocol, and does what the name of the first bag says.

`slow` goes on until it is stopped, `crash` kills itself, `fault` ends with a traceback, `bad` refuses its input, `full` has no space;
any other name gets a report that tells back what was asked.
"""

import json
import os
import signal
import sys
import threading
import time


def main():
    request = json.loads(sys.stdin.readline())
    threading.Thread(target=lambda: (sys.stdin.read(), os._exit(3)), daemon=True).start()
    name = os.path.basename(request["field"][0])
    if name == "field":
        name = os.path.basename(os.path.dirname(request["field"][0]))
    tell(done=0.25, stage="reading")
    if "slow" in name:
        print("no JSON at all", flush=True)
        while True:
            time.sleep(0.05)
            tell(done=0.5, stage="fitting")
    if "crash" in name:
        os.kill(os.getpid(), signal.SIGKILL)
    if "fault" in name:
        raise RuntimeError("a fault of ours")
    if "full" in name:
        tell(error="/tmp: No space left on device", passing=True)
        return 2
    if "bad" in name:
        tell(error=f"{request['field'][0]}: drive/telemetry:\n no message")
        return 2
    tell(done=1.0, stage="done")
    effect = {"effect": "pump_1.leakage", "probability": 0.9,
              "parameters": {"leakage_ratio": {"value": 2.5, "std": 0.1, "unit": "1", "nominal": 1.0}}}
    report = {"verdict": "explained", "gap": {"as_is": 4.0, "before": 3.0, "after": 1.1, "closed_fraction": 0.95}, "where": [],
              "why": [effect], "hypotheses": [], "classes": [], "shrink": {}, "unknown": None, "next_test": None,
              "held_out": "", "notes": [], "asked": request}
    tell(report=report, sentence="Pump 1 leaks 2.5 times as much.")
    return 0


def tell(**message):
    print(json.dumps(message), flush=True)


if __name__ == "__main__":
    sys.exit(main())

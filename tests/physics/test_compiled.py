"""No change of an equation may meet machine code of the old one."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from ddh_twin_py.physics import compiled

import ddh_twin_py

PACKAGE = Path(ddh_twin_py.__file__).parent


def test_the_cache_asks_every_file_that_holds_a_kernel_wherever_it_stands():
    asked = {path for path, _ in compiled.sources()}
    with_kernels = {path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py")
                    if any(line in ("@kernel", "@inlined") for line in path.read_text().splitlines())}
    own = {path for path in with_kernels if not path.startswith("plant/")}  # the plant has a cache of its own
    assert own <= asked and "estimation/fusion/kalman_kernel.py" in own


@pytest.mark.parametrize("path", ["physics/pump.py", "estimation/fusion/uncertain_parameters.py", "twin/temperature_sensors.py",
                                  "telemetry/clocks/clock.py", "real_rigs/eha/model.py", "rig/ddh_rig.yaml"])
def test_what_a_changed_file_freezes_into_kernels_is_compiled_anew(path, monkeypatch):
    before, sources = compiled.cache_directory(), list(compiled.sources())
    monkeypatch.setattr(compiled, "sources", lambda: [(p, content + b" " * (p == path)) for p, content in sources])
    assert compiled.cache_directory() != before
    assert path in dict(sources)


@pytest.mark.parametrize("room", ["physics", "plant"])
def test_without_a_home_kernels_are_compiled_in_each_process(room):
    alone = ("import pwd\ndef nobody(user): raise KeyError(user)\npwd.getpwuid = nobody\n"
             f"import ddh_twin_py.{room}.compiled\nprint('read')")
    env = {name: value for name, value in os.environ.items() if name not in ("HOME", "NUMBA_CACHE_DIR", "DDH_TWIN_CACHE", "XDG_CACHE_HOME")}
    done = subprocess.run([sys.executable, "-c", alone], env=env, capture_output=True, text=True, check=False)
    assert done.stdout == "read\n", done.stderr

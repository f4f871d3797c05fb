"""Replaces include paths of the machine that built the wheels by those of this environment.

Some CMake files of the ROS wheels name /opt/python/cp3XX-cp3XX/include and the numpy headers
beside it; CMake stops at targets whose include directories do not exist.
"""

import re
import sys
import sysconfig
from pathlib import Path

import numpy

PYTHON = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")
NUMPY = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/_core/include")


def main() -> None:
    include = sysconfig.get_paths()["include"]
    changed = 0
    for path in Path(sys.prefix, "share").glob("*/cmake/**/*.cmake"):
        old = path.read_text(encoding="utf-8")
        new = NUMPY.sub(numpy.get_include(), PYTHON.sub(include, old))
        if new != old:
            path.unlink()  # pip may have linked it from its cache
            path.write_text(new, encoding="utf-8")
            changed += 1
    print(f"include paths replaced in {changed} files")


if __name__ == "__main__":
    main()

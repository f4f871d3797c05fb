#!/usr/bin/env bash
# pytest in the environment that setup.sh made; arguments go to pytest.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"
. .venv/ddh/env.sh
export PATH=$root/.venv/bin:$PATH
# The cores are the workers'; threads of the linear algebra would wait for one another on them, far longer than they compute.
export OPENBLAS_NUM_THREADS=${OPENBLAS_NUM_THREADS:-1}
.venv/bin/python tests/support/compile_kernels.py || echo "tests: kernels could not be compiled beforehand; each worker compiles its own" >&2
# Two workers; tests of one file, and all marked "live", stay on one of them; the order is that of tests/conftest.py.
exec .venv/bin/python -m pytest -q -n 2 --dist loadgroup --no-loadscope-reorder "$@"

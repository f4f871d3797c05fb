"""The lock files pin every package, and the environment holds what they say."""

import ast
import importlib.metadata
import re
import sys

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

VERSIONS = ("py312", "py311")
IN_FILES = ("ros.in", "twin.in", "dev.in")


def locked(text: str) -> dict[str, tuple[str, int]]:
    """Version and number of hashes of each package; anything else in the file is an error."""
    found: dict[str, tuple[str, int]] = {}
    name = None
    for line in text.splitlines():
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if pin := re.fullmatch(r"([A-Za-z0-9._-]+)==([A-Za-z0-9.+!-]+) \\", line):
            name = canonicalize_name(pin.group(1))
            found[name] = (pin.group(2), 0)
        elif name and re.fullmatch(r" {4}--hash=sha256:[0-9a-f]{64}( \\)?", line):
            found[name] = (found[name][0], found[name][1] + 1)
        else:
            raise AssertionError(f"neither a pin nor a hash: {line!r}")
    return found


def asked_for(text: str) -> list[Requirement]:
    lines = (line.partition(" #")[0].strip() for line in text.splitlines() if not line.startswith("#"))
    return [Requirement(line) for line in lines if line]


@pytest.mark.parametrize("version", VERSIONS)
def test_lock_pins_everything(version, repo_root):
    lock = locked((repo_root / f"requirements/lock-{version}.txt").read_text())
    assert all(hashes >= 1 for _, hashes in lock.values())
    for name in IN_FILES:
        for requirement in asked_for((repo_root / "requirements" / name).read_text()):
            pin = lock.get(canonicalize_name(requirement.name))
            assert pin, f"{name}: {requirement.name} is not in lock-{version}.txt; run scripts/lock.sh"
            assert requirement.specifier.contains(pin[0]), f"{requirement} but {pin[0]} in lock-{version}.txt"


@pytest.mark.parametrize("version", VERSIONS)
def test_bench_lock_pins_its_tools_and_agrees_with_the_twins(version, repo_root):
    """The tools of the benchmark are used with the twin's own numpy, scipy and numba."""
    bench = locked((repo_root / f"requirements/lock-bench-{version}.txt").read_text())
    twin = locked((repo_root / f"requirements/lock-{version}.txt").read_text())
    assert all(hashes >= 1 for _, hashes in bench.values())
    for requirement in asked_for((repo_root / "requirements/bench.in").read_text()):
        assert requirement.specifier.contains(bench[canonicalize_name(requirement.name)][0])
        assert canonicalize_name(requirement.name) not in twin
    both = bench.keys() & twin.keys()
    assert {"numpy", "scipy", "numba"} <= both
    assert {name: bench[name][0] for name in both} == {name: twin[name][0] for name in both}


@pytest.mark.parametrize("version", VERSIONS)
def test_tools_lock_pins_everything(version, repo_root):
    lock = locked((repo_root / f"requirements/lock-tools-{version}.txt").read_text())
    assert all(hashes >= 1 for _, hashes in lock.values())
    for requirement in asked_for((repo_root / "requirements/tools.in").read_text()):
        assert requirement.specifier.contains(lock[canonicalize_name(requirement.name)][0])


def test_every_line_of_the_twins_requirements_has_a_reason(repo_root):
    for name in ("twin.in", "dev.in", "bench.in", "tools.in"):
        for line in (repo_root / "requirements" / name).read_text().splitlines():
            assert "# " in line, f"{name}: {line}"


def test_what_is_asked_for_is_what_is_imported(repo_root):
    """Each third-party module that the package imports has its line in twin.in, and the other way round."""
    modules = set()
    for path in (repo_root / "ddh_twin_py/ddh_twin_py").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                modules |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                modules.add(node.module.split(".")[0])
    providers = importlib.metadata.packages_distributions()
    asked = {canonicalize_name(r.name) for r in asked_for((repo_root / "requirements/twin.in").read_text())}
    used = set()
    # "compression" is of the standard library, from Python 3.14 on; who wants a cluster installs what that takes.
    for module in modules - set(sys.stdlib_module_names) - {"ddh_twin_py", "ddh_msgs", "compression", "distributed"}:
        names = {canonicalize_name(name) for name in providers.get(module, ())}
        if not any(name.startswith("ros-") for name in names):
            assert names & asked, f"imported, but not in twin.in: {module} ({names or 'not installed'})"
            used |= names & asked
    assert asked == used, f"in twin.in, but not imported: {asked - used}"


def test_both_locks_hold_the_same_ros(repo_root):
    ros = []
    for version in VERSIONS:
        lock = locked((repo_root / f"requirements/lock-{version}.txt").read_text())
        ros.append({name: pin[0] for name, pin in lock.items() if name.startswith(("ros-", "rosbags", "empy"))})
    assert ros[0] == ros[1]


def test_environment_is_the_lock_and_nothing_is_missing(repo_root):
    """What is installed has the locked version, and what it depends on is locked too."""
    lock = locked((repo_root / f"requirements/lock-py3{sys.version_info.minor}.txt").read_text())
    for name, (version, _) in lock.items():
        distribution = importlib.metadata.distribution(name)
        assert distribution.version == version, name
        for text in distribution.requires or ():
            requirement = Requirement(text)
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                assert canonicalize_name(requirement.name) in lock, f"{name} needs {text}"


@pytest.mark.parametrize("version", VERSIONS)
def test_locks_serve_the_oldest_python(version, repo_root):
    """No pin asks for a later patch version of Python than Debian 12 and Ubuntu 24.04 have; asked is what is installed here."""
    (oldest,) = re.findall(rf"oldest_{version[3:]}=(\S+)", (repo_root / "scripts/lock.sh").read_text())
    pins = set()
    for name in ("lock", "lock-tools"):
        lock = locked((repo_root / f"requirements/{name}-{version}.txt").read_text())
        pins |= {(package, pin[0]) for package, pin in lock.items()}
    tools = [str(path) for path in (repo_root / ".venv/tools/lib").glob("python3*/site-packages")]
    asked = 0
    for distribution in (*importlib.metadata.distributions(), *importlib.metadata.distributions(path=tools)):
        needs = distribution.metadata.get("Requires-Python")
        if needs and (canonicalize_name(distribution.name), distribution.version) in pins:
            asked += 1
            assert SpecifierSet(needs).contains(oldest), f"{distribution.name} needs Python {needs}; run scripts/lock.sh"
    assert asked > 30


def test_no_address_of_an_index(repo_root):
    for path in (repo_root / "requirements").iterdir():
        text = path.read_text()
        assert "://" not in text, path.name
        assert not re.search(r"^\s*--?(i|index|extra-index|find-links|trusted|f)\b", text, re.MULTILINE), path.name

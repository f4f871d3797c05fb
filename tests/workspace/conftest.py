"""What the tests of the container files share."""

import re

import pytest
import yaml

VARIABLE = re.compile(r"\$\{(\w+):-([^}]*)\}")


@pytest.fixture(scope="session")
def compose_variables(repo_root):
    """Variables of the compose file and their defaults."""
    return dict(VARIABLE.findall((repo_root / "docker/docker-compose.yaml").read_text()))


@pytest.fixture(scope="session")
def compose(repo_root):
    """The compose file as docker reads it where no variable is set."""
    return yaml.safe_load(VARIABLE.sub(r"\2", (repo_root / "docker/docker-compose.yaml").read_text()))

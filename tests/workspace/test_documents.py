"""The documents: every command is understood, and run or said why not; outputs are compared; the site builds and asks for nothing."""

import re
import runpy
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
import yaml
from ddh_twin_py.cli.main import build_parser, main

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def documents(repo_root):
    return runpy.run_path(str(repo_root / "scripts/run_documents.py"))


@pytest.fixture(scope="module")
def pages(repo_root):
    found = {path: path.read_text("utf-8") for path in (repo_root / "README.md", *sorted((repo_root / "docs").rglob("*.md")))}
    assert len(found) > 60
    return found


def test_every_command_block_is_run_or_says_why_not(documents, pages):
    missing = []
    count = {"run": 0, "refused": 0, "not run": 0}
    for path, page in pages.items():
        blocks = documents["blocks_of"](page)
        fences = re.findall(r"^[ >]*(?:```|~~~) *(?:bash|sh|shell|console)\b", page, re.M)
        assert len(fences) == sum(block.kind in ("bash", "sh") for block in blocks), f"{path.name}: a block of commands is not seen"
        for block in blocks:
            if block.kind in ("bash", "sh"):
                mark = block.mark.split(":")[0]
                if mark in count:
                    count[mark] += 1
                else:
                    missing.append(f"{path.name}:{block.line}")
    assert not missing, f"put <!-- run -->, <!-- refused: N --> or <!-- not run: WHY --> before: {missing}"
    assert count["run"] >= 10


def commands_of(page: str) -> list[str]:
    """Every whole `ddh-twin` command of the page's blocks, indented ones included."""
    code = "\n".join(re.findall(r"^ *```(?:bash|sh)\n(.*?)^ *```$", page, re.M | re.S) + re.findall(r"^    (\S.*)$", page, re.M))
    lines = re.sub(r"\\\n\s*|2>&1", " ", code).splitlines()
    return [match[0].strip() for line in lines for match in re.finditer(r"ddh-twin [^|&;>#`]+", line)]


def test_every_command_of_the_documents_is_understood(pages, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    parser, seen = build_parser(), set()
    for path, page in pages.items():
        for command in commands_of(page):
            words = re.findall(r'"[^"]*"|\S+', command)[1:]
            try:
                found, extra = parser.parse_known_args([word.strip('"') for word in words])
            except SystemExit as left:
                assert left.code == 0, f"{path.name}: {command}"  # --help
                continue
            assert not extra and (found.verb or found.version), f"{path.name}: {command}: {extra}"
            seen.add(found.verb)
    assert {"gap", "replay", "export", "import", "doctor", "fmu", "up", "fleet", "study"} <= seen


@pytest.fixture
def page(tmp_path):
    def write(*blocks):
        path = tmp_path / "page.md"
        path.write_text("# Page\n\n" + "\n\n".join(blocks) + "\n\nEnd.\n")
        return path
    return write


RUN = "<!-- run -->\n```bash\n{}\n```"
OUTPUT = "<!-- output -->\n```text\n{}\n```"


def quiet(*_):
    pass


def test_the_runner_runs_compares_and_writes(documents, page):
    run_page = documents["run_page"]
    file = "<!-- file: in/a.txt -->\n```text\nseven 7.1\n```"
    good = page(file, RUN.format("cat in/a.txt; ls bags"), OUTPUT.format("seven 7.2\npaper_cycle"))
    assert run_page(good, say=quiet) == []  # numbers may differ
    other = page(RUN.format("echo eight 7"), OUTPUT.format("seven 7"))
    (wrong,) = run_page(other, say=quiet)
    assert wrong.startswith("page.md:9: prints other words")
    assert run_page(other, write=True, say=quiet) == [] and "eight 7\n```\n\nEnd." in other.read_text()
    assert run_page(other, say=quiet) == []
    failing = page(RUN.format("echo why >&2; exit 3"), RUN.format("echo never"))
    assert run_page(failing, say=quiet) == ["page.md:4: exit code 3: why"]
    assert run_page(page(OUTPUT.format("x")), say=quiet) == ["page.md:4: an output with no command before it"]
    inside = "1. A list:\n\n   <!-- run -->\n   ```bash\n   exit 4\n   ```"
    assert run_page(page(inside), say=quiet) == ["page.md:6: exit code 4: "]
    listed = page("1. A list:\n\n   <!-- run -->\n   ```bash\n   echo two; echo lines\n   ```",
                  "   <!-- output -->\n   ```text\n   x\n   ```",
                  RUN.format("true"), OUTPUT.format("y"))
    assert run_page(listed, write=True, say=quiet) == [] and run_page(listed, say=quiet) == []
    assert "   ```text\n   two\n   lines\n   ```" in listed.read_text() and "```text\n```\n\nEnd." in listed.read_text()
    assert run_page(page("<!-- not run: never -->\n```bash\nfalse\n```"), say=quiet) == []


@pytest.mark.parametrize("commands", [
    "false && true\ntrue", "false || true", "false &\ntrue", "! false\ntrue", "if false; then true; fi", "echo $(false)", "echo `false`",
    "cat <(false)", "until true; do false; done", "false |& cat\ntrue",
])
def test_the_runner_refuses_what_hides_a_failure(documents, page, commands):
    (wrong,) = documents["run_page"](page(RUN.format(commands)), say=quiet)
    assert "hides whether a command failed" in wrong


@pytest.mark.parametrize("commands", ["false\ntrue", "false; true", "false | cat\ntrue", "(false)\ntrue", "echo $never_set\ntrue"])
def test_the_runner_sees_a_failure_wherever_it_is(documents, page, commands):
    (wrong,) = documents["run_page"](page(RUN.format(commands)), say=quiet)
    assert "exit code 1" in wrong or "exit code 127" in wrong


def test_the_runner_wants_what_is_refused_to_be_refused(documents, page):
    run_page = documents["run_page"]
    refused = "<!-- refused: 2 -->\n```bash\n{}\n```"
    assert run_page(page(refused.format("ls --no-such"), OUTPUT.format(
        "ls: unrecognized option '--no-such'\nTry 'ls --help' for more information.")), say=quiet) == []
    assert run_page(page(refused.format("true")), say=quiet) == ["page.md:4: exit code 0 and not 2: "]
    (wrong,) = run_page(page(refused.format("ls --no-such\ntrue")), say=quiet)
    assert "one command is refused in a block" in wrong
    assert run_page(page(RUN.format("echo 'a && b' | grep -e \"a && b\"  # or: && || !")), say=quiet) == []


def test_no_page_hides_a_failure(documents, pages):
    for path, text in pages.items():
        for block in documents["blocks_of"](text):
            if block.mark == "run" or block.mark.startswith("refused"):
                assert not documents["hiding"](block.text), f"{path.name}:{block.line}"


@pytest.mark.timeout(900)  # compiles, where it is the first
def test_commands_of_a_page_print_what_it_says(documents, repo_root):
    """One page with every change; all of them by .ci/scheduled."""
    assert documents["run_page"](repo_root / "docs/other_tools.md", say=quiet) == []


@pytest.mark.timeout(900)
def test_the_rig_file_that_a_page_shows_is_what_its_command_writes(pages, repo_root, tmp_path):
    """`run_documents` compares words; here numbers, to a tenth of their standard deviation."""
    page = pages[repo_root / "docs/howto_rig_sheet.md"]
    (command,) = (one for one in commands_of(page) if one.startswith("ddh-twin calibrate"))
    assert main(command.replace("out/", f"{tmp_path}/").replace("bags/", f"{repo_root}/bags/").split()[1:]) == 0
    (shown,) = re.findall(r"```text\n(# Fitted by ddh-twin calibrate.*?)```", page, re.S)
    shown, written = (flattened(yaml.safe_load(text)) for text in (shown, (tmp_path / "fitted.yaml").read_text()))
    assert shown.keys() == written.keys() and len(shown) > 10
    for path, (value, std) in written.items():
        assert shown[path] == pytest.approx((value, std), rel=0.01, abs=0.1 * std), path


def flattened(sheet: dict) -> dict[str, tuple[float, float]]:
    """Value and standard deviation by path."""
    return {f"{part}.{name}": (q["value"], q["std"]) for part, own in sheet.items() if isinstance(own, dict) for name, q in own.items()}


class Links(HTMLParser):
    """What a page of the site points to, and the places in it."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.to, self.places = [], {""}
        self.feed(page.read_text("utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.to += [given[name] for name in ("href", "src") if given.get(name)]
        self.places |= {given["id"]} if "id" in given else set()


def broken_links(site: Path) -> list[str]:
    """Links and pictures of a site that lead to no file of it, or to no place on its page."""
    pages = {path: Links(path) for path in site.rglob("*.html")}
    broken = []
    for path, page in pages.items():
        for link in page.to:
            parts = urlsplit(link)
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if parts.scheme or parts.netloc:
                continue
            if not target.exists() or target in pages and unquote(parts.fragment) not in pages[target].places:
                broken.append(f"{path.relative_to(site)}: {link}")
    return broken


def test_a_broken_link_is_found(tmp_path):
    (tmp_path / "a.html").write_text('<p id="x"></p><a href="b.html#y"></a><a href="#x"></a><a href="https://x.org"></a><img src="p.png">')
    (tmp_path / "b.html").write_text('<a href="a.html#x"></a><a href="c.html"></a>')
    assert sorted(broken_links(tmp_path.resolve())) == ["a.html: b.html#y", "a.html: p.png", "b.html: c.html"]


@pytest.mark.timeout(900)
def test_the_site_builds_and_asks_for_nothing(repo_root, tmp_path):
    sphinx = repo_root / ".venv/tools/bin/sphinx-build"
    if not sphinx.exists():
        pytest.skip("no Sphinx here: scripts/tools.sh puts it into .venv/tools")
    command = [sphinx, "-W", "--keep-going", "-q", "-b", "html", "-d", tmp_path / "trees", repo_root / "docs", tmp_path / "site"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    site = (tmp_path / "site").resolve()
    assert broken_links(site) == []
    sources = {path.relative_to(repo_root / "docs").with_suffix(".html") for path in (repo_root / "docs").rglob("*.md")}
    assert sources <= {path.relative_to(site) for path in site.rglob("*.html")}
    asked = re.compile(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=\"(?:https?:)?//[^\"]+\"")
    for path in site.rglob("*.html"):
        assert not asked.findall(path.read_text("utf-8")), path
    styles = "".join(path.read_text("utf-8", "replace") for path in site.rglob("*.css"))
    assert not re.search(r"@import|url\(['\"]?(?:https?:)?//", styles)
    index = (site / "index.html").read_text()
    named = ("tutorial", "howto_machine", "command_line", "messages", "physics", "gap_method")
    assert all(f'href="{name}.html"' in index for name in named)


def test_no_page_has_a_word_that_was_to_be_replaced(pages):
    """A line of one word in capitals stands for a table or a figure that its writer meant to put there."""
    left = [f"{page.name}:{number}: {line}" for page, text in pages.items() for number, line in enumerate(text.splitlines(), 1)
            if re.fullmatch(r"[A-Z][A-Z_]{2,}", line)]
    assert not left

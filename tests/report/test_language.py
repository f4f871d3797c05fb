"""uPlot beside the language that a browser tells: one under LANG=C.UTF-8 tells what is no language tag."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from ddh_twin_py.report.page.charts import Chart, Trace, charts
from ddh_twin_py.report.page.document import Document, EndMatter
from ddh_twin_py.web.page_files import assets

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="there is no Node.js on this machine")
_RUN = """
const vm = require("vm"), { scripts, language } = JSON.parse(require("fs").readFileSync(0, "utf8"));
const any = () => new Proxy(() => 0, { get: (_, key) => (key === Symbol.toPrimitive ? () => 0 : any()), apply: () => any() });
class Navigator { get language() { return language; } }
const page = vm.createContext({ navigator: new Navigator(), document: any(), matchMedia: any(), CustomEvent: class {} });
Object.assign(page, { window: page, devicePixelRatio: 1, addEventListener() {}, dispatchEvent() {} });
for (const script of scripts) vm.runInContext(script, page);
console.log(vm.runInContext("navigator.language + ' ' + uPlot.fmtNum(1234.5)", page));
"""


def of_report():
    """The scripts of a report up to uPlot."""
    page = Document("Kind", "Title", "Said.", EndMatter("", "", [], ()))
    page.add("Charts", charts([Chart("x", "K", np.arange(2.0), [Trace("y", "measured", np.arange(2.0))])]))
    found = re.findall(r"<script>(.*?)</script>", page.html(), re.DOTALL)
    return found[1 : 1 + next(i for i, script in enumerate(found) if "uPlot=" in script)]


def of_live_page():
    """The same of the live page."""
    files = assets()
    names = re.findall(r'<script src="([^"]*)" defer>', files["index.html"].content.decode())
    return [files[name].content.decode() for name in names]


@pytest.mark.parametrize("scripts", [of_report, of_live_page])
@pytest.mark.parametrize(("language", "said"), [("en-US@posix", "en-US 1,234.5"), ("C", "en-US 1,234.5"), ("de-DE", "de-DE 1.234,5")])
def test_charts_are_drawn_whatever_language_the_browser_tells(scripts, language, said):
    asked = json.dumps({"scripts": scripts(), "language": language})
    done = subprocess.run(["node", "-e", _RUN], input=asked, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr[-500:]
    assert done.stdout.strip() == said

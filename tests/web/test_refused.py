"""A page in a real Chromium that is not let in any more says why."""

import pytest
from support.chromium import Chromium, executable

PILL = "document.querySelector('#link').textContent"

pytestmark = pytest.mark.skipif(executable() is None, reason="there is no Chromium on this machine; scripts/browser.sh installs one")


def test_after_a_restart_with_another_token_the_page_asks_for_it(serve):
    first = serve(token="old")
    with Chromium() as browser:
        browser.open(first.url)
        browser.wait("document.documentElement.dataset.ready === 'yes'", 60.0)
        first.server.stop()
        browser.wait(f"{PILL} === 'connection lost, trying again'", 30.0)
        serve(token="new", port=first.server.access.port)
        assert "token" in browser.wait(f"{PILL}.includes('needs its token') && {PILL}", 30.0)

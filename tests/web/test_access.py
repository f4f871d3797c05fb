"""Who may see the page."""

import re
import socket

import pytest
from ddh_twin_py.web.access import Access, is_local


@pytest.mark.parametrize(
    ("host", "local"),
    [("127.0.0.1", True), ("localhost", True), ("::1", True), ("127.3.4.5", True), ("0.0.0.0", False), ("::", False),
     ("192.168.1.7", False), ("rig.example", False)],
)
def test_beyond_this_machine_there_is_always_a_token(host, local):
    assert is_local(host) is local
    access = Access.of(host, 8420)
    assert bool(access.token) is not local
    assert Access.of(host, 8420, "chosen").token == "chosen"
    if not local:
        assert len(access.token) >= 20 and access.token != Access.of(host, 8420).token
        assert not access.knows_token(None) and not access.knows_token("") and not access.knows_token("é")
        assert access.knows_token(access.token) and access.token in access.url


def test_addresses_that_a_person_can_open():
    assert Access.of("127.0.0.1", 8420).url == "http://127.0.0.1:8420/"
    assert Access.of("localhost", 80).url == "http://127.0.0.1:80/"
    assert Access.of("fd00::7", 80, "t").url == "http://[fd00::7]:80/?token=t"


@pytest.mark.parametrize("host", ["0.0.0.0", "::", ""])
def test_served_everywhere_the_address_is_one_of_this_machine(host):
    found = re.fullmatch(r"http://([\d.]+):80/\?token=t", Access.of(host, 80, "t").url)
    with socket.socket() as probe:
        probe.bind((found[1], 0))  # an address that is not this machine's cannot be bound


def test_a_token_of_bytes_that_are_no_text_is_wrong_and_nothing_worse():
    assert not Access.of("0.0.0.0", 80, "t").knows_token(b"\xff".decode(errors="surrogateescape"))


@pytest.mark.parametrize(
    ("headers", "words"),
    [
        ({"Host": "127.0.0.1:8420"}, ""),
        ({"Host": "localhost:9000"}, ""),  # through a tunnel
        ({"Host": "[::1]:8420"}, ""),
        ({"Host": "evil.example:8420"}, "asked for as 'evil.example'"),
        ({}, "asked for as ''"),
        ({"Host": "["}, "asked for as ''"),
        ({"Host": "127.0.0.1:8420", "Origin": "http://["}, "another site, 'http://['"),
        ({"Host": "127.0.0.1:8420", "Origin": "http://127.0.0.1:8420"}, ""),
        ({"Host": "127.0.0.1:8420", "Origin": "http://evil.example"}, "another site, 'http://evil.example'"),
        ({"Host": "127.0.0.1:8420", "Origin": "http://127.0.0.1:9999"}, "another site"),
        ({"Host": "127.0.0.1:8420", "Origin": "null"}, "another site"),
    ],
)
def test_other_sites_do_not_reach_the_page_through_a_browser(headers, words):
    refusal = Access.of("127.0.0.1", 8420).refusal(headers)
    assert words in refusal and bool(refusal) is bool(words)


def test_with_a_token_any_name_will_do():
    access = Access.of("0.0.0.0", 8420, "t")
    assert access.refusal({"Host": "rig-7.plant:8420"}) == ""
    assert "another site" in access.refusal({"Host": "rig-7.plant:8420", "Origin": "http://evil.example"})

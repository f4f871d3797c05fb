"""Whether the live page can be served at a port, asked before any node is started."""

from __future__ import annotations

import errno
import os
import socket

from ddh_twin_py.cli.arguments import InputError


def refuse_taken(host: str, port: int, named: str, way_out: str) -> None:
    """Raise InputError where another program has the address; whatever else is wrong with it, the node says.

    Args:
        named: the option that gives the port, as it is told. way_out: what to do.
    """
    if port == 0:
        return
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (OSError, ValueError):
        return
    for family, kind, protocol, _, address in addresses:
        try:
            with socket.socket(family, kind, protocol) as tried:
                if os.name == "posix":
                    tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server binds: one that has ended holds nothing
                tried.bind(address)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise InputError(f"{named}: the address is in use; {way_out}") from None

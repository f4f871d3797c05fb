"""Browsers that look at the live page, as far as the server sees them: each reads everything and acknowledges it.

    python -m ddh_twin_py.benchmarks.page_viewers http://127.0.0.1:8420/ 20 30

prints what came, as JSON.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from dataclasses import asdict, dataclass

import aiohttp

_SEEN = 5  # frames between two acknowledgements, as the page's script does


@dataclass(frozen=True)
class Seen:
    """By each viewer on average: frames and kB a second; `fewest`: frames a second of the slowest."""

    viewers: int
    frames: float
    fewest: float
    kilobytes: float


async def _look(session: aiohttp.ClientSession, url: str, until: float) -> tuple[int, int]:
    frames = size = 0
    async with session.ws_connect(f"{url}ws", max_msg_size=0) as socket:
        while (left := until - time.monotonic()) > 0.0:
            try:
                message = await socket.receive(left)
            except TimeoutError:
                break
            if message.type is aiohttp.WSMsgType.BINARY:
                frames += 1
                if frames % _SEEN == 0:
                    await socket.send_str(f'{{"seen":{_SEEN}}}')
            elif message.type is not aiohttp.WSMsgType.TEXT:
                break
            size += len(message.data)
    return frames, size


async def look(url: str, viewers: int, seconds: float) -> Seen:
    """So many viewers for so long; `url` ends with a slash."""
    async with aiohttp.ClientSession() as session:
        until = time.monotonic() + seconds
        seen = await asyncio.gather(*(_look(session, url, until) for _ in range(viewers)))
    rates = [frames / seconds for frames, _ in seen]
    return Seen(viewers, sum(rates) / viewers, min(rates), sum(size for _, size in seen) / viewers / seconds / 1e3)


if __name__ == "__main__":
    print(json.dumps(asdict(asyncio.run(look(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]))))))

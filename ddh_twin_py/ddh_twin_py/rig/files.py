"""Files and folders that people name: written whole or not at all, held by one process; what lies near; names as they can be shown."""

from __future__ import annotations

import difflib
import errno
import fcntl
import json
import math
import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

_KINDS = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a named pipe"), (stat.S_ISSOCK, "a socket"),
          (stat.S_ISCHR, "a character device"), (stat.S_ISBLK, "a block device"))


def did_you_mean(path: str | Path) -> str:
    """What lies beside a path that is not there and has a similar name, as `; the nearest is ...`; '' where nothing has.

    Of a link that leads nowhere: what it leads to.
    """
    path = Path(path)
    try:
        if path.is_symlink() and not path.exists():
            nowhere = "leads back to it" if _is_circle(path) else "does not exist"
            return f"; it is a link to {os.readlink(path)}, which {nowhere}"
        names = os.listdir(path.parent)
    except OSError:
        return ""
    near = difflib.get_close_matches(path.name, names, n=1, cutoff=0.7)
    return f"; the nearest is {path.parent / near[0]}" if near else ""


def _is_circle(link: Path) -> bool:
    """Whether a link leads back to itself."""
    try:
        os.stat(link)
    except OSError as error:
        return error.errno == errno.ELOOP
    return False


def no_regular_file(path: str | Path) -> str:
    """What lies at a path, followed where it is a link, in words such as `a folder` or `a named pipe`; '' of a regular file.

    Raises:
        OSError: nothing is there.
    """
    mode = os.stat(path).st_mode
    return "" if stat.S_ISREG(mode) else next((words for kind, words in _KINDS if kind(mode)), "a special file")


def why_no_file(folder: str | Path) -> str:
    """Why no file can be made in a folder, '' where one can; permissions alone do not tell, least of all those of root."""
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        return "no file can be made there" if error.errno == errno.ENOENT else error.strerror  # as in /proc
    return ""


def printable(text: object) -> str:
    """A text on one line in which what no screen or YAML comment may hold (line ends, escapes, lone surrogates) is spelled out: `\\x1b`."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in str(text))


def read_json(path: str | Path) -> object:
    """What a JSON file holds.

    Raises:
        OSError: it cannot be read. ValueError: it is no regular file, no JSON, or nested too deep; the message is one line.
    """
    if what := no_regular_file(path):
        raise ValueError(f"it is {what}, a regular file is needed")
    try:
        return json.loads(Path(path).read_text("utf-8"))
    except ValueError as error:
        raise ValueError(" ".join(str(error).split())) from None
    except RecursionError:
        raise ValueError("nested too deep to be read") from None


def finite(data: object) -> object:
    """Data as JSON can hold it: NaN and infinity as None, numpy's scalars as Python's, mappings and sequences as dict and list."""
    if isinstance(data, Mapping):
        return {str(key): finite(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [finite(value) for value in data]
    if hasattr(data, "item") and not isinstance(data, str):  # a numpy scalar
        data = data.item()
    return None if isinstance(data, float) and not math.isfinite(data) else data


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write a file whole or not at all, making its folder where needed; text is written as UTF-8, lone surrogates (names of files that
    are not UTF-8) as `\\udcff`.

    The old file is replaced in one move once the new one is on the disk, so that a crash leaves one of the two.

    Raises:
        OSError: with the path that was given; nothing is left behind.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.{secrets.token_hex(4)}")  # two may write the same file, each in a container with the same ids
    made = False
    try:
        with open(partial, "xb") as file:
            made = True
            file.write(content.encode("utf-8", "backslashreplace") if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except BaseException as error:
        try:
            if made:
                partial.unlink(missing_ok=True)
        except OSError:
            pass  # what went wrong before is what counts
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise
    return path


@contextmanager
def whole_folder(path: str | Path) -> Iterator[Path]:
    """Make a folder whole or not at all: what is yielded is its name in a folder beside it, from where it is moved at the end.

    Raises:
        OSError: with the path that was given; nothing is left behind, and no folder above it that was not there.
    """
    path = Path(path)
    above = [folder for folder in path.parents if not folder.exists()]
    partial = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=f"{path.name}.", dir=path.parent))
        yield partial / path.name
        (partial / path.name).rename(path)
        partial.rmdir()
    except BaseException as error:
        if partial is not None:
            shutil.rmtree(partial, ignore_errors=True)
        try:
            for folder in above:
                folder.rmdir()
        except OSError:
            pass  # another one wrote into it
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path)) from None
        raise


@contextmanager
def held(folder: Path, lock: str, refusal: Exception) -> Iterator[None]:
    """Hold a folder, which is made where there is none, by a file in it named ``lock``; freed also where the process is killed.

    Raises:
        Exception: ``refusal``, where another process holds it. OSError: the folder cannot be made.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / lock, "w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise refusal from None
        yield

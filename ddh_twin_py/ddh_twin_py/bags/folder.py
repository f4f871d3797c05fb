"""What lies at the path of a bag: its files, and what metadata.yaml says about them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any

import yaml

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.storage import EVER, told
from ddh_twin_py.names import first_of
from ddh_twin_py.rig.files import did_you_mean, no_regular_file
from ddh_twin_py.rig.unique_keys import read_unique
from ddh_twin_py.rig.yaml_file import decoded, mapping, parse_yaml, shown

SUFFIXES = (".mcap", ".db3")
_PACKED_SUFFIXES = tuple(f"{suffix}.zstd" for suffix in SUFFIXES)
DATA_ENDINGS = (*SUFFIXES, *_PACKED_SUFFIXES)
"""How names of files end that hold messages."""
_IDENTIFIERS = ("mcap", "sqlite3")
_MODES = ("", "none", "file", "message")
METADATA = "metadata.yaml"
_SAYS = f"has a {METADATA} in which"
_MOST_TOLD = 3  # counts or types of one bag that are wrong
_SAME_TIME = 1_000_000_000  # ns by which programs that write bags differ in what its begin is
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class TopicEntry:
    """A topic as metadata.yaml lists it."""

    message_type: str
    type_hash: str
    count: int


@dataclass
class BagFolder:
    """The files of a bag in order, its compression mode ('', file, message), its topic list, the span of its log times in ns.

    `topics` is None where metadata.yaml is absent or unusable; `notes` says why. `span` is `EVER` where it is not told. `totals`: how many
    messages metadata.yaml says that there are in all, by its entry. `remarks`: what it says of files that is odd and stops nothing.
    """

    path: Path
    files: list[Path]
    compression_mode: str = ""
    topics: dict[str, TopicEntry] | None = None
    notes: list[str] = field(default_factory=list)
    span: tuple[int, int] = EVER
    totals: dict[str, int] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def miscounted(self, counts: Mapping[str, int]) -> str:
        """Where metadata.yaml gives another number of messages than there are; '' where it nowhere does, or gives none.

        Args:
            counts: messages that the files hold, by topic.
        """
        if self.topics is None or not self.path.is_dir():
            return ""
        listed = {name: entry.count for name, entry in self.topics.items()}
        wrong = [f"message_count of {name} is {listed[name]} and the bag holds {counts.get(name, 0)}"
                 for name in listed if listed[name] != counts.get(name, 0)]
        wrong += [f"topics_with_message_count does not list {name}, of which the bag holds {count}"
                  for name, count in counts.items() if name not in listed]
        total = sum(counts.values())
        wrong += [f"{entry} is {count} and the bag holds {total}" for entry, count in self.totals.items() if count != total]
        return f"{_SAYS} {first_of(wrong, _MOST_TOLD)}" if wrong else ""

    def contradicted(self, types: Mapping[str, str], first: int, last: int) -> list[str]:
        """Where metadata.yaml gives another type of a topic, or another time, than the messages have, in words that follow the bag's path.

        Args:
            types: of the topics of the messages. first, last: log times of all messages, ns, of a bag of which nothing is lost.
        """
        if not self.path.is_dir():
            return []
        listed = {name: entry.message_type for name, entry in (self.topics or {}).items()}
        wrong = [f"type of {name} is {listed[name]!r} and the messages are of {types[name]!r}" for name in listed
                 if name in types and _short(listed[name]) not in ("", _short(types[name]))]
        said = [f"{_SAYS} {first_of(wrong, _MOST_TOLD)}, as which they are read"] if wrong else []
        if self.span == EVER:
            return said
        start, length, lasts = self.span[0], self.span[1] - self.span[0], last - first
        if abs(start - first) > _SAME_TIME:
            said.append(f"{_SAYS} starting_time is {start * 1e-9:.3f} s and the first message is of {first * 1e-9:.3f} s")
        if abs(length - lasts) > _SAME_TIME:
            said.append(f"{_SAYS} duration is {length * 1e-9:.3f} s and the messages last {lasts * 1e-9:.3f} s")
        return said


def holds_bag(path: str | Path) -> bool:
    """Whether there is metadata.yaml or a file of a bag in a folder; False where it cannot be looked into."""
    try:
        return any(name == METADATA or name.endswith(DATA_ENDINGS) for name in os.listdir(path))
    except OSError:
        return False


def open_folder(path: str | Path) -> BagFolder:
    """Look at a rosbag2 folder, or at one .mcap or .db3 file.

    Raises BagError when there is no such path, nothing that could be a bag, a file of it that is
    no regular file, or a compression or storage that cannot be read.
    """
    path = Path(path)
    if not path.exists():
        near = did_you_mean(path) or "; a bag is a rosbag2 folder or one .mcap or .db3 file"
        raise BagError(f"{path} does not exist{near}")
    if path.is_file():
        if not path.name.endswith(DATA_ENDINGS):
            raise BagError(f"{path} is no bag: its name ends in {path.suffix!r}, not in .mcap or .db3")
        return BagFolder(path, [path], _mode_of(path))
    if not path.is_dir():
        raise BagError(f"{path} is no bag but {no_regular_file(path)}; a bag is a rosbag2 folder or one .mcap or .db3 file")
    found = sorted(p for p in path.iterdir() if p.name.endswith(DATA_ENDINGS))
    metadata = path / METADATA
    if not metadata.is_file():
        if not found:
            inside = sorted(p.parent.name for p in path.glob(f"*/{METADATA}"))
            hint = f"; give {' or '.join(str(path / name) for name in inside)}" if inside else ""
            raise BagError(f"{path} is no bag: the folder has no {METADATA} and no .mcap or .db3 file{hint}")
        note = f"has no {METADATA}, the recorder was stopped hard"
        return BagFolder(path, _regular(found), _mode_of(found[0]), notes=[note])
    try:
        information = _information(metadata)
        folder = BagFolder(path, [], _compression(metadata, information), _topics(information), span=_span(information),
                           totals=_totals(information))
        names = _names_of_files(information)
    except BagError:
        raise
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
        if not found:
            raise BagError(f"{metadata} cannot be used ({_reason(error)}) and the folder has no .mcap or .db3 file") from None
        note = f"has a {METADATA} that cannot be used ({_reason(error)})"
        return BagFolder(path, _regular(found), _mode_of(found[0]), notes=[note])
    for name in names:
        file = path / name
        inside = path / PurePath(file).name
        outside = not Path(os.path.abspath(file)).is_relative_to(os.path.abspath(path))
        here = inside if outside and inside.is_file() or not file.is_file() else file
        if here in folder.files:
            folder.remarks.append(f"{_SAYS} relative_file_paths names {here.name} twice; it is read once")
        elif here.is_file():
            folder.files.append(here)
            if outside:
                folder.remarks.append(f"{_SAYS} relative_file_paths names {name!r}, which lies outside of the bag; {here} is read")
        else:
            folder.notes.append(f"lacks the file {name if outside else file.name} that {METADATA} names")
    if folder.files and (more := _not_named(folder, found)):
        folder.remarks.append(f"{_SAYS} relative_file_paths does not name {_names(more)}, which lies beside it and is not read")
    if not folder.files:
        if not found:
            raise BagError(f"{path} has none of the files that its {METADATA} names: {', '.join(names) or 'none'}")
        folder.files = _regular(found)
    folder.remarks += _at_odds(information, folder)
    return folder


def _information(metadata: Path) -> dict[str, Any]:
    """What metadata.yaml says.

    Raises:
        ValueError, KeyError: it says nothing; the message is one line.
    """
    text = decoded(metadata.read_bytes())
    try:
        tree = read_unique(text, _LOADER)
    except (yaml.YAMLError, LookupError, ValueError, AttributeError, RecursionError):
        tree = parse_yaml(text, METADATA, ValueError)  # slower, and says what is wrong
    information = mapping(tree, METADATA, "description of a bag", ValueError)["rosbag2_bagfile_information"]
    return mapping(information, f"{METADATA}: rosbag2_bagfile_information", "description of a bag", ValueError)


def _names_of_files(information: dict[str, Any]) -> list[str]:
    names = information["relative_file_paths"]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"relative_file_paths holds {shown(names)}, a list of names is needed")
    return names


def _regular(files: list[Path]) -> list[Path]:
    """The files of a bag as they are; a pipe would never end, a folder cannot be read."""
    for file in files:
        if not file.exists():
            raise BagError(f"{file} does not exist{did_you_mean(file)}")
        if what := no_regular_file(file):
            raise BagError(f"{file} is no file of a bag but {what}; a regular file is needed")
    return files


def _compression(metadata: Path, information: dict[str, Any]) -> str:
    storage = information.get("storage_identifier")
    if storage not in _IDENTIFIERS:
        raise BagError(f"{metadata}: storage_identifier {storage!r} cannot be read; known are mcap, sqlite3")
    mode = (information.get("compression_mode") or "").lower()
    method = information.get("compression_format") or ""
    if mode not in _MODES or (mode in ("file", "message") and method != "zstd"):
        raise BagError(
            f"{metadata}: compression_mode {mode!r} with compression_format {method!r} cannot be read; "
            "known are modes file and message with format zstd, and none"
        )
    return "" if mode == "none" else mode


def _topics(information: dict[str, Any]) -> dict[str, TopicEntry]:
    entries = information["topics_with_message_count"]
    if not isinstance(entries, list):
        raise ValueError(f"topics_with_message_count holds {shown(entries)}, a list of topics is needed")
    return {
        told(_text(entry["topic_metadata"]["name"])): TopicEntry(
            told(_text(entry["topic_metadata"]["type"])),
            _text(entry["topic_metadata"].get("type_description_hash")),
            _count(told(_text(entry["topic_metadata"]["name"])), entry["message_count"]),
        )
        for entry in entries
    }


def _count(topic: str, value: object) -> int:
    """A number of messages.

    Raises:
        ValueError: it is none.
    """
    if type(value) is not int:
        raise ValueError(f"message_count of {topic} is {shown(value)}, a whole number is needed")
    return value


def _totals(information: dict[str, Any]) -> dict[str, int]:
    """How many messages there are in all, by the entry that says so; without those that are no whole number."""
    files = information.get("files")
    of_files = [file.get("message_count") if isinstance(file, dict) else None for file in files] if isinstance(files, list) else []
    totals = {"message_count": information.get("message_count")}
    if of_files and all(type(count) is int for count in of_files):
        totals["message_count of all files"] = sum(of_files)
    return {entry: count for entry, count in totals.items() if type(count) is int}


def _at_odds(information: dict[str, Any], folder: BagFolder) -> list[str]:
    """What metadata.yaml says of the storage, the packing and the duration that its files contradict, or that cannot be."""
    storage, said = information.get("storage_identifier"), []
    other = [file for file in folder.files if (".mcap" in file.suffixes) != (storage == "mcap")]
    if other:
        said.append(f"{_SAYS} storage_identifier is {storage!r}, while {_names(other)} is read as its name says")
    plain = [file for file in folder.files if not file.name.endswith(_PACKED_SUFFIXES)]
    if folder.compression_mode == "file" and plain:
        said.append(f"{_SAYS} compression_mode is 'file', while {_names(plain)} is not packed and is read as it is")
    duration = information.get("duration")
    length = duration.get("nanoseconds") if isinstance(duration, dict) else None
    if type(length) is int and length < 0:
        said.append(f"{_SAYS} duration is {length} ns, which no recording lasts; it is not used")
    return said


def _not_named(folder: BagFolder, found: list[Path]) -> list[Path]:
    """Files of a bag that lie in its folder and are not read; a packed one and the same unpacked are one."""
    read = {file.name.removesuffix(".zstd") for file in folder.files}
    return [file for file in found if file.name.removesuffix(".zstd") not in read]


def _text(value: object) -> str:
    """A text, empty where none is given.

    Raises:
        TypeError: it is something else.
    """
    if value and not isinstance(value, str):
        raise TypeError(f"{value!r} is no text")
    return value or ""


def _short(message_type: str) -> str:
    """A message type without the folder that older programs leave out."""
    return message_type.replace("/msg/", "/")


def _span(information: dict[str, Any]) -> tuple[int, int]:
    try:
        start, duration = int(information["starting_time"]["nanoseconds_since_epoch"]), int(information["duration"]["nanoseconds"])
    except (KeyError, TypeError, ValueError, OverflowError):
        return EVER
    return (start, start + duration) if duration > 0 else EVER


def _mode_of(path: Path) -> str:
    return "file" if path.name.endswith(_PACKED_SUFFIXES) else ""


def _names(paths: list[Path]) -> str:
    return ", ".join(p.name for p in paths) or "none"


def _reason(error: Exception) -> str:
    text = " ".join(str(error).split()).removeprefix(f"{METADATA}: ")
    return f"no entry {text}" if isinstance(error, KeyError) else text

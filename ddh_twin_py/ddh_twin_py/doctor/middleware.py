"""Do messages cross between processes here, and in which domain."""

from __future__ import annotations

from pathlib import Path

from ddh_twin_py.doctor.check import Check
from ddh_twin_py.doctor.survey import Survey

GROUP = "middleware"
SLOW = 3.0
"""s from the start of a process to its first message, discovery included, above which something is in the way."""
PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"


def came_late(survey: Survey) -> bool:
    """Whether a message of a process of our own came late or not at all, as on a busy computer or where discovery is slow."""
    return survey.loop is None or survey.loop > SLOW


def check_middleware(survey: Survey) -> list[Check]:
    """Which middleware, which domain, whether processes hear each other, and how soon."""
    checks = [_which(survey), _reach(survey), _loop(survey)]
    profile = survey.environment.get(PROFILE, "")
    if profile and not Path(profile).is_file():
        checks.append(Check(GROUP, "profile", "error", f"{PROFILE} names {profile}, which is not there", "a file",
                            "unset it, or name config/fastdds_profile.xml"))
    elif survey.middleware == "rmw_fastrtps_cpp" and not profile:
        checks.append(Check(GROUP, "profile", "note", f"{PROFILE} is not set", "config/fastdds_profile.xml",
                            "set it to the project's profile: quicker discovery, nothing lost in a fast replay"))
    return checks


def _which(survey: Survey) -> Check:
    right = "rmw_fastrtps_cpp is what is tested"
    if survey.middleware == "rmw_fastrtps_cpp":
        return Check(GROUP, "implementation", "ok", survey.middleware, right)
    return Check(GROUP, "implementation", "note", survey.middleware, right, "machine and twin must use the same one")


def _reach(survey: Survey) -> Check:
    reach = survey.environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "") or "SUBNET"
    if survey.environment.get("ROS_LOCALHOST_ONLY", "") == "1":
        reach = "LOCALHOST (ROS_LOCALHOST_ONLY)"
    found = f"domain {survey.domain}, {reach}"
    if reach.startswith("LOCALHOST") or reach == "OFF":
        return Check(GROUP, "reach", "note", found, "as the machine's",
                     "a machine on another computer is not heard: ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET on both")
    return Check(GROUP, "reach", "ok", found, "as the machine's")


def _loop(survey: Survey) -> Check:
    right = f"within {SLOW:g} s"
    if survey.loop is None and (came := [heard.topic for heard in survey.topics.values() if heard.arrived.size]):
        return Check(GROUP, "between processes", "warning", f"a message of a process of our own came too late, those of {len(came)} topics "
                     "came", right, "see whether the computer is busy: messages cross, and neither firewall nor multicast is in the way")
    if survey.loop is None:
        return Check(GROUP, "between processes", "error", "a message of a process of our own did not come", right,
                     "look at firewall, multicast on the loopback device (ip link set lo multicast on), and free space in /dev/shm")
    found = f"first message {survey.loop:.1f} s after the start of a process"
    if came_late(survey):
        set_it = f"discovery is slow: set {PROFILE} to ddh_twin_py/config/fastdds_profile.xml"
        busy = f"discovery is slow though {PROFILE} is set: see whether the computer is busy"
        return Check(GROUP, "between processes", "warning", found, right, busy if survey.environment.get(PROFILE) else set_it)
    return Check(GROUP, "between processes", "ok", found, right)

"""Tally junit reports, the latest last: fail on a skip that this machine should not need, print the closing line."""

import sys
from pathlib import Path
from xml.etree import ElementTree

ALLOWED = ("hardware", "../shared")  # a real device; recordings and the paper, which are not in the repository
FEW = 3  # test modules, failures in which a computer that was late can explain

Cases = dict[str, ElementTree.Element]


def few(report: str) -> int:
    """Return 0 when tests failed, but in so few modules that each gets a second attempt."""
    failed = {name: case.get("classname") for name, case in _cases(report).items() if _failed(case)}
    if not 0 < len(set(failed.values())) <= FEW:
        return 1
    for name in failed:
        print(f"failed at the first attempt: {name}")
    return 0


def closing(status: str, *reports: str) -> int:
    """Print how many passed, failed and were skipped, each as its latest attempt says; return the exit code."""
    first, *later = map(_cases, reports)
    cases = first | {name: case for report in later for name, case in report.items()}
    skipped = [case for case in cases.values() if case.find("skipped") is not None]
    failed = [case for case in cases.values() if _failed(case)]
    wrong = [case for case in skipped if not any(word in _reason(case) for word in ALLOWED)]
    for case in wrong:
        print(f"skipped, but should run here: {_name(case)}: {_reason(case)}")
    for name in [name for name, case in first.items() if _failed(case) and not _failed(cases[name])]:
        print(f"passed at the second attempt, alone: {name}")
    passed = len(cases) - len(skipped) - len(failed)
    print(f"{passed} passed, {len(failed) + len(wrong)} failed, {len(skipped)} skipped")
    return int(status) or bool(failed or wrong or not cases)


def _cases(report: str) -> Cases:
    """Return the cases of a report by name; of one with two entries (its teardown failed, too) the failed one."""
    if not Path(report).exists():
        return {}
    cases: Cases = {}
    for case in ElementTree.parse(report).iter("testcase"):  # noqa: S314 - written by pytest a moment ago
        if _name(case) not in cases or _failed(case):
            cases[_name(case)] = case
    return cases


def _name(case: ElementTree.Element) -> str:
    return f"{case.get('classname')}.{case.get('name')}"


def _failed(case: ElementTree.Element) -> bool:
    return case.find("failure") is not None or case.find("error") is not None


def _reason(case: ElementTree.Element) -> str:
    skipped = case.find("skipped")
    return "" if skipped is None else f"{skipped.get('message')} {skipped.text}"


if __name__ == "__main__":
    sys.exit({"few": few, "closing": closing}[sys.argv[1]](*sys.argv[2:]))

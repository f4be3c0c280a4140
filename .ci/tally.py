"""Tally junit reports: fail on a skip that this machine should not need, print the closing line."""

import sys
from pathlib import Path
from xml.etree import ElementTree

ALLOWED = ("hardware", "../shared")  # a real device; recordings and the paper, which are not in the repository


def main(status: str, *reports: str) -> int:
    """Print how many tests passed, failed and were skipped; return the exit code."""
    cases: dict[str, ElementTree.Element] = {}
    for report in filter(Path.exists, map(Path, reports)):
        for case in ElementTree.parse(report).iter("testcase"):  # noqa: S314 - written by pytest a moment ago
            if _name(case) not in cases or _failed(case):  # one whose teardown failed, too, has two entries
                cases[_name(case)] = case
    skipped = [case for case in cases.values() if case.find("skipped") is not None]
    failed = [case for case in cases.values() if _failed(case)]
    wrong = [case for case in skipped if not any(word in _reason(case) for word in ALLOWED)]
    for case in wrong:
        print(f"skipped, but should run here: {_name(case)}: {_reason(case)}")
    passed = len(cases) - len(skipped) - len(failed)
    print(f"{passed} passed, {len(failed) + len(wrong)} failed, {len(skipped)} skipped")
    return int(status) or bool(failed or wrong or not cases)


def _name(case: ElementTree.Element) -> str:
    return f"{case.get('classname')}.{case.get('name')}"


def _failed(case: ElementTree.Element) -> bool:
    return case.find("failure") is not None or case.find("error") is not None


def _reason(case: ElementTree.Element) -> str:
    skipped = case.find("skipped")
    return "" if skipped is None else f"{skipped.get('message')} {skipped.text}"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

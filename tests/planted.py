#!/usr/bin/env python3
# Each change of planted.jsonl must still be one: its text stands once in the code.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: planted.py ROOT    fails with a line for each change that could not be made any more.

`tests/mutate.py --planted tests/planted.jsonl` makes these changes and says which tests notice.
"""
import json
import sys
from pathlib import Path


def main(root):
    rows = [json.loads(line) for line in
            (root / "tests" / "planted.jsonl").read_text().splitlines()]
    wrong = 0
    for row in rows:
        path = root / row["file"]
        times = path.read_text().count(row["from"]) if path.is_file() else 0
        if times != 1 or row["from"] == row["to"]:
            print(f"{row['file']} holds {times} times: {row['from']}")
            wrong += 1
    print(f"{len(rows)} planted changes, {wrong} that cannot be made")
    return 1 if wrong or not rows else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))

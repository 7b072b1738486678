#!/usr/bin/env python3
# Reads the includes: a room may include itself and the rooms below it, and no other.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: layers.py ROOT    fails with a line for each include that runs up or across."""
import re
import sys
from pathlib import Path

# From the ground up; rooms in one line do not know each other.
FLOORS = [
    ["base"],
    ["keys", "state"],
    ["domain"],
    ["pairs"],
    ["gravity", "solver"],
    ["engine"],
    ["rigid", "potential", "penalty", "solid"],
    ["scene"],
    ["analysis"],
    ["output"],
    ["run"],
    ["main.cpp", "memory.cpp"],
]
LEVEL = {room: level for level, floor in enumerate(FLOORS) for room in floor}
# Where public headers live that are not of the ground floor.
PUBLIC = {"bodies.hpp": "state", "scene.hpp": "scene", "spall.hpp": "run", "simulation.hpp": "run"}


def room_of(path):
    """The room of a file below src, or of a public header "spall/x.hpp"."""
    parts = path.split("/")
    return PUBLIC.get(parts[1], "base") if parts[0] == "spall" else parts[0]


def main(root):
    files = [(p, str(p.relative_to(root / "src"))) for p in (root / "src").rglob("*.[ch]pp")]
    files += [(p, str(p.relative_to(root / "include"))) for p in (root / "include").rglob("*.hpp")]
    wrong, includes = [], 0
    for path, name in files:
        own = room_of(name)
        if own not in LEVEL:
            wrong.append(f"{name}: the room {own} is on no floor of tests/layers.py")
            continue
        for included in re.findall(r'^#include "([^"]+)"', path.read_text(), re.M):
            includes += 1
            room = room_of(included)
            if room != own and LEVEL.get(room, len(FLOORS)) >= LEVEL[own]:
                wrong.append(f"{name} includes {included}: {own} may not know {room}")
    print("\n".join(wrong) or f"{len(files)} files, {includes} includes: none runs up")
    return 1 if wrong or includes == 0 else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))

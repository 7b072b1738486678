# The values of a source that a case names, each beside the result that it is to be compared with.
# SPDX-License-Identifier: BSD-3-Clause
import math
import os
import re
import sys
import tomllib


def look_up(results, key):
    """"deflection.dv", or "read_out.dv[51]": the entry of a column at 51 s; None without one."""
    match = re.fullmatch(r"(\w+)\.(\w+)(?:\[(.+)\])?", key)
    if not match:
        raise ValueError(f"key = \"{key}\" is not like \"deflection.dv\" or \"read_out.dv[51]\"")
    section, name, at = match.groups()
    table = results.get(section, {})
    if at is None:
        return table.get(name)
    for time, value in zip(table.get("since_impact", []), table.get(name, [])):
        if math.isclose(time, float(at), rel_tol=1e-6):
            return value
    return None


class Row:
    """A value of the source, the corrected one (None: as printed), and what the run gave."""

    def __init__(self, row, results):
        unknown = set(row) - {"name", "key", "printed", "check", "unit", "source", "note", "when"}
        if unknown or not {"name", "key"} <= set(row):
            raise ValueError(f"the row \"{row.get('name', '')}\" " + (
                f"has an unknown key, {min(unknown)}" if unknown else "needs a name and a key"))
        self.name, self.key, self.when = row["name"], row["key"], row.get("when", {})
        self.printed, self.check = row.get("printed"), row.get("check")
        self.unit, self.source, self.note = (row.get(k, "") for k in ("unit", "source", "note"))
        self.result = look_up(results, self.key)
        self.applies = all(
            math.isclose(results.get("case", {}).get(k, math.nan), value, rel_tol=1e-9)
            for k, value in self.when.items())


class Reference:
    def __init__(self, path, results):
        try:
            with open(path, "rb") as file:
                table = tomllib.load(file)
            self.title, self.source = table.get("title", "the source"), table.get("source", "")
            self.rows = [Row(row, results) for row in table.get("row", [])]
        except (KeyError, ValueError) as error:
            sys.exit(f"'{path}': {error}")
        self.rows = [row for row in self.rows if row.applies]


def read_reference(folder, results):
    """What a run kept beside its results; None where its case names no source."""
    path = os.path.join(folder, "reference.toml")
    return Reference(path, results) if os.path.exists(path) else None

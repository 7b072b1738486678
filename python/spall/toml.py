"""Tables of Python as the text of a case."""


def to_toml(tables):
    """Of dicts, lists of dicts, lists, texts, numbers, booleans."""
    lines = []
    write(tables, "", lines)
    return "\n".join(lines) + "\n"


def write(table, path, lines):
    plain = {k: v for k, v in table.items() if not is_table(v) and not is_list_of_tables(v)}
    for key, value in plain.items():
        lines.append(f"{name(key)} = {inline(value)}")
    for key, value in table.items():
        inner = f"{path}.{name(key)}" if path else name(key)
        if is_table(value):
            lines.append(f"[{inner}]")
            write(value, inner, lines)
        elif is_list_of_tables(value):
            for row in value:
                lines.append(f"[[{inner}]]")
                write(row, inner, lines)


def is_table(value):
    return isinstance(value, dict)


def is_list_of_tables(value):
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(map(is_table, value))


def name(key):
    plain = key and all(c.isascii() and (c.isalnum() or c in "_-") for c in key)
    return key if plain else text(key)


def text(value):
    escaped = "".join(f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c
                      for c in value.replace("\\", "\\\\").replace('"', '\\"'))
    return f'"{escaped}"'


def inline(value):
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:  # a number or a truth of NumPy
        value = value.item()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return text(value)
    if is_table(value):
        return "{" + ", ".join(f"{name(k)} = {inline(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)) or hasattr(value,
                                                   "tolist") and getattr(value, "ndim", 0) > 0:
        return "[" + ", ".join(inline(v) for v in value) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"{value!r} is neither number, text, list nor table")


def overrides_of(changes):
    """{'contact.friction': 0.3} as after --set; a list of such texts stays as it is."""
    if changes is None:
        return []
    if isinstance(changes, dict):
        for key, value in changes.items():
            if value is None:
                raise TypeError(f"{key} is None: a key is left out where it is not named")
        return [f"{key}={value if isinstance(value, str) else inline(value)}"
                for key, value in changes.items()]
    return list(changes)

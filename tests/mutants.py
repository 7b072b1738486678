#!/usr/bin/env python3
# Changes of the code that a test should notice: drawn at random, and put into it asleep.
# SPDX-License-Identifier: BSD-3-Clause
"""The part of tests/mutate.py that knows C++.

A change is (kind, file, at, before, after). One that sleeps is woken by SPALL_MUTANT=k when the
program starts; mutants.hpp tells how. Asleep it does as the code did before. Awake it is the same
change as that of the text: operators keep their operands, since the language finds them.
"""
import itertools
import json
import random
import re
import sys


# Drawing -----------------------------------------------------------------------------------------

def code_only(text):
    """The text with everything that is not code replaced by blanks, newlines kept."""
    pattern = re.compile(
        r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\''
        r"|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*|\bstatic_assert\((?:[^;]*);|\btemplate <[^\n]*",
        re.S | re.M)
    return pattern.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def other_number(text):
    """0 -> 1, n -> n + 1, x -> 1.3 x."""
    if re.fullmatch(r"\d+", text):
        return str(int(text) + 1)
    return repr(float(text) * 1.3) if float(text) else "1.0"


OPERATORS = {"+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||",
               "||": "&&"}
KINDS = {
    # Between blanks: template brackets, pointers and references stand at their type.
    "operator": (re.compile(r"(?<=\s)([-+*/]=?)(?=\s)"), OPERATORS.get),
    "sign": (re.compile(r"(?:(?<=[(\[{=,?:] )|(?<=[(\[{])|(?<=return ))(-)(?=[\w(])"),
             lambda _: ""),
    "constant": (re.compile(r"(?<![\w.<])((?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)(?![\w.'>])"),
                 other_number),
    "comparison": (re.compile(r"(?<=\s)(<=?|>=?|==|!=|&&|\|\|)(?=\s)"), COMPARISONS.get),
    # An assignment or a call that fills a line and follows a whole statement.
    "statement": (re.compile(r"(?<=[;{}]\n)[ \t]+([a-z_][\w.\[\]:]*"
                             r"(?: [-+*/]?= [^;\n]*|\([^;\n]*\));)(?=\s*\n)"), lambda _: ""),
}


def find_places(texts, only, kinds):
    """All places: kind -> list of (file, offset, before, after), in the order of the files."""
    places = {kind: [] for kind in kinds}
    for name, text in texts.items():
        if only and not re.search(only, name):
            continue
        code = code_only(text)
        for kind in kinds:
            pattern, change = KINDS[kind]
            for found in pattern.finditer(code):
                before = text[found.start(1):found.end(1)]
                places[kind].append((name, found.start(1), before, change(before)))
    return places


def draw(places, seed):
    """Endless until nothing is left: kinds alike, places of a kind alike, none twice."""
    rng = random.Random(seed)
    left = {kind: list(found) for kind, found in places.items() if found}
    while left:
        kind = rng.choice(sorted(left))
        yield kind, *left[kind].pop(rng.randrange(len(left[kind])))
        if not left[kind]:
            del left[kind]


def read_planted(path, texts):
    """Changes chosen by hand: JSON lines of a file, a text that it holds once, and another."""
    for line in path.read_text().splitlines():
        row = json.loads(line)
        text = texts[row["file"]]
        if text.count(row["from"]) != 1:
            sys.exit(f"{path}: {row['file']} does not hold once: {row['from']}")
        yield "planted", row["file"], text.index(row["from"]), row["from"], row["to"]


# Changes that sleep ------------------------------------------------------------------------------

TOKEN = re.compile(r"\d+\.?\d*(?:e[-+]?\d+)?|\w+|::|[-+*/=!<>]=|&&|\|\||->|[^\s\w]|\s+")
ENDS = {";", ",", "?", ":", "=", "return"}  # of a logical expression


def narrowed(kind, at, before, after):
    """A planted change as one of the other kinds, where it is a token or a whole statement."""
    if kind != "planted":
        return kind, at, before, after
    if not after and before.endswith(";"):
        return "statement", at, before, after
    old, new = TOKEN.findall(before), TOKEN.findall(after)
    while old and new and old[0] == new[0]:
        at += len(old.pop(0))
        new.pop(0)
    while old and new and old[-1] == new[-1]:
        old.pop(), new.pop()
    if len(old) == len(new) == 1:
        if new[0] in (OPERATORS.get(old[0]), COMPARISONS.get(old[0])):
            return "operator", at, old[0], new[0]
        if old[0][0].isdigit() and new[0][0].isdigit():
            return "constant", at, old[0], new[0]
    return kind, at, before, after


def logical_expression(code, at):
    """Begin and end of the whole expression of && and ||, one of which stands at this place."""
    tokens = [m for m in TOKEN.finditer(code) if not m[0].isspace()]
    here = next(i for i, token in enumerate(tokens) if token.start() == at)

    def beside(step, opening, closing):
        depth, i = 0, here + step
        while depth or not (tokens[i][0] in ENDS or tokens[i][0] in closing):
            depth += (tokens[i][0] in opening) - (tokens[i][0] in closing)
            i += step
        return tokens[i]
    return beside(-1, ")]}", "([{").end(), beside(1, "([{", ")]}").start()


def without_constexpr(code, at):
    """The edits by which the variable whose definition this place is in gets its value at run."""
    begin = code.rfind(";", 0, at) + 1
    if re.match(r"\s*} \w", code[begin:at]):  # of a struct that is defined with it
        begin = code.rfind(";", 0, code.rfind("{", 0, begin)) + 1
    found = re.finditer(r"(\bstatic )?\bconstexpr(?= [^()]*[={])", code[begin:at])
    return [(begin + m.start(), begin + m.end(), "static inline const" if m[1] else "const")
            for m in found]


def edits(text, code, k, kind, at, before, after):
    """What to put in, as (begin, end, new), so that the k-th change sleeps; None if it cannot."""
    kind, at, before, after = narrowed(kind, at, before, after)
    end, awake = at + len(before), f"spall_mutants::awake({k})"
    if kind == "planted":
        return None
    if kind == "statement":
        made = [(at, at, f"if (!{awake}) ")]
    elif kind == "constant":
        made = [(at, end, f"({awake} ? {after} : {before})")]
    elif kind == "sign":
        made = [(end, end, f"spall_mutants::at({k}) * ")]
    elif before in ("&&", "||"):
        begin, stop = logical_expression(code, at)
        changed = text[begin:at] + after + text[end:stop]
        changed = re.sub(r"(?://[^\n]*)?\n\s*", " ", changed)
        made = [(begin, begin, f"({awake} ? ({changed}) : ("), (stop, stop, "))")]
    else:
        made = [(end, end, f" spall_mutants::at({k}) {before}")]
    return made + without_constexpr(code, at)


def with_sleeping(text, places, header, loose=(), instead=None):
    """The text with changes {number: (kind, at, before, after)}; its lines keep their numbers.

    `loose` are edits besides, and `instead` is that of a change that does not sleep.
    """
    code = code_only(text)
    made = [edits(text, code, k, *place) for k, place in places.items()]
    if instead:
        made = [of for of in made
                if not any(e[0] < instead[1] and e[1] > instead[0] for e in of)] + [[instead]]
    parts, done = [f'#include "{header}"\n#line 1\n'], 0
    for begin, end, new in sorted([*itertools.chain.from_iterable(made), *loose]):
        if begin >= done:  # the same constexpr may be in the way of several
            parts += [text[done:begin], new]
            done = end
    return "".join(parts) + text[done:]

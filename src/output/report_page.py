# The page of one or more runs: words and tables here, the view and the plots in page/.
# SPDX-License-Identifier: BSD-3-Clause
import base64
import html
import json
import os

from report_bodies import PARTS_OF_RADIUS, pack_series
from report_reference import read_reference
from report_verdict import verdicts

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = {"three": "three/three.module.min.js", "orbit": "three/OrbitControls.js",
           "packed": "page/packed.js",
           "bodies": "page/bodies.js", "colors": "page/colors.js", "seen": "page/seen.js",
           "plots": "page/plots.js", "page": "page/page.js"}
HEADLINES = [("deflection", "dv", "dv, m/s"), ("deflection", "beta_along", "β along the flight"),
             ("deflection", "dT_min", "change of the period, min"),
             ("ejecta", "count", "bodies ejected"),
             ("debris", "front_over_speed", "front / speed of impact"),
             ("debris", "hole_over_diameter", "hole / D"),
             ("pile", "packing_fraction", "packing fraction"),
             ("conservation", "linear", "drift of momentum"),
             ("conservation", "energy_unexplained", "energy unexplained"),
             ("time", "total_s", "seconds of computing")]
GRADES = {"good": ("✓", "good"), "note": ("!", "to note"), "bad": ("✕", "bad")}
escape = html.escape


def read(name):
    with open(os.path.join(HERE, name), encoding="utf-8") as file:
        return file.read()


def number(value, digits=6):
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    if isinstance(value, list):
        return ", ".join(number(one, digits) for one in value)
    return escape(str(value))


def table(lines, heading=(), kind=""):
    """Rows of cells that are HTML already; it scrolls within itself."""
    cells = "".join(f"<th scope=col>{cell}" for cell in heading)
    head = f"<thead><tr>{cells}</tr></thead>" if heading else ""
    body = "".join(f"<tr><th scope=row>{first}{''.join(f'<td>{cell}' for cell in rest)}</tr>"
                   for first, *rest in lines)
    return ("<div class=scroll tabindex=0 role=group aria-label=Table>"
            f"<table class='{kind}'>{head}<tbody>{body}</tbody></table></div>")


def origin(run):
    """What made the run: all that it told of that, but for its case."""
    told = {"folder": os.path.abspath(run.folder),
            **{key: value for key, value in run.origin.items() if value != ""}}
    told.pop("title", None)
    seeds = [f"{key}: {value}" for key, value in flat(run.case) if key.endswith(".seed")]
    rows = [(key.replace("_", " "), number(value)) for key, value in told.items()]
    return table(rows + ([("seeds of groups", escape(", ".join(seeds)))] if seeds else []),
                 kind="facts")


def cards(run):
    """The few figures that matter most, where the run has them."""
    found = [(told.get(key), name + section[len(asked):].replace("_", " behind ", 1))
             for asked, key, name in HEADLINES for section, told in run.results.items()
             if section == asked or asked == "debris" and section.startswith("debris_")]
    items = [f"<div><dt>{name}<dd>{number(value, 4)}</div>" for value, name in found
             if value is not None]
    return f"<dl class=cards>{''.join(items)}</dl>" if items else ""


def judgement(run):
    lines = []
    for grade, sentence in verdicts(run):
        sign, word = GRADES[grade]
        lines.append(
            f"<li class={grade}><span aria-label='{word}' role=img>{sign}</span>{escape(sentence)}")
    return f"<ul class=verdicts>{''.join(lines)}</ul>"


def results_of(runs):
    """A table a section; of several runs a column each, and where they differ is marked."""
    sections = {section: {key: None for run in runs for key in run.results.get(section, {})}
                for run in runs for section in run.results}
    parts = []
    for section, keys in sections.items():
        lines = []
        for key in keys:
            values = [run.results.get(section, {}).get(key) for run in runs]
            note = next((note for run in runs if (note := run.notes.get((section, key)))), "")
            texts = ["" if value is None else number(value) for value in values]
            if len(runs) > 1 and not all(same(value, values[0]) for value in values):
                texts = [f"<b>{text}</b>" for text in texts]
            lines.append((key, *texts, f"<span class=note>{escape(note)}</span>"))
        heading = ["", *(escape(name_of(run, runs)) for run in runs), ""] if len(runs) > 1 else ()
        parts.append(f"<section><h3>{section.replace('_', ' ')}</h3>"
                     f"{table(lines, heading, 'values')}</section>")
    return f"<div class='{'tables' if len(runs) == 1 else ''}'>{''.join(parts)}</div>"


def beside(reference):
    """The source's values and this run's, a row each."""
    def cell(value, unit=""):
        if value is None:
            return ""
        text = " to ".join(number(one)
                           for one in value) if isinstance(value, list) else number(value)
        return f"{text} <span class=note>{escape(unit)}</span>"

    lines = []
    for row in reference.rows:
        where = f"<br><span class=note>{escape(row.source)}</span>" if row.source else ""
        lines.append((escape(row.name) + where, cell(row.printed, row.unit),
                      cell(row.check, row.unit),
                      f"<b>{cell(row.result, row.unit)}</b>",
                      f"<span class=note>{escape(row.note)}</span>"))
    return (f"<h2>Beside {escape(reference.title)}</h2><p>{escape(reference.source)}</p>"
            + table(lines, ("", "source", "corrected", "this run", "note"), "values"))


def rows_of_text(lines):
    """A table of texts, the first line its heading."""
    heading, *rest = [[escape(cell) for cell in line] for line in lines]
    return table(rest, heading, "values")


def name_of(run, runs):
    """The end of the folder's name; more of it where two runs would have the same."""
    path = os.path.abspath(run.folder)
    same = sum(os.path.basename(os.path.abspath(one.folder)) == os.path.basename(path)
               for one in runs)
    return os.path.basename(path) if same < 2 else os.path.join(*path.split(os.sep)[-2:])


def summary(run):
    """What changes while a run goes on, beside its bodies and its series."""
    return judgement(run) + cards(run)


def details(run):
    """Tables below the pictures."""
    reference = run.results and read_reference(run.folder, run.results)
    return ((beside(reference) if reference else "")
            + (f"<h2>Results</h2>{results_of([run])}" if run.results else ""))


def scale_of_momentum(run):
    """kg m/s by which drifts are divided, and its name; None while it is not known."""
    case, pile = run.results.get("case", {}), run.results.get("pile", {})
    if "impactor_mass" in case and "impactor_speed" in case:
        return case["impactor_mass"] * case["impactor_speed"], "of the impactor's"
    fastest = run.series["rms_speed"].max(initial=0)
    return (pile["mass"] * fastest,
            "of sum m |v|") if pile.get("mass") and fastest > 0 else (None, "")


def series_of(run):
    momentum, of_what = scale_of_momentum(run)
    return {"series": pack_series(run), "impact": run.impact_time(), "momentum": momentum,
            "momentumName": of_what,
            "free": run.is_free()}


def data_of(run, name, bodies, numbers):
    """What page/page.js draws; `numbers` are the snapshots to carry."""
    frames = [frame for number in numbers if (frame := bodies.frame(number))]
    return {"name": name, "bodies": bodies.header(), "snapshots": len(run.snapshots()),
            "frames": frames,
            "size": run.results.get("pile", {}).get("mean_diameter"), **series_of(run)}


def page(runs, data, pictures="", live=False):
    """The whole page as text. Nothing in it is fetched from elsewhere."""
    one = runs[0] if len(runs) == 1 else None
    title = one.title if one else " and ".join(name_of(run, runs) for run in runs)
    imports = {name: "data:text/javascript;base64," + base64.b64encode(read(path).encode()).decode()
               for name, path in MODULES.items()}
    # An end tag inside the data would end the script that carries them.
    carried = json.dumps({"live": live, "runs": data}, allow_nan=False).replace("</", "<\\/")
    if one:
        text = (f"<p class=lead "
                f"id=lead>{lead(one)}</p>{'<p id=live role=status></p>' * live}<section "
                f"id=summary>{summary(one)}</section>"
                f"<div id=views></div><h2>The run in time</h2><div id=plots></div>{pictures}"
                f"<div id=details>{details(one)}</div>"
                f"<h2>What made it</h2>{origin(one)}{case_of(one)}")
    else:
        columns = "".join(f"<section><h2>{escape(name_of(run, runs))}</h2><p "
                          f"class=lead>{escape(run.title)}. {lead(run)}</p>"
                          f"{judgement(run)}{origin(run)}</section>" for run in runs)
        text = (f"<div class=runs>{columns}</div><div id=views></div><h2>The runs in time</h2><div "
                f"id=plots></div>"
                f"<h2>Results</h2>{results_of(runs)}<h2>What differs in the "
                f"cases</h2>{differences(runs)}")
    return (f"<!doctype html><html lang=en><head><meta charset=utf-8><title>{escape(title)}</title>"
            "<meta name=viewport content='width=device-width, initial-scale=1'>"
            f"<link rel=icon "
            f"href='data:,'><style>{read('uplot/uPlot.min.css')}{read('page/page.css')}</style>"
            f"<script type=importmap>{json.dumps({'imports': imports})}</script></head><body>"
            f"<main><header><h1>{escape(title)}</h1></header>{text}"
            f"<footer>{footer(data)}</footer></main>"
            f"<script type=application/json id=data>{carried}</script>"
            f"<script>{read('uplot/uPlot.iife.min.js')}</script>"
            "<script type=module>import 'page';</script></body></html>")


def lead(run):
    ranks = run.origin["ranks"]
    return (f"{ranks} rank{'s' if ranks > 1 else ''}, {len(run.snapshots())} snapshots, "
            f"{len(run.series['time'])} rows in the series")


def footer(data):
    """How what is shown differs from what the run wrote."""
    parts = []
    for run in data:
        bodies, name = run["bodies"], f"{escape(run['name'])}: " if len(data) > 1 else ""
        parts.append(f"{name}Places are rounded to {bodies['step']:.2g} m, a {PARTS_OF_RADIUS}th "
                     f"of the smallest radius, "
                     "fields to three digits.")
        if bodies["shown"] < bodies["all"]:
            parts.append(
                f"Of {bodies['all']} bodies {bodies['shown']} are shown, equally far apart in "
                f"their numbers.")
        if run["series"]["rows"] < run["series"]["all"]:
            parts.append(
                f"Of {run['series']['all']} rows of the series {run['series']['rows']} are drawn.")
        if run["frames"] and len(run["frames"]) < run["snapshots"]:
            parts.append(f"Of {run['snapshots']} snapshots {len(run['frames'])} are here.")
    return " ".join(parts) + " Walls are not drawn."


def same(one, other):
    """Of results, lists of them too; two that are no numbers are the same."""
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other or (one != one and other != other)


def case_of(run):
    """The case as the run read it."""
    with_text = run.case_text.strip()
    return ("<details><summary>The case</summary>"
            f"<pre tabindex=0>{escape(with_text)}</pre></details>")


def flat(case, place=""):
    """Dotted key and value of everything in a case."""
    for key, value in case.items():
        inner = f"{place}.{key}".strip(".")
        if isinstance(value, dict):
            yield from flat(value, inner)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            for k, one in enumerate(value):
                yield from flat(one, f"{inner}.{one.get('name', k)}")
        else:
            yield inner, value


def differences(runs):
    cases = [dict(flat(run.case)) for run in runs]
    keys = {key: None for case in cases for key in case}
    lines = [(escape(key), *(number(case[key]) if key in case else "" for case in cases))
             for key in keys
             if any(case.get(key) != cases[0].get(key) for case in cases)]
    if not lines:
        return "<p>The cases are the same.</p>"
    return table(lines, ["", *(escape(name_of(run, runs)) for run in runs)], "values")

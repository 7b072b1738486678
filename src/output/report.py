# One page about a run: pictures, curves and the table of results, from the folder that it wrote.
# SPDX-License-Identifier: BSD-3-Clause
import base64
import glob
import html
import io
import os
import re
import sys

from system_python import need

need("spall report", "h5py", "numpy", "matplotlib")

import h5py  # noqa: E402
import numpy as np  # noqa: E402
import tomllib  # noqa: E402

GRAVITY = 6.67430e-11


class Frame:
    """The bodies that are there at one time."""

    def __init__(self, time, position, velocity, radius, mass):
        self.time, self.position, self.velocity = time, position, velocity
        self.radius, self.mass = radius, mass

    def without(self, body):
        keep = np.arange(len(self.radius)) != body
        return Frame(self.time, self.position[keep], self.velocity[keep], self.radius[keep],
                     self.mass[keep])


class GravityMap:
    """Gravity's field on a grid of points, as a snapshot holds it: indices are x, y, z."""

    def __init__(self, group):
        self.counts = group["counts"][:]
        self.low, self.spacing = np.ravel(group["low"]), float(group["spacing"][0])
        shape = tuple(self.counts[::-1])
        self.potential = group["potential"][:].reshape(shape).T
        self.acceleration = np.moveaxis(group["acceleration"][:].reshape(*shape, 3).T, 0, -1)


class Run:
    """What a run left in its folder."""

    def __init__(self, folder):
        self.folder = folder
        with h5py.File(self.need("trajectory.h5")) as file:
            all_bodies = file["particles/all"]
            self.case = tomllib.loads(file["parameters/case"][()].decode())
            time = all_bodies["position/time"][:]
            first = self.frame(all_bodies, 0, time)
            self.after = self.frame(all_bodies, len(time) - 1, time)
            count = len(first.radius)
            self.impactor = count if len(self.after.radius) == count + 1 else -1
            self.before = first
            if self.impactor >= 0:
                there = ~np.isnan(all_bodies["position/value"][:, count, 0])
                self.before = self.frame(all_bodies, int(np.argmax(there)) - 1, time)
        self.gravity = None
        with h5py.File(sorted(glob.glob(os.path.join(folder, "snapshots", "*.h5")))[-1]) as file:
            if "fields/gravity" in file:
                self.gravity = GravityMap(file["fields/gravity"])
        self.has_impact = self.impactor >= 0
        self.flight = np.array([1.0, 0, 0])
        self.impactor_text = ""
        for phase in self.case.get("phases", []):
            if "impactor" in phase:
                flight = np.array(phase["impactor"].get("direction", [1, 0, 0]), float)
                self.flight = flight / np.linalg.norm(flight)
                parts = [phase["impactor"].get(key) for key in ("mass", "speed")]
                self.impactor_text = ", ".join(str(part) for part in parts if part is not None)
        self.series = self.read_series()
        self.results, self.notes = self.read_results()
        pile = self.results.get("pile", {})
        self.size = pile.get("mean_diameter") or 2 * np.linalg.norm(
            self.before.position - np.median(self.before.position, axis=0), axis=1).max()

    def need(self, name):
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            sys.exit(f"spall report: '{path}' is missing: is '{self.folder}' the folder of a run?")
        return path

    @staticmethod
    def frame(all_bodies, k, time):
        position = all_bodies["position/value"][k]
        there = ~np.isnan(position[:, 0])
        return Frame(time[k], position[there], all_bodies["velocity/value"][k][there],
                     all_bodies["radius"][:][there], all_bodies["mass"][:][there])

    def read_series(self):
        path = self.need("series.csv")
        with open(path) as file:
            names = file.readline().strip().split(",")
        rows = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
        return dict(zip(names, rows.T)) if len(rows) else {name: np.zeros(0) for name in names}

    def read_results(self):
        """Values, and the unit and note that stand behind each of them as a comment."""
        path = os.path.join(self.folder, "results.toml")
        if not os.path.exists(path):
            return {}, {}
        with open(path) as file:
            text = file.read()
        notes, section = {}, ""
        for line in text.splitlines():
            if match := re.fullmatch(r"\[(\w+)\]", line):
                section = match[1]
            elif match := re.match(r"(\w+) = .*  # (.*)", line):
                notes[section, match[1]] = match[2]
        return tomllib.loads(text), notes

    def side_view(self):
        """Toward the viewer and up, so that the impactor flies from left to right."""
        up = np.array([0, 0, 1.0]) if abs(self.flight[2]) < 0.9 else np.array([0, 1.0, 0])
        up -= (up @ self.flight) * self.flight
        up /= np.linalg.norm(up)
        return np.cross(self.flight, up), up

    def name_of(self, frame):
        from report_figures import readable_time
        if not self.has_impact:
            return f"{readable_time(frame.time)} after the start"
        if frame is self.before:
            return "before the impact"
        return f"{readable_time(frame.time - self.before.time)} after the impact"

    def marked_speeds(self):
        from report_figures import BLUE, GREEN
        mass = self.before.mass[np.isfinite(self.before.mass)].sum()
        marks = []
        if "gravity" in self.case:
            marks.append((np.sqrt(4 * GRAVITY * mass / self.size), "escape", GREEN))
        if dv := self.results.get("deflection", {}).get("dv"):
            if dv > 0:
                marks.append((dv, "dv", BLUE))
        return marks

    def series_parts(self):
        """Name, x, label of x, whether x is logarithmic, and rows: up to the impact, and since."""
        time = self.series["time"]
        split = self.before.time if self.has_impact else np.inf
        first = time < split * (1 - 1e-12)
        unit, name = (3600, "h") if time[first].max(initial=0) > 7200 else (1, "s")
        parts = []
        for chosen, title in ((first, "Up to the impact" if self.has_impact else "The run"),
                              (~first, "Since the impact")):
            rows = {key: values[chosen] for key, values in self.series.items()}
            if len(rows["time"]) < 2:
                continue
            if title == "Since the impact":
                since = rows["time"] - split
                # The first row stands at 0, where a logarithm ends: half a step of the next.
                since[0] = max(since[0], since[1] / 2)
                parts.append((title, since, "time since the impact (s)", True, rows))
            else:
                parts.append((title, rows["time"] / unit, f"time ({name})", False, rows))
        return parts

    def momentum_measure(self, rows):
        if self.has_impact:
            deflection = self.results.get("deflection", {})
            if "dv_plastic" in deflection:
                return deflection["dv_plastic"] * self.before.mass.sum()
            impactor = self.after.mass[self.impactor]
            return impactor * np.linalg.norm(self.after.velocity[self.impactor]) or 1.0
        mass = self.after.mass[np.isfinite(self.after.mass)].sum()
        return mass * max(rows["rms_speed"].max(), 1e-300)


def number(value):
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return ", ".join(number(one) for one in value)
    return html.escape(str(value))


def headline(run):
    """The few figures that matter most, where the run has them."""
    wanted = [("deflection", "dv", "dv, m/s"), ("deflection", "beta", "momentum enhancement β"),
              ("deflection", "dT_min", "change of the period, min"),
              ("ejecta", "count", "bodies ejected"),
              ("debris", "front_over_speed", "front / speed of impact"),
              ("debris", "hole_over_diameter", "hole / D"),
              ("pile", "packing_fraction", "packing fraction"),
              ("conservation", "linear", "drift of momentum"),
              ("conservation", "energy_unexplained", "energy unexplained"),
              ("time", "total_s", "seconds of computing")]
    cards = []
    for section, key, name in wanted:
        value = run.results.get(section, {}).get(key)
        if value is not None:
            text = f"{value:.4g}" if isinstance(value, float) else str(value)
            cards.append(f"<div class=card><b>{text}</b><span>{name}</span></div>")
    return f"<div class=cards>{''.join(cards)}</div>"


def tables(run):
    parts = []
    for section, rows in run.results.items():
        lines = []
        for key, value in rows.items():
            note = html.escape(run.notes.get((section, key), ""))
            lines.append(f"<tr><td>{key}</td><td class=value>{number(value)}</td>"
                         f"<td class=note>{note}</td></tr>")
        parts.append(f"<section><h3>{section}</h3><table>{''.join(lines)}</table></section>")
    return f"<div class=tables>{''.join(parts)}</div>"


def beside(reference):
    """The source's values and this run's, a row each."""
    def cell(value, unit=""):
        if value is None:
            return "<td class=value></td>"
        if isinstance(value, list):
            value = " to ".join(number(one) for one in value)
        else:
            value = number(value)
        return f"<td class=value>{value} <span class=note>{html.escape(unit)}</span></td>"

    lines = ["<tr><th><th class=value>source<th class=value>corrected<th class=value>this run"
             "<th>note</tr>"]
    for row in reference.rows:
        where = f"<br><span class=note>{html.escape(row.source)}</span>" if row.source else ""
        lines.append(f"<tr><td>{html.escape(row.name)}{where}</td>{cell(row.printed, row.unit)}"
                     f"{cell(row.check, row.unit)}{cell(row.result, row.unit)}"
                     f"<td class=note>{html.escape(row.note)}</td></tr>")
    return (f"<h2>Beside {html.escape(reference.title)}</h2><p>{html.escape(reference.source)}</p>"
            f"<section><table class=beside>{''.join(lines)}</table></section>")


def rows_of_text(lines):
    """A table of texts, the first line its heading."""
    heading, *rest = ["".join(f"<td>{html.escape(cell)}</td>" for cell in line) for line in lines]
    return (f"<section><table class=beside><tr>{heading.replace('td>', 'th>')}</tr>"
            + "".join(f"<tr>{line}</tr>" for line in rest) + "</table></section>")


STYLE = """
body { font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1c2430; background: #f6f7f9;
       margin: 0 auto; max-width: 1120px; padding: 24px; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 18px; margin: 36px 0 8px; }
h3 { font-size: 14px; margin: 0 0 4px; text-transform: capitalize; }
p { color: #5b6472; margin: 4px 0 12px; }
figure { margin: 12px 0; background: white; border-radius: 8px; overflow: hidden;
         box-shadow: 0 1px 3px #0002; }
img { display: block; width: 100%; } figcaption { padding: 8px 16px 12px; color: #5b6472; }
.cards { display: flex; flex-wrap: wrap; gap: 12px; margin: 20px 0; }
.card { flex: 1 1 120px; background: white; border-radius: 8px; padding: 12px 16px;
        box-shadow: 0 1px 3px #0002; }
.card b { display: block; font-size: 20px; } .card span { color: #5b6472; font-size: 13px; }
.tables { columns: 2 460px; column-gap: 16px; }
section { break-inside: avoid; background: white; border-radius: 8px; padding: 12px 16px;
          margin: 0 0 16px; box-shadow: 0 1px 3px #0002; }
table { border-collapse: collapse; width: 100%; font-size: 13px; }
td { padding: 2px 8px 2px 0; vertical-align: top; border-top: 1px solid #eef0f3; }
th { padding: 2px 8px 4px 0; text-align: left; font-weight: 600; }
.value { font-variant-numeric: tabular-nums; text-align: right; } .note { color: #5b6472; }
.beside td, .beside th { padding: 5px 16px 5px 0; }
.beside .value { white-space: nowrap; } .beside td:nth-child(4) { font-weight: 600; }
.beside td:first-child { white-space: nowrap; } .beside td .note { font-weight: 400; }
"""


def main(folder):
    run = Run(folder)
    import report_figures as figures
    from report_reference import read_reference
    pictures = os.path.join(folder, "report")
    os.makedirs(pictures, exist_ok=True)

    def figure(name, drawing, caption):
        """Saves a drawing beside the page and puts it into the page."""
        data = io.BytesIO()
        drawing.savefig(data, dpi=150, facecolor=drawing.get_facecolor())
        figures.plt.close(drawing)
        with open(os.path.join(pictures, name + ".png"), "wb") as file:
            file.write(data.getvalue())
        text = base64.b64encode(data.getvalue()).decode()
        return (f"<figure><img alt='{html.escape(name)}' src='data:image/png;base64,{text}'>"
                f"<figcaption>{caption}</figcaption></figure>")

    title = html.escape(run.case.get("title", os.path.basename(os.path.abspath(folder))))
    bodies = len(run.before.radius)
    body = [f"<h1>{title}</h1><p>{bodies} bodies, {len(run.series['time'])} rows in the series"
            f"{'' if run.results else '; the run has not ended: no results yet'}</p>",
            headline(run) if run.results else ""]
    body.append(figure("bodies", figures.before_and_after(run),
                       "The bodies, both from the same place and at the same scale."))
    body.append(figure("velocities", figures.velocities(run),
                       "Left: bodies behind the plane of the cut, coloured by speed; arrows: "
                       "velocity in the plane of the bodies next to it, length as the root of the "
                       "speed. Right: how many bodies have which speed, and velocity against place."))
    if run.results.get("cloud", {}).get("time"):
        import report_debris as debris
        body.append("<h2>Debris</h2>" + figure(
            "radiographs", debris.radiographs(run),
            "From the side, as on flash radiographs: dark where much mass is in the way."))
        body.append(figure("debris", debris.speeds(run),
                           "Left: debris more than a quarter of a diameter behind the plate. "
                           "Percentiles: 99th of speeds (front, radial), 1st (rear), mean."))
        if state := debris.state(run):
            body.append(figure("state", state, "A slice a sixth of a diameter thick through the axis, at the end. "
                               "Temperature: of the heat that damping left in a body, not of what its motion holds."))
        if "wall" in run.results:
            body.append(figure("wall", debris.wall(run, run.results["wall"]["distance"]),
                               "Debris that fly on freely; within the circles half and 90 % of the "
                               "momentum."))
    if run.gravity and sorted(run.gravity.counts)[1] > 1:
        body.append("<h2>Gravity</h2>" + figure(
            "gravity", figures.gravity(run),
            "Potential and pull of the bodies in the middle plane of the map; circles: bodies that "
            "it cuts; arrows: where the pull points."))
    deflection = run.results.get("deflection", {})
    if len(run.results.get("read_out", {}).get("dv", [])) > 0:
        lines = [(deflection[key], name) for key, name in (("dv_plastic", "m v / M"),
                 ("dv_elastic", "m v (1 + e) / M")) if key in deflection]
        body.append("<h2>Deflection</h2>" + figure(
            "deflection", figures.read_outs(run.results["read_out"], lines),
            "Velocity change of the largest clump along the flight of the impactor. It goes on "
            "changing while ejecta leave, so it is given with its time."))
    if run.results and (reference := read_reference(folder, run.results)):
        body.append(beside(reference))
    if parts := run.series_parts():
        body.append("<h2>The run in time</h2>" + figure(
            "series", figures.series(run, parts),
            "Energy (dissipated and freed: since the start of the column), drift of momentum, "
            "residual of the contact problem in each step, contacts."))
    import report_interior
    if inside := report_interior.interior(run):
        drawing, states = inside
        body.append("<h2>The inside</h2>" + figure(
            "interior", drawing,
            "The largest clump, cut through its centre: empty part of a cube two radii around each place; contacts near the "
            "plane of the flight, as wide as the root of their normal force; porosity of shells; contacts of a body; forces.")
            + rows_of_text(report_interior.table(states)))
    seconds = {key[:-2]: value for key, value in run.results.get("time", {}).items()
               if key.endswith("_s") and key != "total_s" and value > 0}
    if seconds:
        body.append("<h2>Where the time went</h2>" + figure(
            "stages", figures.stage_times(seconds), "Wall-clock seconds of the slowest rank."))
    if run.results:
        body.append("<h2>Results</h2>" + tables(run))
    page = os.path.join(folder, "report.html")
    with open(page, "w") as file:
        file.write(f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title>"
                   f"<style>{STYLE}</style>{''.join(body)}</html>")
    print(page)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: report.py <folder of a run>")
    main(os.path.dirname(sys.argv[1]) or "." if os.path.isfile(sys.argv[1]) else sys.argv[1])

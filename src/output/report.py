# One page about a run, or about several side by side: bodies in 3-D, curves, pictures and results.
# SPDX-License-Identifier: BSD-3-Clause
import base64
import html
import io
import os
import sys
import tomllib

from system_python import need

need("spall report", "h5py", "numpy", "matplotlib")

import numpy as np  # noqa: E402
from PIL import Image  # noqa: E402  (matplotlib needs it, too)
from report_bodies import Bodies  # noqa: E402
from report_page import data_of, name_of, page, rows_of_text  # noqa: E402
from report_run import Run  # noqa: E402


class Pictures:
    """Drawings, each saved beside the page and put into it."""

    def __init__(self, folder):
        self.folder = os.path.join(folder, "report")
        os.makedirs(self.folder, exist_ok=True)
        self.text = ""

    def add(self, name, drawing, caption, heading="", more=""):
        import report_figures as figures
        drawing.canvas.draw()  # once: savefig would draw it first to see how wide its texts are
        image = Image.fromarray(np.asarray(drawing.canvas.buffer_rgba())).convert("RGB")
        figures.plt.close(drawing)
        image.save(os.path.join(self.folder, name + ".png"), compress_level=3)
        small = io.BytesIO()  # a tenth of the size, and no eye tells them apart
        image.save(small, "webp", quality=85, method=2)
        text = base64.b64encode(small.getvalue()).decode()
        heading = f"<h2>{heading}</h2>" if heading else ""
        self.text += (f"{heading}<figure><div class=scroll tabindex=0 role=group "
                      f"aria-label=Picture><img alt='{html.escape(name)}' "
                      f"src='data:image/webp;base64,{text}'></div>"
                      f"<figcaption>{caption}</figcaption></figure>{more}")


def add_debris(pictures, run):
    import report_debris as debris
    for plate, end in debris.plates(run):
        if not run.results["cloud" + end].get("time"):
            continue
        flight = debris.Flight(run, plate, end)
        pictures.add("radiographs" + end, debris.radiographs(flight),
                     "From the side, as on flash radiographs: dark where much mass is in the way.",
                     html.escape(f"Debris behind {plate}") if end else "Debris")
        pictures.add("debris" + end, debris.speeds(flight),
                     "Left: debris more than a quarter of a diameter behind the plate. "
                     "Percentiles: 99th of speeds (front, radial), 1st (rear), mean.")
        if state := debris.state(flight):
            pictures.add("state" + end, state,
                         "A slice a sixth of a diameter thick through the axis, at the end. "
                         + ("Temperature: of all heat of a body: shock, yielding, failure."
                            if flight.yields else
                            "Temperature: of the heat that damping left in a body, not of what "
                            "its motion holds."))
        if flight.wall and (wall := debris.wall(flight)):
            pictures.add("wall" + end, wall,
                         "Debris that fly on freely; within the circles half and 90 % of the "
                         "momentum.")


def add_shields(pictures, run):
    import report_shields
    if drawing := report_shields.radiographs(run):
        pictures.add("shield", drawing,
                     "All that is not fixed from the side, as on flash radiographs: dark where "
                     "much mass is in the way.", "The shield")


def pictures_of(run):
    """What needs more than the bodies' places, or stands in texts: drawn once, when the page is
    made."""
    import report_figures as figures
    import report_interior
    pictures = Pictures(run.folder)
    pictures.add("bodies", figures.before_and_after(run),
                 "The bodies, both from the same place and at the same scale. Each group has a "
                 "colour.", "Pictures")
    pictures.add("velocities", figures.velocities(run),
                 "Left: bodies behind the plane of the cut, coloured by speed; arrows: "
                 "velocity in the plane of the bodies next to it, length as the root of the "
                 "speed. Right: how many bodies have which speed, and velocity against place.")
    if "shields" in run.case:
        add_shields(pictures, run)
    if "debris" in run.case:
        add_debris(pictures, run)
    if run.gravity and sorted(run.gravity.counts)[1] > 1:
        pictures.add("gravity", figures.gravity(run),
                     "Potential and pull of the bodies in the middle plane of the map; circles: "
                     "bodies that "
                     "it cuts; arrows: where the pull points.", "Gravity")
    deflection = run.results.get("deflection", {})
    if len(run.results.get("read_out", {}).get("dv", [])) > 0:
        lines = [(deflection[key], name) for key, name in (("dv_plastic", "m v / M"),
                 ("dv_elastic", "m v (1 + e) / M")) if key in deflection]
        pictures.add("deflection", figures.read_outs(run.results["read_out"], lines),
                     "Velocity change of the largest clump along the flight of the impactor. It "
                     "goes on "
                     "changing while ejecta leave, so it is given with its time.", "Deflection")
    if len(run.results.get("ejecta", {}).get("speeds", [])) > 1:
        pictures.add("ejecta", figures.ejecta_speeds(run.results["ejecta"]),
                     "Ejecta at the last read-out: what of them is faster than a speed, relative "
                     "to the target before the impact.", "Ejecta")
    if inside := report_interior.interior(run):
        drawing, states = inside
        pictures.add("interior", drawing,
                     "The largest clump, cut through its centre: empty part of a cube two radii "
                     "around each place; contacts near "
                     "the plane of the flight, as wide as the root of their normal force; porosity "
                     "of shells; contacts of a body; "
                     "forces.", "The inside", rows_of_text(report_interior.table(states)))
    seconds = {key[:-2]: value for key, value in run.results.get("time", {}).items()
               if key.endswith("_s") and key != "total_s" and value > 0}
    if seconds:
        pictures.add("stages", figures.stage_times(seconds),
                     "Wall-clock seconds of the slowest rank.", "Where the time went")
    return pictures.text


def main(folders):
    runs = [Run(folder, "spall report") for folder in folders]
    shown = [Bodies(run) for run in runs]
    data = [data_of(run, name_of(run, runs), bodies, bodies.shown(run))
            for run, bodies in zip(runs, shown)]
    alone = len(runs) == 1
    path = os.path.join(folders[0], "report.html" if alone else "compared.html")
    text = page(runs, data, pictures_of(runs[0]) if alone else "")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    print(path)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: report.py <folders of runs>")
    names = [os.path.dirname(name) or "." if os.path.isfile(name) else name
             for name in sys.argv[1:]]
    try:
        main(names)
    except (OSError, tomllib.TOMLDecodeError) as error:
        sys.exit(f"spall report: a file of {' or '.join(names)} cannot be read or written: {error}")
